"""Reading and writing of point files."""

import os
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from surflux import _core
from surflux._color import linear_to_srgb, srgb_to_linear
from surflux.files import load_arrays, pack_comments, save_surfels, unpack_comments

FileError = _core.FileError


def write(path, header, rows=()):
    """An ascii PLY; a header line such as `vertex 3: float x y z, uchar red` stands for an element."""
    lines = ["ply", "format ascii 1.0"]
    for line in header:
        name, _, properties = line.partition(":")
        lines.append(f"element {name}")
        for group in filter(None, properties.split(",")):
            kind, *names = group.split()
            lines += [f"property {kind} {n}" for n in names]
    lines += ["end_header", *rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def core_surfels(points, *, radii=1.0, areas=None, reflectance=0.5, emission=0.0, triangles=(), triangle_surfel=()):
    n = len(points)
    return _core.Surfels(
        np.asarray(points, dtype=np.float64),
        np.tile([0.0, 0.6, 0.8], (n, 1)),
        np.broadcast_to(np.asarray(radii, dtype=np.float64), n),
        areas,
        np.broadcast_to(np.asarray(reflectance, dtype=np.float64), (n, 3)),
        np.broadcast_to(np.asarray(emission, dtype=np.float64), (n, 3)),
        np.asarray(triangles, dtype=np.float64).reshape(-1, 3, 3),
        np.asarray(triangle_surfel, dtype=np.uint32),
    )


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


# ---- round trips

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
    # The 98th percentile of the largest channels, 0 ... 100, is 98.
    radiosity = np.zeros((101, 3))
    radiosity[:, 1] = np.arange(101.0)
    save_surfels(path, core_surfels(np.zeros((101, 3))), radiosity=radiosity)
    green = np.array(parse_ply(path)["vertex"]["green"])
    np.testing.assert_array_equal(green, np.rint(255 * linear_to_srgb(np.arange(101.0) / 98.0)))
    assert green[98] == green[100] == 255
    assert green[49] == 188
    save_surfels(path, core_surfels(np.zeros((2, 3))), radiosity=np.zeros((2, 3)))
    assert parse_ply(path)["vertex"]["red"] == [0, 0]


def test_srgb_is_the_inverse_of_linear():
    values = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(srgb_to_linear(linear_to_srgb(values)), values, atol=1e-7)
    # IEC 61966-2-1: .5 in sRGB is ((.5 + .055) / 1.055)^2.4.
    assert srgb_to_linear(0.5) == pytest.approx(0.2140411, abs=1e-7)


# ---- comments

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


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
        pack_comments({"value": float("nan")})


# ---- what a file may say

SQUARE = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]


def with_columns(path, properties, *columns):
    return write(
        path, [f"vertex 4: float x y z, {properties}"], [" ".join(row) for row in zip(SQUARE, *columns, strict=True)]
    )


@pytest.mark.parametrize(
    ("kind", "values", "linear"),
    [
        ("uchar", [255, 188, 0], [1.0, 0.5, 0.0]),
        ("ushort", [65535, 48187, 0], [1.0, 0.5, 0.0]),
        ("ushort", [255, 188, 0], [1.0, 0.5, 0.0]),  # 8 bits in 16
        ("float", [1.0, 0.7353570, 0.0], [1.0, 0.5, 0.0]),
        ("double", [255.0, 187.516, 0.0], [1.0, 0.5, 0.0]),
        ("uchar", [1, 1, 1], [1 / 255 / 12.92] * 3),  # an almost black cloud, no white one
    ],
)
@pytest.mark.parametrize("names", ["red green blue", "diffuse_red diffuse_green diffuse_blue", "r g b"])
def test_colors_become_linear_reflectance(tmp_path, kind, values, linear, names):
    rows = [" ".join(map(str, values))] * 4
    reflectance = load_arrays(with_columns(tmp_path / "a.ply", f"{kind} {names}", rows))["reflectance"]
    np.testing.assert_allclose(reflectance, 0.98 * np.tile(linear, (4, 1)), atol=0.004 if kind[0] == "u" else 1e-5)


