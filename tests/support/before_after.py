"""The picture of the front page: a scan in its own colours, and beside it lit as `surflux solve` lights it.

SURFLUX_DATA=FOLDER python tests/support/before_after.py data/lion.png
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import surflux as sf
from light_of_points import scene_of

CLOUD = "statues/lion_takanawa_342k_surfels.ply"
OPTIONS = "--light", "sun", "--ground"
TARGET, EYE, FOV = [-2.6, 3.8, -1.25], [0.9, -6.3, 1.0], 31
SIZE = (440, 440)
PAPER = 238  # grey of the background


def draw(path):
    scene = scene_of(str(Path(os.environ["SURFLUX_DATA"]) / CLOUD), *OPTIONS)
    solution = sf.solve(scene)
    layers = solution.render(sf.Camera(EYE, TARGET, fov=FOV), SIZE, layers=["albedo", "alpha", "index", "radiance"])
    of_scan = (layers["index"] >= 0) & (solution.objects[layers["index"]] == 0)  # and not of the ground below it
    halves = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "half.png"
        for radiance, exposure, shown in (
            (layers["albedo"], 1.0, of_scan),
            (layers["radiance"], "auto", layers["alpha"]),
        ):
            sf.write_image(file, radiance, exposure=exposure)
            picture, shown = np.asarray(Image.open(file).convert("RGB")), shown[:, :, None]
            halves.append((picture * shown + PAPER * (1.0 - shown)).astype(np.uint8))
    Image.fromarray(np.hstack(halves)).quantize(256).save(path, optimize=True)


if __name__ == "__main__":
    draw(sys.argv[1])
