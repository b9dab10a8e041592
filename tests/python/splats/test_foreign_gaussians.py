"""Files of Gaussians from elsewhere: what the formats allow is read, what is not is refused with the path and why."""

import base64
import json
import struct

import numpy as np
import pytest

import splat_drawing
import surflux as sf
from gltf_samples import SPLAT, glb, header_and_bytes

AS_IN_FILE = (0, 1, 0)


def part(n=4, degree=1, seed=0):
    """Attributes of n Gaussians, as a file has them."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(n, 4))
    found = {
        "POSITION": rng.normal(size=(n, 3)),
        "ROTATION": turns / np.linalg.norm(turns, axis=1, keepdims=True),
        "SCALE": rng.uniform(0.1, 0.2, (n, 3)),
        "OPACITY": rng.uniform(0.1, 0.9, n),
    }
    found |= {f"SH_DEGREE_{d}_COEF_{k}": rng.normal(size=(n, 3)) for d in range(degree + 1) for k in range(2 * d + 1)}
    return {name: array.astype("<f4") for name, array in found.items()}


def loaded(path, parts, up=AS_IN_FILE, **more):
    path.write_bytes(glb(*header_and_bytes(parts, **more)))
    return sf.load_gaussians(path, up=up)


def test_attributes_are_what_the_extension_says(tmp_path):
    given = part(degree=3)
    found = loaded(tmp_path / "a.glb", [given])
    np.testing.assert_array_equal(found.positions, given["POSITION"])
    np.testing.assert_array_equal(found.scales, given["SCALE"])
    np.testing.assert_array_equal(found.opacities, given["OPACITY"])
    np.testing.assert_array_equal(found.rotations, given["ROTATION"][:, [3, 0, 1, 2]])
    np.testing.assert_array_equal(found.harmonics[:, 7], given["SH_DEGREE_2_COEF_3"])
    np.testing.assert_array_equal(found.harmonics[:, 15], given["SH_DEGREE_3_COEF_6"])


def test_nodes_turn_move_and_scale(tmp_path):
    """By matrices and by translation, rotation and scale, one in the other: the covariance is M C C^T M^T, and what was
    seen from d is seen from M d."""
    half = np.sqrt(0.5)
    nodes = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [half, 0, 0, half], "scale": [2, 2, 2]},
        {"mesh": 0, "matrix": [0, 3, 0, 0, -3, 0, 0, 0, 0, 0, 3, 0, 4, 5, 6, 1]},
    ]
    given = part(degree=3)
    found = loaded(tmp_path / "a.glb", [given], nodes=nodes)
    outer = 2 * np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # a quarter turn about x
    inner = 3 * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])  # and one about z
    whole = outer @ inner
    expected = given["POSITION"] @ whole.T + outer @ [4, 5, 6] + [1, 2, 3]
    np.testing.assert_allclose(found.positions, expected, rtol=1e-6, atol=1e-6)
    here = splat_drawing.axes(given["ROTATION"][:, [3, 0, 1, 2]].astype(float)) * given["SCALE"][:, None, :]
    there = splat_drawing.axes(found.rotations) * found.scales[:, None, :]
    moved = whole @ here
    np.testing.assert_allclose(there @ there.transpose(0, 2, 1), moved @ moved.transpose(0, 2, 1), rtol=1e-5, atol=1e-6)
    plain = loaded(tmp_path / "b.glb", [given])
    for seed in range(5):
        d = np.random.default_rng(seed).normal(size=(4, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        before = splat_drawing.colors(plain.harmonics, d)
        np.testing.assert_allclose(splat_drawing.colors(found.harmonics, d @ whole.T / 6), before, atol=1e-6)


def test_small_integers_stand_for_fractions(tmp_path):
    exact = part(n=50)
    given = exact | {
        "ROTATION": np.rint(exact["ROTATION"] * 32767).astype("<i2"),
        "SCALE": np.rint(exact["SCALE"] * 65535).astype("<u2"),
        "OPACITY": np.rint(exact["OPACITY"] * 255).astype("u1"),
    }
    found = loaded(tmp_path / "a.glb", [given])
    np.testing.assert_allclose(found.rotations, exact["ROTATION"][:, [3, 0, 1, 2]], atol=1 / 32767)
    np.testing.assert_allclose(np.linalg.norm(found.rotations, axis=1), 1.0, atol=1e-6)
    np.testing.assert_allclose(found.scales, exact["SCALE"], atol=0.51 / 65535)
    np.testing.assert_allclose(found.opacities, exact["OPACITY"], atol=0.51 / 255)


def test_all_that_the_scene_shows_is_read(tmp_path):
    """Two primitives of different degree, a third in no scene, and a mesh without Gaussians."""
    parts = [part(3, 0, 1), part(5, 2, 2), part(7, 0, 3), part(2, 0, 4)]
    header, data = header_and_bytes(parts, nodes=[{"children": [2, 1]}, {"mesh": 0}, {"mesh": 1}, {"mesh": 2}])
    header["nodes"][0]["children"].append(4)
    header["nodes"].append({"mesh": 3})
    del header["meshes"][3]["primitives"][0]["extensions"]
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    found = sf.load_gaussians(tmp_path / "a.glb", up=AS_IN_FILE)
    assert (len(found), found.degree) == (8, 2)
    np.testing.assert_array_equal(found.positions, np.concatenate([parts[1]["POSITION"], parts[0]["POSITION"]]))
    assert not found.harmonics[5:, 1:].any()
    del header["scene"], header["scenes"]  # without any, all nodes count
    (tmp_path / "b.glb").write_bytes(glb(header, data))
    assert len(sf.load_gaussians(tmp_path / "b.glb")) == 15


def test_buffers_beside_the_file(tmp_path):
    header, data = header_and_bytes([part()])
    header["buffers"][0]["uri"] = "some%20data.bin"
    (tmp_path / "some data.bin").write_bytes(data)
    (tmp_path / "a.gltf").write_text(json.dumps(header))
    found = sf.load_gaussians(tmp_path / "a.gltf", up=AS_IN_FILE)
    np.testing.assert_array_equal(found.positions, part()["POSITION"])
    (tmp_path / "some data.bin").write_bytes(data[:-1])
    with pytest.raises(sf.FileError, match=r"is cut off: buffer 0 has \d+ of \d+ bytes$"):
        sf.load_gaussians(tmp_path / "a.gltf")


# --- what is refused -------------------------------------------------------------------------------------------------


def primitive(header):
    return header["meshes"][0]["primitives"][0]


def spoilt(header, *path, to):
    *path, last = path
    for key in path:
        header = header[key]
    if to is None:
        del header[last]
    else:
        header[last] = to


EXTENSION = ("meshes", 0, "primitives", 0, "extensions", SPLAT)
ATTRIBUTES = ("meshes", 0, "primitives", 0, "attributes")


@pytest.mark.parametrize(
    ("path", "to", "reason"),
    [
        (("asset", "version"), "1.0", "wanted glTF 2.0"),
        (("asset",), None, "has no 'asset'"),
        (("extensionsRequired",), ["KHR_x_spz"], "it needs KHR_x_spz, which is not read here"),
        ((*EXTENSION, "kernel"), "cube", "its kernel is 'cube'; wanted 'ellipse'"),
        ((*EXTENSION, "colorSpace"), "lin_p3", "its colorSpace is 'lin_p3'; wanted one of "),
        ((*EXTENSION, "extensions"), {"KHR_spz": {}}, "its Gaussians have KHR_spz, which is not read here"),
        (("meshes", 0, "primitives", 0, "mode"), 4, "its Gaussians are no points"),
        ((*ATTRIBUTES, f"{SPLAT}:OPACITY"), None, f"has no '{SPLAT}:OPACITY'"),
        ((*ATTRIBUTES, f"{SPLAT}:SH_DEGREE_1_COEF_2"), None, f"has no '{SPLAT}:SH_DEGREE_1_COEF_2'"),
        ((*ATTRIBUTES, f"{SPLAT}:SH_DEGREE_2_COEF_1"), 0, "its spherical harmonics are not whole degrees up to 3"),
        ((*ATTRIBUTES, "POSITION"), 99, "the index of accessors is 99; wanted a whole number from 0 to 7"),
        ((*ATTRIBUTES, f"{SPLAT}:SCALE"), 1, "an accessor is 'VEC4'; wanted VEC3"),
        (("accessors", 0, "count"), 3, "its attributes have different counts"),
        (("accessors", 0, "count"), 10**9, "1000000000 elements of an accessor are not in its buffer"),
        (("accessors", 0, "count"), 0, "0 elements of an accessor are not in its buffer"),
        (("accessors", 0, "sparse"), {}, "has no 'count'"),
        (("accessors", 0, "bufferView"), None, "an accessor has no bufferView"),
        (("accessors", 0, "componentType"), 5124, "has no 5124"),
        (("bufferViews", 0, "byteStride"), 4, "4 elements of an accessor are not in its buffer"),
        (("bufferViews", 0, "extensions"), {"EXT_meshopt": {}}, "a bufferView has EXT_meshopt, which is not read here"),
        (("buffers", 0, "byteLength"), 10**6, "is cut off: buffer 0 has "),
        (("buffers", 0, "uri"), "/etc/passwd", "wanted a file beside it, got '/etc/passwd'"),
        (("buffers", 0, "uri"), "https://a.b/c.bin", "wanted a file beside it"),
        (("buffers", 0, "uri"), "none.bin", "its buffer 'none.bin' is not there"),
        (("buffers", 0, "uri"), "data:application/octet-stream,abc", "a data URI is not base64"),
        (("buffers", 0, "uri"), "data:;base64,a", "a data URI is damaged"),
        (("nodes", 0, "scale"), [1, 1, 2], "a node stretches, skews or mirrors its Gaussians"),
        (("nodes", 0, "scale"), [-1, 1, 1], "a node stretches, skews or mirrors its Gaussians"),
        (("nodes", 0, "scale"), [0, 0, 0], "a node stretches, skews or mirrors its Gaussians"),
        (("nodes", 0, "matrix"), list(range(16)), "the matrix of a node is no translation, rotation and scale"),
        (("nodes", 0, "matrix"), [1, 2], "matrix: wanted 16 finite numbers"),
        (("nodes", 0, "rotation"), [0, 0, 0, 0], "the rotation of a node is 0 0 0 0; wanted a unit quaternion"),
        (("nodes", 0, "children"), [0], "node 0 is in the scene twice"),
        (("scene",), 1, "the index of scenes is 1; wanted a whole number from 0 to 0"),
    ],
)
def test_gltf_that_is_not_read(tmp_path, path, to, reason):
    header, data = header_and_bytes([part()])
    spoilt(header, *path, to=to)
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    with pytest.raises(sf.FileError) as caught:
        sf.load_gaussians(tmp_path / "a.glb")
    assert str(caught.value).startswith(f"{tmp_path / 'a.glb'}: no glTF of Gaussians: {reason}")


def test_gltf_without_gaussians(tmp_path):
    header, data = header_and_bytes([part()])
    del primitive(header)["extensions"]
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    with pytest.raises(sf.FileError, match=f": holds no Gaussians: nothing in its scene has {SPLAT}$"):
        sf.load_gaussians(tmp_path / "a.glb")


def test_two_codings_in_one_file(tmp_path):
    header, data = header_and_bytes([part(seed=1), part(seed=2)], nodes=[{"mesh": 0, "children": [1]}, {"mesh": 1}])
    header["meshes"][1]["primitives"][0]["extensions"][SPLAT]["colorSpace"] = "lin_rec709_display"
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    with pytest.raises(sf.FileError, match="some of its Gaussians are sRGB-coded and some linear"):
        sf.load_gaussians(tmp_path / "a.glb")


def test_a_small_file_does_not_become_a_large_cloud(tmp_path):
    """A thousand nodes that show the same mesh."""
    many = 1000
    nodes = [{"children": list(range(1, many))}, *({"mesh": 0} for _ in range(1, many))]
    (tmp_path / "a.glb").write_bytes(glb(*header_and_bytes([part(100)], nodes=nodes)))
    with pytest.raises(sf.FileError, match="its primitives share their data, which is not read here"):
        sf.load_gaussians(tmp_path / "a.glb")


@pytest.mark.parametrize(
    ("name", "values", "reason"),
    [
        ("POSITION", np.full((4, 3), np.nan), "positions: wanted finite numbers"),
        ("SCALE", np.full((4, 3), -1.0), "scales: wanted values in [0, 1e+30], got -1 at index (0, 0)"),
        ("ROTATION", np.zeros((4, 4)), "rotations: wanted vectors of non-zero length"),
        ("OPACITY", np.full(4, 1.5), "opacities: wanted values in [0, 1], got 1.5 at index 0"),
        ("SH_DEGREE_0_COEF_0", np.full((4, 3), np.inf), "harmonics: wanted finite numbers"),
    ],
)
def test_numbers_that_are_no_gaussians(tmp_path, name, values, reason):
    with pytest.raises(sf.FileError) as caught:
        loaded(tmp_path / "a.glb", [part() | {name: values.astype("<f4")}])
    assert str(caught.value).startswith(f"{tmp_path / 'a.glb'}: {reason}")


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "no glTF of Gaussians: Expecting value"),
        (b"glTF", "no glTF of Gaussians: is cut off"),
        (struct.pack("<4sII", b"glTF", 1, 12), "no glTF of Gaussians: is of version 1 of GLB; wanted 2"),
        (struct.pack("<4sII", b"glTF", 2, 12), "no glTF of Gaussians: has no JSON chunk"),
        (b"\xff\xfe{}", "no glTF of Gaussians: 'utf-8' codec can't decode byte"),
        (b"[]", "no glTF of Gaussians: "),
        (b'{"asset": {"version": NaN}}', "no glTF of Gaussians: NaN is no JSON"),
        (b"[" * 100_000, "no glTF of Gaussians: "),
    ],
)
def test_what_is_no_gltf(tmp_path, data, reason):
    (tmp_path / "a.glb").write_bytes(data)
    with pytest.raises(sf.FileError) as caught:
        sf.load_gaussians(tmp_path / "a.glb")
    assert str(caught.value).startswith(f"{tmp_path / 'a.glb'}: {reason}")


@pytest.mark.parametrize("ending", [".ply", ".glb", ".gltf"])
def test_a_file_that_is_cut_off_anywhere(tmp_path, ending):
    found = loaded(tmp_path / "whole.glb", [part(3, 0)])
    whole = found.save(tmp_path / f"a{ending}").read_bytes()
    for end in (*range(0, len(whole), 11), len(whole) - 1):
        (tmp_path / f"b{ending}").write_bytes(whole[:end])
        with pytest.raises(sf.FileError, match=f"b{ending}"):
            sf.load_gaussians(tmp_path / f"b{ending}")


def ply(path, *without, comment="", **more):
    """An ascii file of one Gaussian, without some properties and with others."""
    names = ["x", "y", "z", "opacity", *(f"{kind}_{k}" for kind in ("f_dc", "scale", "rot") for k in range(3)), "rot_3"]
    row = {name: 0.5 for name in names if name not in without} | more
    columns = "".join(f"property double {name}\n" for name in row)
    numbers = " ".join(map(str, row.values()))
    path.write_text(f"ply\nformat ascii 1.0\n{comment}element vertex 1\n{columns}end_header\n{numbers}\n")
    return path


@pytest.mark.parametrize(
    ("without", "more", "reason"),
    [
        (["f_dc_0"], {}, "holds no Gaussians: its vertices have no f_dc_0"),
        (["scale_2"], {}, "holds no Gaussians: its vertices have no scale_2"),
        ([], {"f_rest_0": 1}, "has 1 property f_rest_; wanted 0, 9, 24 or 45"),
        ([], {f"f_rest_{i}": 1 for i in range(1, 10)}, "has 9 properties f_rest_; wanted 0, 9, 24 or 45"),
        ([], {"opacity": "nan"}, "opacities: wanted finite numbers, got nan"),
        ([], {"scale_0": 1e300}, "scales: wanted finite numbers, got inf"),
        ([], {"scale_0": 100}, "scales: wanted values in [0, 1e+30], got 2.68812e+43"),
        ([], {f"rot_{i}": 0 for i in range(4)}, "rotations: wanted vectors of non-zero length"),
        ([], {"comment": 'comment surflux {"origin":"north"}\n'}, "origin: wanted real numbers, got text"),
        ([], {"comment": "comment surflux {\n"}, "the comments that begin with 'surflux' are no valid JSON"),
    ],
)
def test_ply_that_is_not_read(tmp_path, without, more, reason):
    path = ply(tmp_path / "a.ply", *without, **more)
    with pytest.raises(sf.FileError) as caught:
        sf.load_gaussians(path)
    assert str(caught.value).startswith(f"{path}: {reason}")


def test_points_and_solutions_are_no_gaussians(tmp_path):
    surfels = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0)
    with pytest.raises(sf.FileError, match="holds no Gaussians: its vertices have no f_dc_0"):
        sf.load_gaussians(surfels.save(tmp_path / "a.ply"))


def test_paths_that_are_none(tmp_path):
    found = loaded(tmp_path / "a.glb", [part()])
    for name in ("a.splat", "a", "glb"):
        with pytest.raises(ValueError, match=r"^path: wanted a name ending in .ply, .glb or .gltf, got "):
            found.save(tmp_path / name)
    (tmp_path / "a.splat").write_bytes(b"")
    with pytest.raises(sf.FileError, match=r"a.splat: cannot be read as Gaussians; wanted a name ending in .ply"):
        sf.load_gaussians(tmp_path / "a.splat")
    for name in ("none.glb", "none.ply"):
        with pytest.raises(sf.FileError, match=f"{name}: no such file"):
            sf.load_gaussians(tmp_path / name)
    (tmp_path / "folder.glb").mkdir()
    with pytest.raises(sf.FileError, match=r"folder.glb: is a folder"):
        sf.load_gaussians(tmp_path / "folder.glb")
    for name in ("none/a.glb", "none/a.ply", "none/a.gltf"):
        with pytest.raises(sf.FileError):
            found.save(tmp_path / name)
    for call in (sf.load_gaussians, found.save):
        with pytest.raises(ValueError, match=r"^path: wanted a path, got int"):
            call(3)


def test_up_is_for_gltf(tmp_path):
    found = loaded(tmp_path / "a.glb", [part()])
    path = found.save(tmp_path / "a.ply")
    for call in (lambda: found.save(path, up=(0, 1, 0)), lambda: sf.load_gaussians(path, up=(0, 1, 0))):
        with pytest.raises(ValueError, match=r"^up: a .ply file has the coordinates of the scene"):
            call()
    for call in (lambda up: found.save(tmp_path / "b.glb", up=up), lambda up: sf.load_gaussians(path, up=up)):
        with pytest.raises(ValueError, match=r"^up: "):
            call([0, 0, 0])


def test_a_data_uri_may_be_of_any_kind(tmp_path):
    header, data = header_and_bytes([part()])
    header["buffers"][0]["uri"] = "data:application/gltf-buffer;base64," + base64.b64encode(data).decode()
    (tmp_path / "a.gltf").write_text("\ufeff" + json.dumps(header))  # and files may begin with a byte order mark
    assert len(sf.load_gaussians(tmp_path / "a.gltf")) == 4
