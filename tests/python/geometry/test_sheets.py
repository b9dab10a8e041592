"""Backs for open sheets alone: two_sided="sheets"."""

import numpy as np
import pytest

import surflux as sf
from surflux.geometry.sheets import sheet_faces
from surflux.meshes.reading import read_mesh
from surflux.scenes import shapes


def together(*meshes):
    """Meshes (vertices, faces) in one, with the number of the mesh of each face."""
    first = np.cumsum([0] + [len(vertices) for vertices, _ in meshes])
    faces = [[int(i) + start for i in face] for (_, part), start in zip(meshes, first, strict=False) for face in part]
    owner = np.repeat(np.arange(len(meshes)), [len(part) for _, part in meshes])
    return (np.concatenate([vertices for vertices, _ in meshes]), faces), owner


def cap(height):
    """Of a unit sphere of triangles, corners apart as many files have them, what lies above a height."""
    corners, faces = shapes.icosphere(4)
    above = corners[faces].mean(axis=1)[:, 2] > height
    return corners[faces[above]].reshape(-1, 3), np.arange(3 * above.sum()).reshape(-1, 3)


BOX = np.array([[x, y, z] for x in (4.0, 7.0) for y in (0.0, 3.0) for z in (0.0, 0.02)])
THIN_BOX = BOX, [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
LEAF = np.array([[0, 0, 9], [1, 0, 9], [1, 1, 9.2], [0, 1, 9.0]]), [[0, 1, 2], [0, 2, 3]]


def test_sheets_are_what_does_not_close():
    """Caps of a sphere: vector area pi (1 - h^2), area 2 pi (1 - h), so (1 + h) / 2 of it."""
    mesh, owner = together(cap(0.2), (cap(-0.2)[0] + [0, 0, 4], cap(-0.2)[1]), THIN_BOX, LEAF)
    sheet = sheet_faces(read_mesh(mesh))
    for k, is_one in enumerate((True, False, False, True)):
        assert np.all(sheet[owner == k] == is_one)


def test_pieces_hang_together_by_the_places_of_corners():
    """Two halves of a box, each a sheet by itself, are closed as one piece, though they share no vertex."""
    low, high = ([THIN_BOX[1][k] for k in part] for part in ([0, 2, 5], [1, 3, 4]))
    apart, _ = together((BOX, low), (BOX + np.array([0, 0, 1]), high))
    assert sheet_faces(read_mesh(apart)).all()
    joined, _ = together((BOX, low), (BOX, high))
    assert not sheet_faces(read_mesh(joined)).any()


def test_long_chains_of_faces_are_one_piece():
    n = 3000  # an open tube of quadrilaterals, whose faces stand in no order
    turn = np.tile(2.0 * np.pi / 3.0 * np.arange(3), n)
    vertices = np.column_stack([np.cos(turn), np.sin(turn), np.repeat(np.arange(n), 3)])
    faces = [
        [3 * k + i, 3 * k + (i + 1) % 3, 3 * k + 3 + (i + 1) % 3, 3 * k + 3 + i] for k in range(n - 1) for i in range(3)
    ]
    order = np.random.default_rng(0).permutation(len(faces))
    assert not sheet_faces(read_mesh((vertices, [faces[k] for k in order]))).any()


def test_degenerate_faces_are_no_sheets():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5], [6, 5, 5], [6, 6, 5]], float)
    assert sheet_faces(read_mesh((vertices, [[0, 1, 2], [3, 4, 5]]))).tolist() == [False, True]


def test_backs_of_sheets_alone():
    mesh, _ = together(THIN_BOX, LEAF)
    one, both = sf.Surfels.from_mesh(mesh, 0.3), sf.Surfels.from_mesh(mesh, 0.3, two_sided="sheets")
    leaf = np.flatnonzero(one.points[:, 2] > 8)
    n = len(one)
    assert 0 < len(leaf) < n
    assert len(both) == n + len(leaf)
    assert np.array_equal(both.points, np.vstack([one.points, one.points[leaf]]))
    assert np.array_equal(both.normals, np.vstack([one.normals, -one.normals[leaf]]))
    assert both.areas.sum() == pytest.approx(one.areas.sum() + one.areas[leaf].sum())
    edges = both.triangles[:, 1:] - both.triangles[:, :1]
    facing = np.cross(edges[:, 0], edges[:, 1])
    assert np.all(np.sum(facing * both.normals[both.triangle_surfel], axis=1) > 0)
    assert np.all(np.diff(both.triangle_surfel.astype(int)) >= 0)
    closed = sf.Surfels.from_mesh(THIN_BOX, two_sided="sheets")
    assert len(closed) == 6


def test_light_comes_to_both_sides_of_a_sheet():
    s = sf.Surfels.from_mesh(LEAF, reflectance=0.25, two_sided="sheets")
    solution = sf.solve(sf.Scene([s], lights=[sf.Environment(1.0)]))
    assert solution.irradiance.min() > 3.0


def test_what_two_sided_may_be():
    with pytest.raises(ValueError, match=r'^two_sided: wanted True, False or "sheets", got \'leaves\'$'):
        sf.Surfels.from_mesh(LEAF, two_sided="leaves")


def test_in_a_scene_file(tmp_path):
    (tmp_path / "leaf.obj").write_text("v 0 0 9\nv 1 0 9\nv 1 1 9.2\nv 0 1 9\nf 1 2 3\nf 1 3 4\n")
    entry = '[[object]]\nfile = "leaf.obj"\nkind = "mesh"\n'
    path = tmp_path / "scene.toml"
    path.write_text(entry + 'two_sided = "sheets"')
    assert len(sf.load_scene(path).surfels) == 4
    assert len(sf.load_scene(path, surfels=4).surfels) == 4
    path.write_text(entry + 'two_sided = "leaves"')
    wanted = r'scene\.toml \(object 1, two_sided\): wanted True, False or "sheets", got \'leaves\'$'
    with pytest.raises(sf.FileError, match=wanted):
        sf.load_scene(path)
    path.write_text('[[object]]\nshape = "sphere"\ntwo_sided = "sheets"')
    with pytest.raises(sf.FileError, match=r"\(object 1, two_sided\): wanted True or False, got 'sheets'$"):
        sf.load_scene(path)
