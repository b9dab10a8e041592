"""Weak lamps near what they light, and strong ones that walls hide: each has its light samples."""

import numpy as np
import pytest

import surflux as sf
from scenes import rms
from surflux.scenes import shapes


def room(corner, lamp, exitance):
    """A closed room of 3 x 3 x 2.5 m with a lamp of half a metre, a mesh, below its ceiling."""
    corner = np.array(corner, float)
    vertices, faces, _ = shapes.box(1.0, 10, inward=True)
    walls = sf.Surfels.from_mesh((vertices * [3.0, 3.0, 2.5] + corner, faces), reflectance=0.5)
    sides = corner + lamp + np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.0]])
    return [walls, sf.Surfels.from_mesh((sides, [[0, 1, 2, 3]]), 0.02, reflectance=0.3, emission=exitance)]


@pytest.mark.parametrize(
    ("times", "solve"),
    [(100.0, sf.solve), (10000.0, sf.solve), (100.0, sf.solve_meshless), (1000.0, sf.solve_meshless)],
)
def test_a_strong_lamp_in_the_next_room_takes_no_light_samples_away(times, solve):
    """Of one pool for all lamps a weak one had a hundredth: light of its room was off by 17 %, by 57 % of a
    thousandth, and too low by 6 and 19 %. By solve_meshless what it reflects was off by 11 % of a thousandth."""
    alone = sf.solve(
        sf.Scene(room([3.1, 0, 0], [1.4, 1, 2.4], 1.0)), transport="pairs", insert=False, probes=512, shadow_rays=2048
    )
    n = len(alone.surfels)
    scene = sf.Scene(room([0, 0, 0], [1, 1, 2.4], times) + room([3.1, 0, 0], [1.4, 1, 2.4], 1.0))
    floor = np.flatnonzero(alone.surfels.normals[:600, 2] > 0.9)
    options = {"transport": "rays", "insert": False} if solve is sf.solve else {}
    for seed in range(3):
        found = solve(scene, seed=seed, **options)
        assert rms(found.irradiance[-n:][:600], alone.irradiance[:600], alone.surfels.areas[:600]) < 0.04
        lit = found.irradiance_at(alone.surfels.points[floor], alone.surfels.normals[floor])
        assert lit.mean() == pytest.approx(alone.irradiance[floor].mean(), rel=0.03)


def test_a_sun_outside_takes_no_paths_from_a_lamp_inside():
    """Of 11.75 the path tracer had found 5.1, with a standard error of .1: it asked the sun alone, which walls hide."""
    vertices, faces, _ = shapes.box(1.0, 8, inward=True)
    inside = sf.Surfels.from_mesh((vertices * [4.0, 3.0, 2.5], faces), reflectance=0.5)
    vertices, faces, _ = shapes.box(1.0, 4)
    house = sf.Surfels.from_mesh((vertices * [4.4, 3.4, 2.9] - 0.2, faces), reflectance=0.5)
    lamp, sun = sf.PointLight([2.0, 1.5, 2.2], 24.0), sf.DirectionalLight([0.3, 0.2, -1.0], 1e5)
    at, up = [[2.0, 1.5, 0.0], [1.0, 1.0, 0.0]], np.tile([0.0, 0.0, 1.0], (2, 1))
    alone, error = sf.reference_irradiance(sf.Scene([inside, house], [lamp]), at, up, samples=1024)
    with_sun, error_with_sun = sf.reference_irradiance(sf.Scene([inside, house], [lamp, sun]), at, up, samples=1024)
    assert with_sun == pytest.approx(alone, abs=4.0 * np.hypot(error, error_with_sun).max())
    assert error_with_sun.max() < 0.05 * alone.min()
    solution = sf.solve(sf.Scene([inside, house], [lamp, sun]))
    assert solution.irradiance_at(at, up) == pytest.approx(alone, rel=0.06)
    assert solution.history[-1]["local_error_p90"] < 0.1


def screened_lamp(hole):
    """A lamp of 2 x 2 m at 2 m, exitance 100, and a screen at 1 m with a small square hole."""
    lamp = ([[-1, -1, 2], [-1, 1, 2], [1, 1, 2], [1, -1, 2]], [[0, 1, 2, 3]])
    strips = [[-3, -hole / 2], [hole / 2, 3]]
    sheets = [[[a, -3, 1], [b, -3, 1], [b, 3, 1], [a, 3, 1]] for a, b in strips]
    sheets += [[[-hole / 2, c, 1], [hole / 2, c, 1], [hole / 2, d, 1], [-hole / 2, d, 1]] for c, d in strips]
    mesh = np.reshape(sheets, (-1, 3)), np.arange(16).reshape(-1, 4)
    return [
        sf.Surfels.from_mesh(lamp, 0.25, reflectance=0.0, emission=100.0),
        sf.Surfels.from_mesh(mesh, None, reflectance=0.0, two_sided=True),
    ]


def through_the_hole(hole, at):
    return 100.0 / np.pi * hole**2 / (1.0 + (at[:, :2] ** 2).sum(axis=1)) ** 2


