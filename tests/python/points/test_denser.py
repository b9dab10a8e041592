"""Normals of points that were thinned while they were read: fitted to those that the file has around them."""

import pickle

import numpy as np
import pytest

import surflux as sf
from surflux.points import denser


def ball(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def town(path, seed, ridge=0.0):
    """Houses 10 m wide that stand 10 m apart, 8 points/m2 from above: ((n,) which are roofs, (n, 3) normals)."""
    random = np.random.default_rng(seed)
    xy = random.uniform(0.0, 120.0, (115_200, 2))
    u, v = np.transpose(xy % 20.0 - 10.0)
    roof = np.maximum(abs(u), abs(v)) < 5.0
    z = np.where(roof, 6.0 + ridge * (5.0 - abs(v)), 0.0) + random.normal(0.0, 0.02, len(xy))
    np.savez(path, points=np.c_[xy, z])
    normals = np.c_[0.0 * u, np.where(roof, ridge * np.sign(v), 0.0), np.ones(len(u))]
    return roof, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def angles(normals, others):
    return np.degrees(np.arccos(np.clip(np.sum(normals * others, axis=1), -1.0, 1.0)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_roofs_of_few_points_shade_a_street_by_their_surface(tmp_path, seed):
    """Fitted to the 17 points that were left of each, normals leant by 18 degrees: the street saw .565 for .52."""
    roof, normals = town(tmp_path / "town.npz", seed)
    scan = sf.read_scan(tmp_path / "town.npz", points=2450, seed=seed)
    roof, normals = roof[scan.rows], normals[scan.rows]
    found = scan.surfels()
    assert np.sqrt(np.mean(angles(found.normals, normals)[roof] ** 2)) < 4.0
    inner = np.all(np.abs(scan.points[:, :2] - 60.0) < 45.0, axis=1)
    ours, true = (sf.sky_view_factor(s) for s in (found, sf.Surfels(scan.points, normals)))
    for some in (inner & roof, inner & ~roof):
        assert np.mean(ours[some]) == pytest.approx(np.mean(true[some]), abs=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_ridges_and_eaves_are_as_sharp_as_in_the_file(tmp_path, seed):
    """Of the roofs' points 40 % were off by more than 20 degrees; some 6 % are."""
    roof, normals = town(tmp_path / "town.npz", seed, ridge=0.7)
    read = sf.read_scan(tmp_path / "town.npz", points=2450, seed=seed)
    found = read.surfels(viewpoint=[60.0, 60.0, 1e4])
    off = angles(found.normals, normals[read.rows])
    assert np.mean(off[roof[read.rows]] > 20.0) < 0.12
    assert np.mean(off > 90.0) == 0.0
    np.testing.assert_array_equal(sf.read(tmp_path / "town.npz", points=2450, seed=seed).points, read.points)


def test_blocks_have_the_normals_of_the_whole(tmp_path, monkeypatch):
    """Which face outwards in each of them."""
    points = ball(40_000) * [1.0, 2.0, 3.0]
    np.savez(tmp_path / "a.npz", points=points)
    whole = sf.read_scan(tmp_path / "a.npz", points=4000)
    passes = []
    estimate = denser._core.estimate_normals

    def counted(of, *rest, **more):
        passes.append(len(of))
        return estimate(of, *rest, **more)

    monkeypatch.setattr(denser, "_BLOCK", 8000)
    monkeypatch.setattr(denser._core, "estimate_normals", counted)
    parts = sf.read_scan(tmp_path / "a.npz", points=4000)
    assert len(passes) > 4
    assert max(passes) < 20_000  # a block, what is around it, and the points that are left
    np.testing.assert_array_equal(whole.rows, parts.rows)
    outwards = whole.points / [1.0, 4.0, 9.0]
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    assert np.max(angles(whole.fitted, parts.fitted)) < 8.0
    assert np.max(angles(whole.fitted, outwards)) < 8.0
    assert angles(sf.Surfels(whole.points).normals, outwards).mean() > 1.5 * angles(whole.fitted, outwards).mean()


def test_noise_wider_than_points_are_apart_is_not_followed(tmp_path):
    """Fits to the densest points are off by 40 degrees there."""
    random = np.random.default_rng(0)
    points = np.c_[random.uniform(0.0, 245.0, (60_000, 2)), random.normal(0.0, 4.0, 60_000)]
    np.savez(tmp_path / "a.npz", points=points)
    found = sf.read_scan(tmp_path / "a.npz", points=1200).surfels()
    upright = np.tile([0.0, 0.0, 1.0], (len(found), 1))
    assert np.sqrt(np.mean(angles(found.normals, upright) ** 2)) < 12.0


def test_files_with_normals_keep_theirs_and_whole_ones_have_no_others(tmp_path):
    points = ball(3000)
    np.savez(tmp_path / "a.npz", points=points)
    assert sf.read_scan(tmp_path / "a.npz").fitted is None
    assert sf.read_scan(tmp_path / "a.npz", points=3000).fitted is None
    normals = np.roll(points, 1, axis=1)
    np.savez(tmp_path / "b.npz", points=points, normals=normals)
    scan = sf.read_scan(tmp_path / "b.npz", points=300)
    assert scan.fitted is None
    np.testing.assert_allclose(scan.surfels().normals, normals[scan.rows], atol=1e-15)
    np.savez(tmp_path / "c.npz", points=points, normals=0.0 * normals)  # which nobody filled in
    with pytest.warns(UserWarning, match="normals are zero"):
        assert np.max(angles(sf.read_scan(tmp_path / "c.npz", points=300).surfels().normals, points[:1])) > 0.0
    line = np.c_[np.arange(3000.0), np.zeros((3000, 2))]
    np.savez(tmp_path / "d.npz", points=line)
    assert sf.read_scan(tmp_path / "d.npz", points=300).fitted is None


def test_points_that_a_survey_calls_noise_are_no_part_of_its_surface(tmp_path):
    random = np.random.default_rng(0)
    points = np.c_[random.uniform(0.0, 100.0, (20_000, 2)), np.zeros(20_000)]
    noise = random.random(20_000) < 0.5
    points[noise, 2] = random.uniform(-3.0, 3.0, noise.sum())
    for name, values in (("classification", np.where(noise, 7, 2)), ("withheld", noise.astype(int))):
        np.savez(tmp_path / "a.npz", points=points, **{name: values})
        scan = sf.read_scan(tmp_path / "a.npz", points=1500)
        ground = scan[~noise[scan.rows]]
        off = angles(ground.surfels(viewpoint=[50.0, 50.0, 1e4]).normals, np.array([[0.0, 0.0, 1.0]]))
        assert np.median(off) < 10.0


def test_fitted_normals_go_with_their_points(tmp_path):
    np.savez(tmp_path / "a.npz", points=ball(9000))
    scan = sf.read_scan(tmp_path / "a.npz", points=900)
    np.testing.assert_array_equal(scan[100:200].fitted, scan.fitted[100:200])
    again = pickle.loads(pickle.dumps(scan))
    np.testing.assert_array_equal(again.fitted, scan.fitted)
    assert not again.fitted.flags.writeable
    np.testing.assert_array_equal(again.surfels().normals, scan.surfels().normals)
    inwards = scan.surfels(viewpoint=[0.0, 0.0, 0.0])
    assert np.min(angles(inwards.normals, scan.points)) > 170.0
    aside = scan.surfels(viewpoint=[0.0, 0.0, 5.0])  # from where most of the ball is seen edge on, or from behind
    assert np.max(angles(aside.normals, scan.points)[scan.points[:, 2] > 0.35]) < 10.0


def test_frames_with_steps_are_fitted_once_these_are_gone(tmp_path):
    """Between steps points are no surface."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 320), np.linspace(-0.4, 0.4, 240))
    steps = np.round((0.2 + 0.1 * u) / 0.003)
    points = np.dstack([u, v, np.ones_like(u)]).reshape(-1, 3) / (0.003 * steps.reshape(-1, 1))
    np.savez(tmp_path / "a.npz", points=points)
    assert sf.read_scan(tmp_path / "a.npz", points=10_000).fitted is None
