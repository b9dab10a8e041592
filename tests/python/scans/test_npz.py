"""NPZ files: which arrays are what, and what is refused."""

import io
import zipfile

import numpy as np
import pytest

import surflux as sf

POINTS = np.add(np.random.default_rng(0).uniform(-1.0, 1.0, (25, 3)), [5e5, 4e6, 0.0])


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize("name", ["points", "xyz", "Positions"])
def test_arrays_by_their_names(tmp_path, save, name):
    colors = np.random.default_rng(1).integers(0, 256, (25, 4), dtype=np.uint8)
    normals = np.asfortranarray(np.tile(np.float32([0, 0, 2]), (25, 1)))
    more = {"classification": np.arange(25, dtype=np.uint8), "descriptor": np.ones((25, 5)), "about": np.array("no")}
    save(tmp_path / "a.npz", **{name: POINTS}, normals=normals, colors=colors, count=np.arange(3), **more)
    scan = sf.read_scan(tmp_path / "a.npz")
    np.testing.assert_array_equal(scan.points, POINTS)
    np.testing.assert_array_equal(scan.normals, [[0.0, 0.0, 1.0]] * 25)
    assert scan.reflectance.shape == (25, 3)
    assert sorted(scan.attributes) == ["classification", "descriptor"]
    np.testing.assert_array_equal(scan.attributes["classification"], np.arange(25))


def test_chunks_and_columns_one_by_one(tmp_path, monkeypatch):
    monkeypatch.setattr("surflux.scans.npz.CHUNK", 4)
    np.savez(tmp_path / "a.npz", x=POINTS[:, 0], y=POINTS[:, 1], z=POINTS[:, 2], normals=np.asfortranarray(POINTS))
    scan = sf.read_scan(tmp_path / "a.npz")
    np.testing.assert_array_equal(scan.points, POINTS)
    np.testing.assert_allclose(scan.normals, POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True), rtol=1e-15)


@pytest.mark.parametrize(
    ("arrays", "reason"),
    [
        ({"a": np.zeros(3)}, "no points: wanted an array points (n, 3), or x, y and z; got a"),
        ({"points": np.zeros((3, 2))}, "no points: wanted an array points (n, 3), or x, y and z; got points"),
        ({"points": np.zeros((0, 3))}, "no points: it has none"),
        ({"points": POINTS, "normals": POINTS[:7]}, "normals: wanted 25 rows, as many as there are points"),
        ({"x": POINTS, "y": POINTS, "z": POINTS}, "points: wanted x, y, z of one dimension"),
        ({"points": np.array([[None] * 3])}, "no points: wanted an array points (n, 3), or x, y and z; got none"),
    ],
)
def test_arrays_that_are_refused(tmp_path, arrays, reason):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(sf.FileError) as caught:
        sf.read_scan(tmp_path / "a.npz")
    assert str(caught.value) == f"{tmp_path / 'a.npz'}: {reason}"


def test_files_that_are_cut_off_or_changed(tmp_path):
    np.savez_compressed(tmp_path / "a.npz", points=POINTS)
    whole = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(whole[:-40])
    with pytest.raises(sf.FileError, match=r"a\.npz: is damaged, or no NPZ file \(File is not a zip file\)"):
        sf.read_scan(tmp_path / "a.npz")
    changed = bytearray(whole)
    changed[len(whole) // 2] ^= 255
    (tmp_path / "a.npz").write_bytes(changed)
    with pytest.raises(sf.FileError, match=r"a\.npz: is damaged, or no NPZ file"):
        sf.read_scan(tmp_path / "a.npz")


def test_an_array_that_claims_more_than_the_file_holds(tmp_path):
    head = io.BytesIO()
    shape = {"descr": "<f8", "fortran_order": False, "shape": (10**12, 3)}
    np.lib.format.write_array_header_1_0(head, shape)
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("points.npy", head.getvalue() + bytes(48))
    with pytest.raises(sf.FileError, match=r"is damaged, or no NPZ file \(the array is larger than the file\)"):
        sf.read_scan(tmp_path / "a.npz")


def test_no_array_takes_the_place_of_another(tmp_path):
    xyz = np.random.default_rng(0).random((9, 3))
    others = {"points": np.arange(9.0), "colors": np.arange(9), "row": np.arange(9) + 100, "i": np.ones(9)}
    np.savez(tmp_path / "a.npz", xyz=xyz, intensity=np.zeros(9), **others)
    scan = sf.read_scan(tmp_path / "a.npz")
    np.testing.assert_array_equal(scan.points, xyz)
    assert scan.reflectance is None
    assert {name: values[1] for name, values in scan.attributes.items()} == {
        "points_": 1.0,
        "colors_": 1,
        "row": 101,
        "intensity": 0.0,
        "i": 1.0,
    }


@pytest.mark.parametrize("damage", [None, "columns", "cut off", "text"])
def test_the_archive_is_closed_by_name_whatever_is_in_it(tmp_path, monkeypatch, damage):
    """And not by whoever collects garbage: elsewhere than in CPython that may be never."""
    opened = []

    class Archive(zipfile.ZipFile):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            opened.append(self)

    path = tmp_path / "a.npz"
    np.savez(path, **({"other": POINTS} if damage == "columns" else {"points": POINTS}))
    if damage == "cut off":
        with zipfile.ZipFile(path) as archive:
            data = archive.read("points.npy")
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("points.npy", data[:-1])
    if damage == "text":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("points.npy", "no array")
    monkeypatch.setattr("surflux.scans.npz.zipfile.ZipFile", Archive)
    if damage is None:
        sf.read_scan(path)
    else:
        with pytest.raises(sf.FileError):
            sf.read_scan(path)
    assert [archive.fp for archive in opened] == [None]
