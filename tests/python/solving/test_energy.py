"""Energy in contact: where light goes, followed by rays of the test's own, where surfels touch, cross or coincide."""

import functools

import numpy as np
import pytest

import surflux as sf
from cases import church
from fresh_rays import unaccounted
from scenes import patch, rms, solve_own, surfels_of, two_cells
from surflux.scenes import shapes

UP, DOWN = [0, 0, 1], [0, 0, -1]


def one_disk(at, normal, emission=0.0, radius=1.0):
    return sf.Surfels([at], [normal], radii=radius, areas=np.pi * radius**2, reflectance=0.5, emission=emission)


def round_cloud(height, normal, emission=0.0, n=300):
    """A sunflower: points at sqrt(k / n) of the radius 1, by the golden angle, stand for equal areas."""
    k = np.arange(n) + 0.5
    angle = np.pi * (3 - np.sqrt(5)) * k
    points = np.stack([np.sqrt(k / n) * np.cos(angle), np.sqrt(k / n) * np.sin(angle), np.full(n, height)], axis=1)
    return surfels_of(points, [normal] * n, 0.6, emission, areas=np.pi / n)


def square(corner, u, v, rho, emission=0.0, n=20):
    """n x n surfels on a square."""
    corner, u, v = np.array(corner, float), np.array(u, float), np.array(v, float)
    a, b = (g.reshape(-1, 1) for g in np.meshgrid(*[(np.arange(n) + 0.5) / n] * 2))
    normal = np.cross(u, v)
    return surfels_of(corner + a * u + b * v, [normal / np.linalg.norm(normal)] * n**2, rho, emission)


def resting_ball(n, emission=1.0):
    unit = shapes.sphere(n)
    return surfels_of(0.3 * unit.points + np.array([0.5, 0.5, 0.3]), unit.normals, 0.6, emission)


X, Y, Z, ORIGIN = [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]


def crossing_clouds():
    flat = round_cloud(0.0, UP, 1.0)
    return [flat, surfels_of(flat.points[:, [2, 1, 0]], [[1, 0, 0]] * len(flat), 0.6, areas=flat.areas)]


def random_disks():
    random = np.random.default_rng(1)
    points, normals = random.uniform(-1, 1, (200, 3)), random.normal(size=(200, 3))
    emission = random.uniform(size=200)
    return [sf.Surfels(points, normals, radii=0.3, areas=np.pi * 0.09, reflectance=0.5, emission=emission)]


SCENES = {
    "clouds_1e-3_of_a_radius_apart": lambda: [round_cloud(0.0, UP, 1.0), round_cloud(6e-5, DOWN)],
    "clouds_a_radius_apart": lambda: [round_cloud(0.0, UP, 1.0), round_cloud(0.06, DOWN)],
    "coincident_and_face_to_face": lambda: [one_disk(ORIGIN, UP, 1.0), one_disk(ORIGIN, DOWN)],
    "patches_1e-3_apart": lambda: [patch(ORIGIN, X, Y, 0.5, 1.0), patch([0, 0, 1e-3], Y, X, 0.5)],
    "ball_on_a_floor_of_patches": lambda: [resting_ball(642), patch(ORIGIN, X, Y, 0.7, 0.0, 0.0025)],
    "large_ball_on_a_floor_of_patches": lambda: [resting_ball(162), patch(ORIGIN, X, Y, 0.7, 0.0, 0.0025)],
    "ball_on_a_cloud": lambda: [resting_ball(642), square(ORIGIN, X, Y, 0.7)],
    "corner_of_patches": lambda: [
        patch(ORIGIN, X, Y, 0.7, 1.0, 0.01),
        patch(ORIGIN, Y, Z, 0.5, 0.0, 0.01),
        patch(ORIGIN, Z, X, 0.8, 0.0, 0.01),
    ],
    "corner_of_clouds": lambda: [
        square(ORIGIN, X, Y, 0.7, 1.0, 15),
        square(ORIGIN, Y, Z, 0.5, 0, 15),
        square(ORIGIN, Z, X, 0.8, 0, 15),
    ],
    "disks_that_cross": lambda: [one_disk(ORIGIN, UP, 1.0), one_disk([0.2, 0, 0.1], X, 0.0, 0.5)],
    "clouds_that_cross": crossing_clouds,
    "disks_in_a_heap": random_disks,
}
# Where disks of one cloud lie in a heap, rays meet more, or less, than the areas hold: by this share of what is emitted
# the two do not add up.
OFF = {"disks_in_a_heap": 4.7e-3}
GOAL = 1e-3
# What meets or crosses is off by as much as the goal itself: 9.9e-4 to 1.34e-3, by the seed.
WITHIN = {
    "clouds_that_cross": 1.5e-3,
    "corner_of_clouds": 1.5e-3,
    "disks_that_cross": 1.8e-3,
    "large_ball_on_a_floor_of_patches": 1.5e-3,
    **{name: 1.25 * off for name, off in OFF.items()},
}


@functools.cache
def solved(name):
    scene = sf.Scene(SCENES[name]())
    return scene, solve_own(scene, rays=1024, tolerance=1e-6)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.slow
def test_contact_gives_finite_values_and_rows_of_at_most_one(name):
    scene, solution = solved(name)
    for values in (solution.radiosity, solution.irradiance, solution.direct):
        assert np.all(np.isfinite(values))
    assert np.all(solution.radiosity >= solution.surfels.emission)
    factors = sf.form_factors(scene, rays=256)
    assert factors.min() >= 0.0
    assert factors.sum(axis=1).max() <= 1 + 1e-7


