"""Narrow sources, and those that lie in a surface: all of their light arrives."""

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from scenes import patch

X, Y, Z = np.eye(3)

SOLVERS = {
    "pairs": lambda scene: sf.solve(scene, transport="pairs", insert=False),
    "rays": lambda scene: sf.solve(scene, transport="rays", insert=False),
    "refined": lambda scene: sf.solve(scene, transport="rays"),
    "meshless": lambda scene: sf.solve_meshless(scene, levels=2),
}
every_solver = pytest.mark.parametrize("solver", SOLVERS.values(), ids=SOLVERS)


def power_of_spot(cone, penumbra):
    """2 pi times the integral of smoothstep in angle times its sine, by 10^5 midpoints: to 1e-9."""
    outer, inner = np.radians(cone / 2), np.radians((cone - penumbra) / 2)
    t = (np.arange(100_000) + 0.5) / 100_000 * outer
    x = np.clip((outer - t) / (outer - inner), 0, 1) if penumbra else np.ones_like(t)
    return 2 * np.pi * (x * x * (3 - 2 * x) * np.sin(t)).mean() * outer


@every_solver
@pytest.mark.parametrize("cone", [1.0, 3.0])
@pytest.mark.slow
def test_a_narrow_spot_on_wide_patches(solver, cone):
    """On patches of .25 m, in the middle of one, across an edge and at a corner of four."""
    ground = patch([0, 0, 0], 2 * X, 2 * Y, 0.0, 0.0, 0.0625)
    for at in ([0.6, 0.65], [0.75, 0.61], [1.0, 1.0]):
        for tilt in ([0, 0, -1.0], [0.2, 0.1, -1.0]):
            spot = sf.SpotLight([*(np.array(at) - 1.3 * np.array(tilt[:2])), 1.3], tilt, 5.0, cone=cone, penumbra=0.5)
            solution = solver(sf.Scene([ground], [spot]))
            power = (solution.surfels.areas[:, None] * solution.direct).sum(axis=0)
            assert power == pytest.approx(5.0 * power_of_spot(cone, 0.5), rel=1e-6)


def cloud(seed, n=40):
    """A floor of 2 x 2, one point in each of n x n cells."""
    random = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2)
    points = np.c_[(cells + random.uniform(0.2, 0.8, cells.shape)) * 2 / n, np.zeros(n * n)]
    return sf.Surfels(points, [[0, 0, 1]] * n * n, reflectance=0.0)


def ball(seed, n=2000):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return sf.Surfels(points, points, reflectance=0.0)


@every_solver
@pytest.mark.parametrize("cone", [0.1, 1.0, 3.0, 9.0])
@pytest.mark.slow
def test_a_narrow_spot_on_points(solver, cone):
    """Its circle is a hundredth of the points' spacing, up to four times as wide as that; all of it is on them."""
    power = 5.0 * power_of_spot(cone, 0.05)
    for at, tilt in ([0.6, 0.65], [0, 0, -1.0]), ([1.012, 0.97], [0.2, 0.1, -1.0]):
        spot = sf.SpotLight([*(np.array(at) - 1.3 * np.array(tilt[:2])), 1.3], tilt, 5.0, cone=cone, penumbra=0.05)
        solution = solver(sf.Scene([cloud(1)], [spot]))
        assert (solution.surfels.areas[:, None] * solution.direct).sum(axis=0) == pytest.approx(power, rel=1e-6)
    spot = sf.SpotLight([0, 0, 2], [0.03, 0.01, -1], 5.0, cone=cone, penumbra=0.05)
    solution = solver(sf.Scene([ball(1)], [spot]))
    assert (solution.surfels.areas[:, None] * solution.direct).sum(axis=0) == pytest.approx(power, rel=1e-6)


@pytest.mark.slow
def test_solvers_have_the_same_light_of_a_narrow_spot_on_points():
    scene = sf.Scene([cloud(2)], [sf.SpotLight([1, 1, 1.3], [0.1, 0, -1], 5.0, cone=4.0, penumbra=1.0)])
    pairs, rays, meshless = (SOLVERS[name](scene).direct for name in ("pairs", "rays", "meshless"))
    assert pairs.any()
    np.testing.assert_array_equal(pairs, rays)
    np.testing.assert_allclose(pairs, meshless, rtol=1e-12)


@pytest.mark.slow
def test_two_scans_share_a_narrow_spot():
    scene = sf.Scene([cloud(1), cloud(2)], [sf.SpotLight([1, 1, 1.3], [0, 0, -1], 5.0, cone=2.0, penumbra=0.5)])
    solution = SOLVERS["rays"](scene)
    power = solution.surfels.areas * solution.direct[:, 0]
    assert power.sum() == pytest.approx(5.0 * power_of_spot(2.0, 0.5), rel=1e-6)
    assert min(power[:1600].sum(), power[1600:].sum()) > 0


