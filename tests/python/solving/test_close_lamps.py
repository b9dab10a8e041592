"""Lamps close to a surface: paths of the reference seldom meet their spot there, and a warning says so."""

import warnings

import numpy as np
import pytest

import surflux as sf

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)


def scene(*lights):
    """A ceiling of 2 x 2, and a black floor 2 below it."""
    ceiling = sf.Surfels.from_mesh((SQUARE[::-1] + np.array([0, 0, 2]), [[0, 1, 2, 3]]), reflectance=0.5)
    return sf.Scene([ceiling, sf.Surfels.from_mesh((SQUARE, [[0, 1, 2, 3]]), reflectance=0.0)], list(lights))


def told(lights, samples=64):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        sf.reference_irradiance(scene(*lights), [[0, 0, 0.0]], [[0, 0, 1.0]], samples)
    return [str(one.message) for one in found]


def test_a_lamp_close_to_the_ceiling_is_told():
    """Of 4096 paths from the floor .1 meet the spot of a centimetre's radius; two seeds of three see none of it."""
    said = told([sf.PointLight([0, 0, 1.99], 1.0)], 4096)
    assert len(said) == 1
    assert "light 0 (PointLight) is so close to a surface that 0.1 of 4096 paths" in said[0]


@pytest.mark.parametrize(
    ("light", "is_told"),
    [
        (sf.PointLight([0, 0, 1.5], 1.0), False),  # far off
        (sf.PointLight([0, 0, 1.99], 0.0), False),  # dark
        (sf.PointLight([0, 0, 2.01], 1.0), False),  # above the ceiling
        (sf.PointLight([1.5, 0, 1.99], 1.0), False),  # beside it
        (sf.PointLight([0, 1.01, 1.99], 1.0), False),  # so as well, in the circle around it
        (sf.PointLight([0, 0, 2 - 1e-12], 1.0), False),  # in it
        (sf.PointLight([0, 0, 0.01], 1.0), False),  # over the floor, which is black
        (sf.SpotLight([0, 0, 1.99], [0, 0, -1], 1.0, 60), False),  # which shines down
        (sf.SpotLight([0, 0, 1.99], [0, 0, 1], 1.0, 60), True),
        (sf.AreaLight([0, 0, 1.99], [0, 0.04, 0], [0.04, 0, 0], 1.0), False),  # down
        (sf.AreaLight([0, 0, 1.99], [0.04, 0, 0], [0, 0.04, 0], 1.0), True),
        (sf.AreaLight([-0.5, -0.5, 1.99], [1, 0, 0], [0, 1, 0], 1.0), False),  # wide: its spot is as wide
        (sf.DirectionalLight([0, 0, 1], 1.0), False),
    ],
)
def test_what_lights_a_small_spot(light, is_told):
    assert len(told([sf.PointLight([0, 0, 1], 1.0), light])) == is_told


def test_under_a_cloud():
    rng = np.random.default_rng(0)
    cloud = sf.Surfels(np.c_[rng.uniform(-1, 1, (2000, 2)), np.full(2000, 2.0)], np.tile([0, 0, -1.0], (2000, 1)))
    with pytest.warns(UserWarning, match="so close to a surface"):
        sf.reference_irradiance(sf.Scene([cloud], [sf.PointLight([0, 0, 1.98], 1.0)]), [[0, 0, 0.0]], [[0, 0, 1.0]], 64)
