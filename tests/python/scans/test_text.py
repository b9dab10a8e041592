"""XYZ, PTS and CSV: which columns are what, and what is refused."""

import numpy as np
import pytest

import surflux as sf
from surflux._base.color import reflectance_of_colors


def scan_of(tmp_path, text, name="a.xyz", **options):
    (tmp_path / name).write_text(text)
    return sf.read_scan(tmp_path / name, **options)


@pytest.mark.parametrize("mark", [" ", "\t", ",", ";", ", ", "  \t"])
def test_three_columns_are_places(tmp_path, mark):
    rows = [["635619.85", "848899.70", "406.59"], ["-1e-3", "2", ".5"]]
    scan = scan_of(tmp_path, "\n".join(mark.join(row) for row in rows))
    np.testing.assert_array_equal(scan.points, [[635619.85, 848899.7, 406.59], [-0.001, 2.0, 0.5]])
    assert (scan.normals, scan.reflectance, dict(scan.attributes)) == (None, None, {})


NORMAL, COLOR, INTENSITY = "0 0.6 0.8", "255 0 188", "0.25"


@pytest.mark.parametrize(
    ("name", "rest", "parts"),
    [
        ("a.xyz", INTENSITY, "i"),
        ("a.pts", "-1873", "i"),
        ("a.xyz", COLOR, "c"),
        ("a.xyz", NORMAL, "n"),
        ("a.xyzn", NORMAL, "n"),
        ("a.xyzrgb", "1 0 0.7353570", "c"),
        ("a.xyz", f"{COLOR} {INTENSITY}", "ci"),
        ("a.xyz", f"{INTENSITY} {COLOR}", "ic"),
        ("a.pts", f"17 {COLOR}", "ic"),
        ("a.xyz", f"{COLOR} {NORMAL}", "cn"),
        ("a.txt", f"{NORMAL} {COLOR}", "nc"),
    ],
)
def test_columns_without_names_are_told_by_what_they_hold(tmp_path, name, rest, parts):
    count = "2\n" if name == "a.pts" else ""
    scan = scan_of(tmp_path, f"{count}1 2 3 {rest}\n4 5 6 {rest}\n", name)
    np.testing.assert_array_equal(scan.points, [[1, 2, 3], [4, 5, 6]])
    assert ("i" in parts) == ("intensity" in scan.attributes)
    assert ("n" in parts) == (scan.normals is not None)
    assert ("c" in parts) == (scan.reflectance is not None)
    if "n" in parts:
        np.testing.assert_allclose(scan.normals, [[0.0, 0.6, 0.8]] * 2, rtol=1e-15)
    if "c" in parts:
        np.testing.assert_allclose(
            scan.reflectance, reflectance_of_colors([[255, 0, 188]] * 2, 255.0), atol=0.003
        )  # 188 is .7373


