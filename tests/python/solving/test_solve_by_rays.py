"""solve(transport="rays"): what holds for every scene that light is gathered in by rays."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from cases.builders import cloud_room
from scenes import ball_inside, cube_inside, patch, rms, surfels_of
from surflux.scenes import shapes

PER_ITERATION = {
    *("iteration", "surfels", "cut", "refined", "inserted", "links", "rays", "channels", "applications", "residual"),
    *("error", "seconds", "power_in", "power_absorbed", "power_escaped", "power_into_backs"),
    *("power_lost", "power_lost_error", "parts", "largest_part_lost", "imbalance", "imbalance_left"),
}


def by_rays(scene, **options):
    return sf.solve(scene, transport="rays", **options)


def furnished(lights=None, n=10, offset=(0, 0, 0)):
    """A coloured room and a ball in it."""
    vertices, faces, _ = shapes.box(1.0, n, inward=True)
    room = sf.Surfels.from_mesh((vertices + np.array(offset), faces), reflectance=[0.7, 0.5, 0.3])
    unit = shapes.sphere(300)
    ball = surfels_of(0.2 * unit.points + np.array([0.5, 0.5, 0.35]) + offset, unit.normals, 0.6)
    if lights is None:
        lamp = sf.AreaLight(np.add([0.4, 0.4, 0.99], offset), [0.2, 0, 0], [0, -0.2, 0], 30.0)
        lights = [lamp, sf.PointLight(np.add([0.2, 0.3, 0.8], offset), [0.5, 0.2, 0.1])]
    return sf.Scene([room, ball], lights)


def balance(figures):
    """What is left of the power that entered, as a share of it."""
    ends = figures["power_absorbed"] + figures["power_escaped"] + figures["power_into_backs"]
    return abs(figures["power_in"] - ends) / figures["power_in"]


def measured_error(scene, solution, count=300, samples=2048):
    """Relative RMS error of irradiance_at at random places, and of the standard error of what it is held against."""
    s, random = solution.surfels, np.random.default_rng(1)
    pick = random.choice(len(s), count, p=s.areas / s.areas.sum())
    points, normals = s.points[pick], s.normals[pick]
    truth, spread = sf.reference_irradiance(scene, points, normals, samples=samples)
    squared = ((solution.irradiance[pick] - truth) ** 2).sum() - (spread**2).sum()
    size = (truth**2).sum()
    return np.sqrt(max(squared, 0.0) / size), np.sqrt((spread**2).sum() / size)


@pytest.mark.parametrize("rho", [0.5, 0.9, 0.999])
@pytest.mark.parametrize(
    "room",
    [
        lambda rho: [cube_inside(20, rho, 2.0)],
        lambda rho: [sf.Surfels.from_mesh(inside_of_an_icosphere(), reflectance=rho, emission=2.0)],
    ],
    ids=["cube", "icosphere"],
)
def test_closed_convex_rooms_are_exact_furnaces(room, rho):
    """B = E / (1 - rho). Rows that miss 1 by 1e-5 would show a hundredfold at rho = .999."""
    solution = by_rays(sf.Scene(room(rho)), tolerance=1e-9)
    np.testing.assert_allclose(solution.radiosity, 2.0 / (1 - rho), rtol=1e-6)
    assert len(solution.history) >= 1
    for figures in solution.history:
        assert figures["applications"] <= 100
        assert balance(figures) < 1e-6
    assert solution.error < 1e-6


def test_what_is_even_stays_coarse():
    """Where H is the same everywhere only what touches, the edges of the cube, is resolved."""
    solution = by_rays(sf.Scene([cube_inside(20, 0.5, 2.0)]))
    assert solution.history[-1]["cut"] < 0.8 * len(solution.surfels)


def inside_of_an_icosphere():
    points, faces = shapes.icosphere(3)
    return points, faces[:, ::-1]


@pytest.mark.parametrize("rho", [0.5, 0.999])
def test_rooms_of_points_are_furnaces_but_for_their_gaps(rho):
    """Clouds along the walls of a cube do not close it: edges are open by a little."""
    solution = by_rays(sf.Scene(cloud_room(12, rho, 2.0)), tolerance=1e-9)
    np.testing.assert_allclose(solution.radiosity * (1 - rho) / 2.0, 1.0, rtol=1e-6)


def test_black_walls_send_nothing():
    solution = by_rays(sf.Scene([cube_inside(10, 0.0)], [sf.PointLight([0.5, 0.5, 0.4], 1.0)]))
    assert np.array_equal(solution.irradiance, solution.direct)
    assert np.all(solution.radiosity == 0.0)
    assert solution.direct.min() > 0.0
    glowing = by_rays(sf.Scene([cube_inside(10, 0.0, 1.5)]), insert=False)
    np.testing.assert_allclose(glowing.irradiance, 1.5, rtol=1e-6)
    assert np.all(glowing.direct == 0.0)
    assert np.all(glowing.radiosity == 1.5)


def test_nothing_comes_of_nothing():
    with pytest.warns(UserWarning, match="stays black"):
        solution = by_rays(sf.Scene([cube_inside(6), ball_inside(100, 0.2, [0.5, 0.5, 0.5], sign=1)]))
    for values in (solution.radiosity, solution.irradiance, solution.direct):
        assert np.all(values == 0.0)
    assert np.isnan(solution.error)
    # One surfel alone under the sun.
    one = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.1, reflectance=0.25, emission=3.0)
    np.testing.assert_allclose(
        by_rays(sf.Scene([one], [sf.DirectionalLight([0, 0, -1], 2.0)])).radiosity, 3.5, rtol=1e-12
    )


@pytest.mark.parametrize("insert", [False, True])
def test_history_tells_what_was_done(insert):
    scene = furnished()
    solution = by_rays(scene, insert=insert)
    assert len(solution.history) >= 2
    for k, figures in enumerate(solution.history):
        assert set(figures) >= PER_ITERATION, PER_ITERATION - set(figures)
        assert figures["iteration"] == k + 1
        assert all(np.isfinite(value) for value in figures.values())
        assert all(value >= 0.0 for name, value in figures.items() if name != "power_lost")
        assert figures["cut"] <= figures["surfels"]
        assert figures["channels"] == 3
        assert figures["applications"] <= 100
        # Rows sum to 1 but for what neighbours say of what escapes; the estimate of the error covers it.
        assert balance(figures) <= max(figures["error"], 0.01)
    for name in ("surfels", "cut", "inserted", "links", "rays", "seconds"):
        values = [figures[name] for figures in solution.history]
        assert values == sorted(values), name
    last = solution.history[-1]
    assert last["surfels"] == len(solution.surfels)
    assert last["residual"] <= 1e-4
    assert last["error"] == solution.error
    assert last["seconds"] <= sum(solution.timings.values())
    assert (last["inserted"] > 0) == insert == (len(solution.surfels) > len(scene.surfels))
    # Each split adds four and takes one away.
    assert len(solution.surfels) == len(scene.surfels) + last["inserted"] * 3 / 4


@pytest.mark.slow
def test_it_is_as_far_off_as_it_says():
    scene = furnished()
    solution = by_rays(scene)
    truth, spread = measured_error(scene, solution)
    assert spread < 0.015
    assert truth < 0.03
    assert truth < 4 * solution.error + spread


def test_threads_and_seeds():
    one, two, other = (by_rays(furnished(), seed=seed, threads=threads) for seed, threads in ((5, 1), (5, 2), (6, 2)))
    for name in ("radiosity", "irradiance", "direct", "parents"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    assert np.array_equal(one.surfels.points, two.surfels.points)
    assert one.error == two.error
    assert [f["links"] for f in one.history] == [f["links"] for f in two.history]
    at = np.array([[0.3, 0.6, 0.0], [0.9, 0.2, 0.0]]), [[0, 0, 1]] * 2
    assert np.array_equal(one.irradiance_at(*at, threads=1), two.irradiance_at(*at, threads=2))
    assert not np.array_equal(one.irradiance[:100], other.irradiance[:100])
    # Another seed is other noise, and nothing else.
    np.testing.assert_allclose(other.irradiance_at(*at), one.irradiance_at(*at), rtol=0.1)


@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_the_scene_stays_as_it_is(transport):
    scene = furnished()
    names = ("points", "normals", "radii", "reflectance", "emission", "triangles", "triangle_surfel")
    before = [np.array(getattr(s, name)) for s in scene.objects for name in names]
    solution = sf.solve(scene, transport=transport)
    after = [getattr(s, name) for s in scene.objects for name in names]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
    assert scene.surfels.areas is None
    assert scene.objects[1].areas is None
    assert len(solution.surfels) > len(scene.surfels)
    assert set(solution.parents) == set(range(len(scene.surfels)))


@pytest.mark.slow
@pytest.mark.parametrize("insert", [False, True])
def test_the_cut_says_which_surfels_share_a_node(insert):
    solution = sf.solve(furnished(n=18), transport="rays", insert=insert)
    nodes = solution.history[-1]["cut"]
    assert np.array_equal(np.unique(solution.cut), np.arange(nodes))
    assert nodes < 0.9 * len(solution.surfels)
    first = np.unique(solution.cut, return_index=True)[1]
    assert np.array_equal(solution.objects, solution.objects[first[solution.cut]])  # each within one object
    facing = np.einsum("ij,ij->i", solution.surfels.normals, solution.surfels.normals[first[solution.cut]])
    assert facing.min() > 0.0
    pairs = sf.solve(furnished(), transport="pairs", insert=insert)
    assert np.array_equal(pairs.cut, pairs.parents)
    assert sf.solve_meshless(furnished(), levels=2, rays=16).cut is None


def test_auto_takes_pairs_of_few_and_rays_of_many():
    few, many = sf.solve(furnished(), insert=False), sf.solve(furnished(n=18), insert=False)
    assert "closure_residual" in few.history[-1]
    assert "closure_residual" not in many.history[-1]
    assert many.history[-1]["cut"] < len(many.surfels) == 2244


def test_both_ways_agree():
    scene = furnished()
    pairs, rays = (sf.solve(scene, transport=way, insert=False) for way in ("pairs", "rays"))
    np.testing.assert_allclose(rays.direct, pairs.direct, rtol=1e-9, atol=1e-12)  # the same shadow rays
    assert rms(rays.irradiance, pairs.irradiance, pairs.surfels.areas) < 0.02
    bounced = [s.irradiance - s.direct for s in (rays, pairs)]
    assert rms(*bounced, pairs.surfels.areas) < 0.04


@pytest.mark.slow
@pytest.mark.parametrize("offset", [[1e6, -1e6, 1e6]])
def test_far_from_the_origin_it_is_the_same(offset):
    """1e6 m is held to 1e-10 m; ties between equal neighbours may fall otherwise, so fields are compared."""
    before, after = by_rays(furnished(), insert=False), by_rays(furnished(offset=offset), insert=False)
    assert rms(after.irradiance, before.irradiance, before.surfels.areas) < 0.01
    np.testing.assert_allclose(after.direct, before.direct, rtol=1e-6, atol=1e-9)
    inserted = by_rays(furnished(offset=offset))
    at = np.random.default_rng(3).uniform(0.05, 0.95, (200, 3)) * [1, 1, 0]
    up = np.tile([0.0, 0, 1], (200, 1))
    here = by_rays(furnished()).irradiance_at(at, up, "interpolated")
    there = inserted.irradiance_at(at + np.array(offset), up, "interpolated")
    assert rms(there, here, np.ones(200)) < 0.03


def room_with(emission, size):
    """A room with a lamp that is a patch of it."""
    lamp = patch([0.5 - size / 2, 0.5 - size / 2, 0.98], [0, size, 0], [size, 0, 0], 0.0, emission, size**2 / 16)
    return sf.Scene([cube_inside(10, [0.7, 0.5, 0.3]), lamp])


@pytest.mark.parametrize(
    ("scene", "within"),
    [
        (room_with(30.0, 0.1), 0.03),
        (room_with(3.0, 0.8), 0.05),  # between large patches, steep beside it
        (sf.Scene([cube_inside(8, 0.5, 1.0), ball_inside(200, 0.2, [0.5, 0.5, 0.4], 0.2, sign=1)]), 0.03),
    ],
    ids=["small", "large", "everywhere"],
)
@pytest.mark.slow
def test_what_glows(scene, within):
    solution = by_rays(scene)
    assert np.all(solution.direct == 0.0)
    assert solution.irradiance.min() >= 0.0
    truth, spread = measured_error(scene, solution)
    assert spread < within / 2
    assert truth < within


def image_of_a_sky():
    image = np.full((32, 64, 3), [0.2, 0.3, 0.5])
    image[6:9, 10:14] = [60.0, 50.0, 40.0]
    return image


@pytest.mark.parametrize(
    "sky", [sf.Environment([0.5, 1.0, 2.0]), sf.Environment(image_of_a_sky())], ids=["even", "image"]
)
def test_skies(sky):
    unit = shapes.sphere(300)
    ball = surfels_of(0.3 * unit.points + np.array([0, 0, 0.4]), unit.normals, [0.7, 0.5, 0.3])
    floor = patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.5, 0.0, 0.01)
    scene = sf.Scene([floor, ball], [sky])
    solution = by_rays(scene)
    truth, spread = measured_error(scene, solution)
    assert spread < 0.015
    assert truth < 0.03
    assert solution.direct.max() > 0.0
    assert np.all(solution.irradiance >= solution.direct - 1e-6 * solution.irradiance.max())


@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_sheets_with_two_sides(transport):
    """A sheet across a room, lit from one side: the other receives nothing, whichever way light is exchanged."""
    vertices, faces, _ = shapes.box(1.0, 8, inward=True)
    room = sf.Surfels.from_mesh((vertices, faces), reflectance=0.0)
    sheet = sf.Surfels.from_mesh(
        shapes.rectangle([0, 0, 0.5], [1, 0, 0], [0, 1, 0], (8, 8)), reflectance=0.5, two_sided=True
    )
    solution = sf.solve(sf.Scene([room, sheet], [sf.PointLight([0.5, 0.5, 0.8], 1.0)]), transport=transport)
    s = solution.surfels
    of_sheet = solution.objects == 1
    above, below = (of_sheet & (s.normals[:, 2] * sign > 0.5) for sign in (1, -1))
    assert solution.irradiance[above].min() > 0.0
    assert np.all(solution.direct[below] == 0.0)
    assert solution.irradiance[below].max() < 1e-9
    assert s.areas[above].sum() == pytest.approx(1.0, rel=1e-12)
    up, down = ([[0, 0, sign]] * 2 for sign in (1, -1))
    at = [[0.3, 0.3, 0.5], [0.61, 0.42, 0.5]]
    assert solution.irradiance_at(at, up, "interpolated").min() > 0.5
    assert solution.irradiance_at(at, down, "interpolated").max() < 1e-9


@pytest.mark.slow
def test_links_grow_with_surfels_and_not_with_their_pairs():
    """Blobs over a floor, made by formula. Links from 1000 surfels to 32 000: as M^1.15 at most."""

    def links(n):
        blobs = []
        for k in range(3):
            unit = shapes.sphere(n // 4)
            bump = 1 + 0.2 * np.sin(5 * unit.points[:, :1] + k) * np.sin(4 * unit.points[:, 1:2])
            points = 0.25 * bump * unit.points + np.array([0.7 * k - 0.7, 0.1 * k, 0.4])
            blobs.append(surfels_of(points, unit.normals, 0.6))
        floor = patch([-1.5, -1, 0], [3, 0, 0], [0, 2, 0], 0.5, 0.0, 6 / (n // 4))
        scene = sf.Scene([*blobs, floor], [sf.PointLight([0, -1, 2], 10.0)])
        figures = by_rays(scene, insert=False).history[-1]
        return figures["surfels"], figures["links"]

    counts, found = np.array([links(n) for n in (1000, 4000, 32000)]).T
    assert np.log(found[-1] / found[0]) / np.log(counts[-1] / counts[0]) < 1.15
    assert found[-1] < 0.01 * counts[-1] ** 2


def test_an_object_that_is_buried_and_lit():
    """What the box shows to the lamp in it are backs: its patches see nothing, and neither do interpolated fields."""
    vertices, faces, _ = shapes.box((2, 2, 2), (4, 4, 4), inward=False)
    box = sf.Surfels.from_mesh((vertices, faces), reflectance=0.5)
    rng = np.random.default_rng(1)
    points = rng.normal(size=(300, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    ball = sf.Surfels(1 + 0.3 * points, normals=points, reflectance=0.5)
    scene = sf.Scene([box, ball], [sf.PointLight([1.7, 1.0, 1.0], 1.0)])
    rays = sf.solve(scene, transport="rays", insert=False)
    pairs = sf.solve(scene, transport="pairs", insert=False)
    assert np.isfinite(rays.error)
    assert rays.irradiance.min() >= 0
    np.testing.assert_allclose(rays.irradiance, pairs.irradiance, atol=0.05 * pairs.irradiance.max())


def test_irradiance_anywhere_does_not_pass_a_wall():
    """A bright and a dim room share a floor; beside the wall the dim side has nothing of the bright one."""
    vertices, faces, _ = shapes.box((2, 1, 1), (8, 4, 4), inward=True)
    room = sf.Surfels.from_mesh((vertices, faces), reflectance=0.3)
    corners = [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]
    wall = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [3, 2, 1, 0]]), patch_area=0.0625, reflectance=0.3)
    scene = sf.Scene([room, wall], [sf.PointLight([0.5, 0.5, 0.9], 10.0), sf.PointLight([1.5, 0.5, 0.9], 0.1)])
    solution = sf.solve(scene, transport="rays", insert=False)
    y = np.linspace(0.2, 0.8, 9)
    at = np.stack([np.full(9, 1.03), y, np.zeros(9)], axis=1)
    found = solution.irradiance_at(at, np.tile([0.0, 0.0, 1.0], (9, 1)), "interpolated")
    lit = solution.irradiance[(solution.surfels.points[:, 0] > 1.01) & (solution.surfels.normals[:, 2] > 0.9)]
    assert found.max() <= 1.2 * lit.max()


def test_what_is_inserted_into_patches_has_their_reflectance():
    """A floor of red and blue tiles under a ball, which throws a shadow over their borders."""
    red, blue = [0.8, 0.2, 0.1], [0.1, 0.2, 0.8]
    x = np.linspace(0, 1, 9)
    grid = np.stack([*np.meshgrid(x, x, [0.0], indexing="ij")], -1).reshape(-1, 3)
    corner = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()[:, None]
    faces = corner + np.array([0, 9, 10, 1])
    tiles = np.where((np.add.outer(np.arange(8), np.arange(8)).ravel() % 2 == 0)[:, None], red, blue)
    floor = sf.Surfels.from_mesh((grid, faces), patch_area=1.0, reflectance=tiles)
    ball = surfels_of(0.15 * shapes.sphere(300).points + [0.5, 0.5, 0.3], shapes.sphere(300).normals, 0.5)
    solution = sf.solve(sf.Scene([floor, ball], [sf.PointLight([0.6, 0.4, 1.5], 5.0)]), transport="rays")
    of_floor = solution.objects == 0
    assert of_floor.sum() > len(floor) + 20
    parents = floor.reflectance[solution.parents[of_floor]]
    np.testing.assert_array_equal(solution.surfels.reflectance[of_floor], parents)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_beneath_a_roof_reflected_light_takes_the_place_of_the_sky(seed):
    """At the tops of columns, in whose middle it is the other way round: there it was a fifth of what it is."""
    scene = sf.load_scene(Path(__file__).parents[3] / "data" / "colonnade.toml")
    tops = np.array([[x, 0, 3.95] for x in (0.2, 2.2, 4.2, 6.2, 7.8)])
    normals = np.tile([0.0, -1.0, 0.0], (5, 1))
    exact, _ = sf.reference_irradiance(scene, tops + 1e-5 * normals, normals, samples=2048)
    found = sf.solve(scene, seed=seed).irradiance_at(tops, normals, direct="traced")
    np.testing.assert_allclose(found[:, 0], exact[:, 0], rtol=0.2)
