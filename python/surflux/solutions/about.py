"""What a file says of a solution as a whole."""

import numpy as np

from surflux.scenes.lights import Environment
from surflux.solutions.towards import lobes_lost

# Element of a PLY file: the pixels of Environments, row by row, one image after another.
PIXELS, CHANNELS = "environment", ("r", "g", "b")


def about_solution(solution):
    """A dict for `pack_comments`: figures, camera and what is seen of the lights; images are `pixels_of`."""
    lamps = [[list(v) for v in (lamp.corner, lamp.edge_u, lamp.edge_v, lamp.exitance)] for lamp in solution._lamps]
    environments = [
        {
            "radiance": list(light.radiance),
            "size": None if light.image is None else list(light.image.shape[:2]),
        }
        | light._to_file()
        for light in solution._environments
    ]
    return {
        "solution": 1,
        "error": solution.error,
        "timings": solution.timings,
        "history": solution.history,
        "attempts": solution.attempts,
        "camera": None if solution.camera is None else solution.camera.to_dict(),
        "lamps": lamps,
        "environments": environments,
        "lobes_lost": lobes_lost(solution),
    }


def pixels_of(solution):
    """(n, 3) of all images of Environments; None where there are none."""
    images = [light.image.reshape(-1, 3) for light in solution._environments if light.image is not None]
    return np.concatenate(images) if images else None


def environments_of(about, pixels):
    """The Environments of about_solution and pixels_of; ValueError, TypeError or KeyError where they do not fit."""
    found, begin = [], 0
    for values in about.get("environments", ()):  # none in files that were written before there were any
        light = values["radiance"]
        if values["size"] is not None:
            height, width = (int(side) for side in values["size"])
            end = begin + height * width
            if min(height, width) < 1 or pixels is None or len(pixels) < end:
                raise ValueError(f"wanted an image of {width} x {height} pixels in its element {PIXELS!r}")
            light, begin = pixels[begin:end].reshape(height, width, 3), end
        found.append(Environment._of_file(light, values["up"], values["azimuth"], values.get("columns")))
    return found