def test_stored_reflectance_wins_over_colors(tmp_path):
    path = with_columns(
        tmp_path / "a.ply",
        "uchar red green blue, float reflectance_r reflectance_g reflectance_b",
        ["255 255 255 .1 .2 .3"] * 4,
    )
    loaded = load_arrays(path)
    np.testing.assert_array_equal(loaded["reflectance"], np.tile([0.1, 0.2, 0.3], (4, 1)))
    assert loaded["columns"] == {}


def test_bad_normals_are_marked(tmp_path):
    path = with_columns(tmp_path / "a.ply", "float nx ny nz", ["0 0 2", "0 0 0", "nan 0 1", "0 inf 0"])
    normals = load_arrays(path)["normals"]
    np.testing.assert_array_equal(normals[0], [0, 0, 2])
    assert np.all(np.isnan(normals[1:]))


def test_a_radius_that_was_never_filled_in_is_none(tmp_path):
    assert load_arrays(with_columns(tmp_path / "a.ply", "float radius", ["0"] * 4))["radii"] is None
    np.testing.assert_array_equal(
        load_arrays(with_columns(tmp_path / "b.ply", "float radius", ["2"] * 4))["radii"], [2] * 4
    )


def test_somebody_elses_patches_are_left_alone(tmp_path):
    path = write(tmp_path / "a.ply", ["vertex 1: float x y z", "patch 1: int size"], ["0 0 0", "7"])
    assert load_arrays(path)["triangles"].shape == (0, 3, 3)


@pytest.mark.parametrize(
    ("properties", "column", "reason"),
    [
        ("float nx ny", ["0 0"] * 4, "its vertices have nx, but no nz"),
        ("float reflectance_r", ["0"] * 4, "its vertices have reflectance_r, but no reflectance_g"),
        ("float radius", ["1", "1", "-1", "1"], "vertex 2: radius is -1; wanted a finite number"),
        ("float radius", ["1", "0", "1", "1"], "vertex 1: radius is 0; wanted a finite number"),
        ("float area", ["1", "nan", "1", "1"], "vertex 1: area is nan; wanted a finite number not below 0"),
        (
            "float emission_r emission_g emission_b",
            ["0 0 0", "0 0 -1", *["0 0 0"] * 2],
            "vertex 1: emission is -1; wanted",
        ),
        (
            "float reflectance_r reflectance_g reflectance_b",
            ["1 0 0"] * 4,
            "vertex 0: reflectance is 1; wanted less than 1",
        ),
        ("float red green blue", ["0 0 0", "nan 0 0", *["0 0 0"] * 2], "vertex 1: colour is nan; wanted"),
        ("float red green blue", ["0 0 70000"] * 4, "vertex 0: colour is 70000; wanted at most 1, 255 or 65535"),
        (
            "float radiosity_r radiosity_g radiosity_b",
            ["0 0 inf"] * 4,
            "vertex 0: radiosity is inf; wanted a finite number",
        ),
    ],
)
def test_refuses_what_cannot_be_surfels(tmp_path, properties, column, reason):
    path = with_columns(tmp_path / "a.ply", properties, column)
    with pytest.raises(FileError) as caught:
        load_arrays(path)
    assert str(caught.value).startswith(f"{path}: {reason}")


def test_refuses_coordinates_that_are_not_finite(tmp_path):
    path = write(tmp_path / "a.ply", ["vertex 2: float x y z"], ["0 0 0", "0 nan 0"])
    with pytest.raises(FileError, match=r"\(line 9\): vertex 1: y is nan; wanted a finite number$"):
        load_arrays(path)


