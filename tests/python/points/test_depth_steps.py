"""Frames of depth cameras, whose depth has steps: points are moved to the planes that they are steps of."""

import logging

import numpy as np
import pytest

import surflux as sf
from surflux.cli.commands import main
from surflux.points.depth_steps import depth_step

STEP = 0.003


def rays(width=160, height=120):
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, width), np.linspace(-0.4, 0.4, height))
    return np.dstack([u, v, np.ones_like(u)]).reshape(-1, 3)


def room(step=STEP, seed=None):
    """A corner of two walls and a floor, 2 to 5 m away, as a depth camera measures it: (points, true disparities)."""
    d = rays()
    disparity = np.max([0.2 + 0.05 * d[:, 0], 0.3 - 0.4 * d[:, 0], 0.2 + 0.5 * d[:, 1]], axis=0)
    noise = 0.0 if seed is None else np.random.default_rng(seed).uniform(-0.7, 0.7, len(d))
    return d / (step * np.round(disparity / step + noise))[:, None], disparity


def off(points, disparity):
    return np.sqrt(np.mean(np.square((1.0 / np.abs(points[:, 2]) - disparity) / STEP)))


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_walls_are_planes_again(seed):
    points, disparity = room(seed=seed)
    found = sf.Scan(points, attributes={"label": np.arange(len(points))}).without_depth_steps()
    assert len(found) > 0.99 * len(points)
    assert off(found.points, disparity[found.attributes["label"]]) < 0.5 * off(points, disparity)
    assert turned(found.points) < 0.4 * turned(points)


@pytest.mark.parametrize("share", [0.02, 0.05])
def test_flying_pixels_are_left_out_and_change_nothing_else(share):
    """They doubled what was taken for noise, by which all is measured: all were moved to walls, and bars with them."""
    d = rays(320, 240)
    bar = np.abs(d[:, 0] - 0.2) < 3.5 / 320
    disparity = 0.35 + 0.1 * d[:, 0] + 0.05 * d[:, 1] + 8 * STEP * bar
    steps = np.round(disparity / STEP)
    rng = np.random.default_rng(0)
    flying = rng.random(len(d)) < share
    steps[flying] -= rng.integers(10, 20, np.count_nonzero(flying))
    found = sf.Scan(d / (STEP * steps)[:, None], attributes={"label": np.arange(len(d))}).without_depth_steps()
    kept = found.attributes["label"]
    assert np.mean(flying[kept]) < 0.2 * share
    right = ~flying[kept]
    assert np.count_nonzero(right) > 0.999 * np.count_nonzero(~flying)
    assert off(found.points[right], disparity[kept][right]) < 0.1


@pytest.mark.parametrize("seed", range(3))
def test_spots_that_are_off_alike_lie_on_their_wall(seed):
    """Neighbours share what their disparity is taken from: a wall had bumps of up to two steps, with their shadows."""
    d, rng = rays(320, 240), np.random.default_rng(seed)
    disparity = 0.35 + 0.03 * d[:, 0] + 0.02 * d[:, 1]
    noise, is_spot = rng.uniform(-0.6, 0.6, len(d)), np.zeros(len(d), bool)
    for place in d[rng.choice(len(d), 40, replace=False)]:
        spot = np.hypot(*(d - place)[:, :2].T) < 3.5 / 320
        noise[spot], is_spot = rng.uniform(1.4, 1.9), is_spot | spot
    measured = STEP * np.round(disparity / STEP + noise)
    found = sf.Scan(d / measured[:, None], attributes={"label": np.arange(len(d))}).without_depth_steps()
    kept = found.attributes["label"]
    there = is_spot[kept]
    assert off(found.points[there], disparity[kept][there]) < 0.5
    assert off(found.points[~there], disparity[kept][~there]) < 0.15


def test_a_stray_far_off_the_picture_changes_nothing():
    points, disparity = room()
    found = sf.Scan(np.vstack([points, [[5.0, 5.0, 0.005]]])).without_depth_steps()
    assert off(found.points[:-1], disparity) < 0.5 * off(points, disparity)


