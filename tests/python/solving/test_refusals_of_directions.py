"""What harmonics and the glossy reference refuse: every argument says its own name."""

import numpy as np
import pytest

import surflux as sf
from refused import COLORS, COUNTS, NAN, NEVER, NO_HARMONICS, NO_ORDERS, NUMBERS, RHO, VECTORS, cases, says_its_name


def shone(scene=None, points=((0, 0, 0),), normals=((0, 0, 1),), directions=((0, 0, 1),), **options):
    return sf.reference_radiance(sf.Scene([disk()]) if scene is None else scene, points, normals, directions, **options)


def from_harmonics(coefficients=(1, 0, 0, 0), height=4):
    return sf.Environment.from_harmonics(coefficients, height)


def sky_harmonics(order=5):
    return sf.Environment(1.0).harmonics(order)


def harmonics(directions=((0, 0, 1),), order=5):
    return sf.spherical_harmonics(directions, order)


def turned(coefficients=(1, 0, 0, 0), rotation=((1, 0, 0), (0, 1, 0), (0, 0, 1))):
    return sf.rotate_harmonics(coefficients, rotation)


def convolved(coefficients=(1, 0, 0, 0), exponent=1.0):
    return sf.convolve_harmonics(coefficients, exponent)


def multiplied(a=((1, 2),) * 4, b=(1, 0, 0, 0), order=None):
    return sf.multiply_harmonics(a, b, order)


def disk():
    return sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0)


REFUSED = [
    (shone, "scene", [disk(), [disk()], "room.toml", 5]),
    (shone, "points", [*VECTORS, [0, 0, 1], [[0, 0, NAN]], np.zeros((0, 3))]),
    (shone, "normals", [*VECTORS, [0, 0, 1], [[0, 0, 0]], [[0, 0, 1]] * 2]),
    (shone, "directions", [*VECTORS, [0, 0, 1], [[0, 0, 0]], [[0, 0, 1]] * 2]),
    (shone, "reflectance", [*COLORS, *RHO[:3], [0.1] * 5]),
    (shone, "specular", [*COLORS, *RHO[:3], [0.1] * 5]),
    (shone, "exponent", [*NUMBERS, [1, 2, 3], -1, 2e6]),
    (shone, "glossy_bounces", [1, 0, None, "yes"]),
    (shone, "samples", [*COUNTS, None, 15]),
    (shone, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (shone, "threads", [0, -1, 1.5, True, "2"]),
    (shone, "progress", [None, 1, "yes"]),
    (from_harmonics, "coefficients", [v for v in NO_HARMONICS if v is not None]),
    (from_harmonics, "height", [*(v for v in COUNTS if v != 1), None, 0, 2**14 + 1]),
    (sky_harmonics, "order", [*NO_ORDERS, None]),
    (harmonics, "directions", [*VECTORS, [1, 2, 3], [[0, 0, 0]], [[0, 0, NAN]], np.zeros((0, 3))]),
    (harmonics, "order", [*NO_ORDERS, None]),
    (turned, "coefficients", NO_HARMONICS),
    (turned, "rotation", [*NEVER, np.eye(2), np.eye(4), 2 * np.eye(3), np.diag([1, 1, -1.0]), np.diag([1, 1, 0.0])]),
    (convolved, "coefficients", NO_HARMONICS),
    (convolved, "exponent", [*NUMBERS, None, -1]),
    (multiplied, "a", NO_HARMONICS),
    (multiplied, "b", [*NO_HARMONICS, np.zeros((4, 3))]),
    (multiplied, "order", NO_ORDERS),
]


@pytest.mark.parametrize(("function", "argument", "value"), list(cases(REFUSED)))
def test_refuses_with_the_name_of_the_argument(function, argument, value):
    says_its_name(function, argument, value)