def test_refuses_files_without_points(tmp_path):
    for header in ([], ["vertex 0: float x y z"], ["face 0:"]):
        with pytest.raises(FileError, match="no points: it has no element 'vertex', or an empty one"):
            load_arrays(write(tmp_path / "a.ply", header))
    with pytest.raises(FileError, match="no points: its vertices have no x, y and z"):
        load_arrays(write(tmp_path / "a.ply", ["vertex 1: float a"], ["0"]))
    with pytest.raises(FileError, match="its vertices have x, but no z"):
        load_arrays(write(tmp_path / "a.ply", ["vertex 1: float x y"], ["0 0"]))


def test_refuses_patches_of_no_surfel(tmp_path):
    corners = " ".join(f"{axis}{corner}" for corner in range(3) for axis in "xyz")
    header = ["vertex 1: float x y z", f"patch 2: int surfel, double {corners}"]
    good = "0" + " 0" * 9
    for bad in ("1" + " 0" * 9, "-1" + " 0" * 9, "0" + " 0" * 8 + " inf"):
        path = write(tmp_path / "a.ply", header, ["0 0 0", good, bad])
        with pytest.raises(FileError, match="patch 1: wanted the number of one of 1 surfels and finite corners"):
            load_arrays(path)


def test_formats_go_by_suffix_or_by_name(tmp_path):
    source = write(tmp_path / "a.PLY", ["vertex 1: float x y z"], ["1 2 3"])
    assert len(load_arrays(source)["points"]) == 1
    other = source.rename(tmp_path / "scan.dat")
    assert len(load_arrays(str(other), format="ply")["points"]) == 1
    with pytest.raises(FileError, match=r"scan\.dat: format 'dat' cannot be read as points; supported now: ply"):
        load_arrays(other)
    with pytest.raises(FileError, match="format 'las' cannot be read"):
        load_arrays(other, format="las")
    with pytest.raises(FileError, match="a name without a suffix, and no format, cannot be read"):
        load_arrays(tmp_path / "scan")


def test_paths_of_any_bytes(tmp_path):
    path = os.fsencode(tmp_path / "a") + b"\xff.ply"
    save_surfels(path, core_surfels([[1.0, 2.0, 3.0]]))
    assert load_arrays(path)["points"].tolist() == [[1, 2, 3]]
    with pytest.raises(FileError, match=r"b\\xff\.ply: no such file"):
        load_arrays(os.fsencode(tmp_path / "b") + b"\xff.ply")
    with pytest.raises(FileError, match="ü: no such file"):
        load_arrays("ü", format="ply")


def test_comments_need_not_be_text(tmp_path):
    path = tmp_path / "a.ply"
    path.write_bytes(
        b"ply\nformat ascii 1.0\ncomment \xff\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\n"
        b"property int \xfe\nend_header\n1 2 3 4\n"
    )
    assert load_arrays(path)["comments"] == ["\ufffd"]


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
    with pytest.raises(FileError, match=r"no_folder/a\.ply: cannot be written \(No such file or directory\)"):
        save_surfels(tmp_path / "no_folder" / "a.ply", surfels)


# ---- real files

POINTS_ONLY = "cannot be read as points; supported now: ply"
BROKEN = {
    "OutOfMemory.off": POINTS_ONLY,
    "ZeroPoints.e57": POINTS_ONLY,
    "autzen-utm.pcd": POINTS_ONLY,
    "bad-crc.e57": POINTS_ONLY,
    "bad_vlr_count.las": POINTS_ONLY,
    "cube_binary_header_with_RN_newline.ply": 8,
    "cube_uv.ply": 24,
    "diamond_with_bool.ply": "(line 13): property 'is_green' has the unknown type 'bool'",
    "empty.obj": POINTS_ONLY,
    "empty.ply": "the file is empty",
    "float-color.ply": 3,
    "float_inf_point_cloud.ply": "(line 8): vertex 0: z is inf",
    "lfs_pointer_bun_zipper_res4.ply": "(line 1): a pointer of git-lfs, not the file itself",
    "malformed.obj": POINTS_ONLY,
    "missingheader.pcd": POINTS_ONLY,
    "nancolor.obj": POINTS_ONLY,
    "negative_indices.obj": POINTS_ONLY,
    "no_vertex.ply": "no points",
    "noise-dirty.las": POINTS_ONLY,
    "notenoughindices.obj": POINTS_ONLY,
    "number_formats.obj": POINTS_ONLY,
    "only_a_part_of_vertexcolors.obj": POINTS_ONLY,
    "platonic_shelf_big_endian.ply": 50,
    "ply_empty_header.ply": "no points",
    "point_cloud.obj": POINTS_ONLY,
    "point_cloud_test_pos_norm.ply": 4,
    "points.ply": 4,
    "points_ascii_with_lists.ply": 5,
    "points_emptyface.ply": 1024,
    "test_extra_whitespace.ply": 3,
    "utm17_comma.pcd": POINTS_ONLY,
    "utm17_space.pcd": POINTS_ONLY,
    "whitespace.off": POINTS_ONLY,
}


