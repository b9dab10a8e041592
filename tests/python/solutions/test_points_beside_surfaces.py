"""Solution.irradiance_at of points beside their surfaces, between things that stand close, and in mid-air."""

import warnings

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from scenes import patch, rms, room_with_a_window, up
from surflux.scenes import shapes


def on_the_floor(count, seed=0):
    return np.column_stack([np.random.default_rng(seed).uniform(-0.95, 0.95, (count, 2)), np.zeros(count)])


@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
def test_points_that_rounding_put_behind_their_surface(solve):
    """Of a tilted floor, to the millimetre, and in floats far from the origin."""
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]] @ turn.T
    for offset, rounded in ((0.0, lambda x: np.round(x, 3)), (500.0, lambda x: x.astype(np.float32))):
        floor = sf.Surfels.from_mesh((corners + offset, [[0, 1, 2, 3]]), patch_area=0.02, reflectance=0.5)
        lamp = np.array([0.0, 0.0, 3.0]) + offset
        solution = solve(sf.Scene([floor], [sf.PointLight(lamp, 10.0)]))
        at = rounded(on_the_floor(500) @ turn.T + offset).astype(np.float64)
        to = lamp - at
        expected = 10.0 * (to @ turn[:, 2]) / np.linalg.norm(to, axis=1) ** 3
        found = solution.irradiance_at(at, np.tile(turn[:, 2], (500, 1)))[:, 0]
        np.testing.assert_allclose(found, expected, rtol=2e-3)


@pytest.mark.parametrize("offset", [0.0, 700.0])
def test_points_of_a_sheet_keep_their_side(offset):
    """A hair through a sheet of two sides they had the direct light of the one and the indirect of the other."""
    leaf = sf.Surfels.from_mesh(
        (np.add([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], offset), [[0, 1, 2, 3]]), 0.01, 0.5, two_sided=True
    )
    lamp = np.array([0.5, 0.5, 1.0]) + offset
    solution = sf.solve(sf.Scene([leaf], [sf.PointLight(lamp, 1.0)]))
    at = np.column_stack([np.random.default_rng(0).uniform(0.05, 0.95, (50, 2)), np.zeros(50)]) + offset
    to = lamp - at
    expected = (to[:, 2] / np.linalg.norm(to, axis=1) ** 3)[:, None]
    for off in (0.0, 1e-7, 1e-6, 1e-5):
        for side in (1.0, -1.0):
            found = solution.irradiance_at(at - [0.0, 0.0, side * off], np.tile([0.0, 0.0, side], (50, 1)))
            np.testing.assert_allclose(found, (side > 0) * expected * np.ones(3), rtol=1e-3, atol=1e-9)
    turn = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])  # of floats, which are off the plane then
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    turned = sf.solve(sf.Scene([leaf.transformed(matrix)], [sf.PointLight(turn @ lamp, 1.0)]))
    places = (at @ turn.T).astype(np.float32).astype(np.float64)
    found = turned.irradiance_at(places, np.tile(turn[:, 2], (50, 1)))
    np.testing.assert_allclose(found, expected * np.ones(3), rtol=1e-3)
    behind = solution.irradiance_at(at - [0.0, 0.0, 0.02], np.tile([0.0, 0.0, 1.0], (50, 1)), direct="traced")
    np.testing.assert_allclose(behind, 0.0, atol=1e-9)  # in the air below


def test_points_on_a_curve_that_patches_are_chords_of():
    around = 2 * np.pi * np.arange(32) / 32
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    corners = np.concatenate([np.c_[ring, np.zeros(32)], np.c_[ring, np.ones(32)]])
    faces = [[k, 32 + k, 32 + (k + 1) % 32, (k + 1) % 32] for k in range(32)]  # seen from within
    wall = sf.Surfels.from_mesh((corners, faces), patch_area=0.05, reflectance=0.0)
    solution = sf.solve(sf.Scene([wall], [sf.PointLight([0, 0, 0.5], 1.0)]))
    turn = np.random.default_rng(0).uniform(0, 2 * np.pi, 300)
    at = np.stack([np.cos(turn), np.sin(turn), 0 * turn + 0.5], axis=1)
    found = solution.irradiance_at(at, [-1.0, -1.0, 1.0] * at * [1, 1, 0])[:, 0]
    np.testing.assert_allclose(found, 1.0, rtol=0.02)


