"""Transfers of a closed house on a ground that goes on beneath it: no light comes in."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux.scenes import shapes


def house_on(ground, area=0.1, thickness=0.0, turn=0.0):
    """A closed house of 2 m on a ground that goes on beneath it; and which surfels are in it."""
    turned = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    corners = ground * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), area, 0.4)
    shells = []
    for side, height in ((2.0, 2.0), (2.0 + 2.0 * thickness, 2.0 + thickness))[: 2 if thickness > 0.0 else 1]:
        vertices, faces, _ = shapes.box([side, side, height], 1, inward=side == 2.0 and thickness > 0.0)
        vertices = np.asarray(vertices) - [side / 2, side / 2, 0.0]
        walls = [face for face in faces if vertices[list(face), 2].max() > 0.0]
        shells.append(sf.Surfels.from_mesh((vertices @ turned, walls), area, 0.6, two_sided=thickness == 0.0))
    scene = sf.Scene(sf.divide_patches([floor, *shells]))

    def is_inside(surfels):
        before = (surfels.points + 0.01 * surfels.normals) @ turned.T
        return (np.abs(before[:, :2]) < 1.0).all(axis=1) & (before[:, 2] > 0.0) & (before[:, 2] < 2.0)

    return scene, is_inside


@pytest.mark.parametrize("seed", quick(0, of=range(3)))
def test_walls_that_stand_on_a_surface_part_its_light(seed):
    """Groups of a ground that went on beneath a closed house sent light of the sun into it, and shared rays to it."""
    scene, is_inside = house_on(4.0)
    transfer = sf.precompute_transfer(scene, seed=seed, epsilon_t=0.05)
    sun = sf.DirectionalLight([0.5, 0.3, -1.0], 800.0)
    solution = transfer.relight(sun)
    inside = is_inside(solution.surfels)
    assert inside.sum() > 200
    assert solution.irradiance[inside].max() == 0.0
    for rays in (256, 64, 16):  # fewer than groups, as on a wider ground with so many as there are by default
        assert transfer.indirect(sun, shadow_rays=rays)[inside].max() == 0.0


@pytest.mark.parametrize(
    "case",
    quick(
        ("local", 32, 0.0, 0),
        ("sky", 32, 0.2, 0),
        of=[
            (lighting, each, thickness, seed)
            for lighting in ("local", "distant", "sky")
            for each in (16, 32)
            for thickness in (0.0, 0.2)
            for seed in range(3)
        ],
    ),
)
def test_groups_end_at_walls(case):
    """Of 16 and 32 surfels in the mean they had ground in and around the house: up to 200 of 800 W/m2 were in it."""
    lighting, each, thickness, seed = case
    scene, is_inside = house_on(12.0, 0.2, thickness, turn=0.3)
    senders = sum(len(of) for of in scene.objects) // each
    transfer = sf.precompute_transfer(scene, lighting, seed=seed, senders=senders)
    light = sf.DirectionalLight([0.5, 0.3, -1.0], 800.0) if lighting == "local" else sf.Environment([255.0] * 3)
    solution = transfer.relight(light)
    assert (inside := is_inside(solution.surfels)).sum() > 100
    assert solution.irradiance[inside].max() < 0.5
    assert solution.irradiance[~inside].max() > 500.0


@pytest.mark.parametrize("seed", quick(0, of=range(3)))
def test_corners_of_a_house_part_the_ground(seed):
    """Each wall ran over a quarter of the patch at a corner, which stayed whole: 4 to 9 W/m2, of `solve` 194."""
    scene, is_inside = house_on(12.0, 0.2)
    sun = sf.DirectionalLight([0.5, 0.3, -1.0], 800.0)
    relit = sf.precompute_transfer(scene, seed=seed).relight(sun)
    for solution in (relit, sf.solve(sf.Scene(scene.objects, [sun]), seed=seed)):
        assert (inside := is_inside(solution.surfels)).sum() > 100
        assert solution.irradiance[inside].max() == 0.0


def test_a_house_on_one_patch_parts_it():
    """Its walls run over a third of the width of the ground together: it was as bright inside as outside."""
    scene, is_inside = house_on(12.0, 700.0, turn=0.3)
    sun = sf.DirectionalLight([0.5, 0.3, -1.0], 800.0)
    solution = sf.solve(sf.Scene(scene.objects, [sun]))
    assert (inside := is_inside(solution.surfels)).sum() > 5
    assert solution.irradiance[inside].max() == 0.0
