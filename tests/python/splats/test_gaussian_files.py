"""Files of Gaussians: what is saved comes back, and other readers find in it what the formats say."""

import base64
import json
import struct

import numpy as np
import pytest
import trimesh
from trimesh.exchange.gltf import extensions as trimesh_extensions
from trimesh.exchange.gltf import validate

import splat_drawing
import surflux as sf
from gltf_samples import SPLAT, glb_parts

NAMES = ("positions", "scales", "rotations", "opacities", "harmonics")
ENDINGS = (".ply", ".glb", ".gltf")


def some(n=7, degree=3, at=(0, 0, 0), **more):
    """Gaussians of random numbers, of the size of a hand."""
    rng = np.random.default_rng(n)
    arrays = rng.normal(size=(n, 3)) * 0.1 + at, rng.uniform(0.001, 0.05, (n, 3)), rng.normal(size=(n, 4))
    harmonics = 0.3 * rng.normal(size=(n, (degree + 1) ** 2, 3))
    return sf.Gaussians(*arrays, rng.uniform(0.1, 0.99, n), harmonics, **more)


def directions(n):
    found = np.random.default_rng(5).normal(size=(n, 3))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


# --- there and back --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", range(4))
@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_saved_comes_back(tmp_path, ending, degree):
    gaussians = some(degree=degree)
    path = gaussians.save(tmp_path / f"a{ending}")
    back = sf.load_gaussians(path)
    assert (len(back), back.degree, back.color_space) == (7, degree, "srgb")
    as_float = {name: getattr(gaussians, name).astype(np.float32) for name in NAMES}
    for name in ("positions", "rotations", "harmonics"):
        np.testing.assert_array_equal(getattr(back, name), as_float[name])
    if ending == ".ply":  # which has logarithms and logits: those are floats, off by 2^-24 of themselves
        np.testing.assert_allclose(back.scales, gaussians.scales, rtol=7 * 2**-24)
        np.testing.assert_allclose(back.opacities, gaussians.opacities, rtol=5 * 2**-24)
    else:
        np.testing.assert_array_equal(back.scales, as_float["scales"])
        np.testing.assert_array_equal(back.opacities, as_float["opacities"])
    again = back.save(tmp_path / f"again{ending}")
    assert again.read_bytes() == path.read_bytes()


def test_formats_hold_the_same(tmp_path):
    gaussians = some()
    ply, glb, gltf = (sf.load_gaussians(gaussians.save(tmp_path / f"a{ending}")) for ending in ENDINGS)
    for name in NAMES:
        np.testing.assert_array_equal(getattr(glb, name), getattr(gltf, name))
        np.testing.assert_allclose(getattr(ply, name), getattr(glb, name), rtol=5e-7)


@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_linear_colours_say_so(tmp_path, ending):
    gaussians = some(color_space="linear")
    path = gaussians.save(tmp_path / f"a{ending}")
    assert b'"colorSpace":"lin_rec709_display"' in path.read_bytes()
    assert sf.load_gaussians(path).color_space == "linear"
    with pytest.raises(ValueError, match=r"^path: linear colours fit into .glb and .gltf alone"):
        gaussians.save(tmp_path / "a.ply")


@pytest.mark.parametrize("ending", ENDINGS)
def test_survey_coordinates_keep_millimetres(tmp_path, ending):
    """Floats at 5e6 are half a metre apart; from an origin amid a metre they are 6e-8."""
    at = [5.0e6 + 0.3, 4.2e5, -812.7]
    gaussians = some(at=at)
    path = gaussians.save(tmp_path / f"a{ending}")
    back = sf.load_gaussians(path)
    np.testing.assert_allclose(back.positions, gaussians.positions, rtol=0, atol=3e-8)
    if ending == ".ply":
        header = path.read_bytes().split(b"end_header")[0].decode()
        origin = json.loads(header.split("comment surflux ")[1].splitlines()[0])["origin"]
        stored = trimesh.load(path).vertices
    else:
        text = path.read_bytes()
        header = json.loads(text) if ending == ".gltf" else glb_parts(text)[0]
        x, y, z = header["nodes"][0]["matrix"][12:15]
        origin = [x, -z, y]
        stored = trimesh.load(path, file_type=ending[1:]).geometry.popitem()[1].vertices
    assert np.abs(np.subtract(origin, at)).max() < 0.5
    assert np.abs(stored).max() < 1.0
    np.testing.assert_allclose(stored + np.array(origin), gaussians.positions, rtol=0, atol=3e-8)
    again = back.save(tmp_path / f"again{ending}")
    np.testing.assert_array_equal(sf.load_gaussians(again).positions, back.positions)


