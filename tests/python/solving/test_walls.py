"""Thin, doubled and open walls in one mesh hold the light, and take none from what stands beside them."""

import numpy as np
import pytest

import surflux as sf
from cases import church
from scenes import two_cells

DARK = 0.01  # of the mean over all surfels
LOST = 0.05  # of what indirect light there is


def faces_a_dark_room(surfels):
    before = surfels.points + 1e-3 * surfels.normals
    inside = np.zeros(len(surfels), dtype=bool)
    for low, high in church.DARK_ROOMS.values():
        inside |= np.all((before > low) & (before < high), axis=1)
    return inside


@pytest.fixture(scope="module", params=[True, False], ids=["aligned", "across"])
def lit_church(request):
    """With faces of the floor that end with the dark rooms, and with such as go on beneath their walls."""
    scene = church.scene(aligned=request.param)
    black = church.scene(reflectance=0.0, aligned=request.param)
    surfels = scene.surfels
    inside = faces_a_dark_room(surfels)
    others = np.flatnonzero(~inside)
    places = surfels.points[others], surfels.normals[others]
    total, error = sf.reference_irradiance(scene, *places, samples=192, seed=1)
    direct, _ = sf.reference_irradiance(black, *places, samples=64, seed=2)
    dark = surfels.points[inside], surfels.normals[inside]
    assert sf.reference_irradiance(scene, *dark, samples=64, seed=3)[0].max() == 0.0
    return scene, inside, others, total[:, 0], error[:, 0], direct[:, 0]


def assert_none_is_lost(found, indirect, error):
    lit = indirect - 4 * error > 0.3 * np.mean(indirect)
    assert lit.sum() >= 200
    assert (found[lit] > LOST * indirect[lit]).all()


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.slow
def test_a_church_keeps_its_rooms_dark_and_its_walls_lit(lit_church, seed):
    scene, inside, others, total, error, direct = lit_church
    solution = sf.solve(scene, seed=seed)
    areas = solution.surfels.areas
    mean = np.average(solution.irradiance[:, 0], weights=areas)
    own = inside[solution.parents]
    assert own.sum() >= 500
    assert solution.irradiance[own].max() < DARK * mean

    share = np.bincount(solution.parents, areas * (solution.irradiance - solution.direct)[:, 0], len(scene.surfels))
    found = (share / np.bincount(solution.parents, areas, len(scene.surfels)))[others]
    assert_none_is_lost(found, total - direct, error)

    points, normals = scene.surfels.points[inside], scene.surfels.normals[inside]
    assert solution.irradiance_at(points, normals, direct="traced").max() < DARK * mean


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
@pytest.mark.slow
def test_functions_speak_for_the_air_that_they_are_in(lit_church, seed):
    scene, inside, others, total, error, direct = lit_church
    solution = sf.solve_meshless(scene, seed=seed)
    mean = np.average(solution.irradiance[:, 0], weights=solution.surfels.areas)
    assert np.count_nonzero(solution.irradiance[inside, 0] > DARK * mean) <= inside.sum() / 500
    assert_none_is_lost((solution.irradiance - solution.direct)[others, 0], total - direct, error)
    points, normals = scene.surfels.points[inside], scene.surfels.normals[inside]
    at = solution.irradiance_at(points, normals, direct="traced")[:, 0]
    assert np.count_nonzero(at > DARK * mean) <= inside.sum() / 500


