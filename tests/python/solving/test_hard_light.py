"""Light that hardly gets anywhere: thin walls, slits, grazing rays, and a lamp of a millionth of a steradian."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from scenes import cloud_room, patch, solve_own, surfels_of
from surflux.scenes import shapes

UP = [0, 0, 1]
THIN = 1e-3
CELLS = (np.arange(20) + 0.5) / 20
LIGHTS = [sf.PointLight([0.4, 0.5, 0.6], 1.0), sf.AreaLight([0.3, 0.3, 0.9], [0, 0.3, 0], [0.3, 0, 0], 5.0)]


def wall_of_patches():
    vertices, faces, _ = shapes.box((THIN, 1, 1), 1)
    return sf.Surfels.from_mesh((np.add(vertices, [1 - THIN / 2, 0, 0]), faces), 1 / 64, 0.7)


def wall_of_disks():
    """Two sheets of one object, back to back."""
    y, z = (a.ravel() for a in np.meshgrid(CELLS, CELLS))
    sides = [np.stack([np.full(400, 1 + side * THIN / 2), y, z], axis=1) for side in (-1, 1)]
    return surfels_of(np.concatenate(sides), [[-1, 0, 0]] * 400 + [[1, 0, 0]] * 400, 0.7)


def double_room(kind):
    if kind == "clouds":
        return cloud_room(10, 0.7, size=(2, 1, 1))
    vertices, faces, _ = shapes.box((2, 1, 1), (16, 8, 8), inward=True)
    return [sf.Surfels.from_mesh((vertices, faces), reflectance=0.7)]


def leak(solution):
    """Of what all surfels receive, the share of those beyond x = 1."""
    s = solution.surfels
    power = s.areas * solution.irradiance.sum(axis=1)
    x = s.points[:, 0]
    dark = (x > 1 + THIN) | ((np.abs(x - 1) < THIN) & (s.normals[:, 0] > 0.5))
    assert 0.3 < dark.mean() < 0.7
    return power[dark].sum() / power.sum()


@pytest.mark.slow
@pytest.mark.parametrize("wall", [wall_of_patches, wall_of_disks])
@pytest.mark.parametrize("room", ["patches", "clouds"])
def test_thin_walls_hold_the_light(room, wall):
    """1e-3 of the room thick, lit from one side: at most 2e-5 of all that is received comes through."""
    solution = solve_own(sf.Scene([*double_room(room), wall()], LIGHTS))
    assert solution.direct[:, 0].max() > 0
    assert leak(solution) <= 2e-5


@pytest.mark.slow
@pytest.mark.parametrize("insert", [False, True])
@pytest.mark.parametrize("wall", [wall_of_patches, wall_of_disks])
@pytest.mark.parametrize("room", ["patches", "clouds"])
def test_thin_walls_hold_the_light_of_rays(room, wall, insert):
    """Disks stick out through the wall, groups lie on both sides, and fields are interpolated along floors below it."""
    solution = sf.solve(sf.Scene([*double_room(room), wall()], LIGHTS), transport="rays", insert=insert)
    assert solution.direct[:, 0].max() > 0
    assert leak(solution) <= 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_a_closed_box_of_two_sided_sheets_holds_the_light_of_all_pairs(seed):
    """Patches of the room straddle planes of the box's: what lies behind these sends nothing to them."""
    room = sf.Surfels.from_mesh(shapes.box((4, 4, 4), 10, inward=True)[:2], reflectance=0.7)
    vertices, faces, _ = shapes.box((0.8, 0.8, 0.8), 4)
    box = sf.Surfels.from_mesh((np.add(vertices, [1.6, 1.71, 1.52]), faces), reflectance=0.7, two_sided=True)
    scene = sf.Scene([room, box], [sf.PointLight([2.03, 2.1, 1.9], 10.0)])
    solution = solve_own(scene, seed=seed)
    inward = np.einsum("ik,ik->i", box.normals, [2.0, 2.11, 1.92] - box.points) > 0
    assert solution.irradiance[len(room) :][inward].min() > 0
    assert not solution.irradiance[: len(room)].any()
    assert not solution.irradiance[len(room) :][~inward].any()


@pytest.mark.parametrize("at_once", [False, True])
@pytest.mark.slow
def test_two_rooms_wall_to_wall(at_once):
    """Clouds of two closed rooms, 1e-3 apart; each wall an object, or all one."""
    lit = cloud_room(14, 0.7)
    objects = [*lit, *(surfels_of(np.add(s.points, [1 + THIN, 0, 0]), s.normals, 0.7) for s in lit)]
    if at_once:
        objects = [surfels_of(*(np.concatenate([getattr(s, k) for s in objects]) for k in ("points", "normals")), 0.7)]
    solution = solve_own(sf.Scene(objects, LIGHTS))
    power = solution.surfels.areas * solution.irradiance.sum(axis=1)
    beyond = len(power) // 2
    assert power[beyond:].sum() <= 1e-4 * power.sum()
    assert solution.history[-1]["power_escaped"] == 0.0