def test_coordinates_that_floats_hold_stay(tmp_path):
    path = some(at=[20, -8, 3]).save(tmp_path / "a.ply")
    assert b"origin" not in path.read_bytes()
    np.testing.assert_array_equal(trimesh.load(path).vertices, some(at=[20, -8, 3]).positions.astype(np.float32))
    path = some(at=[20, -8, 3]).save(tmp_path / "a.glb", up=[0, 1, 0])
    assert "matrix" not in glb_parts(path.read_bytes())[0]["nodes"][0]


def test_extremes_are_finite_in_the_file(tmp_path):
    """Opacities of 0 and 1 have no logit, and a scale of 0 has no logarithm."""
    one = [[0.0, 0, 0]] * 2, [[0.0, 1e-30, 1e30], [1, 1, 1]], [[1.0, 0, 0, 0]] * 2, [0.0, 1.0], np.zeros((2, 1, 3))
    back = sf.load_gaussians(sf.Gaussians(*one).save(tmp_path / "a.ply"))
    np.testing.assert_allclose(back.opacities, [0.0, 1.0], atol=1.2e-7)
    np.testing.assert_allclose(back.scales[0], [0.0, 1e-30, 1e30], rtol=2e-4, atol=1e-37)
    back = sf.load_gaussians(sf.Gaussians(*one).save(tmp_path / "a.glb"))
    assert back.opacities.tolist() == [0.0, 1.0]
    assert back.scales[0, 0] == 0.0


# --- PLY, as the program of Kerbl and others has it ------------------------------------------------------------------

COLUMNS = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", *(f"f_rest_{i}" for i in range(45))]
COLUMNS += ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]


def test_ply_is_what_other_programs_read(tmp_path):
    """Columns in the order of save_ply of scene/gaussian_model.py, which viewers take as a block of floats; the numbers
    by trimesh."""
    gaussians = some()
    path = gaussians.save(tmp_path / "a.ply")
    header, body = path.read_bytes().split(b"end_header\n")
    lines = header.decode().splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    assert lines[-len(COLUMNS) - 1 :] == ["element vertex 7", *(f"property float {name}" for name in COLUMNS)]
    assert len(body) == 7 * 4 * len(COLUMNS)
    found = trimesh.load(path).metadata["_ply_raw"]["vertex"]["data"]
    table = {name: np.asarray(found[name], np.float64).ravel() for name in COLUMNS}
    close = {"rtol": 1e-6, "atol": 1e-7}
    for k, name in enumerate(("scale_0", "scale_1", "scale_2")):
        np.testing.assert_allclose(np.exp(table[name]), gaussians.scales[:, k], **close)
    np.testing.assert_allclose(1 / (1 + np.exp(-table["opacity"])), gaussians.opacities, **close)
    for k in range(4):
        np.testing.assert_allclose(table[f"rot_{k}"], gaussians.rotations[:, k], **close)
    # features_rest: (n, 15, 3) transposed to (n, 3, 15) and flattened: all of red, then green, then blue.
    for channel in range(3):
        np.testing.assert_allclose(table[f"f_dc_{channel}"], gaussians.harmonics[:, 0, channel], **close)
        for k in range(15):
            wanted = gaussians.harmonics[:, k + 1, channel]
            np.testing.assert_allclose(table[f"f_rest_{15 * channel + k}"], wanted, **close)
    thin = splat_drawing.axes(gaussians.rotations)[np.arange(7), :, gaussians.scales.argmin(axis=1)]
    np.testing.assert_allclose(np.stack([table[name] for name in ("nx", "ny", "nz")], 1), thin, **close)