@pytest.mark.slow
def test_pictures_of_dark_rooms_are_dark():
    """Seen from within, of the meshless basis itself: floors beneath walls, and sheets without thickness."""
    solution = sf.solve_meshless(church.scene(aligned=False))
    mean = np.average(solution.radiosity[:, 0], weights=solution.surfels.areas) / np.pi
    for low, high in church.DARK_ROOMS.values():
        eye, target = np.array([0.1, 0.1, 0.9]), np.array([0.9, 0.9, 0.1])
        at = [low + share * np.subtract(high, low) for share in (eye, target)]
        seen = solution.render(sf.Camera(*at, fov=80), size=(80, 60))[..., 0]
        assert np.count_nonzero(seen > DARK * mean) <= seen.size / 500


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.slow
def test_walls_that_are_modelled_twice_let_no_light_through(seed):
    """Every face again at its place, facing the same way."""
    corners, faces = church.mesh(size=3.0, aligned=False)
    twice = np.concatenate([corners, corners]), np.concatenate([faces, len(corners) + np.roll(faces, 1, axis=1)])
    scene = sf.Scene([sf.Surfels.from_mesh(twice, reflectance=0.6)], church.lights())
    inside = faces_a_dark_room(scene.surfels)
    assert inside.sum() >= 500
    for solution in (sf.solve(scene, seed=seed), sf.solve_meshless(scene, seed=seed)):
        parents = np.arange(len(inside)) if solution.parents is None else solution.parents
        light = solution.irradiance[:, 0]
        mean = np.average(light, weights=solution.surfels.areas)
        assert light[inside[parents]].max() < DARK * mean


def panelled(gap):
    """A wall 2 x 2 at y = 0 that faces -y, and before it a panel that covers its lower half and faces the same way."""
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    quads = [([0, 0, 0], 2 * x, 2 * z), ([0, -gap, 0], 2 * x, z)]
    # The panel ends at the wall on all sides.
    y = np.array([0, gap, 0])
    quads += [([0, -gap, 1], 2 * x, y), ([0, -gap, 0], z, y), ([2, -gap, 0], y, z), ([0, -gap, 0], y, 2 * x)]
    corners = np.array([[c, c + u, c + u + v, c + v] for c, u, v in ((np.array(c), u, v) for c, u, v in quads)])
    floor = np.array([[[-1, -3, 0], [3, -3, 0], [3, -1, 0], [-1, -1, 0]]], dtype=float)
    corners = np.concatenate([corners, floor]).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 4)


@pytest.mark.parametrize("gap", [0.01, 0.003])
def test_what_a_panel_covers_has_nothing_of_its_light(gap):
    mesh = sf.Surfels.from_mesh(panelled(gap), patch_area=0.01, reflectance=0.6)  # they end with it
    solution = sf.solve(sf.Scene([mesh], [sf.DirectionalLight([0, 0.6, -0.8], 10.0)]))
    x, z = (axis.ravel() for axis in np.meshgrid(np.linspace(0.1, 1.9, 10), np.linspace(0.1, 0.9, 9)))
    facing = np.tile([0.0, -1, 0], (len(x), 1))
    covered = solution.irradiance_at(np.stack([x, 0 * x, z], axis=1), facing, "interpolated")
    before = solution.irradiance_at(np.stack([x, 0 * x - gap, z], axis=1), facing, "interpolated")
    assert before.min() > 1.0
    assert covered.max() < DARK * before.mean()


def test_no_group_spans_a_wall():
    """The dark one has exactly nothing, where groups of floor on both sides of the wall would send across."""
    solution = sf.solve(two_cells(), zeta=0.1, insert=False)
    beyond = solution.surfels.points[:, 0] > 1
    assert beyond.sum() > 1000
    assert solution.irradiance[beyond].max() == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("radius", [None, 0.7, 1.5])
def test_no_function_reaches_through_a_wall(radius):
    """Nor where disks are so wide that walls of either cell have none of their own: nooks have."""
    scene = two_cells()
    solution = sf.solve_meshless(scene, radius=radius)
    beyond = solution.surfels.points[:, 0] > 1
    assert solution.irradiance[beyond].max() == 0.0
    assert (
        solution.irradiance_at(scene.surfels.points[beyond], scene.surfels.normals[beyond], "interpolated").max() == 0.0
    )


@pytest.mark.parametrize("radius", [None, 0.7])
def test_functions_in_sight_keep_the_light_of_a_closed_room(radius):
    solution = sf.solve_meshless(two_cells(), radius=radius)
    lit = solution.surfels.points[:, 0] < 1
    areas = solution.surfels.areas[lit]
    direct = np.average(solution.direct[lit, 0], weights=areas)
    # sum A (H - D) (1 - rho) = rho sum A D
    found = np.average(solution.irradiance[lit, 0] - solution.direct[lit, 0], weights=areas)
    assert found == pytest.approx(0.7 / 0.3 * direct, rel=0.01)


