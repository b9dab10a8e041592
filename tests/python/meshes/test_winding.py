"""Faces that are wound against those beside them, and boxes with one side turned inwards."""

import warnings
from itertools import pairwise

import numpy as np
import pytest

import surflux as sf
from surflux.meshes.reading import read_mesh
from surflux.meshes.winding import faces_against, opposite_edges, wound_alike
from surflux.scenes import shapes

CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
SIDES = [[2, 3, 1, 0], [4, 5, 7, 6], [0, 1, 5, 4], [3, 2, 6, 7], [2, 0, 4, 6], [1, 3, 7, 5]]


def rotation(seed):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


def box(size, seed, side):
    """Corners and faces of a box, turned by chance but for seed 0, with one side that faces inwards."""
    faces = [face[::-1] if k == side else face for k, face in enumerate(SIDES)]
    return CORNERS * size @ (rotation(seed).T if seed else np.eye(3)), faces


@pytest.mark.filterwarnings("ignore:.*wound against:UserWarning")
@pytest.mark.parametrize("side", range(6))
@pytest.mark.parametrize("seed", range(6))
def test_a_side_of_a_box_that_faces_inwards(side, seed):
    """Its normals meet those beside it at 90 degrees: which were neighbours was chance, and none in line with axes."""
    size = np.array([1, 1, 1]) if seed == 0 else np.random.default_rng(seed).uniform(0.5, 2, 3)
    mesh = box(size, seed, side)
    patches = sf.Surfels.from_mesh(mesh, patch_area=0.01)
    np.testing.assert_array_equal(sf.inward_patches(patches) > 0, patches.faces == side)
    # A cloud of it.
    corners, faces = mesh
    a, b, c = corners[faces[side]][:3]
    normal = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    points = sf.Surfels.sample_mesh(mesh, 3000, seed)
    wrong = (np.abs((points.points - a) @ normal) < 1e-9) & (points.normals @ normal > 0.99)
    assert np.mean(sf.facing(points.points, points.normals).turned != wrong) < 0.002


def test_faces_that_are_wound_against_the_others_are_told(tmp_path):
    """They stayed black, without a word; who has both sides of them, or has them turned, need not be told."""
    corners, faces = box([1, 1, 1], 0, 4)
    told = r"^mesh: 1 of 6 faces is wound against .* faces the other side \(from 0: 4\);"
    with pytest.warns(UserWarning, match=told):
        patches = sf.Surfels.from_mesh((corners, faces), patch_area=0.01)
    np.testing.assert_array_equal(sf.inward_patches(patches, rooms=True) > 0, patches.faces == 4)
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    (tmp_path / "box.obj").write_text("\n".join(lines))
    scene = tmp_path / "scene.toml"
    sheets = 'two_sided = "sheets"'  # a box is none
    for option, told in (("", True), (sheets, True), ("orient = true", False), ("two_sided = true", False)):
        scene.write_text(f'[[object]]\nfile = "box.obj"\nkind = "mesh"\n{option}\n')
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            made = sf.load_scene(scene).surfels
        assert any("wound against" in str(w.message) for w in found) == told
        outwards = np.sum((made.points - 0.5) * made.normals, axis=1) > 0
        assert np.count_nonzero(outwards) == (6 if "true" in option else 5)  # six patches: too few to ask rays about
    for function in (
        lambda: sf.Surfels.from_mesh(tmp_path / "box.obj", two_sided="sheets"),
        lambda: sf.Surfels.sample_mesh(tmp_path / "box.obj", 60),
    ):
        with pytest.warns(UserWarning, match=r"box\.obj: 1 of 6 faces is wound"):
            function()


@pytest.mark.parametrize("seed", range(6))
def test_of_two_halves_the_one_that_faces_inwards_is_against(seed):
    """No side has more area; both stayed as they were, and half of the box black."""
    wrong = np.zeros(6, bool)
    wrong[np.array([0, 2, 4]) + np.random.default_rng(seed).integers(0, 2, 3)] = True  # one of each two alike
    faces = [face[::-1] if w else face for face, w in zip(SIDES, wrong, strict=True)]
    corners = (CORNERS * [1.0, 0.7, 2.0] + 5.0) @ rotation(seed + 1).T
    for vertices in (corners, corners.astype(np.float32), corners.round(6)):
        np.testing.assert_array_equal(faces_against(read_mesh((vertices, faces))), wrong)


def test_of_two_halves_of_what_is_open_none_is():
    """Which slope of a valley is the wrong one, nothing tells."""
    valley = [[0, -1, 1], [1, -1, 1], [1, 0, 0], [0, 0, 0], [1, 1, 1], [0, 1, 1]]
    assert not faces_against(read_mesh((valley, [[0, 1, 2, 3], [3, 2, 4, 5][::-1]]))).any()


def test_polygons_are_turned_over_and_others_stay():
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1.5, 0, 0], [1.5, 0.5, 0], [1.5, 1, 0]]
    for pentagon, wrong in (([1, 4, 5, 6, 2], 0), ([2, 6, 5, 4, 1], 1)):
        mesh, turned = wound_alike(read_mesh((corners, [[0, 1, 2, 3], pentagon])))
        assert turned == wrong
        assert mesh.indices.tolist() == [0, 1, 2, 3, 1, 4, 5, 6, 2]


