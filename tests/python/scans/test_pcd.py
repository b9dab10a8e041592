"""PCD files: what the three kinds of data hold, and what is refused."""

import struct

import numpy as np
import pytest

import surflux as sf
from scan_files import lzf, packed, pcd, table
from surflux._base.color import reflectance_of_colors
from surflux.scans.lzf import decompressed


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("kind", ["f4", "f8"])
def test_all_kinds_of_data_hold_the_same(tmp_path, data, kind):
    rows = table(300, kind=kind)
    scan = sf.read_scan(pcd(tmp_path / "a.pcd", rows, data, viewpoint="1 2 3 1 0 0 0"))
    np.testing.assert_array_equal(scan.points, np.stack([rows[axis] for axis in "xyz"], axis=1))
    np.testing.assert_array_equal(scan.normals, [[0.0, 0.0, 1.0]] * 300)
    bits = rows["rgb"].view(np.uint32)
    colors = np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=1)
    np.testing.assert_array_equal(scan.reflectance, reflectance_of_colors(colors, 255.0))
    assert list(scan.attributes) == ["intensity", "label"]
    for name, values in scan.attributes.items():
        np.testing.assert_array_equal(values, rows[name])
        assert values.dtype == rows[name].dtype
    assert scan.viewpoint.tolist() == [1.0, 2.0, 3.0]
    np.testing.assert_array_equal(scan.rows, np.arange(300))


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_points_that_are_not_finite_are_left_out_and_counted(tmp_path, data):
    rows = table(12)
    rows["x"][3], rows["z"][7] = np.nan, np.inf
    path = pcd(tmp_path / "a.pcd", rows, data, size=(4, 3))
    with pytest.warns(UserWarning, match=r"a\.pcd: 2 points of 12 left out, without a finite place$"):
        scan = sf.read_scan(path)
    assert scan.rows.tolist() == [0, 1, 2, 4, 5, 6, 8, 9, 10, 11]
    np.testing.assert_array_equal(scan.attributes["label"], scan.rows)
    rows["y"] = np.nan
    with pytest.raises(sf.FileError, match=r"a\.pcd: no points: none of its 12 has finite coordinates$"):
        sf.read_scan(pcd(path, rows, data))


def test_the_viewpoint_that_all_writers_set_says_something_of_depth_cameras_alone(tmp_path):
    rows = table(12)
    assert sf.read_scan(pcd(tmp_path / "a.pcd", rows)).viewpoint is None
    assert sf.read_scan(pcd(tmp_path / "a.pcd", rows, VIEWPOINT=None)).viewpoint is None
    assert sf.read_scan(pcd(tmp_path / "a.pcd", rows, size=(4, 3))).viewpoint.tolist() == [0.0, 0.0, 0.0]
    assert sf.read_scan(pcd(tmp_path / "a.pcd", rows, viewpoint="0 0 0 0 1 0 0")).viewpoint.tolist() == [0.0] * 3


def test_estimated_normals_turn_to_the_viewpoint(tmp_path):
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0)), axis=-1).reshape(-1, 2)
    rows = np.zeros(400, dtype=[(axis, "f8") for axis in "xyz"])
    rows["x"], rows["y"] = grid.T
    for height in (5.0, -5.0):
        s = sf.read(pcd(tmp_path / "a.pcd", rows, viewpoint=f"10 10 {height} 1 0 0 0"))
        np.testing.assert_allclose(s.normals, [[0.0, 0.0, np.sign(height)]] * 400, atol=1e-12)
        s = sf.read(tmp_path / "a.pcd", viewpoint=[0.0, 0.0, -height])  # the caller knows better
        np.testing.assert_allclose(s.normals, [[0.0, 0.0, -np.sign(height)]] * 400, atol=1e-12)


def test_names_in_capitals_commas_and_fields_without_use(tmp_path):
    text = "VERSION 0.7\nFIELDS X Y Z _ Intensity\nSIZE 4 4 4 4 4\nTYPE F F F F F\nCOUNT 1 1 1 2 1\nWIDTH 2\nHEIGHT 1\n"
    (tmp_path / "a.pcd").write_text(text + "POINTS 2\nDATA ascii\n289814.15,4320978.61,170.76,0,0,5\n1,2,3,0,0,6\n")
    scan = sf.read_scan(tmp_path / "a.pcd")
    np.testing.assert_array_equal(scan.points, [[289814.15, 4320978.61, 170.76], [1.0, 2.0, 3.0]])  # to the centimetre
    assert {name: values.tolist() for name, values in scan.attributes.items()} == {"intensity": [5.0, 6.0]}


