"""Lamps as wide as what they light is far: all of their light is reflected, each colour of its own lamps."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes


def room(patch_area):
    vertices, faces, _ = shapes.box(1.0, 1, inward=True)
    return sf.Surfels.from_mesh((vertices * [4.0, 5.0, 3.0], faces), patch_area, reflectance=0.5)


def panel(exitance, pieces=1):
    """3 x 3 m at a height of 2.2 m, whole or cut up."""
    side = 3.0 / pieces
    return [
        sf.AreaLight([0.5 + side * i, 1.0 + side * j, 2.2], [0, side, 0], [side, 0, 0], exitance)
        for i in range(pieces)
        for j in range(pieces)
    ]


@pytest.mark.parametrize("patch_area", [0.25, 1.0])
def test_a_lamp_cut_up_is_the_same_light(patch_area):
    """Of the first bounce 12 and 20 % were missing: what rays find of a lamp, and light samples leave to them."""

    def reflected(lamps, seed):
        found = sf.solve_meshless(sf.Scene([room(patch_area)], lamps), levels=1, bounces=1, seed=seed)
        return found.surfels.areas @ (found.irradiance - found.direct)[:, 0]

    whole, cut = (np.mean([reflected(lamps, seed) for seed in range(2)]) for lamps in (panel(20.0), panel(20.0, 5)))
    assert whole == pytest.approx(cut, rel=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_beside_a_green_panel_a_red_lamp_is_as_it_is_alone(seed):
    """The power that the panel had lost was made up for by factors of all light: red was 13 % too bright."""
    red = sf.PointLight([1.0, 1.0, 1.5], [0.5, 0.0, 0.0])
    both, alone = (
        sf.solve_meshless(sf.Scene([room(0.25)], [red, *others]), seed=seed) for others in (panel([0.0, 20.0, 0.0]), [])
    )
    areas = alone.surfels.areas
    assert areas @ both.irradiance[:, 0] == pytest.approx(areas @ alone.irradiance[:, 0], rel=0.01)
