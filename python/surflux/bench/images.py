"""Seconds of pictures: a million surfels at 1280 x 720."""

from functools import cache
from time import perf_counter

import numpy as np

from surflux.pictures.camera import Camera
from surflux.points.surfels import Surfels
from surflux.solutions.solution import Solution

NAME = "picture of a million surfels"
SIZE = (1280, 720)
CAMERA = Camera([0, -7, 2.5], [0, 0, -0.3])


@cache
def landscape(n=1_000_000):
    """A Solution of n surfels that nobody has solved: hills of formulas under a checkered light."""
    side = int(np.sqrt(n))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2)
    x, y = ((grid + np.random.default_rng(0).uniform(0.2, 0.8, grid.shape)) * (10.0 / side) - 5.0).T
    z = 0.5 * np.sin(1.3 * x) * np.cos(1.1 * y) + 0.1 * np.sin(5 * x + 2 * y) + 0.05 * np.cos(11 * y - 3 * x)
    dx = 0.65 * np.cos(1.3 * x) * np.cos(1.1 * y) + 0.5 * np.cos(5 * x + 2 * y) + 0.15 * np.sin(11 * y - 3 * x)
    dy = -0.55 * np.sin(1.3 * x) * np.sin(1.1 * y) + 0.2 * np.cos(5 * x + 2 * y) - 0.55 * np.sin(11 * y - 3 * x)
    areas = (10.0 / side) ** 2 * np.sqrt(1 + dx**2 + dy**2)
    surfels = Surfels(
        np.stack([x, y, z], 1), normals=np.stack([-dx, -dy, 1 + 0 * x], 1), radii=np.sqrt(areas), areas=areas
    )
    light = np.clip(surfels.normals @ [0.4, 0.3, 0.866], 0.0, None)[:, None]
    light = light * np.where(((np.floor(4 * x) + np.floor(4 * y)) % 2 == 0)[:, None], [3.0, 2.4, 1.5], [0.6, 0.9, 1.5])
    rows = np.arange(len(surfels), dtype=np.uint32)
    return Solution(surfels, parents=rows, objects=0 * rows, radiosity=light, irradiance=2 * light, direct=2 * light)


@cache
def _fine():
    return landscape().render(CAMERA, SIZE, samples=4)


def picture(threads):
    """Surfels, seconds with one sample a pixel, RMS difference from 4 x 4 samples, what that is, seconds by samples.

    OpenGL's own threads, as llvmpipe has them, are not limited.
    """
    solution = landscape()
    seconds = {}
    for samples in (1, 2):
        start = perf_counter()
        image = solution.render(CAMERA, SIZE, samples=samples, threads=threads)
        seconds[f"{samples} x {samples} samples"] = perf_counter() - start
        if samples == 1:
            error = np.sqrt(np.mean((image - _fine()) ** 2) / np.mean(_fine() ** 2))
    return len(solution.surfels), seconds["1 x 1 samples"], error, "4 x 4 samples a pixel, RMS", seconds
