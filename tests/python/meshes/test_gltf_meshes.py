"""Faces of glTF files: which ones, where they stand, in which order; and what is told of those that are not read."""

import sys

import numpy as np
import pytest

import surflux as sf
from gltf_squares import SQUARE, Square
from surflux.meshes.reading import read_mesh


def areas(mesh):
    a, b, c = mesh.vertices[mesh.indices.reshape(-1, 3)].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def normals(mesh):
    a, b, c = mesh.vertices[mesh.indices.reshape(-1, 3)].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def test_nothing_but_surflux_reads_them(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert areas(read_mesh(Square().save(tmp_path / "a.gltf"))).sum() == 1.0


def test_integers_are_what_they_stand_for(tmp_path):
    """KHR_mesh_quantization: shorts were coordinates of up to 32767."""
    short = Square(position=np.rint(SQUARE * 32767).astype("<i2"))
    short.header["extensionsRequired"] = ["KHR_mesh_quantization"]
    np.testing.assert_array_equal(read_mesh(short.save(tmp_path / "a.gltf")).vertices, SQUARE)
    plain = Square(position=(SQUARE * 7).astype("i1"))
    plain.header["accessors"][0]["normalized"] = False
    np.testing.assert_array_equal(read_mesh(plain.save(tmp_path / "a.gltf")).vertices, 7 * SQUARE)


@pytest.mark.parametrize("based", [True, False])
def test_sparse_accessors(tmp_path, based):
    square = Square()
    accessor = square.header["accessors"][0]
    rows, values = ([2], [[3, 3, 0]]) if based else ([1, 2, 3], [[1, 0, 0], [3, 3, 0], [0, 1, 0]])
    accessor["sparse"] = {
        "count": len(rows),
        "indices": {"bufferView": square.view(np.array(rows, "<u2")), "componentType": 5123},
        "values": {"bufferView": square.view(np.array(values, "<f4"))},
    }
    if not based:
        del accessor["bufferView"]
    assert areas(read_mesh(square.save(tmp_path / "a.gltf"))).sum() == 3.0
    accessor["sparse"]["count"] = 9
    with pytest.raises(sf.FileError, match=r"a\.gltf: no glTF of meshes: count of sparse is 9"):
        read_mesh(square.save(tmp_path / "a.gltf"))


@pytest.mark.parametrize("indexed", [True, False])
@pytest.mark.parametrize(
    ("mode", "corners", "wanted"),
    [
        (4, [0, 1, 2, 0, 2, 3], [[0, 1, 2], [0, 2, 3]]),
        (5, [0, 1, 3, 2], [[0, 1, 3], [1, 2, 3]]),
        (6, [0, 1, 2, 3], [[0, 1, 2], [0, 2, 3]]),
    ],
)
def test_triangles_strips_and_fans(tmp_path, indexed, mode, corners, wanted):
    """Fans were left out."""
    position, indices = (SQUARE, corners) if indexed else (SQUARE[corners], None)
    mesh = read_mesh(Square(position=position, places=None, indices=indices, mode=mode).save(tmp_path / "a.gltf"))
    np.testing.assert_array_equal(mesh.vertices[mesh.indices], SQUARE[np.ravel(wanted)])
    assert (normals(mesh)[:, 2] > 0.0).all()


def test_points_and_lines_are_left_out(tmp_path):
    square = Square()
    primitives = square.header["meshes"][0]["primitives"]
    primitives += [square.primitive | {"mode": mode} for mode in (0, 1, 2, 3)]
    assert areas(read_mesh(square.save(tmp_path / "a.gltf"))).sum() == 1.0
    del primitives[0]
    with pytest.raises(sf.FileError, match=r"a\.gltf: faces: wanted at least one, got none; points are not read of"):
        read_mesh(square.save(tmp_path / "a.gltf"))


def test_nodes_stand_in_the_order_of_the_file(tmp_path):
    """The last came first, and decals of a wall lay behind it."""
    square = Square()
    square.header["nodes"] = [{"mesh": 0, "translation": [k, 0, 0]} for k in range(4)] + [{"children": [2, 1]}]
    square.header["scenes"][0]["nodes"] = [3, 4, 0]
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_array_equal(mesh.vertices[::4, 0], [3, 2, 1, 0])
    del square.header["scenes"], square.header["scene"]  # then all nodes are shown
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_array_equal(mesh.vertices[::4, 0], [0, 3, 2, 1])


def test_decals_lie_before_the_wall_that_stands_first(tmp_path):
    square = Square(pbrMetallicRoughness={"baseColorFactor": [0.2, 0.2, 0.2, 1]})
    square.header["materials"].append({"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.9, 0.9, 1]}})
    square.header["meshes"].append({"primitives": [square.primitive | {"material": 1}]})
    square.header["nodes"] = [{"mesh": 0, "scale": [4, 4, 1]}, {"mesh": 1, "translation": [1, 1, 0]}]
    square.header["scenes"][0]["nodes"] = [0, 1]
    wall = sf.Surfels.from_mesh(square.save(tmp_path / "a.gltf"), 0.1)
    lit = sf.solve(sf.Scene([wall], [sf.Environment(1 / np.pi)]), rays=16)
    light = (lit.radiosity[:, 0] * lit.surfels.areas).sum()
    np.testing.assert_allclose(light, 15 * 0.2 + 1 * 0.9, rtol=0.01)


def test_nodes_turn_scale_and_mirror(tmp_path):
    square = Square()
    half = np.sqrt(0.5)
    parent = {"children": [1], "translation": [0, 0, 5], "rotation": [0, 0, half, half]}
    square.header["nodes"] = [parent, {"mesh": 0, "scale": [-2, 1, 1]}]
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 5], [0, -2, 5], [-1, -2, 5], [-1, 0, 5]], atol=1e-12)
    assert (normals(mesh)[:, 2] > 0.0).all()
    matrix = np.diag([1.0, -1.0, 1.0, 1.0])
    matrix[:3, 3] = [1, 2, 3]
    square.header["nodes"] = [{"mesh": 0, "matrix": matrix.T.ravel().tolist()}]
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_array_equal(mesh.vertices, SQUARE * [1, -1, 1] + [1, 2, 3])
    assert (normals(mesh)[:, 2] > 0.0).all()


