"""Patches of one object end where walls of another one stand on them."""

import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

AROUND = [[-0.8, -0.8, 0], [1.2, -0.8, 0], [1.2, 1.2, 0], [-0.8, 1.2, 0]], [[0, 1, 2, 3]]


def floor():
    return sf.Surfels.from_mesh(AROUND, patch_area=0.25, reflectance=0.5)


def box():
    """0.63 wide, turned, on the floor, its sides nowhere along the edges of patches."""
    a = np.radians(20)
    turn = [[np.cos(a), -np.sin(a), 0, 0.21], [np.sin(a), np.cos(a), 0, 0.13], [0, 0, 1, 0], [0, 0, 0, 1]]
    s = sf.Surfels.from_mesh(shapes.box((0.63, 0.63, 0.5), patches=3)[:2], reflectance=0.5)
    low = s.bounds
    there = np.eye(4)
    there[:3, 3] = -(low[0] + low[1]) / 2 + [0, 0, (low[1] - low[0])[2] / 2]
    return s.transformed(np.array(turn) @ there)


def beneath(points, grown=0.0):
    """Which points of the floor are beneath the box."""
    a = np.radians(-20)
    x, y = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) @ (points[:, :2] - [0.21, 0.13]).T
    return np.maximum(np.abs(x), np.abs(y)) < 0.315 + grown


LAMP = sf.AreaLight([-0.5, -0.5, 1.5], [0, 0.6, 0], [0.6, 0, 0], 10.0)