@pytest.mark.parametrize("head", ["x,y,z,Red,Green,Blue,Intensity,GpsTime,height", "//X,Y,Z,R,G,B,i,gps_time,height"])
def test_columns_may_have_names(tmp_path, head):
    scan = scan_of(tmp_path, f"{head}\n1,2,3,65535,0,0,7,1e9,12\n4,5,6,0,0,65535,8,2e9,13\n", "a.csv")
    np.testing.assert_array_equal(scan.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(scan.reflectance, [[0.98, 0, 0], [0, 0, 0.98]])
    wanted = {"intensity": [7.0, 8.0], "gps_time": [1e9, 2e9], "height": [12.0, 13.0]}
    assert {name: values.tolist() for name, values in scan.attributes.items()} == wanted


@pytest.mark.parametrize("names", ["Easting,Northing,Height", "East,North,Elevation", "easting,northing,altitude"])
def test_columns_of_surveys(tmp_path, names):
    scan = scan_of(
        tmp_path, f"id,{names},intensity\n9,500008.5,4000007.25,0.5,7\n8,500002.5,4000005.0,0.25,3\n", "a.csv"
    )
    np.testing.assert_array_equal(scan.points, [[500008.5, 4000007.25, 0.5], [500002.5, 4000005.0, 0.25]])
    assert {name: values.tolist() for name, values in scan.attributes.items()} == {"id": [9, 8], "intensity": [7, 3]}


@pytest.mark.parametrize(
    ("names", "left"), [("easting,northing,height,elevation", "elevation"), ("east,northing,height,z", "height")]
)
def test_a_name_of_surveys_that_is_none_is_an_attribute(tmp_path, names, left):
    scan = scan_of(tmp_path, f"{names}\n1,2,3,4\n5,6,7,8\n", "a.csv")
    z, kept = ([3, 7], [4, 8]) if left == "elevation" else ([4, 8], [3, 7])
    np.testing.assert_array_equal(scan.points, [[1, 2, z[0]], [5, 6, z[1]]])
    assert {name: values.tolist() for name, values in scan.attributes.items()} == {left: kept}


@pytest.mark.parametrize("head", ["x;y;z;intensity\n", ""])
def test_decimal_commas_between_semicolons(tmp_path, head):
    scan = scan_of(tmp_path, f"{head}0,5;1e3;-2,25;7,5\n1;0;3.5;8\n", "a.csv")
    np.testing.assert_array_equal(scan.points, [[0.5, 1000.0, -2.25], [1.0, 0.0, 3.5]])
    np.testing.assert_array_equal(scan.attributes["intensity"], [7.5, 8.0])


def test_intensity_that_may_be_a_colour_is_told_of(tmp_path):
    """Of four columns of bytes none says which is the intensity."""
    with pytest.warns(
        UserWarning, match=r"a\.xyz: .* taken are red green blue intensity for columns 4 to 7, which may"
    ):
        scan = scan_of(tmp_path, "1 2 3 235 200 100 50\n4 5 6 20 200 100 50\n")
    assert scan.attributes["intensity"].tolist() == [50, 50]
    named = scan_of(tmp_path, "# x y z intensity r g b\n1 2 3 235 200 100 50\n4 5 6 20 200 100 50\n", "b.xyz")
    assert named.attributes["intensity"].tolist() == [235, 20]
    np.testing.assert_allclose(named.reflectance, reflectance_of_colors([[200, 100, 50]] * 2, 255.0))


def test_further_columns_are_numbered(tmp_path):
    with pytest.warns(UserWarning, match=r"a\.xyz: .* x y z for the first of 5, and nothing for the others"):
        scan = scan_of(tmp_path, "1 2 3 4 5\n")
    assert {name: values.tolist() for name, values in scan.attributes.items()} == {"column_4": [4.0], "column_5": [5.0]}


def test_blank_lines_comments_and_other_line_ends(tmp_path):
    scan = scan_of(tmp_path, "\ufeff# made by hand\r\n\r\n1 2 3\r\n  // a note\r\n4 5 6")
    np.testing.assert_array_equal(scan.points, [[1, 2, 3], [4, 5, 6]])


def test_pts_counts_its_points_and_may_have_several_parts(tmp_path):
    scan = scan_of(tmp_path, "2\n1 2 3\n4 5 6\n1\n7 8 9\n", "a.pts")
    np.testing.assert_array_equal(scan.points, [[1, 2, 3], [4, 5, 6], [7, 8, 9]])
    with pytest.raises(sf.FileError, match=r"a\.pts \(line 1\): truncated: 3 points are promised, and 2 are there$"):
        scan_of(tmp_path, "3\n1 2 3\n4 5 6\n", "a.pts")
    with pytest.raises(sf.FileError, match=r"a\.pts \(line 1\): 1 points are promised, and 2 are there$"):
        scan_of(tmp_path, "1\n1 2 3\n4 5 6\n", "a.pts")


def test_lines_are_read_in_chunks_and_named_by_their_number(tmp_path, monkeypatch):
    monkeypatch.setattr("surflux.scans.tables._LINES", 7)
    points = np.arange(90.0).reshape(30, 3)
    text = "".join(f"{x} {y} {z}\n" for x, y, z in points)
    np.testing.assert_array_equal(scan_of(tmp_path, text).points, points)
    with pytest.raises(sf.FileError, match=r"a\.xyz \(line 31\): has 2 values; wanted 3$"):
        scan_of(tmp_path, text + "1 2\n")
    with pytest.raises(sf.FileError, match=r"a\.xyz \(line 31\): '7_0' is no number$"):
        scan_of(tmp_path, text + "1 2 7_0\n")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", ": the file is empty"),
        ("# nothing\n", ": no points: no line has numbers"),
        ("1 2\n", r" (line 1): has 2 values; wanted x, y and z"),
        (
            "lon lat height\n1 2 3\n",
            r" (line 1): 'lon' is no number, and the line does not name the columns",
        ),
        ("x,y,z,code\n1,2,3,wall\n", " (line 2): 'wall' is no number"),
        ("X,easting,northing,height\n7,1,2,3\n", " (line 1): 'X' is no number, and the line does not name"),
        ("x;y;z\n1,500;12.5;3\n", " (line 2): '1,500' is no number"),
        ("1 2 3 -1 0 0\n2 2 3 70 0 0\n", ": point 0: colour is -1; wanted a finite number not below 0"),
        ("1 2 3 9 0 0\n2 2 3 70000 0 0\n", ": point 1: colour is 70000; wanted at most 1, 255 or 65535"),
        ("1 2 1e31\n", ": point 0: a coordinate is 1e+31; wanted up to 1e+30"),
        ("nan 0 0\n", ": no points: none of its 1 has finite coordinates"),
        ("1 2 3\n\0", ": is no text, though its name says so"),
    ],
)
def test_what_is_refused(tmp_path, text, reason):
    with pytest.raises(sf.FileError) as caught:
        scan_of(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path / 'a.xyz'}{reason}")


def test_intensity_stands_in_for_colours(tmp_path):
    (tmp_path / "a.pts").write_text("4\n0 0 0 -2000\n1 0 0 -1000\n0 1 0 0\n1 1 0 5000\n")
    s = sf.read(tmp_path / "a.pts")
    # From the least, 0, 1000, 2000 and 7000: the last is white, .98, and the others make the mean .5: .34 for 1000.
    np.testing.assert_allclose(s.reflectance, np.repeat([[0.0], [0.34], [0.68], [0.98]], 3, axis=1), rtol=1e-12)
    (tmp_path / "a.pts").write_text("4\n0 0 0 9\n1 0 0 9\n0 1 0 9\n1 1 0 9\n")  # says nothing
    np.testing.assert_array_equal(sf.read(tmp_path / "a.pts").reflectance, 0.5)
    np.testing.assert_array_equal(sf.read(tmp_path / "a.pts", reflectance=0.3).reflectance, 0.3)
