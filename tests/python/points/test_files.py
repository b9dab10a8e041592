"""What point files may say, and what is refused."""

import os

import numpy as np
import pytest

from ply_samples import core_surfels, write
from surflux import _core
from surflux.points.ply_arrays import load_arrays
from surflux.points.writing import save_surfels

FileError = _core.FileError

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
    path = with_columns(tmp_path / "a.ply", "float nx ny nz", ["0 3e200 4e200", "0 0 0", "nan 0 1", "0 inf 0"])
    normals = load_arrays(path)["normals"]
    np.testing.assert_allclose(normals[0], [0, 0.6, 0.8], rtol=1e-15)
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


def test_formats_go_by_content_or_by_name(tmp_path):
    source = write(tmp_path / "a.PLY", ["vertex 1: float x y z"], ["1 2 3"])
    assert len(load_arrays(source)["points"]) == 1
    other = source.rename(tmp_path / "scan.dat")
    assert len(load_arrays(str(other))["points"]) == 1
    assert len(load_arrays(str(other), format="ply")["points"]) == 1
    with pytest.raises(FileError, match=r"scan\.dat: is no PLY file, but las$"):
        load_arrays(other, format="las")
    with pytest.raises(FileError, match="format 'dxf' cannot be read as points; supported now: ply, pcd, las"):
        load_arrays(other, format="dxf")
    (tmp_path / "scan").touch()
    with pytest.raises(FileError, match="a name without a suffix cannot be read as points"):
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
    assert load_arrays(path)["comments"] == ["ÿ"]  # Latin-1, as nothing else reads it