@functools.cache
def left_over(name):
    """(emitted - absorbed - escaped - into backs) / emitted, its standard error a quarter of GOAL at most."""
    scene, solution = solved(name)
    rays = 2 ** min(16, round(np.log2(1.2e6 / len(solution.surfels))))
    off, error = unaccounted(scene, solution, rays)
    assert error <= GOAL / 4
    return off


# One of each kind.
QUICK = "clouds_a_radius_apart", "patches_1e-3_apart", "ball_on_a_cloud", "corner_of_patches", "disks_that_cross"


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in SCENES]
)
def test_light_ends_where_rays_find_it_to_end(name):
    assert abs(left_over(name)) <= WITHIN.get(name, GOAL)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.xfail(strict=True, reason=f"off by {off:.1e} of what is emitted"))
        for name, off in OFF.items()
    ],
)
def test_all_light_is_accounted_for(name):
    """To 1e-3 of what is emitted, as in all other scenes."""
    assert abs(left_over(name)) <= GOAL


def long_room(rho, glows):
    """1 x 1 x 4, in which one end glows, or a lamp hangs as far from it as it is wide."""
    room = sf.Surfels.from_mesh(shapes.box((1.0, 1.0, 4.0), inward=True)[:2], patch_area=0.04, reflectance=rho)
    low = room.bounds[0]
    if not glows:
        return sf.Scene([room], [sf.PointLight(low + 0.5, 1.0)])
    return sf.Scene([room.replace(emission=(room.points[:, 2] < low[2] + 1e-6).astype(float))])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(seed for seed in (1, 2))])
@pytest.mark.parametrize("rho", [*(rho for rho in (0.01, 0.5, 0.9, 0.99)), 0.999])
@pytest.mark.parametrize("glows", [True, False])
@pytest.mark.parametrize(
    "solve",
    [
        sf.solve_meshless,
        pytest.param(functools.partial(sf.solve_meshless, indirect_only=False), marks=pytest.mark.slow),
        functools.partial(sf.solve, transport="rays"),
    ],
    ids=["meshless", "meshless, direct in the basis", "rays"],
)
def test_light_is_kept_from_end_to_end_of_a_long_room(solve, glows, rho, seed):
    """What is made of 5e-5 a bounce comes back a thousand times; what rises steeply towards a source makes the most."""
    figures = solve(long_room(rho, glows), seed=seed).history[-1]
    assert abs(figures["power_lost"]) <= 1e-3 * figures["power_in"]


def test_light_that_a_solver_loses_is_warned_of():
    """By functions twice as wide as the room, which has few of its own."""
    scene = two_cells()
    with pytest.warns(UserWarning, match=r"^[\d.]+% of the light is (made|lost) by the solver: ") as said:
        solution = sf.solve_meshless(scene, radius=2.0, seed=2)
    figures, areas = solution.history[-1], solution.surfels.areas
    off = figures["power_lost"] / figures["power_in"]
    # All of sum A D is absorbed: (1 - rho) sum A H.
    found = 0.3 * np.sum(areas * solution.irradiance[:, 0]) / np.sum(areas * solution.direct[:, 0])
    assert found - 1 == pytest.approx(-off, rel=0.02)  # the balance knows, and so does the estimate
    assert solution.error > abs(off)
    (text,) = [str(w.message) for w in said if "by the solver" in str(w.message)]
    assert text.startswith(f"{abs(off):.1%} of the light is {'lost' if off > 0 else 'made'}")


@pytest.mark.slow
def test_uniform_furnace_under_the_sky_keeps_its_rows_whole():
    """All radiance is 1, of surfaces and sky: where factors of senders change a row, what it has of the sky follows."""
    unit, rho = shapes.sphere(1500), 0.7
    ball = sf.Surfels(0.5 * unit.points + [0, 0, 0.6], unit.normals, reflectance=rho, emission=(1 - rho) * np.pi)
    corners = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.04, reflectance=rho)
    floor = floor.replace(emission=np.full(3, (1 - rho) * np.pi))
    scene = sf.Scene([ball, floor], [sf.Environment(1.0)])
    off = [sf.solve_meshless(scene, seed=seed).radiosity / np.pi - 1 for seed in (0, 1)]
    assert np.sqrt(np.mean(np.square(off))) < 1.8e-5  # 2.5e-5 where the sky's part stayed as it was


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_what_leaves_thin_walls_outwards_does_not_light_the_rooms(seed):
    """In a church of large patches those of its outside, in the sun, and of its inside make one group of senders.

    The group's share of what leaves the scene was that of the light in the rooms: their light was 19 % off (RMS), where
    thirty reflections, of which nothing is scaled, are 4 % off.
    """
    scene = church.scene(size=4.0)
    found, unscaled = (sf.solve_meshless(scene, seed=seed, bounces=bounces) for bounces in (None, 30))
    indirect, wanted = (s.irradiance - s.direct for s in (found, unscaled))
    assert rms(indirect, wanted, found.surfels.areas) < 0.06
    assert abs(found.history[-1]["power_lost"]) < 0.005 * found.history[-1]["power_in"]


def test_what_escapes_between_plates_is_told_by_own_rays():
    """Where solve_meshless gathers light at surfels by themselves, what escapes there is theirs, too: 1 % too much."""
    low = patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.3, 1.0, 0.01)
    scene = sf.Scene([low, patch([0, 0, 0.1], [0, 1, 0], [1, 0, 0], 0.3, 0.0, 0.01)])
    true = sf.solve(scene, transport="pairs", insert=False).history[-1]["power_escaped"]
    found = [sf.solve_meshless(scene, seed=seed).history[-1]["power_escaped"] for seed in range(3)]
    np.testing.assert_allclose(found, true, rtol=0.003)
