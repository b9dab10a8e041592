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


def hall(half, height=3.0):
    """A closed hall with a ball of disks under what shines from its ceiling, whole or in pieces."""
    vertices, faces, _ = shapes.box(1.0, 1, inward=True)
    walls = sf.Surfels.from_mesh((vertices * [2 * half, 2 * half, height], faces), half**2 / 900, reflectance=0.5)
    k = np.arange(300) + 0.5
    z, turn = 1 - k / 150, np.pi * (1 + 5**0.5) * k
    normals = np.column_stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z])
    ball = sf.Surfels(0.5 * normals + [1.3 * half, 1.1 * half, 0.6], normals=normals, reflectance=0.5)

    def ceiling(pieces):
        side = 2 * half / pieces
        steps = [(side * i, side * j) for i in range(pieces) for j in range(pieces)]
        return [sf.AreaLight([x, y, height - 0.01], [0, side, 0], [side, 0, 0], 10.0) for x, y in steps]

    return sf.Scene([ball, walls]), ceiling


@pytest.mark.parametrize("seed", range(2))
def test_the_indirect_light_of_a_ceiling_is_that_of_its_pieces(seed):
    """Four points of a light that is 16 m wide and 3 m away tell little of it: 10 % were missing or too much."""
    scene, ceiling = hall(8.0)
    transfer = sf.precompute_transfer(scene, seed=seed)
    whole, cut = (transfer.indirect(ceiling(pieces), seed=seed)[:300, 0] for pieces in (1, 8))
    assert np.sqrt(np.mean((whole - cut) ** 2) / np.mean(cut**2)) < 0.05


@pytest.mark.parametrize("half", [10.0, 50.0])
def test_half_shadows_of_wide_lights(half):
    """Of 64 points of its area one or two carried all: a fifth off under 20 m of light, a third under 100 m."""
    scene, ceiling = hall(half)
    ball = scene.objects[0].replace(reflectance=0.0)
    above = sf.Surfels(ball.points + np.array([0.5, 0.3, 1.0]), normals=ball.normals, reflectance=0.0)
    scene = sf.Scene([ball, above], ceiling(1))
    solution = sf.solve(scene, insert=False)
    s = solution.surfels[:300:5]
    true, error = sf.reference_irradiance(scene, s.points, s.normals, samples=16384)
    off = np.sqrt(np.mean((solution.direct[:300:5] - true) ** 2 - error**2) / np.mean(true**2))
    assert off < 0.05


def test_a_far_lamp_is_parallel_light():
    """Its solid angle was the difference of nearly equal numbers: a sun in metres was a million times too bright."""
    ground = sf.Surfels.from_mesh(([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]]), 0.05, reflectance=0.5)
    direction = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    for far in (1e7, 1e9, 1.5e11):
        lamps = [sf.PointLight(far * direction, far**2), sf.SpotLight(far * direction, -direction, far**2, cone=20.0)]
        for lamp in lamps:
            found = sf.solve(sf.Scene([ground], [lamp]), insert=False).direct
            np.testing.assert_allclose(found, direction[2], rtol=1e-6)
