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


def test_reflectance_and_emission_are_those_of_surfels(tmp_path):
    """(n, 3), or (n,) for grey, as columns reflectance_r, _g and _b are; NaN is not known: the colour's, or nothing."""
    rho, exitance = np.random.default_rng(2).random((2, 25, 3)) * 0.9
    np.savez(tmp_path / "a.npz", points=POINTS, reflectance=rho, emission=exitance)
    found = sf.read(tmp_path / "a.npz")
    np.testing.assert_allclose(found.reflectance, rho)
    np.testing.assert_allclose(found.emission, exitance)
    rho[3], exitance[4] = np.nan, np.nan
    colors = np.full((25, 3), 255, np.uint8)  # white is .98
    np.savez(tmp_path / "a.npz", points=POINTS, reflectance=rho[:, 0], emission=exitance[:, 0], colors=colors)
    found = sf.read_scan(tmp_path / "a.npz").surfels()
    grey = np.where(np.arange(25) == 3, 0.98, rho[:, 0])
    np.testing.assert_allclose(found.reflectance, np.stack([grey] * 3, axis=1))
    np.testing.assert_allclose(found.emission[:, 2], np.nan_to_num(exitance[:, 0]))
    assert np.all(sf.read(tmp_path / "a.npz", reflectance=0.25).reflectance == 0.25)


@pytest.mark.parametrize(
    ("arrays", "reason"),
    [
        (
            {"reflectance": np.linspace(-20, 3, 25)},
            "reflectance is not used: wanted values from 0 to below 1, got -20 to 3",
        ),
        (
            {"reflectance": np.full((25, 3), 1.0)},
            "reflectance is not used: wanted values from 0 to below 1, got 1 to 1",
        ),
        (
            {"reflectance": np.zeros((25, 4))},
            r"reflectance is not used: wanted shape \(n,\) or \(n, 3\), got \(25, 4\)",
        ),
        ({"emission": np.full(25, -2)}, "emission is not used: wanted values from 0, finite, got -2 to -2"),
        ({"emission": np.full(25, np.inf)}, "emission is not used: wanted values from 0, finite, got inf to inf"),
    ],
)
def test_arrays_that_are_no_reflectance_or_emission_are_told(tmp_path, arrays, reason):
    np.savez(tmp_path / "a.npz", points=POINTS, **arrays)
    with pytest.warns(UserWarning, match=rf"a\.npz: its column {reason}"):
        found = sf.read(tmp_path / "a.npz")
    assert np.all(found.reflectance == 0.5)
    assert not found.emission.any()


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
