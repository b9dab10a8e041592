"""Light of colours that have one luminance: it differs as much as its channels do."""

import numpy as np
import pytest

import surflux as sf

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
RED, GREEN = np.array([0.9, 0.05, 0.05]), np.array([0.05, 0.9, 0.05])
GREEN *= (RED @ LUMINANCE) / (GREEN @ LUMINANCE)


def square(corner, u, v):
    corner, u, v = (np.array(vector, float) for vector in (corner, u, v))
    return [corner, corner + u, corner + u + v, corner + v]


def room_with_stripes(first, second, patch_area):
    """A lit room of which one wall has stripes, of either reflectance in turn."""
    x, y, z = np.eye(3)
    corners = [square(*side) for side in (([-1, 0, 0], 2 * x, y), ([-1, 0, 1], y, 2 * x), ([-1, 1, 0], 2 * x, z))]
    corners += [square([-1, 0, 0], y, z), square([1, 0, 0], z, y)]
    colors = [np.full(3, 0.5)] * len(corners) + [first, second] * 3
    corners += [square([k / 3 - 1, 0, 0], z, x / 3) for k in range(6)]
    mesh = np.concatenate(corners), np.arange(4 * len(corners)).reshape(-1, 4)
    return sf.Scene([sf.Surfels.from_mesh(mesh, patch_area, reflectance=colors)], [sf.PointLight([0.0, 0.6, 0.5], 1.0)])


@pytest.mark.parametrize("patch_area", [0.02, 0.005])
def test_functions_are_as_fine_as_channels_differ(patch_area):
    """Luminance told whether light differs: stripes were as one grey, and red was off by more than it is now."""
    striped = room_with_stripes(RED, GREEN, patch_area)
    grey = room_with_stripes(*[np.full(3, RED @ LUMINANCE)] * 2, patch_area)
    for seed in range(3):
        points, of_grey = (sf.solve_meshless(one, seed=seed).history[-1]["points"] for one in (striped, grey))
        assert points > 1.08 * of_grey
