"""LAS and LAZ through laspy."""

import sys

import numpy as np
import pytest

import surflux as sf
from scan_files import las
from surflux._base.color import reflectance_of_colors


@pytest.fixture(autouse=True)
def extra():
    pytest.importorskip("laspy")
    pytest.importorskip("lazrs")


@pytest.mark.parametrize("name", ["a.las", "a.laz", "a.copc.laz", "a.dat"])
@pytest.mark.parametrize("point_format", [1, 2, 3, 6, 7, 8])
def test_all_that_is_said_of_points_is_kept(tmp_path, name, point_format):
    source = tmp_path / ("a.las" if name == "a.dat" else name)
    points, data = las(source, point_format=point_format, extra=("NormalX", "NormalY", "NormalZ", "Deviation"))
    scan = sf.read_scan(source.rename(tmp_path / name))
    np.testing.assert_allclose(scan.points, points, rtol=0, atol=1e-9 * 4e6)
    assert (scan.reflectance is not None) == (point_format in (2, 3, 7, 8))
    if scan.reflectance is not None:
        colors = np.stack([data.red, data.green, data.blue], axis=1)
        np.testing.assert_array_equal(scan.reflectance, reflectance_of_colors(colors, 65535.0))
    for name in ("intensity", "classification", "return_number", "number_of_returns", "point_source_id"):
        np.testing.assert_array_equal(scan.attributes[name], data[name])
    assert ("gps_time" in scan.attributes) == (point_format != 2)
    if "gps_time" in scan.attributes:
        np.testing.assert_array_equal(scan.attributes["gps_time"], data.gps_time)
    np.testing.assert_array_equal(scan.attributes["Deviation"], data["Deviation"])
    normals = np.stack([data[f"Normal{axis}"] for axis in "XYZ"], axis=1).astype(np.float64)
    np.testing.assert_allclose(scan.normals, normals / np.linalg.norm(normals, axis=1, keepdims=True), rtol=1e-12)
    assert scan.viewpoint is None


def test_colours_of_eight_bits_in_sixteen(tmp_path):
    _, data = las(tmp_path / "a.las", colors=255)
    colors = np.stack([data.red, data.green, data.blue], axis=1)
    np.testing.assert_array_equal(sf.read_scan(tmp_path / "a.las").reflectance, reflectance_of_colors(colors, 255.0))


def test_colours_that_nobody_filled_in_are_none(tmp_path):
    las(tmp_path / "a.las", colors=0)
    scan = sf.read_scan(tmp_path / "a.las")
    assert scan.reflectance is None
    grey = scan.attributes["intensity"] * (0.5 / scan.attributes["intensity"].mean())
    s = sf.read(tmp_path / "a.las")
    np.testing.assert_allclose(s.reflectance, np.repeat(np.minimum(grey, 0.98)[:, None], 3, axis=1), rtol=1e-12)


@pytest.mark.parametrize(("point_format", "raw", "degrees"), [(3, -17, -17.0), (7, -3000, -18.0)])
def test_scan_angles_are_degrees(tmp_path, point_format, raw, degrees):
    import laspy

    header = laspy.LasHeader(point_format=point_format, version="1.4")
    data = laspy.LasData(header)
    data.x = data.y = data.z = np.zeros(2)
    data["scan_angle_rank" if point_format < 6 else "scan_angle"] = np.array([raw, 0])
    data.write(str(tmp_path / "a.las"))
    np.testing.assert_allclose(sf.read_scan(tmp_path / "a.las").attributes["scan_angle"], [degrees, 0.0], rtol=1e-6)


def test_chunks_join_to_the_whole(tmp_path, monkeypatch):
    points, data = las(tmp_path / "a.laz", n=100)
    monkeypatch.setattr("surflux.scans.las.CHUNK", 7)
    told = []
    scan = sf.read_scan(tmp_path / "a.laz", progress=lambda done, total: told.append((done, total)))
    np.testing.assert_allclose(scan.points, points, rtol=0, atol=1e-9 * 4e6)
    np.testing.assert_array_equal(scan.attributes["gps_time"], data.gps_time)
    assert told == [(min(done, 100), 100) for done in range(7, 106, 7)]
    with pytest.raises(sf.Cancelled):
        sf.read_scan(tmp_path / "a.laz", progress=lambda done, total: done < 50)


@pytest.mark.parametrize("name", ["a.las", "a.laz"])
def test_files_that_are_cut_off_or_changed(tmp_path, name):
    las(tmp_path / name, n=2000)
    whole = (tmp_path / name).read_bytes()
    for left in (10, 100, 300, 400, len(whole) // 2):
        (tmp_path / name).write_bytes(whole[:left])
        with pytest.raises(sf.FileError, match=r"laspy cannot read it|truncated: the header promises 2000 points, and"):
            sf.read_scan(tmp_path / name)
    (tmp_path / name).write_bytes(b"LASF" + b"x" * 400)
    with pytest.raises(
        sf.FileError, match=r"\(byte 100\): the header promises 2021161080 records of 54 bytes or more$"
    ):
        sf.read_scan(tmp_path / name)


def test_an_empty_tile(tmp_path):
    import laspy

    laspy.LasData(laspy.LasHeader(point_format=3, version="1.2")).write(str(tmp_path / "a.las"))
    with pytest.raises(sf.FileError, match=r"a\.las: no points: it has none$"):
        sf.read(tmp_path / "a.las")


@pytest.mark.parametrize(("missing", "name"), [("laspy", "a.las"), ("lazrs", "a.laz"), ("pye57", "a.e57")])
def test_without_the_extra_the_message_is_the_line_that_installs_it(tmp_path, monkeypatch, missing, name):
    if name.endswith("e57"):
        (tmp_path / name).write_bytes(b"ASTM-E57")
    else:
        las(tmp_path / name)
    monkeypatch.setitem(sys.modules, missing, None)
    if missing == "lazrs":
        monkeypatch.setattr("laspy.LazBackend.detect_available", lambda: ())
    with pytest.raises(sf.FileError, match=rf"{name}: needs {missing}, .*: pip install 'surflux\[scans\]'$"):
        sf.read(tmp_path / name)