@pytest.mark.slow
def test_a_bright_sky_through_a_hole_has_the_noise_of_its_own_rays():
    """Rays that are aimed at the bright part of an image decide, not how many others happen to find the hole."""
    image = np.full((64, 128, 3), 0.01)
    image[:2] = 1000.0
    a, b = 0.4, 0.6
    ceiling = [[[0, 0], [1, 0], [1, a], [0, a]], [[0, b], [1, b], [1, 1], [0, 1]]]
    ceiling += [[[0, a], [a, a], [a, b], [0, b]], [[b, a], [1, a], [1, b], [b, b]]]
    vertices = [[x, y, 1.0] for strip in ceiling for x, y in strip]
    lid = sf.Surfels.from_mesh((vertices, [[4 * k + 3, 4 * k + 2, 4 * k + 1, 4 * k] for k in range(4)]), 0.04, 0.0)
    floor = patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.0, 0.0, 0.01)
    scene = sf.Scene([floor, lid], [sf.Environment(image)])
    below = np.flatnonzero(np.all(np.abs(floor.points[:, :2] - 0.5) < 0.1, axis=1))
    found = np.array([solve_own(scene, seed=seed).irradiance[below, 0].mean() for seed in range(6)])
    assert found.std() < 0.03 * found.mean()


def slit_in_a_wall(width):
    low, high = 0.5 - width / 2, 0.5 + width / 2
    sheets = [[[1, a, 0], [1, b, 0], [1, b, 1], [1, a, 1]] for a, b in ((0, low), (high, 1))]
    return [sf.Surfels.from_mesh((sheet, [[0, 1, 2, 3]]), reflectance=0.0, two_sided=True) for sheet in sheets]


def through_slit(width):
    """A F between unit squares 2 apart through a slit half way: F's integral over where the slit is crossed.

    By midpoints, with the closed form in z; y0, y2 the ends of a ray, which crosses the slit at (y0 + y2) / 2.
    """
    n = 400
    y0 = ((np.arange(n) + 0.5) / n)[:, None]
    y2 = 2 * (0.5 + width * ((np.arange(n) + 0.5) / n - 0.5)) - y0
    squared = 4 + (y2 - y0) ** 2
    # The integral over z0 and z2 from 0 to 1 of 4 / (pi (c + (z2 - z0)^2)^2) is 4 / pi atan(1 / sqrt c) / c^1.5.
    kernel = 4 / np.pi * np.arctan(1 / np.sqrt(squared)) / squared**1.5
    return (kernel * ((y2 > 0) & (y2 < 1))).mean() * 2 * width


@pytest.mark.parametrize(("width", "within"), [(0.1, 0.02), (0.01, 0.12), (0.001, 0.3)])
@pytest.mark.parametrize("lamp", ["patches", "area light"])
@pytest.mark.slow
def test_slits_let_through_what_they_should(lamp, width, within):
    """Flux between two walls of 16 x 16 patches; the mean over seeds, because few rays find a narrow slit."""
    receiver = patch([2, 0, 0], [0, 0, 1], [0, 1, 0], 0.0, 0.0, 1 / 256)
    edges = [0, 0, 0], [0, 1, 0], [0, 0, 1]
    objects, lights = [receiver, *slit_in_a_wall(width)], []
    if lamp == "patches":
        objects.append(patch(*edges, 0.0, 1.0, 1 / 256))
    else:
        lights.append(sf.AreaLight(*edges, 1.0))
    fluxes = []
    for seed in range(2 if lamp == "patches" else 16):
        solution = solve_own(sf.Scene(objects, lights), seed=seed)
        fluxes.append((solution.irradiance[:256, 0] * solution.surfels.areas[:256]).sum())
    assert np.mean(fluxes) == pytest.approx(through_slit(width), rel=within)


def floors(offset=(0, 0, 0)):
    x, y = (a.ravel() for a in np.meshgrid(2 * CELLS - 1, 2 * CELLS - 1))
    return [
        patch(np.add([-1, -1, 0], offset), [2, 0, 0], [0, 2, 0], 0.0, 0.0, 0.01),
        patch(np.add([-1, -1, 0], offset), [2, 0, 0], [0, 2, 0], 0.0),
        surfels_of(np.stack([x, y, 0 * x], axis=1) + offset, [UP] * 400, 0.0),
    ]


