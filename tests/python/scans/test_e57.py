"""E57 through pye57: several scans, their poses, and points that scanners call invalid."""

import numpy as np
import pytest

import surflux as sf
from surflux._base.color import reflectance_of_colors


@pytest.fixture(autouse=True)
def extra():
    pytest.importorskip("pye57")


def e57(path, *scans):
    """A file of scans, each (data by pye57's names, position or None, quaternion or None)."""
    import pye57

    with pye57.E57(str(path), mode="w") as file:
        for data, position, turn in scans:
            pose = {} if position is None else {"translation": np.array(position), "rotation": np.array(turn)}
            file.write_scan_raw(data, **pose)
    return path


def station(n, seed, **more):
    random = np.random.default_rng(seed)
    # pye57 writes single precision.
    data = {f"cartesian{axis}": random.uniform(1.0, 2.0, n).astype(np.float32).astype(np.float64) for axis in "XYZ"}
    return data | more


QUARTER = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]  # around z: x becomes y, y becomes -x


def test_scans_stand_in_their_poses(tmp_path):
    first, second = station(50, 0), station(30, 1)
    path = e57(tmp_path / "a.e57", (first, [10.0, 20.0, 5.0], QUARTER), (second, [0.0, 0.0, 1.5], [1.0, 0, 0, 0]))
    scan = sf.read_scan(path)
    x, y, z = (first[f"cartesian{axis}"] for axis in "XYZ")
    np.testing.assert_allclose(scan.points[:50], np.stack([10 - y, 20 + x, 5 + z], axis=1), rtol=1e-14)
    x, y, z = (second[f"cartesian{axis}"] for axis in "XYZ")
    np.testing.assert_allclose(scan.points[50:], np.stack([x, y, 1.5 + z], axis=1), rtol=1e-14)
    assert scan.viewpoints.tolist() == [[10.0, 20.0, 5.0], [0.0, 0.0, 1.5]]
    assert scan.viewpoint is None
    assert scan.attributes["scan"].tolist() == [0] * 50 + [1] * 30


def test_the_position_of_a_single_scan_is_the_viewpoint(tmp_path):
    path = e57(tmp_path / "a.e57", (station(5, 0), [10.0, 20.0, 5.0], QUARTER))
    scan = sf.read_scan(path)
    assert scan.viewpoint.tolist() == [10.0, 20.0, 5.0]
    assert "scan" not in scan.attributes


def test_normals_of_each_scan_turn_to_its_scanner(tmp_path):
    grid = np.stack(np.meshgrid(np.arange(15.0), np.arange(15.0)), axis=-1).reshape(-1, 2).T
    floor = {"cartesianX": grid[0], "cartesianY": grid[1], "cartesianZ": np.full(225, -3.0)}
    ceiling = floor | {"cartesianZ": np.full(225, 3.0)}
    straight = [1.0, 0.0, 0.0, 0.0]
    path = e57(tmp_path / "a.e57", (floor, [0.0, 0.0, 0.0], straight), (ceiling, [0.0, 0.0, 1.0], straight))
    wanted = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 225, axis=0)
    np.testing.assert_allclose(sf.read(path).normals, wanted, atol=1e-12)
    scan = sf.read_scan(path)
    np.testing.assert_allclose(scan[scan.attributes["scan"] == 1].surfels().normals, wanted[225:], atol=1e-12)


def test_points_thinned_while_they_are_read_keep_their_scanners(tmp_path):
    stations = (station(600, 0), [10.0, 20.0, 5.0], QUARTER), (station(600, 1), [1.0, 2.0, 3.0], QUARTER)
    path = e57(tmp_path / "a.e57", *stations)
    scan = sf.read_scan(path, points=100)
    np.testing.assert_array_equal(scan.viewpoints, [[10.0, 20.0, 5.0], [1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(scan.attributes["scan"], scan.rows >= 600)


def test_colours_and_intensity_are_kept_and_invalid_points_are_not(tmp_path):
    random = np.random.default_rng(3)
    colors = random.integers(0, 256, (40, 3)).astype(np.uint8)
    more = {f"color{name}": colors[:, k] for k, name in enumerate(("Red", "Green", "Blue"))}
    more["intensity"] = random.random(40).astype(np.float32)
    more["cartesianInvalidState"] = (np.arange(40) % 8 == 0).astype(np.int8)
    path = e57(tmp_path / "a.e57", (station(40, 0, **more), None, None))
    with pytest.warns(UserWarning, match=r"a\.e57: 5 points of 40 left out, without a finite place"):
        scan = sf.read_scan(path)
    valid = np.flatnonzero(np.arange(40) % 8)
    np.testing.assert_array_equal(scan.rows, valid)
    np.testing.assert_allclose(scan.reflectance, reflectance_of_colors(colors[valid], 255.0), atol=1e-6)
    np.testing.assert_array_equal(scan.attributes["intensity"], more["intensity"][valid])


def test_steps_of_reading_join_to_the_whole(tmp_path, monkeypatch):
    data = station(50, 0)
    path = e57(tmp_path / "a.e57", (data, None, None))
    monkeypatch.setattr("surflux.scans.e57._STEP", 7)
    np.testing.assert_array_equal(sf.read_scan(path).points, np.stack([data[f"cartesian{a}"] for a in "XYZ"], axis=1))


def test_spherical_places(tmp_path, monkeypatch):
    from surflux.scans import e57 as reader

    columns = {
        "sphericalRange": [2.0, 1.0],
        "sphericalAzimuth": [np.pi / 2, 0.0],
        "sphericalElevation": [0.0, np.pi / 6],
    }
    columns = {name: np.array(values) for name, values in columns.items()}
    placed = reader._placed(columns, reader._SPHERICAL, None, None)
    np.testing.assert_allclose(placed, [[0.0, 2.0, 0.0], [np.sqrt(0.75), 0.0, 0.5]], atol=1e-15)


def test_files_that_are_cut_off_or_changed(tmp_path):
    whole = e57(tmp_path / "a.e57", (station(500, 0), None, None)).read_bytes()
    for left in (8, 40, 1024, len(whole) - 1024):
        (tmp_path / "a.e57").write_bytes(whole[:left])
        with pytest.raises(sf.FileError, match=r"a\.e57: pye57 cannot read it \("):
            sf.read_scan(tmp_path / "a.e57")
    changed = bytearray(whole)
    changed[len(whole) // 2] ^= 1
    (tmp_path / "a.e57").write_bytes(changed)
    with pytest.raises(sf.FileError, match=r"pye57 cannot read it \(E57Exception: checksum mismatch"):
        sf.read_scan(tmp_path / "a.e57")


def test_files_without_scans(tmp_path):
    with pytest.raises(sf.FileError, match=r"a\.e57: no points: it has none$"):
        sf.read_scan(e57(tmp_path / "a.e57"))