@pytest.mark.scans
@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_give_points_or_a_file_error(name):
    path = os.path.join(os.environ["SURFLUX_DATA"], "broken", name)
    assert os.path.exists(path)
    if isinstance(BROKEN[name], int):
        loaded = load_arrays(path)
        assert loaded["points"].shape == (BROKEN[name], 3)
        assert np.all(np.isfinite(loaded["points"]))
    else:
        with pytest.raises(FileError) as caught:
            load_arrays(path)
        assert str(caught.value).startswith(path)
        assert BROKEN[name] in str(caught.value)


@pytest.mark.scans
def test_the_table_of_broken_files_is_complete():
    assert sorted(os.listdir(os.path.join(os.environ["SURFLUX_DATA"], "broken"))) == sorted(BROKEN)


@pytest.mark.scans
def test_details_of_real_files():
    broken = os.path.join(os.environ["SURFLUX_DATA"], "broken")
    # Blue, as floats of 0 ... 1, and an alpha that is left alone.
    blue = load_arrays(os.path.join(broken, "float-color.ply"))["reflectance"]
    np.testing.assert_array_equal(blue, [[0, 0, 0.98]] * 3)
    # All normals of this file are zero.
    assert np.all(np.isnan(load_arrays(os.path.join(broken, "point_cloud_test_pos_norm.ply"))["normals"]))
    cube = load_arrays(os.path.join(broken, "cube_binary_header_with_RN_newline.ply"))["points"]
    np.testing.assert_array_equal(np.unique(cube, axis=0), np.indices((2, 2, 2)).reshape(3, 8).T)


@pytest.mark.scans
@pytest.mark.parametrize(
    ("name", "points", "low", "high"),
    [
        ("armadillo_43k", 43_243, (-0.43527, -0.5734, -0.37948), (0.40334, 0.42655, 0.38333)),
        ("buddha_50k", 49_950, (-0.46095, -1.0022, -0.32388), (0.35222, 0.9775, 0.49018)),
        ("bun_zipper", 35_947, (-0.09469, 0.032987, -0.061874), (0.061009, 0.18732, 0.0588)),
        ("bunny_34834", 34_834, (-0.09469, 0.032987, -0.061874), (0.061009, 0.18732, 0.0588)),
        ("dragon_50k", 50_000, (-7.0467, 0, -3.1513), (7.0467, 9.9399, 3.1513)),
        ("lion_takanawa_342k_surfels", 341_989, (-4.985, 1.039, -3.445), (-0.789, 6.7235, 1.1235)),
    ],
)
def test_statues_have_the_points_and_boxes_of_their_manifest(name, points, low, high):
    loaded = load_arrays(os.path.join(os.environ["SURFLUX_DATA"], "statues", name + ".ply"))
    assert len(loaded["points"]) == points
    np.testing.assert_allclose(loaded["points"].min(axis=0), low, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(loaded["points"].max(axis=0), high, rtol=1e-4, atol=1e-6)
    assert (loaded["normals"] is not None) == ("bunny_" in name or "lion" in name)
    assert (loaded["reflectance"] is not None) == ("lion" in name)