@pytest.mark.parametrize("angle", quick(89.9, of=[89.0, 89.9, 89.999]))
@pytest.mark.parametrize("offset", [(0, 0, 0), (5e6, -5e6, 300.0)])
def test_grazing_sun(angle, offset):
    """E cos all over a plane, which does not shade itself; and on a sphere, up to the terminator."""
    sine, cosine = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    sun = sf.DirectionalLight([sine, 0, -cosine], 1000.0)
    for floor in floors(offset):
        solution = solve_own(sf.Scene([floor], [sun]))
        np.testing.assert_allclose(solution.direct, 1000 * cosine, rtol=1e-9)
        found, _ = sf.reference_irradiance(sf.Scene([floor], [sun]), floor.points, floor.normals, samples=16)
        np.testing.assert_allclose(found, 1000 * cosine, rtol=1e-9)
    unit = shapes.sphere(1000)
    ball = surfels_of(unit.points + offset, unit.normals, 0.0)
    lit = 1000 * np.maximum(0, unit.normals @ [-sine, 0, cosine])
    np.testing.assert_allclose(solve_own(sf.Scene([ball], [sun])).direct[:, 0], lit, atol=1e-6)


@pytest.mark.parametrize("height", [1e-1, 1e-2, 1e-3, 1e-4])
def test_a_lamp_that_skims_a_floor(height):
    """A square of half side 1 under a point light: I times its solid angle, 4 atan(1 / (h sqrt(2 + h^2)))."""
    solid_angle = 4 * np.arctan(1 / (height * np.sqrt(2 + height**2)))
    for floor in floors()[:2]:
        solution = solve_own(sf.Scene([floor], [sf.PointLight([0, 0, height], 1.0)]))
        assert (solution.direct[:, 0] * solution.surfels.areas).sum() == pytest.approx(solid_angle, rel=1e-9)


SIDE = 1e-3
LAMPS = {
    "patch": lambda: patch([-SIDE / 2, -SIDE / 2, 1], [0, SIDE, 0], [SIDE, 0, 0], 0.0, 1e6),
    "surfel": lambda: sf.Surfels(
        [[0, 0, 1]], [[0, 0, -1]], radii=SIDE / np.sqrt(np.pi), areas=SIDE**2, reflectance=0.0, emission=1e6
    ),
    "area light": lambda: sf.AreaLight([-SIDE / 2, -SIDE / 2, 1], [0, SIDE, 0], [SIDE, 0, 0], 1e6),
}


@pytest.mark.slow
@pytest.mark.parametrize("floor", [0, 2])
@pytest.mark.parametrize("lamp", LAMPS)
def test_one_bright_tiny_lamp(lamp, floor):
    """1e-6 of a steradian over a floor: E a^2 cos^2 / (pi r^2), in closed form as exact as 1e-6."""
    floor_is_patches, lamp, floor = floor == 0, LAMPS[lamp](), floors()[floor]
    is_light = isinstance(lamp, sf.AreaLight)
    scene = sf.Scene([floor], [lamp]) if is_light else sf.Scene([floor, lamp])
    solution = solve_own(scene, rays=4096)
    d = np.array([0, 0, 1]) - floor.points
    expected = 1e6 * SIDE**2 * d[:, 2] ** 2 / (np.pi * (d**2).sum(axis=1) ** 2)
    received = solution.irradiance[: len(floor), 0]
    # What a patch receives is a mean over it, not what its centre does: .33 % on the floor of patches.
    np.testing.assert_allclose(received, expected, rtol=0.006 if floor_is_patches else 0.003)
    found, error = sf.reference_irradiance(scene, floor.points, floor.normals, samples=1024)
    assert np.all(np.abs(found[:, 0] - expected) < 5 * error[:, 0] + 1e-3 * expected)
    assert (error[:, 0] / expected).max() < 2.5e-3


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-6, 3e-6, 1e-5])
def test_nothing_gets_between_plates_that_all_but_touch(gap):
    """In a room, where rays to them come from far away: they see each other alone, to the error that is asked for."""
    x, y, corner, rise = np.array([0.4, 0, 0]), np.array([0, 0.4, 0]), np.array([0.3, 0.3, 0.5]), [0, 0, gap]
    room = sf.Surfels.from_mesh(shapes.box(1.0, 5, inward=True)[:2])
    scene = sf.Scene([room, patch(corner, x, y, 0.5, 1.0, 0.01), patch(corner + rise, y, x, 0.5, 0.0, 0.01)])
    of_plates = sf.form_factors(scene, error=1e-3)[len(room) :]
    assert of_plates[:, : len(room)].sum(axis=1) == pytest.approx(0, abs=1e-3)
    # B = 1 + H / 2 of the lower one, H / 2 of the upper: H = 4 / 3 up there. Floats carry the exchange.
    upper = sf.solve(scene, transport="pairs", insert=False).irradiance[-16:, 0]
    assert upper == pytest.approx(4 / 3, rel=1e-3)
