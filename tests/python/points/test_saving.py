"""What is saved comes back, and other readers show it."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ply_samples import core_surfels
from surflux import _core
from surflux._base.color import linear_to_srgb, srgb_to_linear
from surflux.drawing.colors import Shown, screen_bytes
from surflux.pictures.images import tone_map
from surflux.points.ply_arrays import load_arrays
from surflux.points.writing import pack_comments, save_surfels, unpack_comments

FileError = _core.FileError


def parse_ply(path):
    """Another reader, for tables of scalars in binary little-endian files: {element: {column: list}}."""
    codes = dict(char="b", uchar="B", short="h", ushort="H", int="i", uint="I", float="f", double="d")
    data = path.read_bytes()
    header, body = data.split(b"end_header\n", 1)
    elements = {}
    for line in header.decode().split("\n"):
        words = line.split()
        if words[:1] == ["element"]:
            rows = elements[words[1]] = (int(words[2]), [])
        elif words[:1] == ["property"]:
            rows[1].append((words[2], codes[words[1]]))
    out = {}
    for name, (count, columns) in elements.items():
        row = struct.Struct("<" + "".join(code for _, code in columns))
        values = list(row.iter_unpack(body[: count * row.size]))
        body = body[count * row.size :]
        out[name] = {column: [v[i] for v in values] for i, (column, _) in enumerate(columns)}
    assert body == b""
    return out


coordinates = st.floats(-1e300, 1e300, allow_subnormal=True)
fractions = st.floats(0.0, 1.0, exclude_max=True)
lengths = st.floats(1e-300, 1e300)


@st.composite
def clouds(draw):
    n = draw(st.integers(1, 6))
    t = draw(st.integers(0, 4))
    return {
        "points": draw(arrays(np.float64, (n, 3), elements=coordinates)),
        "radii": draw(arrays(np.float64, n, elements=lengths)),
        "areas": draw(st.none() | arrays(np.float64, n, elements=lengths)),
        "reflectance": draw(arrays(np.float64, (n, 3), elements=fractions)),
        "emission": draw(arrays(np.float64, (n, 3), elements=st.floats(0.0, 1e300))),
        "triangles": draw(arrays(np.float64, (t, 3, 3), elements=coordinates)),
        "triangle_surfel": np.sort(draw(arrays(np.uint32, t, elements=st.integers(0, n - 1)))),
    }


@settings(max_examples=200, deadline=None)
@given(cloud=clouds())
def test_what_is_saved_comes_back(cloud, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "round_trip.ply"
    n = len(cloud["points"])
    radiosity = np.arange(3.0 * n).reshape(n, 3)
    save_surfels(path, core_surfels(**cloud), radiosity=radiosity)
    back = load_arrays(path)
    for name in ("points", "radii", "triangles", "triangle_surfel"):
        np.testing.assert_array_equal(back[name], cloud[name])
    if cloud["areas"] is None:
        assert back["areas"] is None
    else:
        np.testing.assert_array_equal(back["areas"], cloud["areas"])
    assert np.all(back["reflectance"] < 1.0)
    # Half a unit in the last place of float32, and one whole where 1 itself must be avoided.
    np.testing.assert_allclose(back["reflectance"], cloud["reflectance"], rtol=2**-24, atol=2**-24)
    np.testing.assert_allclose(back["emission"], cloud["emission"], rtol=2**-24, atol=1e-44)
    np.testing.assert_array_equal(back["radiosity"], radiosity)
    np.testing.assert_allclose(back["normals"], np.tile([0.0, 0.6, 0.8], (n, 1)), rtol=2**-24)


def test_positions_are_double_only_where_float_does_not_hold_them(tmp_path):
    path = tmp_path / "a.ply"
    save_surfels(path, core_surfels([[0.5, 0.25, 3.0]]))
    assert b"property float x" in path.read_bytes()
    save_surfels(path, core_surfels([[0.5, 0.1, 3.0]], radii=0.1))
    assert b"property double x" in path.read_bytes()
    assert b"property double radius" in path.read_bytes()


def test_further_columns_and_comments_come_back(tmp_path):
    path = tmp_path / "a.ply"
    extra = {
        "parent": np.array([7, 4_000_000_000], dtype=np.uint32),
        "level": np.array([-1, 3]),
        "leaf": np.array([True, False]),
        "error": np.array([0.25, 1e300]),
        "gradient": np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
    }
    irradiance, direct = np.full((2, 3), 2.5), np.array([[0.0, 0.5, -1e-9], [1.0, 2.0, 3.0]])
    save_surfels(
        path, core_surfels(np.eye(3)[:2]), irradiance=irradiance, direct=direct, columns=extra, comments=["by hand"]
    )
    back = load_arrays(path)
    for name in ("parent", "level", "leaf", "error"):
        np.testing.assert_array_equal(back["columns"][name], extra[name])
    for i, channel in enumerate("rgb"):
        np.testing.assert_array_equal(back["columns"][f"gradient_{channel}"], extra["gradient"][:, i])
    np.testing.assert_array_equal(back["irradiance"], irradiance)
    np.testing.assert_array_equal(back["direct"], direct.astype(np.float32))
    assert back["comments"] == ["by hand"]
    assert back["radiosity"] is None
    types = _core.read_ply(path)["types"]["vertex"]
    assert [types[name] for name in ("parent", "level", "leaf", "error")] == ["uint", "int", "uchar", "double"]


def test_other_readers_show_the_surfels(tmp_path):
    import pyvista
    import trimesh

    path = tmp_path / "a.ply"
    points = np.array([[0.1, 0.2, 0.3], [5e6, 1.0, 2.0], [0.0, 1.0, 0.0]])
    triangles = np.arange(18.0).reshape(2, 3, 3)
    surfels = core_surfels(points, reflectance=[0.98, 0.49, 0.0], triangles=triangles, triangle_surfel=[0, 2])
    save_surfels(path, surfels, comments=pack_comments({"text": "long " * 1000}))
    ours = parse_ply(path)
    np.testing.assert_array_equal(np.stack([ours["vertex"][axis] for axis in "xyz"], axis=1), points)
    assert ours["patch"]["surfel"] == [0, 2]
    np.testing.assert_array_equal([ours["patch"][f"{a}{k}"][1] for k in range(3) for a in "xyz"], triangles[1].ravel())
    # Reflectance .98 is white; half of it, .5 linear, is 188 in sRGB: 255 (1.055 .5^(1/2.4) - .055) = 187.5.
    shown = [[255, 188, 0]] * 3
    np.testing.assert_array_equal(np.stack([ours["vertex"][c] for c in ("red", "green", "blue")], axis=1), shown)
    cloud = trimesh.load(path)
    np.testing.assert_array_equal(cloud.vertices, points)
    np.testing.assert_array_equal(np.asarray(cloud.colors)[:, :3], shown)
    mesh = pyvista.read(path)
    np.testing.assert_array_equal(mesh.points, points.astype(np.float32))
    np.testing.assert_array_equal(mesh.point_data["RGB"], shown)


def test_radiosity_is_shown_exposed(tmp_path):
    path = tmp_path / "a.ply"
    # The 99th percentile of the largest channels, 0 ... 100, is 99, as in views and on pages.
    radiosity = np.zeros((101, 3))
    radiosity[:, 1] = np.arange(101.0)
    save_surfels(path, core_surfels(np.zeros((101, 3))), radiosity=radiosity)
    green = np.array(parse_ply(path)["vertex"]["green"])
    np.testing.assert_array_equal(green, np.rint(255 * linear_to_srgb(np.arange(101.0) / 99.0)))
    assert green[99] == green[100] == 255 > green[98]
    shown = Shown("radiosity", "light", "", radiosity)
    np.testing.assert_array_equal(screen_bytes(shown)[:, 1], green)
    save_surfels(path, core_surfels(np.zeros((2, 3))), radiosity=np.zeros((2, 3)))
    assert parse_ply(path)["vertex"]["red"] == [0, 0]


def test_srgb_is_the_inverse_of_linear():
    values = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(srgb_to_linear(linear_to_srgb(values)), values, atol=1e-7)
    # IEC 61966-2-1: .5 in sRGB is ((.5 + .055) / 1.055)^2.4.
    assert srgb_to_linear(0.5) == pytest.approx(0.2140411, abs=1e-7)
    # The same curve as that of PNG files; what is no colour is black.
    np.testing.assert_array_equal(linear_to_srgb([np.nan, -1.0, 2.0]), [0.0, 0.0, 1.0])
    flat = values[:999].reshape(1, 333, 3).astype(np.float32)
    shown = tone_map(flat, exposure=1.0, filmic=False)
    np.testing.assert_array_equal(shown, linear_to_srgb(flat).astype(np.float32))


# ---- comments

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@pytest.mark.slow
@settings(max_examples=50, deadline=None)
@given(data=st.dictionaries(st.text(), json_values))
def test_comments_carry_any_data(data, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "comments.ply"
    save_surfels(path, core_surfels(np.zeros((1, 3))), comments=["first", *pack_comments(data), "surfluxed last"])
    assert unpack_comments(load_arrays(path)["comments"]) == data


def test_long_data_is_split():
    lines = pack_comments({"text": " x" * 1000})
    assert max(map(len, lines)) <= 408
    assert unpack_comments(lines) == {"text": " x" * 1000}


def test_comments_without_data_or_with_broken_data():
    assert unpack_comments(["made with love", "surflux 0.1 wrote this"]) == {}
    with pytest.raises(FileError, match=r"^a\.ply: the comments that begin with 'surflux' are no valid JSON"):
        unpack_comments(['surflux {"camera":'], "a.ply")
    with pytest.raises(ValueError, match="JSON"):
        pack_comments({"value": float("inf")})
    assert unpack_comments(pack_comments({"value": [float("nan"), 1.0]})) == {"value": [None, 1.0]}  # unknown


def test_save_refuses(tmp_path):
    surfels = core_surfels(np.zeros((2, 3)))
    path = tmp_path / "a.ply"
    with pytest.raises(ValueError, match=r"^radiosity: got shape \(3, 3\); wanted \(2, 3\)"):
        save_surfels(path, surfels, radiosity=np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"^direct: not finite at \(1, 2\)"):
        save_surfels(path, surfels, direct=[[0, 0, 0], [0, 0, np.nan]])
    with pytest.raises(ValueError, match=r"^level: got shape \(1,\); wanted \(2,\)"):
        save_surfels(path, surfels, columns={"level": [1]})
    with pytest.raises(ValueError, match="column radius: given twice"):
        save_surfels(path, surfels, columns={"radius": [1, 2]})
    with pytest.raises(ValueError, match="comments: one line each"):
        save_surfels(path, surfels, comments=["a\nb"])
    assert not path.exists()
    with pytest.raises(FileError, match=r"no_folder/a\.ply: cannot be written: there is no folder .*no_folder$"):
        save_surfels(tmp_path / "no_folder" / "a.ply", surfels)
