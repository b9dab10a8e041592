"""Points without a colour, which files have black, among others that have one."""

import logging

import numpy as np
import pytest

import surflux as sf
from surflux.cli.commands import main
from surflux.points.exposure import with_colors_beside

RED, BLUE = np.array([0.6, 0.2, 0.1]), np.array([0.1, 0.2, 0.6])


def wall(seed):
    """Points of a wall, red on one side and blue on the other, and which of them lie in a square about a corner."""
    points = np.c_[np.random.default_rng(seed).uniform(size=(4000, 2)), np.zeros(4000)]
    colors = np.where(points[:, :1] < 0.5, RED, BLUE)
    return points, colors, np.all(points[:, :2] < 0.3, axis=1)


@pytest.mark.parametrize("seed", range(3))
def test_black_points_have_the_colours_beside_them(seed, caplog):
    points, colors, corner = wall(seed)
    beside = np.abs(points[:, 0] - 0.5) < 0.1
    with caplog.at_level(logging.INFO, "surflux"):
        found = with_colors_beside(points, np.where((corner | beside)[:, None], 0.0, colors), "--raw-colors")
    assert "hardly any being nearly so, have the colours beside them (--raw-colors: none)" in caplog.text
    np.testing.assert_allclose(found[corner], np.tile(RED, (corner.sum(), 1)))
    np.testing.assert_array_equal(found[~(corner | beside)], colors[~(corner | beside)])
    near_red = beside & (points[:, 0] < 0.44)
    assert np.abs(found[near_red] - RED).max() < 0.5 * np.abs(RED - BLUE).max()


def test_black_of_a_picture_stays():
    """Its dark places go down to black; and where all are black, or few, none lacks a colour."""
    points, colors, corner = wall(0)
    dark = np.where(corner[:, None], np.clip(np.random.default_rng(0).uniform(-0.01, 0.01, (4000, 1)), 0, 1), colors)
    few = colors * (np.arange(4000) > 20)[:, None]
    for rho in (dark, few, np.zeros((4000, 3))):
        assert with_colors_beside(points, rho, "") is rho
    far = points + [5, 0, 0] * (np.arange(4000) < 2000)[:, None]
    found = with_colors_beside(far, RED * (np.arange(4000) >= 2000)[:, None], "")
    np.testing.assert_allclose(found, np.tile(RED, (4000, 1)))  # the mean, where only black is near


def test_solve_lights_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    points, colors, corner = wall(0)
    bytes_of = np.where(corner[:, None], 0, np.round(255 * colors ** (1 / 2.2))).astype(np.uint8)
    rows = np.c_[points, bytes_of]
    np.savetxt("wall.csv", rows, fmt="%.6f %.6f %.6f %d %d %d", header="x y z red green blue", comments="")
    for options, least in ([], 0.05), (["--raw-colors"], 0.0):
        assert main(["solve", "wall.csv", "--light", "sky", "--no-image", "-o", "lit.ply", *options]) == 0
        lit = sf.read_scan("lit.ply")
        reflectance = [lit.attributes[f"reflectance_{c}"] for c in "rgb"]
        assert np.min(reflectance) >= least
        assert (np.min(reflectance) == 0.0) == bool(options)