def test_what_is_nearer_below_keeps_its_points():
    """A sheet over a floor has points of its own, and not those of the floor, a hair over this."""
    floor = patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.0, 0.0, 0.04)
    sheet = patch([-1, -1, 0.02], [2, 0, 0], [0, 2, 0], 0.0, 0.0, 0.04)
    scene = sf.Scene([floor, sheet], [sf.PointLight([0, 0, 1], 1.0)])
    solution = sf.solve(scene)
    at = np.array([[0.1, 0.1, 0.001], [0.1, 0.1, 0.018], [0.1, 0.1, 0.02], [0.1, 0.1, -0.001]])
    found = solution.irradiance_at(at, up(at))[:, 0]
    expected = 0.98 / np.linalg.norm([0.1, 0.1, 0.98]) ** 3
    np.testing.assert_allclose(found, [0.0, expected, expected, 0.0], atol=1e-6)


def test_gathered_light_is_right_between_things_and_in_mid_air():
    """A box that floats 3 cm over a floor of patches five times as wide, and a plane at the height of a desk."""
    box = shapes.box(1.0, 1)[:2]
    corners = np.array(box[0]) * [0.5, 0.5, 0.4] + [0.2, 0.2, 0.03]
    room = sf.Surfels.from_mesh((np.array(box[0]) * 2.0, [face[::-1] for face in box[1]]), 0.02, 0.6)
    thing = sf.Surfels.from_mesh((corners, box[1]), 0.02, 0.5)
    scene = sf.Scene([room, thing], [sf.AreaLight([0.8, 0.8, 1.99], [0, 0.4, 0], [0.4, 0, 0], 20.0)])
    random = np.random.default_rng(0)
    floor = np.c_[random.uniform(0.0, 0.9, (60, 2)), np.zeros(60)]
    floor = floor[(floor[:, :2] < 0.2).any(axis=1) | (floor[:, :2] > 0.7).any(axis=1)]
    desk = np.c_[random.uniform(1.0, 1.9, (20, 2)), np.full(20, 0.75)]
    at = np.concatenate([floor, desk])
    true, _ = sf.reference_irradiance(scene, at, up(at), samples=4096)
    for solve in (sf.solve, sf.solve_meshless):
        solution = solve(scene)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = solution.irradiance_at(at, up(at), indirect="gathered", rays=1024)
        assert rms(found, true, np.ones(len(at))) < 0.02
        with pytest.warns(UserWarning, match="20 of .* points are on no surface"):
            flat = solution.irradiance_at(at, up(at))
        assert rms(found[: len(floor)], true[: len(floor)], np.ones(len(floor))) < rms(
            flat[: len(floor)], true[: len(floor)], np.ones(len(floor))
        )
    one, two = (solution.irradiance_at(at, up(at), indirect="gathered", threads=threads) for threads in (1, 2))
    assert np.array_equal(one, two)


def test_a_room_turned_inside_out_is_told_of_where_light_is_gathered():
    """Under a sky through its window it has no reflected light, and its faces outside hide that in all figures."""
    room, _ = room_with_a_window(0.1, 0.5)
    desk = np.column_stack([np.full(5, 3.0), np.linspace(0.5, 4.5, 5), np.full(5, 0.8)])
    found = {}
    for turned in (False, True):
        solution = sf.solve(sf.Scene([room.flipped() if turned else room], [sf.Environment(1.0)]))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            found[turned] = solution.irradiance_at(desk, up(desk), indirect="gathered", rays=256)
        assert [str(w.message)[:33] for w in told] == (["points: 5 of 5 points have mostly"] if turned else [])
    assert (found[True] < 0.9 * found[False]).all()