def test_ply_of_another_program(tmp_path):
    """Ascii, in another order, with more columns, quaternions of any length, and opacities that are certain."""
    names = ["opacity", *COLUMNS[:3], *COLUMNS[6:9], *COLUMNS[58:], "scale_0", "scale_1", "scale_2", "red"]
    row = [np.inf, 1, 2, 3, 0.5, 0, -0.5, 2, 0, 0, 0, 0, -1, -2, 7]
    text = "\n".join(["ply", "format ascii 1.0", "element vertex 1", *(f"property double {n}" for n in names)])
    path = tmp_path / "a.ply"
    path.write_text(f"{text}\nend_header\n{' '.join(map(str, row))}\n")
    found = sf.load_gaussians(path)
    assert (found.opacities.tolist(), found.positions.tolist()) == ([1.0], [[1, 2, 3]])
    assert found.rotations.tolist() == [[1.0, 0, 0, 0]]
    np.testing.assert_allclose(found.scales, [np.exp([0, -1, -2])])
    np.testing.assert_allclose(found.colors_towards([0, 0, 1]), [0.5 + splat_drawing.C0 * np.array([0.5, 0, -0.5])])


# --- glTF, as KHR_gaussian_splatting has it --------------------------------------------------------------------------


@pytest.fixture
def attributes_of(monkeypatch):
    """What trimesh reads of the attributes of a file with the extension: {name: array}, and the scene."""
    met = {}

    def handler(context):
        accessors = context["accessors"]
        met.update({name: accessors[k] for name, k in context["primitive"]["attributes"].items()})

    monkeypatch.setitem(trimesh_extensions._handlers.setdefault("primitive_preprocess", {}), SPLAT, handler)

    def read(path):
        met.clear()
        scene = trimesh.load(path)
        return dict(met), scene

    return read


@pytest.mark.parametrize("color_space", ["srgb", "linear"])
@pytest.mark.parametrize("ending", [".glb", ".gltf"])
def test_gltf_is_what_other_programs_read(tmp_path, attributes_of, ending, color_space):
    gaussians = some(color_space=color_space)
    found, scene = attributes_of(gaussians.save(tmp_path / f"a{ending}"))
    degrees = [(degree, n) for degree in range(4) for n in range(2 * degree + 1)]
    wanted = {f"{SPLAT}:SH_DEGREE_{d}_COEF_{n}": gaussians.harmonics[:, k] for k, (d, n) in enumerate(degrees)}
    w, *xyz = gaussians.rotations.T
    wanted |= {f"{SPLAT}:ROTATION": np.stack([*xyz, w], 1), f"{SPLAT}:SCALE": gaussians.scales}
    wanted |= {f"{SPLAT}:OPACITY": gaussians.opacities, "POSITION": gaussians.positions}
    assert set(found) == {*wanted, "COLOR_0"}
    for name, values in wanted.items():
        np.testing.assert_array_equal(np.reshape(found[name], values.shape), values.astype(np.float32))
    # COLOR_0 is linear, of the harmonic of degree 0, with the opacity.
    color = np.clip(0.5 + splat_drawing.C0 * gaussians.harmonics[:, 0], 0.0, 1.0)
    if color_space == "srgb":
        color = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(found["COLOR_0"][:, :3], color, atol=1e-6)
    np.testing.assert_array_equal(found["COLOR_0"][:, 3], gaussians.opacities.astype(np.float32))
    # Whoever does not know the extension: a cloud in colours, y up.
    (cloud,) = scene.dump()
    assert isinstance(cloud, trimesh.PointCloud)
    x, y, z = gaussians.positions.T
    np.testing.assert_allclose(cloud.vertices, np.stack([x, z, -y], 1), atol=1e-7)
    np.testing.assert_allclose(cloud.colors[:, :3], 255 * color, atol=1.0)