@pytest.mark.parametrize("side", range(6))
def test_faces_of_a_box_in_any_layout(side):
    corners, faces = box([1, 2, 3], 0, side)
    wanted = np.arange(6) == side
    mesh = read_mesh((corners, faces))
    np.testing.assert_array_equal(faces_against(mesh), wanted)
    assert len(opposite_edges(mesh)) == 4
    thin = read_mesh((corners, [*faces, [faces[0][0], faces[0][1], faces[0][1]]]))  # no area, on an edge
    np.testing.assert_array_equal(faces_against(thin), [*wanted, False])
    apart = corners[np.concatenate(faces)], np.arange(24).reshape(6, 4)  # as in STL, no corner is shared
    np.testing.assert_array_equal(faces_against(read_mesh(apart)), wanted)


@pytest.mark.parametrize("seed", range(3))
def test_faces_of_several_bodies(seed):
    """Each by itself: a ball, whose cap is turned over, and one that is all inside out, which no edge can tell."""
    ball, triangles = shapes.icosphere(3)
    cap = ball[triangles].mean(axis=1) @ rotation(seed + 1)[0] > 0.4
    first = np.where(cap[:, None], triangles[:, ::-1], triangles)
    second = triangles[:, ::-1] + len(ball)
    order = np.random.default_rng(seed).permutation(2 * len(triangles))
    mesh = read_mesh((np.vstack([ball, ball + 3.0]), np.vstack([first, second])[order]))
    np.testing.assert_array_equal(faces_against(mesh), np.concatenate([cap, np.zeros(len(triangles), bool)])[order])


def test_what_has_no_two_sides():
    """A Moebius strip; two faces of one size; three faces at one edge."""
    turn = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    across = np.stack([np.cos(turn / 2) * np.cos(turn), np.cos(turn / 2) * np.sin(turn), np.sin(turn / 2)], axis=1)
    middle = np.stack([3 * np.cos(turn), 3 * np.sin(turn), 0 * turn], axis=1)
    strip = [[k, k + 1, k + 13, k + 12] for k in range(11)] + [[11, 12, 0, 23]]
    moebius = read_mesh((np.vstack([middle - across, middle + across]), strip))
    assert not faces_against(moebius).any()
    assert len(opposite_edges(moebius)) > 0
    squares = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [1, 0, 1], [1, 1, 1]]
    assert not faces_against(read_mesh((squares, [[0, 1, 2, 3], [1, 2, 5, 4]]))).any()
    assert not faces_against(read_mesh((squares, [[0, 1, 2, 3], [1, 2, 5, 4], [1, 2, 7, 6]]))).any()


def polygons(*faces):
    """A mesh of faces by their corners: those at one place count as one."""
    offsets = np.cumsum([0, *(len(face) for face in faces)])
    return np.concatenate(faces).astype(np.float64), [list(range(*ends)) for ends in pairwise(offsets)]


def test_bodies_that_touch_and_are_cut_otherwise_stay_as_they_are():
    """Below a leg the floor is cut in two, as sides of it are: it was taken for a part of these, and turned over."""
    below = [[(0, 0, 0), (0.5, 0, 0), (0.5, 1, 0), (0, 1, 0)], [(0.5, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 1, 0)]]
    around = [
        [(-2, -2, 0), (3, -2, 0), (1, 0, 0), (0, 0, 0)],
        [(3, -2, 0), (3, 3, 0), (1, 1, 0), (1, 0, 0)],
        [(3, 3, 0), (-2, 3, 0), (0, 1, 0), (1, 1, 0)],
        [(-2, 3, 0), (-2, -2, 0), (0, 0, 0), (0, 1, 0)],
    ]
    front = [[(x, 0, 0), (x + 0.5, 0, 0), (x + 0.5, 0, 4), (x, 0, 4)] for x in (0.0, 0.5)]
    back = [[(x + 0.5, 1, 0), (x, 1, 0), (x, 1, 4), (x + 0.5, 1, 4)] for x in (0.0, 0.5)]
    sides = [[(1, 0, 0), (1, 1, 0), (1, 1, 4), (1, 0, 4)], [(0, 1, 0), (0, 0, 0), (0, 0, 4), (0, 1, 4)]]
    mesh = read_mesh(polygons(*below, *around, *front, *back, *sides))
    assert not np.any(faces_against(mesh))
    # What is wound against all around it is told as before.
    turned = read_mesh(polygons(*below, around[0][::-1], *around[1:], *front, *back, *sides))
    assert np.flatnonzero(faces_against(turned)).tolist() == [2]


def test_a_solution_in_gltf_is_wound_as_it_was(tmp_path):
    pytest.importorskip("trimesh")
    floor = sf.Surfels.from_mesh(shapes.box(2.0, 1)[:2], 0.2)
    corners, faces, _ = shapes.box(0.5, 1)
    leg = sf.Surfels.from_mesh((np.add(corners, [0.7, 0.7, 2.0]), faces), 0.05)
    scene = sf.Scene(sf.divide_patches([floor, leg]), [sf.PointLight([0.4, 0.5, 4], 10.0), sf.Environment(0.1)])
    solution = sf.solve(scene, rays=16)
    assert not np.any(faces_against(read_mesh(solution.save(tmp_path / "lit.glb"))))