ROOM = [  # 4 x 4 x 2, and a wall across it
    [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]],
    [[0, 0, 2], [0, 4, 2], [4, 4, 2], [4, 0, 2]],
    [[0, 0, 0], [0, 4, 0], [0, 4, 2], [0, 0, 2]],
    [[4, 0, 0], [4, 0, 2], [4, 4, 2], [4, 4, 0]],
    [[0, 4, 0], [4, 4, 0], [4, 4, 2], [0, 4, 2]],
    [[0, 0, 0], [0, 0, 2], [4, 0, 2], [4, 0, 0]],
    [[2, 0, 0], [2, 4, 0], [2, 4, 2], [2, 0, 2]],
]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sides", ["faces", "sheets", True])
def test_both_sides_of_a_wall_in_one_mesh_share_no_light(sides, seed):
    """Patches of its sides lie at the very same places: a bright lamp on one side, a dim one on the other."""
    faces = np.array([*ROOM, ROOM[-1][::-1]] if sides == "faces" else ROOM, float)
    mesh = faces.reshape(-1, 3), np.arange(4 * len(faces)).reshape(-1, 4)
    room = sf.Surfels.from_mesh(mesh, 0.02, reflectance=0.6, two_sided=False if sides == "faces" else sides)
    lamps = [sf.PointLight([0.7, 2.5, 1.2], 6), sf.PointLight([3.4, 1.0, 1.2], [0.3, 0.3, 0.6])]
    solution = sf.solve(sf.Scene([room], lamps), seed=seed)
    on_dim_side = (np.abs(solution.surfels.points[:, 0] - 2) < 1e-6) & (solution.surfels.normals[:, 0] > 0.9)
    indirect = (solution.irradiance - solution.direct)[on_dim_side, 0]
    assert on_dim_side.sum() > 300
    assert indirect.max() < 2.0 * np.median(indirect)  # it was 15 to 20 times that
    assert abs(solution.history[-1]["power_lost"]) < 1e-3 * solution.history[-1]["power_in"]


def two_colored_rooms(patch_area, thickness=0.02):
    """Two rooms on one floor and under one ceiling, a red lamp and a green one of the same luminance."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    red, green = np.array([1.0, 0.02, 0.02]), np.array([0.02, 1.0, 0.02])
    green *= (red @ weights) / (green @ weights)

    def square(corner, u, v):
        corner, u, v = (np.array(vector, float) for vector in (corner, u, v))
        return sf.Surfels.from_mesh(
            (np.array([corner, corner + u, corner + u + v, corner + v]), [[0, 1, 2, 3]]), patch_area, reflectance=0.7
        )

    x, y, z = np.eye(3)
    shell = [([-1, 0, 0], 2 * x, y), ([-1, 0, 1], y, 2 * x), ([-1, 0, 0], z, 2 * x), ([-1, 1, 0], 2 * x, z)]
    ends = [([-1, 0, 0], y, z), ([1, 0, 0], z, y)]
    wall = [([-thickness / 2, 0, 0], z, y), ([thickness / 2, 0, 0], y, z)]
    objects = sf.divide_patches([square(*sides) for sides in shell + ends + wall])
    return sf.Scene(objects, [sf.PointLight([-0.5, 0.5, 0.6], red), sf.PointLight([0.5, 0.5, 0.6], green)])


@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
@pytest.mark.parametrize("patch_area", [0.05, 0.01])
def test_colors_of_one_luminance_do_not_mix_through_a_wall(solve, patch_area):
    """Light was told apart by its luminance alone: beside the wall either room had fifteen times its share of red."""
    scene = two_colored_rooms(patch_area)
    at = np.array([[x, y, 0.0] for x in (-0.3, -0.1, -0.05, -0.02, 0.02, 0.05, 0.1, 0.3) for y in (0.3, 0.5, 0.7)])
    up = np.tile([0.0, 0.0, 1.0], (len(at), 1))
    true, _ = sf.reference_irradiance(scene, at, up, samples=4096)
    for seed in range(3):
        assert solve(scene, seed=seed).irradiance_at(at, up) == pytest.approx(true, rel=0.1)