def test_rgba_of_whole_numbers_and_fields_of_several_values(tmp_path):
    rows = np.zeros(2, dtype=[("x", "f4"), ("y", "f4"), ("z", "f4"), ("rgba", "u4"), ("fpfh", "f4", (3,))])
    rows["rgba"] = packed([[255, 0, 0], [0, 0, 255]]).view(np.uint32) | 255 << 24
    rows["fpfh"] = [[1, 2, 3], [4, 5, 6]]
    scan = sf.read_scan(pcd(tmp_path / "a.pcd", rows, COUNT="1 1 1 1 3"))
    np.testing.assert_array_equal(scan.reflectance, [[0.98, 0, 0], [0, 0, 0.98]])
    np.testing.assert_array_equal(scan.attributes["fpfh"], [[1, 2, 3], [4, 5, 6]])


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ({"FIELDS": None}, ": the header has no FIELDS"),
        ({"FIELDS": "x y u rgb nx ny nz intensity label"}, ": no points: wanted columns x, y and z, got x, y, u, rgb"),
        ({"FIELDS": "x y z"}, r" (line 4): SIZE has 9 values for 3 fields"),
        ({"FIELDS": "x x z rgb normal_x normal_y normal_z intensity label"}, r" (line 3): a second field 'x'"),
        ({"SIZE": "4 4 4 4 4 4 4 4 3"}, r" (line 5): field 'label' is of type 'U' and size 3; wanted F, U or I"),
        ({"SIZE": "4 4 4 4 4 4 4 4 many"}, r" (line 4): SIZE is '4 4 4 4 4 4 4 4 many'; wanted whole numbers from 0"),
        ({"COUNT": "1 1 2 1 1 1 1 1 1"}, r" (line 6): field 'z' has 2 values; wanted 1"),
        ({"COUNT": "1 1 1 1 1 1 1 1 99999"}, r" (line 6): field 'label' has 99999 values; wanted at most 4096"),
        ({"POINTS": 13}, r" (line 10): POINTS is 13, but WIDTH and HEIGHT make 12"),
        ({"VIEWPOINT": "1 2 3"}, r" (line 9): VIEWPOINT is '1 2 3'; wanted a position and a quaternion"),
        ({"DATA": "zip"}, r" (line 11): DATA is 'zip'; wanted ascii, binary or binary_compressed"),
        ({"WORDS": "1"}, r" (line 11): its header has a line that begins with 'WORDS'; wanted VERSION, "),
    ],
)
def test_headers_that_are_refused(tmp_path, lines, reason):
    if "WORDS" in lines:
        lines = {"DATA": None, **lines}
    with pytest.raises(sf.FileError) as caught:
        sf.read_scan(pcd(tmp_path / "a.pcd", table(12), **lines))
    assert str(caught.value).startswith(f"{tmp_path / 'a.pcd'}{reason}")


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_a_header_that_promises_a_trillion_points(tmp_path, data):
    many = {"POINTS": 10**12, "WIDTH": 10**12}
    with pytest.raises(sf.FileError, match=r"truncated: .*1000000000000 points|unpacks to .* makes 36000000000000 of"):
        sf.read_scan(pcd(tmp_path / "a.pcd", table(12), data, **many))


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_files_that_are_cut_off_say_so(tmp_path, data):
    whole = pcd(tmp_path / "a.pcd", table(12), data).read_bytes()
    for left in (20, whole.index(b"DATA"), len(whole) - 70, whole.index(b"DATA") + len(f"DATA {data}\n")):
        (tmp_path / "a.pcd").write_bytes(whole[:left])
        with pytest.raises(sf.FileError, match=r"the header (ends before|has no)|truncated: |has \d values; wanted 9"):
            sf.read_scan(tmp_path / "a.pcd")


def test_text_that_is_no_number_is_named_by_its_line(tmp_path):
    path = pcd(tmp_path / "a.pcd", table(3), "ascii")
    lines = path.read_text().splitlines()
    lines[-2] = lines[-2].replace(lines[-2].split()[1], "1.2.3", 1)
    path.write_text("\n".join(lines))
    with pytest.raises(sf.FileError, match=r"a\.pcd \(line 13\): '1\.2\.3' is no number$"):
        sf.read_scan(path)


def test_damage_to_compressed_points_is_told(tmp_path):
    whole = bytearray(pcd(tmp_path / "a.pcd", table(40), "binary_compressed").read_bytes())
    begin = whole.index(b"binary_compressed\n") + len(b"binary_compressed\n")
    whole[begin + 8] = 0xE0  # a reference to what is before the beginning
    (tmp_path / "a.pcd").write_bytes(whole)
    with pytest.raises(sf.FileError, match=rf"\(byte {begin}\): its compressed points are damaged: the stream byte"):
        sf.read_scan(tmp_path / "a.pcd")
    whole[begin + 4 : begin + 8] = struct.pack("<I", 7)
    (tmp_path / "a.pcd").write_bytes(whole)
    with pytest.raises(
        sf.FileError, match=rf"\(byte {begin}\): unpacks to 7 bytes; the header makes 1440 of its points"
    ):
        sf.read_scan(tmp_path / "a.pcd")


@pytest.mark.parametrize("size", [0, 1, 31, 33, 500, 20_000])
@pytest.mark.parametrize("values", [1, 4, 256])
def test_lzf_gives_back_what_was_compressed(size, values):
    data = np.random.default_rng(size).integers(0, values, size, dtype=np.uint8).tobytes()
    assert decompressed(lzf(data), size) == data


@pytest.mark.parametrize("stream", [b"\x05abc", b"\x20", b"\xe0", b"\xe0\x01", b"\x00a\x3f\xff", b"\x00a\x00b"])
def test_lzf_refuses_other_bytes(stream):
    with pytest.raises(ValueError, match=r"byte|gives"):
        decompressed(stream, 1)