@pytest.mark.slow
def test_what_stands_in_a_narrow_spot_keeps_it_from_points():
    """Half of the cone ends on a black sheet over the floor, which is a mesh here and points there."""
    spot = sf.SpotLight([1, 1, 1.3], [0, 0, -1], 5.0, cone=2.0, penumbra=0.0)
    sheet = patch([1, 0, 0.65], X, 2 * Y, 0.0, 0.0, 0.25)
    scene = sf.Scene([cloud(1), sheet], [spot])
    for solver in SOLVERS.values():
        solution = solver(scene)
        power = solution.surfels.areas * solution.direct[:, 0]
        on_floor = solution.surfels.points[:, 2] == 0
        # 4096 even directions: off a line through their circle by no more than its length in cells of 1/64.
        half = 0.5 * 5.0 * power_of_spot(2.0, 0.0)
        assert power[on_floor].sum() == pytest.approx(half, rel=1 / 64)
        assert power[~on_floor].sum() == pytest.approx(half, rel=1e-6)


def power_on_square(light, at):
    """Of a lamp of 1 W/sr, or W, over the square 2 x 2: by 1000^2 midpoints of a grid drawn together under it."""
    t = (np.arange(1000) + 0.5) / 1000 * 2 - 1
    stretched, width = t**3, 3 * t**2 * 2 / 1000
    axes = [at[k] + np.where(stretched < 0, at[k], 2 - at[k]) * stretched for k in (0, 1)]
    widths = [np.where(stretched < 0, at[k], 2 - at[k]) * width for k in (0, 1)]
    r2 = (axes[0][:, None] - at[0]) ** 2 + (axes[1] - at[1]) ** 2 + at[2] ** 2
    kernel = at[2] / r2**1.5 if isinstance(light, sf.PointLight) else at[2] ** 2 / (np.pi * r2**2)
    return (kernel * widths[0][:, None] * widths[1]).sum()


@every_solver
@pytest.mark.parametrize("height", [0.004, 0.02, 0.1])
@pytest.mark.slow
def test_a_small_lamp_close_over_a_floor(solver, height):
    """On points .05 apart, and on patches of .25 m: all that goes down arrives, but for what the square's end takes."""
    at = np.array([1.012, 0.97, height])
    side = 0.1 * height
    area = sf.AreaLight(at - [side / 2, side / 2, 0], side * Y, side * X, 1 / side**2)
    ground = patch([0, 0, 0], 2 * X, 2 * Y, 0.0, 0.0, 0.0625)
    for lamp in (sf.PointLight(at, 1.0), area):
        expected = power_on_square(lamp, at)
        for floor in (cloud(1), ground):
            solution = solver(sf.Scene([floor], [lamp]))
            power = (solution.surfels.areas * solution.direct[:, 0]).sum()
            # The outermost points stand up to .8 of .05 inside of the square: its rim of .04 has, of all light from
            # there, 8 * .04 h / 2 pi and less.
            short = 8 * 0.04 * height / (2 * np.pi) if floor is not ground else 0.0
            # Of a lamp .1 above, centres more than 3 radii away miss half a per cent, and rays have .1 % of noise.
            assert power == pytest.approx(expected, rel=0.006 + short)


@pytest.mark.parametrize(("cone", "penumbra", "angle"), [(45, 5, 21.25), (120, 60, 45), (160, 160, 40), (220, 80, 90)])
@pytest.mark.parametrize("width", [1e-3, 5e-5, 1e-5, 1e-6])
def test_small_patches_in_the_penumbra_of_a_far_spot_are_lit(cone, penumbra, angle, width):
    """Below 5e-5 of the distance they were black: the rule for a patch in a cone has 1e-9 of the cone's power."""
    e = 0.5 * width
    square = patch([-e, -e, 0], 2 * e * X, 2 * e * Y, 0.0, 0.0, 1.0)
    a = np.radians(angle)
    spot = sf.SpotLight([0, 0, 1], [np.sin(a), 0, -np.cos(a)], 1.0, cone=cone, penumbra=penumbra)
    x = ((cone / 2) - angle) / (penumbra / 2)
    found = sf.solve(sf.Scene([square], [spot])).direct[0, 0]
    assert found == pytest.approx(x * x * (3.0 - 2.0 * x), rel=2e-3)


