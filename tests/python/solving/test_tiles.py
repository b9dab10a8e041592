"""solve_tiles: rows taken home, light as of the whole survey, runs that go on, refusals."""

import json

import numpy as np
import pytest

import surflux as sf
from surflux.scenes.studio import clear_day

SIDE, EACH = 40.0, 1200
HALO = 15.0
ABOVE = (SIDE, SIDE, 1000.0)


def hills(seed, count=4 * EACH):
    """Points of rolling ground of 2 x 2 tiles."""
    xy = np.random.default_rng(seed).uniform(0.0, 2.0 * SIDE, (count, 2))
    return np.column_stack([xy, 3.0 * np.sin(xy[:, 0] / 7.0) * np.cos(xy[:, 1] / 9.0)])


def in_tiles(points, folder):
    """Paths of the points as 2 x 2 tiles, and the rows of each."""
    paths, rows = [], []
    for k in range(4):
        low = SIDE * np.array([k % 2, k // 2])
        of = np.flatnonzero(np.all((points[:, :2] >= low) & (points[:, :2] < low + SIDE), axis=1))
        paths.append(folder / f"tile{k}.laz")
        sf.Scan(points[of]).save(paths[-1])
        rows.append(of)
    return paths, rows


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tiles")
    points = hills(0)
    paths, rows = in_tiles(points, folder)
    return points, paths, rows, sf.solve_tiles(paths, folder / "lit", halo=HALO, viewpoint=ABOVE)


def test_outputs_have_all_rows_of_their_tiles_in_order(solved):
    _, paths, _, tiles = solved
    for path, tile in zip(paths, tiles, strict=True):
        before, after = sf.read_scan(path), sf.read_scan(tile.output)
        assert np.array_equal(before.points, after.points)
        assert after.attributes["left_out"].shape == (len(before),)
        assert {"irradiance_r", "direct_r", "radiosity_r"} <= set(after.attributes)
        assert tile.points == len(after)


@pytest.mark.slow
def test_light_is_that_of_the_whole_survey_also_at_borders(solved):
    points, _, rows, tiles = solved
    scene = sf.Scene([sf.Scan(points).surfels(viewpoint=ABOVE)], [clear_day(150.0)])
    whole, other = (sf.solve(scene, insert=False, seed=seed).per_surfel("irradiance")[:, 0] for seed in (0, 1))
    found = np.empty(len(points))
    for of, tile in zip(rows, tiles, strict=True):
        found[of] = sf.read_scan(tile.output).attributes["irradiance_r"]
    border = np.any(np.abs(points[:, :2] - SIDE) < 2.0, axis=1)
    chance = np.sqrt(np.mean((whole - other) ** 2))  # what two solutions of the whole differ by
    for of in (border, ~border):
        assert np.sqrt(np.mean((found - whole)[of] ** 2)) < 1.5 * chance


def roughly(paths, folder, halo=HALO, **given):
    """solve_tiles in a tenth of a second each."""
    rough = {"transport": "rays", "rays": 16, "zeta": 1.0, "insert": False}
    given |= {"halo": halo, "lights": [sf.Environment(1.0)], "solve_options": rough, "viewpoint": ABOVE}
    return sf.solve_tiles(paths, folder, **given)


@pytest.mark.slow
def test_a_finished_run_is_kept_and_other_options_solve_again(tmp_path):
    paths, _ = in_tiles(hills(1, 800), tmp_path)
    first = roughly(paths, tmp_path / "lit")
    assert not any(tile.kept for tile in first)
    again = roughly(paths, tmp_path / "lit")
    assert all(tile.kept for tile in again)
    assert [tile.error for tile in again] == [tile.error for tile in first]
    (tmp_path / "lit" / "tile2.laz").unlink()
    assert [tile.kept for tile in roughly(paths, tmp_path / "lit")] == [True, True, False, True]
    assert not any(tile.kept for tile in roughly(paths, tmp_path / "lit", 2 * HALO))


@pytest.mark.slow
def test_a_stopped_run_goes_on_and_ends_as_one_that_was_not(tmp_path):
    paths, _ = in_tiles(hills(2, 800), tmp_path)
    second = tmp_path / "lit" / "tile1.laz"
    with pytest.raises(sf.Cancelled):
        roughly(paths, tmp_path / "lit", progress=lambda *_: not second.exists())
    assert sorted(path.name for path in (tmp_path / "lit").iterdir()) == [
        "surflux-tiles.json",
        "tile0.laz",
        "tile1.laz",
    ]
    record = tmp_path / "lit" / "surflux-tiles.json"
    found = json.loads(record.read_text())
    del found["tiles"]["tile1.laz"]  # as where the power fails after an output is written, and before it is noted
    record.write_text(json.dumps(found))
    assert [tile.kept for tile in roughly(paths, tmp_path / "lit")] == [True, False, False, False]
    roughly(paths, tmp_path / "at once")
    for path in paths:
        stopped, whole = (sf.read_scan(tmp_path / folder / path.name).attributes for folder in ("lit", "at once"))
        np.testing.assert_array_equal(stopped["irradiance_r"], whole["irradiance_r"])


def test_what_cannot_be_is_refused_by_name(solved, tmp_path):
    _, paths, _, _ = solved
    with pytest.raises(ValueError, match="paths: wanted at least one tile"):
        sf.solve_tiles([], tmp_path)
    with pytest.raises(ValueError, match="paths: wanted a list"):
        sf.solve_tiles(str(paths[0]), tmp_path)
    with pytest.raises(ValueError, match="is a tile itself"):
        sf.solve_tiles(paths, paths[0].parent)
    with pytest.raises(ValueError, match="halo"):
        sf.solve_tiles(paths, tmp_path, halo=0.0)
    with pytest.raises(ValueError, match="seed is an argument of its own"):
        sf.solve_tiles(paths, tmp_path, solve_options={"seed": 1})
    broken = tmp_path / "broken.laz"
    broken.write_bytes(paths[0].read_bytes()[:300])
    with pytest.raises(sf.FileError, match="broken"):
        sf.solve_tiles([*paths, broken], tmp_path / "out")


def test_files_that_are_not_its_own_stay(solved, tmp_path):
    _, paths, _, _ = solved
    folder = tmp_path / "lit"
    folder.mkdir()
    (folder / "tile0.laz").write_bytes(b"mine")
    with pytest.raises(sf.FileError, match="is there already"):
        sf.solve_tiles(paths, folder)
    assert (folder / "tile0.laz").read_bytes() == b"mine"
    (folder / "tile0.laz").unlink()
    (folder / "surflux-tiles.json").write_text(json.dumps({"other": 1}))
    with pytest.raises(sf.FileError, match="no record of solved tiles"):
        sf.solve_tiles(paths, folder)