@pytest.mark.parametrize("rays", [256, 1024, 2048])
def test_an_opening_that_few_rays_find_is_not_missing_in_the_mean(rays):
    """Places whose probes find nothing of a lamp stopped there, and others had more rays, which find less."""
    solution = sf.solve(sf.Scene(screened_lamp(0.06)))
    random = np.random.default_rng(0)
    at = np.column_stack([random.uniform(-0.5, 0.5, (3000, 2)), np.zeros(3000)])
    up = np.tile([0.0, 0.0, 1.0], (3000, 1))
    found = np.mean([solution.irradiance_at(at, up, rays=rays, seed=seed)[:, 0].mean() for seed in range(3)])
    assert found == pytest.approx(through_the_hole(0.06, at).mean(), rel=0.06)


def test_solvers_have_light_of_an_opening_in_the_mean():
    floor = ([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]], [[0, 1, 2, 3]])
    patches = sf.Surfels.from_mesh(floor, 0.0005, reflectance=0.0)
    scene = sf.Scene([*screened_lamp(0.06), patches])
    found = [sf.solve(scene, transport="rays", insert=False, seed=seed) for seed in range(3)]
    on = slice(-len(patches), None)
    true = through_the_hole(0.06, found[0].surfels.points[on]).mean()
    assert np.mean([one.irradiance[on, 0].mean() for one in found]) == pytest.approx(true, rel=0.08)


def test_lamps_are_told_apart_however_large_the_ground_is():
    """Clusters went by the extent of the scene: with a ground of a kilometre all lamps were one."""
    exact = {"transport": "pairs", "insert": False, "probes": 512, "shadow_rays": 2048}
    alone = sf.solve(sf.Scene(room([3.1, 0, 0], [1.4, 1, 2.4], 1.0)), **exact)
    ground = [[-500, -500, -1], [500, -500, -1], [500, 500, -1], [-500, 500, -1]], [[0, 1, 2, 3]]
    objects = room([0, 0, 0], [1, 1, 2.4], 1e4) + room([3.1, 0, 0], [1.4, 1, 2.4], 1.0)
    found = sf.solve(sf.Scene([sf.Surfels.from_mesh(ground, 4e4), *objects]), transport="rays", insert=False)
    lit = found.irradiance[-len(alone.surfels) :][:600]
    assert rms(lit, alone.irradiance[:600], alone.surfels.areas[:600]) < 0.06


def test_lights_that_are_off_take_no_light_samples():
    """Beyond seven lights share their light samples."""
    corners = [[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.1)
    roof = sf.Surfels.from_mesh((np.add(corners, [0, 0, 3]), [[0, 1, 2, 3]]), 0.1)
    lamps = [sf.PointLight([2.0, 1.5, 2.2], 24.0), sf.PointLight([2.0, 1.5, 4.0], 1e6)]
    at, up = [[2.0, 1.5, 0.0]], [[0.0, 0.0, 1.0]]
    off = [sf.PointLight([2.0, 1.5, 2.0], 0.0)] * 7 + [sf.DirectionalLight([0.0, 0.0, -1.0], 0.0)] * 7
    plain, error = sf.reference_irradiance(sf.Scene([floor, roof], lamps), at, up, samples=64)
    crowded, _ = sf.reference_irradiance(sf.Scene([floor, roof], off + lamps), at, up, samples=64)
    np.testing.assert_array_equal(plain, crowded)
    assert (error < 0.01 * plain).all()


def test_blue_light_is_solved_as_finely_as_white():
    """Norms of colours, not luminance: a blue room had twice the functions of a white one."""
    vertices, faces, _ = shapes.box(1.0, 5, inward=True)
    walls = sf.Surfels.from_mesh((vertices, faces), reflectance=0.5)
    lamps = [sf.PointLight([0.4, 0.5, 0.7], color) for color in ([1.0, 1.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])]
    white, *others = (sf.solve_meshless(sf.Scene([walls], [lamp])).history[-1]["points"] for lamp in lamps)
    assert others == pytest.approx([white, white], rel=0.05)


def test_mesh_lamps_are_traced_beside_a_faint_glow_of_disks():
    """Whether rays find what shines went by all emissive surfels: the lamp's light was blended, 56 % off."""
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.25, reflectance=0.0)
    small = np.array([[-0.1, -0.1, 0.3], [-0.1, 0.1, 0.3], [0.1, 0.1, 0.3], [0.1, -0.1, 0.3]])
    lamp = sf.Surfels.from_mesh((small, [[0, 1, 2, 3]]), 0.01, reflectance=0.0, emission=1000.0)
    random = np.random.default_rng(1)
    cloud = np.column_stack([random.uniform(-3, 3, (2000, 2)), np.full(2000, 5.0)])
    glow = sf.Surfels(cloud, np.tile([0.0, 0.0, -1.0], (2000, 1)), reflectance=0.0, emission=1e-3)
    at = np.column_stack([random.uniform(-0.9, 0.9, (200, 2)), np.zeros(200)])
    up = np.tile([0.0, 0.0, 1.0], (200, 1))
    scene = sf.Scene([floor, lamp, glow])
    true, _ = sf.reference_irradiance(scene, at, up, samples=4096)
    assert rms(sf.solve(scene).irradiance_at(at, up), true, np.ones(200)) < 0.02