@pytest.mark.parametrize(("cone", "penumbra"), [(60, 20), (120, 60), (200, 60)])
@pytest.mark.parametrize("width", [1e-4, 1e-6])
def test_slivers_under_a_spot_are_lit_along_their_length(cone, penumbra, width):
    """What is small as the light sees it may still be long: a mean by area was a quarter of its light."""
    strip = patch([-5, 0, 0], 10 * X, width * Y, 0.0, 0.0, 1e9)
    spot = sf.SpotLight([0, 0, 1], [0, 0, -1], 1.0, cone=cone, penumbra=penumbra)
    at = (np.arange(200_000) + 0.5) / 200_000 * 10 - 5
    x = np.clip((cone / 2 - np.degrees(np.arctan(np.abs(at)))) / (penumbra / 2), 0.0, 1.0)
    true = np.mean(x * x * (3.0 - 2.0 * x) / (1.0 + at * at) ** 1.5)
    assert sf.solve(sf.Scene([strip], [spot])).direct[0, 0] == pytest.approx(true, rel=1e-4)


def test_a_narrow_spot_at_points_is_exact():
    ground = patch([0, 0, 0], 2 * X, 2 * Y, 0.0, 0.0, 0.0625)
    scene = sf.Scene([ground], [sf.SpotLight([1, 1, 1.3], [0, 0, -1], 5.0, cone=2.0, penumbra=0.0)])
    radius = 1.3 * np.tan(np.radians(1.0))
    points = np.array([[1, 1, 0], [1 + 0.99 * radius, 1, 0], [1 + 1.01 * radius, 1, 0]])
    r2 = ((points - [1, 1, 1.3]) ** 2).sum(axis=1)
    expected = 5.0 * 1.3 / r2**1.5 * [1, 1, 0]
    normals = [[0, 0, 1]] * 3
    assert np.allclose(sf.reference_irradiance(scene, points, normals, samples=16)[0][:, 0], expected, rtol=1e-9)
    traced = sf.solve(scene, insert=False).irradiance_at(points, normals, direct="traced")[:, 0]
    assert np.allclose(traced, expected, rtol=1e-9)


def lights_in_a_ceiling():
    at = [1.0, 1.0, 1.7]
    return {
        "area": sf.AreaLight([0.7, 0.7, 1.7], 0.6 * Y, 0.6 * X, 10.0),
        "point": sf.PointLight(at, 3.0),
        "spot": sf.SpotLight(at, [0, 0, -1], 3.0, cone=100.0),
    }


@pytest.mark.parametrize("light", lights_in_a_ceiling().values(), ids=lights_in_a_ceiling())
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.3, 0.1, 0.777)])
@pytest.mark.slow
def test_a_lamp_in_the_plane_of_a_ceiling_loses_nothing(light, offset):
    ground = patch([0, 0, 0], 2 * X, 2 * Y, 0.0, 0.0, 0.04)
    ceiling = patch([0, 0, 1.7], 2 * Y, 2 * X, 0.0, 0.0, 0.04)
    n, found = len(ground), []
    for objects in ([ground], [ground, ceiling]):
        scene = sf.Scene([shifted(s, offset) for s in objects], [moved(light, offset)])
        points, normals = scene.objects[0].points, scene.objects[0].normals
        ways = [solver(scene).direct[:n, 0] for name, solver in SOLVERS.items() if name != "refined"]
        ways.append(sf.reference_irradiance(scene, points[::9], normals[::9], samples=64)[0][:, 0])
        ways.append(sf.solve(scene, insert=False).irradiance_at(points, normals, direct="traced")[:, 0])
        found.append(ways)
    for open_sky, under_ceiling in zip(*found, strict=True):
        assert np.allclose(under_ceiling, open_sky, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.3, 0.1, 0.777)])
def test_the_first_bounce_of_a_lamp_in_the_plane_of_a_ceiling(offset):
    """Rays from where others meet large patches near by: of a lamp a thousandth lower they bring .1 % more or less."""
    room = cube_inside(8, 0.5, 0.0).transformed(np.c_[np.eye(4)[:, :3], [*offset, 1.0]])
    received = []
    for height in (1.0, 0.999):
        lamp = sf.AreaLight(np.add(offset, [0.35, 0.35, height]), 0.3 * Y, 0.3 * X, 10.0)
        solution = sf.solve_meshless(sf.Scene([room], [lamp]), levels=1, bounces=1)
        indirect = (solution.irradiance - solution.direct)[:, 0]
        received.append([solution.surfels.areas @ indirect, indirect[room.normals[:, 2] > 0.5].sum()])
    assert received[0] == pytest.approx(received[1], rel=5e-3)


def shifted(s, offset):
    """The patches elsewhere."""
    corners = (s.triangles + offset).reshape(-1, 3)
    return sf.Surfels.from_mesh((corners, np.arange(len(corners)).reshape(-1, 3)), reflectance=0.0)


