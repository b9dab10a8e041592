"""Solving: what holds for every scene. Scenes with a known irradiance are in tests/cases."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from quick import quick
from scenes import ball_inside, cube_inside, patch, rms, solve_own, surfels_of
from surflux.scenes import shapes


def solve(objects, lights=(), **options):
    return solve_own(sf.Scene(objects, lights), **options)


def furnished(rotation=None, scale=1.0, offset=(0, 0, 0), power=1.0, ball=True):
    """A coloured room with a ball, under a point, a spot, and an area light; moved as a whole, H stays the same.

    Radiant intensity is per solid angle and H per area: in a scene scale times as large it grows with the square.
    """
    rotation, offset = np.eye(3) if rotation is None else rotation, np.array(offset, dtype=float)

    def place(p):
        return scale * (np.array(p, dtype=float) @ rotation.T) + offset

    def turn(d):
        return np.array(d, dtype=float) @ rotation.T

    vertices, faces, _ = shapes.box(1.0, 6, inward=True)
    objects = [sf.Surfels.from_mesh((place(vertices), faces), reflectance=[0.7, 0.5, 0.3])]
    if ball:
        unit = shapes.sphere(162)
        objects.append(surfels_of(place(0.2 * unit.points + np.array([0.5, 0.5, 0.4])), turn(unit.normals), 0.6))
    lights = [
        sf.PointLight(place([0.2, 0.3, 0.8]), [power * scale**2, 0, 0]),
        sf.SpotLight(place([0.8, 0.8, 0.9]), turn([-0.4, -0.4, -0.6]), [0, power * scale**2, 0]),
        sf.AreaLight(place([0.4, 0.4, 0.99]), scale * turn([0.2, 0, 0]), scale * turn([0, -0.2, 0]), 3.0 * power),
    ]
    return sf.Scene(objects, lights)


def spread_over_seeds(name):
    """How far the rays of one seed are from those of another: what any other change of rays may bring too."""
    solutions = [solve_own(furnished(), seed=seed) for seed in range(1, 5)]
    mean = sum(getattr(s, name) for s in solutions) / len(solutions)
    # One solution is sqrt(4 / 3) times as far from the mean of all seeds as from that of four, two are sqrt(2) apart.
    return np.sqrt(8 / 3) * max(rms(getattr(s, name), mean, s.surfels.areas) for s in solutions)


def random_rotation(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def test_areas_of_the_icosphere():
    """642 points, radius .8, 4 pi .8^2 = 8.0425: tangent disks lie outside, D04 section 8.1 reports +2.63 %."""
    areas = sf.effective_areas(shapes.sphere(642, 0.8), method="paper")
    assert 1.01 < areas.sum() / 8.042477 < 1.04


@pytest.mark.parametrize("s", [cube_inside(6, 0.9, 2.0), ball_inside(300, rho=0.9, emission=2.0)], ids=["cube", "ball"])
def test_fresh_rays_find_a_furnace_right(s):
    solution = solve([s])
    assert np.all(solution.direct == 0)
    assert solution.error < 1e-3


@pytest.mark.parametrize("two_sided", [True, False])
def test_a_wall_of_surfels_holds_the_light(two_sided):
    """Two rooms and a wall between them: less than 1e-4 of what both receive reaches the dark one."""
    vertices, faces, _ = shapes.box((2, 1, 1), (16, 8, 8), inward=True)
    rooms = sf.Surfels.from_mesh((vertices, faces), reflectance=0.7)
    at = (np.arange(20) + 0.5) / 20
    points = np.stack(np.broadcast_arrays(1.0, *np.meshgrid(at, at)), axis=-1).reshape(-1, 3)
    wall = surfels_of(points, [[-1, 0, 0]] * 400, 0.7, two_sided=two_sided)
    solution = solve([rooms, wall], [sf.PointLight([0.4, 0.5, 0.6], 1.0)])
    power = solution.surfels.areas * solution.irradiance[:, 0]
    dark = solution.surfels.points[:, 0] > 1.0
    assert dark.sum() == 5 * 64  # the mesh of the room is symmetric: half of it, without the wall
    assert power[dark].sum() < 1e-4 * power.sum()


def test_the_same_every_time_and_other_rays_for_another_seed():
    first, again = (solve_own(furnished(), seed=5) for _ in range(2))
    assert np.array_equal(again.irradiance, first.irradiance)
    assert again.error == first.error
    assert not np.array_equal(solve_own(furnished(), seed=6).irradiance, first.irradiance)


def test_the_scene_stays_as_it_is():
    scene = furnished()
    ball, names = scene.objects[1], ("points", "normals", "radii", "reflectance", "emission", "triangles")
    before = [np.array(getattr(s, name)) for s in scene.objects for name in names]
    lights = scene.lights
    solution = solve_own(scene)
    assert all(
        np.array_equal(a, b)
        for a, b in zip(before, (getattr(s, name) for s in scene.objects for name in names), strict=True)
    )
    assert ball.areas is None
    assert scene.surfels.areas is None
    assert scene.lights == lights
    assert solution.surfels.areas is not None
    assert np.array_equal(solution.parents, np.arange(len(scene.surfels)))
    assert np.array_equal(solution.surfels.points, scene.surfels.points)


def test_what_belongs_together():
    solution = solve_own(furnished())
    s = solution.surfels
    assert np.array_equal(solution.radiosity, s.emission + s.reflectance * solution.irradiance)
    # Indirect light is no less than none, but for what the solver leaves: a relative residual of 1e-4.
    assert (solution.irradiance - solution.direct).min() > -1e-4 * solution.irradiance.max()
    assert solution.radiosity.min() >= 0.0
    figures = solution.history[-1]
    ends = figures["power_absorbed"] + figures["power_escaped"] + figures["power_into_backs"]
    assert figures["power_in"] == pytest.approx(ends, rel=1e-3)
    assert figures["residual"] <= 1e-4
    assert figures["closure_residual"] <= 1e-7
    assert figures["surfels"] == len(s)
    assert set(solution.timings) >= {"areas", "hemispheres", "direct", "exchange", "closure", "solve"}


def test_grey_scenes_solve_one_channel():
    grey = solve_own(sf.Scene([cube_inside(4, 0.5)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)]))
    assert grey.history[0]["channels"] == 1
    assert np.array_equal(grey.radiosity[:, 0], grey.radiosity[:, 2])
    for s, light in (([0.5, 0.5, 0.4], 1.0), (0.5, [1.0, 1.0, 0.9])):
        coloured = solve_own(sf.Scene([cube_inside(4, s)], [sf.PointLight([0.5, 0.5, 0.5], light)]))
        assert coloured.history[0]["channels"] == 3
        # The red channel knows nothing of the blue one: conjugate gradients end at 1e-4 in each.
        np.testing.assert_allclose(coloured.irradiance[:, 0], grey.irradiance[:, 0], rtol=1e-3)


@pytest.mark.slow
def test_light_adds_up():
    """Twice the light, twice the solution, bit by bit; two lights, the sum of each: H is linear in the lights."""
    once, twice = solve_own(furnished()), solve_own(furnished(power=2.0))
    assert np.array_equal(twice.irradiance, 2 * once.irradiance)
    scene = furnished()
    alone = sum(solve_own(sf.Scene(scene.objects, [light]), tolerance=1e-8).direct for light in scene.lights)
    # Each light has shadow rays of its own, drawn by its place in the list.
    assert rms(alone, once.direct, once.surfels.areas) < 1.5 * spread_over_seeds("direct")
    tight = solve_own(furnished(), tolerance=1e-8)
    assert rms(once.irradiance, tight.irradiance, tight.surfels.areas) < 1e-4


@pytest.mark.parametrize("scale", quick(1e-3, 1e6, of=[1e-6, 1e-3, 1e3, 1e6]))
def test_the_unit_does_not_matter(scale):
    """The same rays are drawn and the same pairs found: all that differs is rounding, float in the exchange."""
    before, after = solve_own(furnished(), tolerance=1e-7), solve_own(furnished(scale=scale), tolerance=1e-7)
    np.testing.assert_allclose(after.irradiance, before.irradiance, rtol=1e-6)


@pytest.mark.parametrize("offset", [[5e6, -5e6, 300.0], [4.5e5, 5.2e6, 5e6 / 3]])
def test_survey_coordinates_cost_nothing(offset):
    """5e6 m is held to 1e-9 m, 1e-8 of a patch of this room. No pair of patches may be taken for another kind."""
    before, after = solve_own(furnished(), tolerance=1e-7), solve_own(furnished(offset=offset), tolerance=1e-7)
    np.testing.assert_allclose(after.irradiance, before.irradiance, rtol=1e-6)


@pytest.mark.slow
def test_turning_the_scene():
    """Where all see each other hardly anything differs; past a ball other rays go, as with another seed."""
    before = solve_own(furnished(ball=False), tolerance=1e-8)
    after = solve_own(furnished(random_rotation(1), ball=False), tolerance=1e-8)
    # Points of a patch keep off its rim by 1e-6 of the scene's bounds, which turn to another size.
    np.testing.assert_allclose(after.irradiance, before.irradiance, rtol=1e-4)
    before, after = solve_own(furnished()), solve_own(furnished(random_rotation(2)))
    np.testing.assert_allclose(after.direct, before.direct, rtol=1e-3)
    difference = rms(after.irradiance, before.irradiance, before.surfels.areas)
    assert difference < spread_over_seeds("irradiance") < 0.05


@pytest.mark.slow
def test_the_order_of_objects_does_not_matter():
    scene = furnished()
    before = solve_own(scene)
    after = solve_own(sf.Scene(scene.objects[::-1], scene.lights))
    order = np.concatenate([np.arange(len(after.surfels))[162:], np.arange(162)])
    difference = rms(after.irradiance[order], before.irradiance, before.surfels.areas)
    assert difference < 1.5 * spread_over_seeds("irradiance")


def test_areas_that_are_given_are_used():
    """A flat grid under a wide patch: the exchange is A_i F_ij, so half the area sends half the light."""
    grid = [[x, y, 0] for x in range(6) for y in range(6)]
    far = patch([0, 5, 50], [5, 0, 0], [0, -5, 0], rho=0.0)

    def received(area):
        lamp = sf.Surfels(grid, [[0, 0, 1]] * 36, areas=area, emission=1.0, reflectance=0.0)
        return solve([lamp, far]).irradiance[36, 0]

    assert received(0.5) == pytest.approx(0.5 * received(1.0), rel=0.02)


def test_nothing_comes_of_nothing():
    ball, room = ball_inside(100, 0.2, [0.5, 0.5, 0.5], sign=1), cube_inside(3)
    one = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.1)
    dark = [sf.PointLight([0.1, 0.1, 0.1], 0), sf.Environment(0.0), sf.DirectionalLight([0, 0, -1], 0)]
    for objects in ([room, ball], [one]):
        for lights in ([], dark):
            solution = solve(objects, lights)
            for values in (solution.radiosity, solution.irradiance, solution.direct):
                assert np.all(values == 0.0)
            assert np.isnan(solution.error)  # there is nothing for an error to be relative to


def test_black_surfaces_and_single_surfels():
    # No light comes back from black walls: H = D, B = E.
    black = solve([cube_inside(4, 0.0)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])
    assert np.array_equal(black.irradiance, black.direct)
    assert np.all(black.radiosity == 0.0)
    assert black.direct.min() > 0.0
    # A surfel alone: B = E + rho H, H = irradiance of the sun, which stands 60 degrees off its normal.
    sun = sf.DirectionalLight([np.sqrt(0.75), 0, -0.5], 4.0)
    one = solve([sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.1, reflectance=0.25, emission=3.0)], [sun])
    np.testing.assert_allclose(one.radiosity, 3.5, rtol=1e-12)
    # A closed black room that glows: H = E.
    np.testing.assert_allclose(solve([cube_inside(4, 0.0, 1.5)]).irradiance, 1.5, rtol=1e-6)


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_warnings_name_the_line_that_solved(solver):
    ball = sf.Surfels.from_mesh(shapes.box(patches=2)[:2])
    with pytest.warns(UserWarning, match="all of it stays black") as said:
        solver(sf.Scene([ball]))
    assert [Path(w.filename).name for w in said] == [Path(__file__).name]


@pytest.mark.slow
def test_an_estimate_that_is_no_solution_is_warned_of():
    """A point lamp 1e-3 from a corner lights a thousandth of one patch of each wall."""
    room = sf.Surfels.from_mesh(shapes.box(patches=3, inward=True)[:2], reflectance=0.5)
    scene = sf.Scene([room], [sf.PointLight(room.bounds[0] + 1e-3, 1.0)])
    with pytest.warns(UserWarning, match=r"\d+\.\d% of the light is lost by the solver"):
        solution = sf.solve_meshless(scene)
    lit = solution.irradiance[:, 0] > 0.5 * solution.irradiance.max()  # one patch of each wall, alike for symmetry
    assert lit.sum() == 3
    off = np.ptp(solution.irradiance[lit, 0]) / solution.irradiance[lit, 0].mean()
    assert off > 0.2
    assert solution.error > 0.3 * off


def test_light_on_less_than_a_disk_is_warned_of():
    n = 12
    at = np.stack(np.meshgrid(*2 * [np.arange(n) + 0.5]), -1).reshape(-1, 2) / n
    floor = sf.Surfels(np.c_[at, np.zeros(n * n)], [[0, 0, 1]] * n * n, reflectance=0.0)
    spot = sf.SpotLight([0.51, 0.47, 1.0], [0, 0, -1], 9.0, cone=1.0, penumbra=0.5)
    with pytest.warns(UserWarning, match=r"the irradiance is off by an estimated \d+%: light is concentrated on less"):
        assert sf.solve(sf.Scene([floor], [spot])).error > 0.25
