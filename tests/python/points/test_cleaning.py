"""Points that are not of the surface: repeats, and what stands alone."""

import numpy as np
import pytest

import surflux as sf
from surflux.cli.cloud import CLOUD_LIMIT, Cloud
from surflux.cli.commands import RUNS
from surflux.cli.options import command_line
from surflux.points.cleaning import cleaned, first_of_each, isolated, known_classes


def square(n, seed):
    """Random points of a square of side 1, uneven as scans are."""
    return np.column_stack([np.random.default_rng(seed).random((n, 2)), np.zeros(n)])


def test_repeats_count_as_the_first():
    points = square(1000, 0)
    order = np.random.default_rng(1).permutation(3000)
    many = np.tile(points, (3, 1))[order]
    first = first_of_each(many)
    assert np.array_equal(many[first], many)
    kept = first == np.arange(3000)
    assert kept.sum() == 1000
    for row in range(3000):
        assert first[row] == np.flatnonzero(order % 1000 == order[row] % 1000)[0]


def test_zero_has_one_sign():
    assert first_of_each(np.array([[0.0, 1.0, 2.0], [-0.0, 1.0, 2.0]])).tolist() == [0, 0]


def test_the_back_of_a_sheet_is_no_repeat():
    points = np.zeros((5, 3))
    normals = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0.1, 1], [0, 0.1, -1], [0, 0, -1]])
    assert first_of_each(points, normals).tolist() == [0, 1, 0, 1, 1]


def test_what_stands_alone_is_found_at_any_density():
    """Half the square is a hundred times as dense: the sparse half is not alone, two points above are."""
    for seed in range(3):
        points = square(20_000, seed)
        sparse = (points[:, 0] > 0.5) & (np.arange(len(points)) % 100 > 0)
        points = points[~sparse]
        alone = np.array([[0.2, 0.5, 0.3], [0.7, 0.2, 0.9]])
        found = isolated(np.concatenate([points, alone]))
        assert found[-2:].all()
        assert found[:-2].mean() < 1e-3


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("clump", "strays"), [(1, True), (5, True), (8, True), (15, True), (16, False), (60, False)])
def test_clumps_too_small_for_a_surface_float(clump, strays, seed):
    """As dense as the square that they float over. A wire beside it is none, nor is the edge of the square."""
    rng = np.random.default_rng(seed)
    points = square(10_000, seed)
    floating = rng.normal([0.5, 0.5, 0.6], 0.01, (clump, 3))
    wire = np.column_stack([np.linspace(0, 1, 200), np.full(200, 1.5), np.full(200, 0.4)])
    found = isolated(np.concatenate([points, wire, floating]))
    assert found[-clump:].all() == strays
    assert found[-clump:].any() == strays
    assert not found[len(points) : -clump].any()
    assert found[: len(points)].mean() < 1e-3


@pytest.mark.scans
def test_no_disk_of_a_thinned_scan_reaches_into_the_air(scans):
    """Clumps of leaves that thinning left two or three points of had disks as large as the lion's head."""
    scan = sf.read_scan(scans / "statues/lion_takanawa_342k_surfels.ply", points=50_000)
    radii = scan[cleaned(scan)[0]].surfels().radii
    assert radii.max() < 12.5 * np.median(radii)


def test_a_withheld_point_does_not_stand_for_another_at_its_place():
    points = np.concatenate([square(1000, 2), square(1000, 2)[:5]])
    scan = sf.Scan(points, attributes={"withheld": (np.arange(1005) < 5).astype(np.uint8)})
    used, first, left_out = cleaned(scan)
    assert used.tolist() == list(range(5, 1005))
    assert np.flatnonzero(left_out).tolist() == [0, 1, 2, 3, 4]
    assert np.array_equal(first, np.arange(1005))
    assert cleaned(scan, keep_outliers=True)[0].tolist() == list(range(1000))


def test_uneven_sampling_is_not_cleaned():
    """Of the corners of a mesh with few large faces, more than a hundredth are far from others."""
    points = np.concatenate([square(2000, 3), 5.0 * square(60, 4) + [2.0, 0.0, 0.0]])
    points[2000:, 2] = np.linspace(1, 9, 60)
    assert not isolated(points).any()
    assert not isolated(points[:10]).any()


def cluttered():
    """A square, its first five points again at the end, and one that stands alone."""
    points = np.concatenate([square(1000, 2), [[0.5, 0.5, 9.0]], square(1000, 2)[:5]])
    return sf.Scan(points)


def test_a_scan_is_cleaned_in_one_way(caplog):
    scan = cluttered()
    with caplog.at_level("INFO"):
        used, first, alone = cleaned(scan)
    assert used.tolist() == list(range(1000))
    assert first.tolist() == [*range(1001), 0, 1, 2, 3, 4]
    assert np.flatnonzero(alone).tolist() == [1000]
    said = [record.getMessage() for record in caplog.records]
    assert said == [
        "counted once, for another one stands at their place: 5 points",
        "isolated, left out of light and picture: 1 point of 1006 (--keep-outliers keeps them)",
    ]
    caplog.clear()
    with caplog.at_level("INFO"):
        used, _, alone = cleaned(scan, keep_outliers=True, say=False)
    assert used.tolist() == list(range(1001))
    assert not alone.any()
    assert not caplog.records


def test_read_cleans_a_file_as_the_command_does(tmp_path, caplog):
    scan, withheld = cluttered(), np.arange(1006) == 7
    path = sf.Scan(scan.points, attributes={"withheld": withheld.astype(np.uint8)}).save(tmp_path / "a.npz")
    options = command_line(RUNS, CLOUD_LIMIT).parse_args(["solve", str(path), "--raw-colors", "--normals", "keep"])
    with caplog.at_level("INFO"):
        found = sf.read(path, clean=True)
    assert np.array_equal(found.points, np.delete(scan.points[:1000], 7, axis=0))
    assert "1 point of 1006 (clean = false keeps them)" in caplog.text
    command = Cloud(options).surfels
    assert all(np.array_equal(getattr(found, name), getattr(command, name)) for name in ("points", "normals", "radii"))
    assert len(sf.read(path)) == 1006


def test_what_cannot_be_cleaned_is_refused(tmp_path):
    patches = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])).save(tmp_path / "a.ply")
    with pytest.raises(sf.FileError, match=r"a\.ply: has patches, of which none is left out: clean is for points"):
        sf.read(patches, clean=True)
    withheld = {"withheld": np.ones(100, np.uint8)}
    path = sf.Scan(square(100, 0), attributes=withheld).save(tmp_path / "b.npz")
    with pytest.raises(sf.FileError, match=r"b\.npz: all of its points are withheld; clean = false takes them"):
        sf.read(path, clean=True)
    with pytest.raises(ValueError, match=r"^clean: wanted True or False, got 1"):
        sf.read(path, clean=1)


def test_what_is_no_whole_number_is_no_class(caplog):
    with caplog.at_level("INFO"):
        assert known_classes("a.csv", np.array([2.0, np.nan, 6.0, np.inf, 1e300, 2.5])).tolist() == [2, 0, 6, 0, 0, 0]
        assert (
            "a.csv: 4 points of 6 without a class (at index 1: nan) count as class 0, never classified" in caplog.text
        )
        caplog.clear()
        assert known_classes("a.csv", np.array([2, 255], np.uint8)).tolist() == [2, 255]
        assert known_classes("a.csv", np.array([3.0, 4.0])).tolist() == [3, 4]
    assert not caplog.records