def moved(light, offset):
    if isinstance(light, sf.AreaLight):
        return sf.AreaLight(np.add(light.corner, offset), light.edge_u, light.edge_v, light.exitance)
    if isinstance(light, sf.SpotLight):
        return sf.SpotLight(
            np.add(light.position, offset), light.direction, light.intensity, light.cone, light.penumbra
        )
    return sf.PointLight(np.add(light.position, offset), light.intensity)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_a_lamp_that_hardly_rises_over_the_floor_does_not_shine_through_a_wall(transport, seed):
    """Of a lamp from 1 m below the floor to 2 cm above it, few shadow rays have a say, and none of them arrives."""
    floor = patch([-1, -1, 0], 2 * X, 2 * Y, 0.5, 0.0, 0.05)
    wall = sf.Surfels.from_mesh(
        ([[0.5, -3, -2], [0.5, -3, 2], [0.5, 3, 2], [0.5, 3, -2]], [[0, 1, 2, 3]]), patch_area=0.1, reflectance=0.5
    )
    lamp = sf.AreaLight([1.5, -0.5, -1], [0, 0, 1.02], [0, 1, 0], 100.0)
    solution = sf.solve(sf.Scene([floor, wall], [lamp]), transport=transport, insert=False, seed=seed)
    points = solution.surfels.points
    on_floor = np.abs(points[:, 2]) < 1e-9
    assert solution.direct[on_floor & (points[:, 0] > 0.6)].max() > 0.01
    np.testing.assert_array_equal(solution.direct[on_floor & (points[:, 0] < 0.4)], 0.0)


@pytest.mark.parametrize("width", [0.02, 0.04])
def test_sun_through_slits_keeps_its_power(width):
    """Patches of which probes missed all slits stayed dark, and others had more rays, which found less: 25 and 9 % of
    the power were missing."""
    corners = [[0, 0, 0], [6, 0, 0], [6, 6, 0], [0, 6, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.0625, reflectance=0.0)
    pitch, turn = 0.731, np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    strips = []
    for left in pitch * np.arange(-6, 16):
        across = np.array([[left + width, -9], [left + pitch, -9], [left + pitch, 12], [left + width, 12]]) @ turn
        strips.append(np.column_stack([across, np.ones(4)]))
    mesh = np.concatenate(strips), np.arange(4 * len(strips)).reshape(-1, 4)
    screen = sf.Surfels.from_mesh(mesh, reflectance=0.0, two_sided=True)
    scene = sf.Scene([floor, screen], [sf.DirectionalLight([0, 0, -1], 1.0)])
    found = []
    for seed in range(4):
        solution = sf.solve(scene, insert=False, seed=seed)
        areas = solution.surfels.areas[: len(floor)]
        found.append((areas @ solution.direct[: len(floor), 0]) / areas.sum())
    assert np.mean(found) == pytest.approx(width / pitch, rel=0.06)


def test_a_slit_that_few_probes_find_does_not_scale_the_light_of_a_lamp():
    """What patches send had to agree with what arrives, as if their direct light were exact: where a shadow ray had
    found the slit, all light was .69 to 2.7 times what it is."""
    length, width, height, gap = 4.0, 3.0, 2.5, [1.7, 1.701]
    faces = [
        [[0, 0, 0], [length, 0, 0], [length, width, 0], [0, width, 0]],
        [[0, 0, 0], [0, width, 0], [0, width, height], [0, 0, height]],
        [[length, 0, 0], [length, 0, height], [length, width, height], [length, width, 0]],
        [[0, 0, 0], [0, 0, height], [length, 0, height], [length, 0, 0]],
        [[0, width, 0], [length, width, 0], [length, width, height], [0, width, height]],
        [[0, 0, height], [0, width, height], [gap[0], width, height], [gap[0], 0, height]],
        [[gap[1], 0, height], [gap[1], width, height], [length, width, height], [length, 0, height]],
    ]
    mesh = np.reshape(faces, (-1, 3)), np.arange(28).reshape(-1, 4)
    room = sf.Surfels.from_mesh(mesh, patch_area=1.0, reflectance=0.5)
    lights = [sf.DirectionalLight([0.2, 0, -1], 1000.0), sf.PointLight([0.6, 1.4, 1.2], [0.5] * 3)]
    scene = sf.Scene([room], lights=lights)
    x, y = np.meshgrid(np.linspace(0.2, 3.8, 12), np.linspace(0.2, 2.8, 8))
    points = np.column_stack([x.ravel(), y.ravel(), np.full(96, height)])
    normals = np.tile([0, 0, -1.0], (96, 1))
    exact, _ = sf.reference_irradiance(scene, points, normals, samples=4096)
    found = [
        sf.solve_meshless(scene, levels=1, seed=seed).irradiance_at(points, normals, direct="traced").mean()
        for seed in range(4)
    ]
    assert np.sqrt(np.mean((found / exact.mean() - 1.0) ** 2)) < 0.3
