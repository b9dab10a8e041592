"""Arrays of a Scan are its own, and nobody writes to them."""

import copy
import pickle

import numpy as np
import pytest

import surflux as sf
from surflux._base.frozen import frozen, given_away
from surflux.points.scan import scan_of_columns
from surflux.scans.reading import read_columns

NAMES = "points", "normals", "reflectance", "viewpoints", "rows"


def arrays_of(scan):
    return {name: getattr(scan, name) for name in NAMES} | scan.attributes


def given(dtype):
    up = np.tile([0, 0, 1], (5, 1)).astype(dtype)
    attributes = {"intensity": np.arange(5, dtype=np.uint16), "height": np.zeros(5, dtype)}
    return [np.arange(15).reshape(5, 3).astype(dtype), up, np.ones((5, 3), dtype), attributes, up[:1], np.arange(5)]


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64])
def test_what_becomes_of_the_arrays_given_does_not_matter(dtype):
    source = given(dtype)
    scan = sf.Scan(*source)
    before = {name: values.copy() for name, values in arrays_of(scan).items()}
    for array in [*source[:3], *source[3].values(), *source[4:]]:
        array += 1
    for name, values in arrays_of(scan).items():
        np.testing.assert_array_equal(values, before[name], err_msg=name)


def scans(tmp_path):
    made = sf.Scan(*given(np.float64))
    yield from (made, made[1:3], made[[3, 1]], made[np.arange(5) < 2], sf.read_scan(made.save(tmp_path / "a.npz")))


def test_arrays_are_read_only(tmp_path):
    for scan in scans(tmp_path):
        for values in arrays_of(scan).values():
            with pytest.raises(ValueError, match="read-only"):
                values[:] = 0


def test_a_part_of_a_read_only_array_is_copied():
    whole = np.arange(30.0).reshape(10, 3)
    part = whole[:5]
    part.setflags(write=False)
    scan = sf.Scan(part)
    whole += 1.0
    assert scan.points[0].tolist() == [0, 1, 2]


def test_what_a_reader_gives_away_is_not_copied(tmp_path):
    path = sf.Scan(*given(np.float64)).save(tmp_path / "a.ply")
    read = read_columns(path)
    scan = scan_of_columns(path, read)
    for name, values in {"points": scan.points, "intensity": scan.attributes["intensity"]}.items():
        assert np.shares_memory(values, read.columns[name]), name
    array = given_away(np.zeros(3))
    assert frozen(array) is array
    assert frozen(array, np.float32) is not array


@pytest.mark.parametrize("again", [lambda scan: pickle.loads(pickle.dumps(scan)), copy.deepcopy, copy.copy])
def test_copies_are_read_only_too(again):
    for name, values in arrays_of(again(sf.Scan(*given(np.float64)))).items():
        assert not values.flags.writeable, name


def test_memory_of_others_is_copied():
    data = bytearray(np.arange(5, dtype=np.uint16).tobytes())
    scan = sf.Scan(np.zeros((5, 3)), attributes={"k": np.frombuffer(memoryview(data).toreadonly(), np.uint16)})
    data[:] = bytes(len(data))
    np.testing.assert_array_equal(scan.attributes["k"], np.arange(5))
