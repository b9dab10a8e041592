"""From a solution to the arrays of Gaussians."""

import numpy as np

from surflux._base import check
from surflux._base.color import linear_to_srgb, white_of
from surflux._base.passes import stage
from surflux.solutions.solution import Solution
from surflux.solutions.towards import has_lobes, warn_of_lost_lobes
from surflux.splats.shapes import shapes_of
from surflux.splats.view_colors import HIGHEST, even, fitted, mean_ahead


def baked(solution, degree, exposure, stops, color_space):
    """(positions, scales, rotations, opacities, harmonics) of Gaussians.of."""
    if not isinstance(solution, Solution):
        raise ValueError(f"solution: wanted a Solution, got {type(solution).__name__}")
    surfels, towards = solution.surfels, solution.radiance_towards
    stops = check.number("stops", stops, -100.0, 100.0)
    glossy = has_lobes(solution)
    if exposure is None:
        radiance = mean_ahead(towards, surfels.normals) if glossy else solution.radiosity / np.pi
        exposure = 1.0 / white_of(radiance, surfels.emission)
    factor = check.number("exposure", exposure, 0.0, low_open=True) * 2.0**stops

    def coded(radiance):
        shown = np.clip(factor * radiance, 0.0, 1.0)
        return linear_to_srgb(shown) if color_space == "srgb" else shown

    degree = (HIGHEST if glossy else 0) if degree is None else degree
    if glossy:
        callback = stage("colours by direction")
        colors = fitted(lambda directions: coded(towards(directions)), surfels.normals, degree, callback)
    else:
        warn_of_lost_lobes(solution)
        colors = np.zeros((len(surfels), (degree + 1) ** 2, 3))
        colors[:, :1] = even(coded(solution.radiosity / np.pi))
    return *shapes_of(surfels), colors
