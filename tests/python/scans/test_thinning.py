"""Even samples taken while files are read."""

import numpy as np
import pytest

import surflux as sf
from scan_files import pcd, table
from surflux.scans import ply
from surflux.scans.thinning import EvenSample, UniformSample


def sampled(points, limit, seed=0, parts=6):
    sample = EvenSample(limit, seed)
    for part in np.array_split(points, parts):
        sample.add({"points": part})
    return sample.columns()["points"]


@pytest.mark.parametrize("parts", [1, 6, 60])
def test_a_surface_is_sampled_evenly_however_dense_it_was(parts):
    """Half of the points are in a hundredth of the square, and few of the sample are."""
    random = np.random.default_rng(0)
    points = np.zeros((60_000, 3))
    points[:, :2] = random.random((60_000, 2))
    points[::2] *= 0.1
    kept = sampled(points, 1000, parts=parts)
    assert 970 <= len(kept) <= 1000
    corner = np.mean(np.all(kept < 0.1, axis=1))
    assert corner < 0.03  # .01, and cells that the border cuts
    assert len(sampled(points, 60_000)) == 60_000


def test_a_uniform_sample_is_as_dense_as_its_points():
    """Half of the points are in a tenth of the interval: half of the sample, too, however the chunks come."""
    points = np.linspace(0.0, 1.0, 40_000)[:, None] ** [1, 1, 1]
    points[::2] *= 0.1
    for parts in (1, 7, 90):
        sample = UniformSample(4000, seed=1)
        for part in np.array_split(points, parts):
            sample.add(part)
        kept = sample.points()
        assert kept.shape == (4000, 3)
        assert len(np.unique(kept[:, 0])) > 3990
        assert abs(np.mean(kept[:, 0] < 0.1) - 0.55) < 5 * np.sqrt(0.25 / 4000)
    few = UniformSample(4000)
    few.add(points[:3000])
    assert len(few.points()) == 3000


def test_strays_and_coincident_points_take_nothing_from_the_rest():
    random = np.random.default_rng(0)
    points = random.random((20_000, 3)) * [1.0, 1.0, 0.0]
    points[0], points[1] = [1e20, 0.0, 0.0], [-1e30, 0.0, 0.0]
    assert 970 <= len(sampled(points, 1000)) <= 1000
    assert 1 <= len(sampled(np.full((20_000, 3), 5.0), 1000)) <= 10


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("limit", [500, 3000, 14_000])
def test_as_many_points_are_taken_as_are_asked_for(seed, limit):
    """However they come: 97 % or more, which cells of a grid can be made for."""
    random = np.random.default_rng(seed)
    ball = random.normal(size=(30_000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    for points in (ball, ball[np.argsort(ball[:, 2])], random.random((30_000, 3))):
        for parts in (1, 5, 40):
            assert 0.97 * limit <= len(sampled(points, limit, seed, parts)) <= limit


def test_fewer_points_than_were_asked_for_are_told(tmp_path, caplog):
    """Of a thousand places ten points each no sample has 5000."""
    places = np.random.default_rng(0).random((1000, 3))
    np.savez(tmp_path / "a.npz", points=np.tile(places, (10, 1)))
    with caplog.at_level("INFO", "surflux"):
        assert len(sf.read_scan(tmp_path / "a.npz", points=5000)) == 1000
    assert "a.npz: 1000 points are taken, fewer than the 5000 asked for: many stand in one place" in caplog.text


@pytest.mark.parametrize("data", ["ascii", "binary", "binary_compressed"])
def test_files_are_thinned_by_seed_and_rows_say_what_is_left(tmp_path, data):
    rows = table(5000)
    path = pcd(tmp_path / "a.pcd", rows, data)
    scan = sf.read_scan(path, points=200)
    assert 194 <= len(scan) <= 200
    np.testing.assert_array_equal(scan.attributes["label"], scan.rows)
    np.testing.assert_array_equal(scan.points[:, 0], rows["x"][scan.rows])
    assert np.all(np.diff(scan.rows) > 0)
    np.testing.assert_array_equal(sf.read_scan(path, points=200).rows, scan.rows)
    assert not np.array_equal(sf.read_scan(path, points=200, seed=1).rows, scan.rows)
    assert len(sf.read(path, points=200)) == len(scan)
    assert len(sf.read_scan(path, points=5000)) == 5000
    with pytest.raises(ValueError, match=r"^points: wanted a whole number from 2"):
        sf.read(path, points=1)


def test_radii_and_areas_are_made_anew_where_a_file_is_thinned(tmp_path):
    s = sf.Surfels.sample_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 600)
    s.areas = 1.0 / 600
    s.save(tmp_path / "a.ply")
    thin = sf.read(tmp_path / "a.ply", points=60)
    assert thin.areas is None
    assert np.median(thin.radii) > 2.0 * np.median(s.radii)  # sqrt(10) times as far apart


def test_carriage_returns_among_numbers_are_no_ends_of_lines(tmp_path, monkeypatch):
    """A binary PLY with lines that end in LF is read in chunks whatever its bytes."""
    points = np.frombuffer(b"\r" * 12 * 500, dtype="<f4").reshape(-1, 3) * np.arange(500, dtype="<f4")[:, None]
    points[:7] = np.frombuffer(b"\r\r\r\r", dtype="<f4")[0]
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 500\n" + "".join(
        f"property float {c}\n" for c in "xyz"
    )
    (tmp_path / "a.ply").write_bytes(header.encode() + b"end_header\n" + points.astype("<f4").tobytes())
    monkeypatch.setattr(ply, "_read_whole", None)
    assert len(sf.read_scan(tmp_path / "a.ply", points=100).points) <= 100


def test_patches_are_kept_where_nothing_is_thinned_and_else_refused(tmp_path):
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    floor.save(tmp_path / "floor.ply")
    assert len(sf.read(tmp_path / "floor.ply", points=len(floor)).triangles) == len(floor.triangles)
    with pytest.raises(sf.FileError, match=r"floor\.ply: its patches would be torn apart by points=3; read all of it"):
        sf.read(tmp_path / "floor.ply", points=3)