@pytest.mark.parametrize("length", [1e-200, 0.1, 1.0, 5.0, 1e200])
def test_rotations_of_any_length_turn(tmp_path, length):
    """They were refused below .5 and above 2."""
    square = Square()
    square.header["nodes"] = [{"mesh": 0, "rotation": [0, 0, length, length]}]
    mesh = read_mesh(square.save(tmp_path / "a.gltf"))
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 0], [0, 1, 0], [-1, 1, 0], [-1, 0, 0]], atol=1e-12)


def test_matrices_have_a_last_row_up_to_rounding(tmp_path):
    """Those of programs that multiply floats were refused."""
    square = Square()
    matrix = np.diag([2.0, 2.0, 2.0, 1.0000001])
    matrix[3, :3] = [1e-7, -3e-8, 0]
    square.header["nodes"] = [{"mesh": 0, "matrix": matrix.T.ravel().tolist()}]
    np.testing.assert_array_equal(read_mesh(square.save(tmp_path / "a.gltf")).vertices, 2.0 * SQUARE)


@pytest.mark.parametrize(
    ("node", "reason"),
    [
        ({"rotation": [0, 0, 0, 0]}, "the rotation of a node is 0 0 0 0; wanted a unit quaternion"),
        ({"matrix": [*np.eye(4).ravel()[:3], 0.1, *np.eye(4).ravel()[4:]]}, "the matrix of a node is no translation, "),
    ],
)
def test_nodes_that_stand_nowhere_are_refused(tmp_path, node, reason):
    square = Square()
    square.header["nodes"][0] |= node
    with pytest.raises(sf.FileError, match=rf"a\.gltf: no glTF of meshes: {reason}"):
        read_mesh(square.save(tmp_path / "a.gltf"))


REQUIRED = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "FOO_bar"]


@pytest.mark.parametrize("name", [*REQUIRED, "KHR_texture_basisu"])
def test_what_a_file_requires_and_is_not_read_is_refused(tmp_path, name):
    square = Square()
    square.header["extensionsRequired"] = ["KHR_mesh_quantization", name]
    with pytest.raises(sf.FileError) as caught:
        read_mesh(square.save(tmp_path / "a.gltf"))
    assert str(caught.value) == f"{tmp_path / 'a.gltf'}: requires {name}, which is not read; wanted a file without it"


@pytest.mark.parametrize(
    ("node", "said"),
    [
        ({"extensions": {"EXT_mesh_gpu_instancing": {}}}, "EXT_mesh_gpu_instancing is not read"),
        ({"extensions": {"KHR_node_visibility": {"visible": False}}}, "KHR_node_visibility is not read"),
        ({"skin": 0, "weights": [0.0, 0.5]}, "skin and weights are not read"),
    ],
)
def test_what_changes_faces_and_is_not_read_is_told(tmp_path, node, said):
    square = Square()
    square.header["nodes"][0] |= node
    with pytest.warns(UserWarning, match=rf"a\.gltf: {said}: faces stand as they do without"):
        assert areas(read_mesh(square.save(tmp_path / "a.gltf"))).sum() == 1.0


def test_what_is_below_a_hidden_node_is_told(tmp_path):
    square = Square()
    hidden = {"children": [1], "extensions": {"KHR_node_visibility": {"visible": False}}}
    square.header["nodes"] = [hidden, {"mesh": 0}]
    with pytest.warns(UserWarning, match=r"a\.gltf: KHR_node_visibility is not read"):
        read_mesh(square.save(tmp_path / "a.gltf"))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("visibility", [{}, {"visible": True}])
def test_what_changes_nothing_is_not_told(tmp_path, visibility):
    square = Square()
    square.header["meshes"][0]["weights"] = [0.0, 0.0]
    square.header["nodes"][0]["extensions"] = {"KHR_node_visibility": visibility}
    read_mesh(square.save(tmp_path / "a.gltf"))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"indices": [0, 1, 4]}, "an index is 4; wanted one of 4 vertices of its primitive"),
        ({"indices": [0, 1, 2, 3]}, "4 corners of triangles; wanted three of each"),
        ({"places": SQUARE[:3, :2]}, "attributes of a primitive have different counts"),
    ],
)
def test_primitives_that_do_not_fit_are_refused(tmp_path, change, reason):
    with pytest.raises(sf.FileError) as caught:
        read_mesh(Square(**change).save(tmp_path / "a.gltf"))
    assert str(caught.value) == f"{tmp_path / 'a.gltf'}: no glTF of meshes: {reason}"


def test_names_of_buffers_are_encoded(tmp_path):
    """%20 is a blank; the file was not found."""
    (tmp_path / "my b.bin").write_bytes(SQUARE.tobytes())
    square = Square()
    square.header["buffers"][0]["uri"] = "my%20b.bin"
    assert areas(read_mesh(square.save(tmp_path / "a.gltf"))).sum() == 1.0