def turned(points):
    """The share of the estimated normals of the left wall that are more than 10 degrees off."""
    left = points[:, 0] < -0.3 * points[:, 2]
    normals = sf.Surfels(points, viewpoint=[0, 0, 0]).normals[left]
    return np.mean(normals @ [0.8, 0.0, -0.6] < np.cos(np.radians(10.0)))


def test_a_camera_may_look_back_and_its_rows_keep_what_they_have():
    points, disparity = room()
    scan = sf.Scan(points * [1, 1, -1], attributes={"label": np.arange(len(points))})
    found = scan.without_depth_steps()
    assert off(found.points, disparity[found.attributes["label"]]) < 0.5 * off(scan.points, disparity)
    assert np.all(found.points[:, 2] < 0.0)


def test_what_has_no_steps_stays_as_it_is():
    points, disparity = room()
    exact = rays() / disparity[:, None]
    sphere = np.random.default_rng(0).normal(size=(5000, 3))
    millimetres = np.round(exact, 3)
    terrain = np.column_stack([np.random.default_rng(1).uniform(0, 100, (9000, 2)), np.repeat(np.arange(9.0), 1000)])
    for other in (exact, sphere, millimetres, terrain, points[:500], np.zeros((2000, 3))):
        scan = sf.Scan(other)
        assert depth_step(scan.points) is None
        assert scan.without_depth_steps() is scan


def test_reading_clean_takes_steps_off(tmp_path):
    points, disparity = room()
    sf.Scan(points).save(tmp_path / "frame.ply")
    (tmp_path / "scene.toml").write_text("""[[object]]
file = "frame.ply"
clean = true
""")
    for surfels in (sf.read(tmp_path / "frame.ply", clean=True), sf.load_scene(tmp_path / "scene.toml").surfels):
        assert len(surfels) == len(points)
        assert off(surfels.points, disparity) < 0.5 * off(points, disparity)
    assert sf.read(tmp_path / "frame.ply").points == pytest.approx(points)


def test_progress_cancels():
    with pytest.raises(sf.Cancelled):
        sf.Scan(room()[0]).without_depth_steps(progress=lambda done, total: False)


@pytest.mark.parametrize("option", [[], ["--keep-steps"]])
def test_solve_lights_the_planes_and_writes_the_points_as_read(option, tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    points, _ = room(seed=0)
    points[60 * 160 + 130] *= 0.5  # in the middle of a wall
    sf.Scan(points).save("frame.ply")
    with caplog.at_level(logging.INFO, "surflux"):
        assert main(["solve", "frame.ply", "--rays", "16", "-o", "lit.npz", "--no-image", *option]) == 0
    lit = np.load("lit.npz")
    assert lit["points"] == pytest.approx(points)
    assert ("depth is in steps" in caplog.text) == (not option)
    irradiance = lit["irradiance"]
    assert np.isnan(irradiance[60 * 160 + 130]).all()
    rest = irradiance[np.isfinite(irradiance).all(axis=1)]
    assert len(rest) > 0.98 * len(points)


@pytest.mark.scans
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "share"),
    [("office1", 0.3), ("region_growing_rgb_tutorial", 0.6), ("table_scene_mug_stereo_textured", 0.75)],
)
def test_disks_of_real_frames_do_not_stand_like_scales(name, share, scans):
    """Their black backs were seen from all sides: in office1 they took an eighth of the light, now a hundredth."""
    scan = sf.read_scan(scans / "scans" / f"{name}.pcd")
    found = scan.without_depth_steps()
    assert len(found) > 0.99 * len(scan)
    depths = [np.abs(of.points[:, 2]).mean() for of in (scan, found)]
    assert depths[1] == pytest.approx(depths[0], rel=0.005)
    assert into_backs(found) < share * into_backs(scan)


def into_backs(scan):
    """What of the light ends on backs, of every fourth point under an even sky."""
    surfels = scan[::4].surfels(0.5, viewpoint=[0, 0, 0])
    figures = sf.solve(sf.Scene([surfels], [sf.Environment(1.0)]), rays=32, insert=False).history[-1]
    return np.sum(figures["power_into_backs"]) / np.sum(figures["power_absorbed"])