def test_glb_has_the_structure_of_gltf(tmp_path):
    gaussians = some(n=5, degree=1)
    header, data = glb_parts(gaussians.save(tmp_path / "a.glb").read_bytes())
    validate(header)  # against Khronos' schema of glTF 2.0, by trimesh and jsonschema
    assert header["extensionsUsed"] == [SPLAT]
    assert "extensionsRequired" not in header  # points are better than nothing
    (primitive,) = header["meshes"][0]["primitives"]
    assert primitive["mode"] == 0
    assert primitive["extensions"] == {SPLAT: {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}}
    assert header["buffers"] == [{"byteLength": len(data)}]
    end = 0
    for accessor, view in zip(header["accessors"], header["bufferViews"], strict=True):
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        assert (accessor["componentType"], accessor["count"]) == (5126, 5)
        assert (view["buffer"], view["byteOffset"], view["byteLength"]) == (0, end, 5 * 4 * width)
        assert view["byteOffset"] % 4 == 0
        end += view["byteLength"]
    assert end == len(data)
    position = header["accessors"][primitive["attributes"]["POSITION"]]
    stored = np.frombuffer(data, "<f4", 15).reshape(5, 3)
    assert position["min"] == stored.min(axis=0).tolist()
    assert position["max"] == stored.max(axis=0).tolist()


def test_a_glb_that_its_lengths_cannot_hold(tmp_path, monkeypatch):
    monkeypatch.setattr("surflux.scans.gltf.GLB_MOST", 1000)
    with pytest.raises(ValueError, match=r"^path: a .glb file has up to 4 GiB, got 0.0; .gltf and .ply hold more$"):
        some().save(tmp_path / "a.glb")
    assert list(tmp_path.iterdir()) == []


def test_gltf_has_its_buffer_inside(tmp_path):
    gaussians = some(n=3, degree=0)
    header = json.loads(gaussians.save(tmp_path / "a.gltf").read_text())
    validate(header)
    (buffer,) = header["buffers"]
    kind, packed = buffer["uri"].split(",")
    assert kind == "data:application/octet-stream;base64"
    data = base64.b64decode(packed)
    assert len(data) == buffer["byteLength"]
    np.testing.assert_array_equal(struct.unpack_from("<9f", data), gaussians.positions.ravel().astype(np.float32))


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (0.6, 0.0, 0.8), (0, 0, -2)])
def test_what_is_up_is_y_in_gltf(tmp_path, up):
    """The node turns it there; read with another direction up, Gaussians are turned, colours and all."""
    gaussians = some(n=20)
    path = gaussians.save(tmp_path / "a.glb", up=up)
    node = glb_parts(path.read_bytes())[0]["nodes"][0]
    turn = np.array(node.get("matrix", np.eye(4).ravel())).reshape(4, 4).T[:3, :3]
    np.testing.assert_allclose(turn @ up, [0, np.linalg.norm(up), 0], atol=1e-12)
    back = sf.load_gaussians(path, up=up)
    for name in NAMES:
        np.testing.assert_allclose(getattr(back, name), getattr(gaussians, name), atol=1e-7)
    in_file = sf.load_gaussians(path, up=(0, 1, 0))
    np.testing.assert_allclose(in_file.positions, back.positions @ turn.T, atol=1e-12)
    axes = splat_drawing.axes(in_file.rotations)
    np.testing.assert_allclose(axes, turn @ splat_drawing.axes(back.rotations), atol=1e-6)
    for towards in directions(10):
        seen = [
            splat_drawing.colors(g.harmonics, np.tile(-d, (20, 1)))
            for g, d in ((back, towards), (in_file, turn @ towards))
        ]
        np.testing.assert_allclose(*seen, atol=1e-6)