def test_pieces_cover_what_was_and_are_on_one_side():
    whole, wall = floor().replace(emission=[1.0, 2.0, 3.0]), box()
    cut, same = sf.divide_patches([whole, wall])
    assert len(cut) > len(whole)
    assert cut.areas.sum() == pytest.approx(whole.areas.sum(), rel=1e-12)
    assert same is wall
    np.testing.assert_array_equal(np.unique(cut.emission, axis=0), [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(np.bincount(cut.faces), [len(cut)])
    corners = cut.triangles + 1e-9 * (cut.points[cut.triangle_surfel][:, None] - cut.triangles)
    inside = beneath(corners.reshape(-1, 3), 1e-9).reshape(-1, 3)
    outside = ~beneath(corners.reshape(-1, 3), -1e-9).reshape(-1, 3)
    assert (
        inside.all(axis=1) | outside.all(axis=1)
    ).mean() > 0.9  # lines go on beyond the box, so that pieces are convex
    under = beneath(cut.points)
    assert cut.areas[under].sum() == pytest.approx(0.63**2, rel=1e-9)
    again = sf.divide_patches([cut, wall])
    assert again[0] is cut


def test_patches_that_were_turned_round_are_cut_as_well():
    both = sf.Surfels.from_mesh(AROUND, patch_area=0.25, two_sided=True)
    tall = box().transformed([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.25], [0, 0, 0, 1]])
    cut, _ = sf.divide_patches([both, tall])
    up = cut.normals[:, 2] > 0
    assert cut.areas[up].sum() == pytest.approx(4.0, rel=1e-12)
    assert cut.areas[~up].sum() == pytest.approx(4.0, rel=1e-12)
    for side in (cut[up], cut[~up]):
        assert side.areas[beneath(side.points)].sum() == pytest.approx(0.63**2, rel=1e-9)
    facing = np.cross(cut.triangles[:, 1] - cut.triangles[:, 0], cut.triangles[:, 2] - cut.triangles[:, 0])
    assert (np.sum(facing * cut.normals[cut.triangle_surfel], axis=1) > 0).all()


def test_areas_that_were_given_are_shared_out():
    whole = floor().replace(areas=1.0)
    cut, _ = sf.divide_patches([whole, box()])
    assert cut.areas.sum() == pytest.approx(len(whole), rel=1e-12)
    whole.areas = None
    assert sf.divide_patches([whole, box()])[0].areas is None


def test_clouds_and_what_nothing_stands_on_stay_as_they_are():
    things = [floor(), shapes.sphere(162), box().transformed(np.diag([0.1, 0.1, 0.1, 1.0]) + 2 * np.eye(4, k=3))]
    assert all(a is b for a, b in zip(sf.divide_patches(things), things, strict=True))
    for wrong in ([], floor(), [floor(), None]):
        with pytest.raises(ValueError, match="objects: wanted"):
            sf.divide_patches(wrong)


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.slow
def test_no_light_beneath_a_box_that_is_an_object_of_its_own(solver, seed):
    with pytest.warns(UserWarning, match=r"object 0: walls of other objects stand on \d+ patches of it"):
        solver(sf.Scene([floor(), box()], [LAMP]), seed=seed)
    scene = sf.Scene(sf.divide_patches([floor(), box()]), [LAMP])
    solution = solver(scene, seed=seed)
    on_floor = solution.objects == 0
    mean = np.average(solution.irradiance[:, 0], weights=solution.surfels.areas)
    s = solution.surfels
    assert solution.irradiance[on_floor & beneath(s.points), 0].max() < 0.01 * mean
    rng = np.random.default_rng(seed)
    points = np.append(rng.uniform(-0.3, 0.7, (2000, 2)), np.zeros((2000, 1)), axis=1)
    normals = np.tile([0.0, 0.0, 1.0], (2000, 1))
    found = solution.irradiance_at(points, normals, "interpolated")[:, 0]
    under = beneath(points, -1e-6)
    assert np.count_nonzero(found[under] > 0.01 * mean) <= under.sum() / 500
    beside = beneath(points, 0.05) & ~beneath(points, 0.005)
    exact, _ = sf.reference_irradiance(scene, points[beside], normals[beside], 1024)
    off = np.linalg.norm(found[beside] - exact[:, 0]) / np.linalg.norm(exact[:, 0])
    assert off < 0.25  # in its shadow, too; with floors that go on beneath it was .6


def test_scene_files_are_cut_as_they_are_loaded(tmp_path):
    text = '[[object]]\nshape = "rectangle"\npatches = 2\nedge_u = [2, 0, 0]\nedge_v = [0, 2, 0]\n'
    (tmp_path / "floor.toml").write_text(text)
    wall = '[[object]]\nshape = "rectangle"\ncorner = [0.3, 0, 0]\nedge_u = [0, 2, 0]\nedge_v = [0, 0, 1]\n'
    (tmp_path / "wall.toml").write_text(text + wall)
    assert len(sf.load_scene(tmp_path / "floor.toml").surfels) == 4
    ground, _ = sf.load_scene(tmp_path / "wall.toml").objects
    assert len(ground) == 6
    assert ground.areas.sum() == pytest.approx(4.0, rel=1e-12)


def test_what_was_cut_is_not_found_to_be_cut_again():
    def block(low, high):
        corners = np.array([[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]) * np.subtract(high, low) + low
        return corners, [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]

    corners, faces = block([0, 0, 0], [3, 3, 3])
    room = sf.Surfels.from_mesh((corners, [face[::-1] for face in faces]), patch_area=0.1)
    pane = sf.Surfels.from_mesh(block([1.4, 0, 0], [1.401, 3, 3]), patch_area=0.1)  # both sides on the same patches
    cut = sf.divide_patches([room, pane])
    again = sf.divide_patches(cut)
    assert len(cut[0]) > len(room)
    assert [len(s) for s in again] == [len(s) for s in cut]


@pytest.mark.parametrize("lighting", ["local", "sky"])
def test_transfers_tell_of_walls_on_patches(lighting):
    """A strip of ground along a house had no light in a year of sun, without a word; solve told of it."""
    ground = sf.Surfels.from_mesh(([[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]], [[0, 1, 2, 3]]), patch_area=4.0)
    wall = sf.Surfels.from_mesh(([[-3, 0.5, 0], [3, 0.5, 0], [3, 0.5, 2], [-3, 0.5, 2]], [[0, 1, 2, 3]]))
    options = {"levels": 2, "rays": 16}
    with pytest.warns(UserWarning, match="object 0: walls of other objects stand on . patches of it"):
        sf.precompute_transfer(sf.Scene([ground, wall]), lighting, **options)
    cut = sf.Scene(sf.divide_patches([ground, wall]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.precompute_transfer(cut, lighting, **options)


def test_a_scene_is_no_list_of_objects():
    square = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    with pytest.raises(ValueError, match=r"at least one Surfels, got Scene; a Scene has one, its objects"):
        sf.divide_patches(sf.Scene([square]))