@pytest.mark.parametrize("indirect_only", [True, False])
def test_wide_patches_send_what_the_basis_has_where_rays_end(indirect_only):
    """Walls of one patch each: by their means places in mid-air were off by a fifth."""
    room = sf.Surfels.from_mesh(shapes.box((6, 4, 3), 1, inward=True)[:2], reflectance=0.5)
    scene = sf.Scene([room], [sf.PointLight([1, 1, 2.5], 500.0)])
    places = np.random.default_rng(0).uniform([0.5, 0.5, 0.5], [5.5, 3.5, 2.0], (24, 3))
    facing = np.random.default_rng(1).normal(size=(24, 3))
    off = []
    for seed in range(3):
        solution = sf.solve_meshless(scene, levels=3, indirect_only=indirect_only, seed=seed)
        found = solution.irradiance_at(places, facing, indirect="gathered", rays=256, seed=seed)
        path_traced, noise = sf.reference_irradiance(scene, places, facing, samples=16384, seed=seed)
        off.append(np.sqrt(np.mean((found / path_traced - 1.0) ** 2)))
        assert np.sqrt(np.mean((noise / path_traced) ** 2)) < 0.02
    assert np.median(off) < 0.03, off


def test_gathering_needs_a_scene_and_traced_light(tmp_path):
    at = on_the_floor(2)
    solved = sf.solve(sf.Scene([patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.5, 0.0, 0.1)], [sf.Environment(1.0)]))
    with pytest.raises(ValueError, match=r"^indirect: wanted one of"):
        solved.irradiance_at(at, up(at), indirect="traced")
    with pytest.raises(ValueError, match=r'^direct: wanted "traced" where indirect light is gathered'):
        solved.irradiance_at(at, up(at), "interpolated", indirect="gathered")
    solved.save(tmp_path / "room.ply")
    with pytest.raises(ValueError, match=r'^indirect: wanted "interpolated", for a solution from a file'):
        sf.load_solution(tmp_path / "room.ply").irradiance_at(at, up(at), indirect="gathered")


def test_light_of_a_number_of_bounces_is_not_gathered():
    """It was, with one bounce more than the rest has."""
    room = cube_inside(4, 0.5)
    lamp, at = [sf.PointLight([0.5, 0.5, 0.5], 1.0)], [[0.3, 0.4, 0.0]]
    transfer = sf.precompute_transfer(sf.Scene([room]), levels=2, rays=64)
    for one in (
        sf.solve_meshless(sf.Scene([room], lamp), bounces=1, levels=2, rays=64),
        transfer.relight(lamp, bounces=1),
        sf.precompute_transfer(sf.Scene([room]), bounces=1, levels=2, rays=64).relight(lamp),
    ):
        with pytest.raises(ValueError, match=r'^indirect: wanted "interpolated", for light gathered from 1 bounce'):
            one.irradiance_at(at, up(at), indirect="gathered")


def test_light_gathered_is_reflected_by_what_the_room_was_relit_with():
    """It was reflected by what the room had when its transfer was computed: half of it was missing."""
    room = cube_inside(6, 0.2)
    dim = sf.precompute_transfer(sf.Scene([room]), levels=3, rays=256)
    solution = dim.relight([sf.PointLight([0.5, 0.5, 0.5], 1.0)], reflectance=0.8)
    at = [[0.3, 0.4, 0.0], [0.6, 0.2, 0.0]]
    flat, found = (solution.irradiance_at(at, up(at), indirect=how) for how in ("interpolated", "gathered"))
    assert found == pytest.approx(flat, rel=0.02)
    np.testing.assert_array_equal(solution._scene.surfels.reflectance, solution.surfels.reflectance)
