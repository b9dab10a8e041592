"""solve_tiles: records and outputs that others have altered, and what its messages name."""

import json
import logging

import numpy as np
import pytest

import surflux as sf
from small_tiles import saved, waves
from surflux.points.shades import Shades
from surflux.solving.tile_result import SolvedTile, SolvedTiles

FIGURES = {"points": 9, "left_out": 0, "surfels": 9, "around": 0, "error": 0.01, "seconds": 1.0}
ENTRY = {"key": "k", "file": [1, 2], "figures": FIGURES}


def without(entry, key):
    return {name: value for name, value in entry.items() if name != key}


@pytest.mark.parametrize(
    ("entry", "wrong"),
    [
        ("finished", "wanted an object, got 'finished'"),
        (without(ENTRY, "key"), "'key' is missing"),
        (without(ENTRY, "file"), "'file' is missing"),
        (without(ENTRY, "figures"), "'figures' is missing"),
        (ENTRY | {"figures": [1]}, r"'figures' is \[1\]"),
        (ENTRY | {"figures": without(FIGURES, "points")}, "'points' is missing"),
        (ENTRY | {"figures": FIGURES | {"points": 9.5}}, "'points' is 9.5"),
        (ENTRY | {"figures": FIGURES | {"error": "low"}}, "'error' is 'low'"),
        (ENTRY | {"figures": FIGURES | {"left_out": True}}, "'left_out' is True"),
        (ENTRY | {"figures": FIGURES | {"kept": 1}}, "'kept' does not belong there"),
    ],
)
def test_an_altered_record_is_refused_by_file_and_place(tmp_path, entry, wrong):
    paths = saved(tmp_path, *waves(100))
    (tmp_path / "lit").mkdir()
    record = tmp_path / "lit" / "surflux-tiles.json"
    record.write_text(json.dumps({"tiles": {"0.laz": ENTRY, "1.laz": entry}}))
    with pytest.raises(sf.FileError, match=rf"surflux-tiles.json \(tiles: 1.laz\): is not as it was written: {wrong};"):
        sf.solve_tiles(paths, tmp_path / "lit")


@pytest.mark.parametrize(
    "text", ["[", "[]", '{"tiles": 3}', '{"tile": {}}', '{"tiles": {}, "outputs": 1}', "[" * 100_000]
)
def test_what_is_no_record_is_refused(tmp_path, text):
    paths = saved(tmp_path, *waves(100))
    (tmp_path / "lit").mkdir()
    (tmp_path / "lit" / "surflux-tiles.json").write_text(text)
    with pytest.raises(sf.FileError, match=r"surflux-tiles.json: is no record of solved tiles"):
        sf.solve_tiles(paths, tmp_path / "lit")


def test_a_map_of_altered_outputs_names_them(tmp_path):
    points, _ = waves(100)
    lit = {f"radiosity_{c}": np.ones(100) for c in "rgb"}
    paths = [tmp_path / "0.laz", tmp_path / "1.laz"]
    sf.Scan(points).save(paths[0], lit)
    sf.Scan(points).save(paths[1])  # by another program, without light
    found = SolvedTiles(tuple(SolvedTile(path, path, **FIGURES, kept=False) for path in paths))
    with pytest.raises(sf.FileError, match=r"1.laz: has no radiosity_r, as solve_tiles wrote it; wanted it solved"):
        found.map()
    paths[1].unlink()
    with pytest.raises(sf.FileError, match=r"1.laz"):
        found.map()


def test_a_message_of_exposure_names_the_argument(caplog):
    dark = {"points": np.zeros((4, 3)), "colors": np.full((4, 3), 90, np.uint16)}
    shades = Shades()
    shades.add(dark)
    with caplog.at_level(logging.INFO, "surflux"):
        shades.reflectance(dark)
    assert "(raw_colors keeps them)" in caplog.text
    assert "--" not in caplog.text


def test_points_of_tiles_without_a_colour_are_told(tmp_path):
    """Counted over all tiles: where one has none, its points would reflect nothing, without a word."""
    x, y = np.meshgrid(np.arange(40.0), np.arange(20.0))
    for k in range(2):
        points = np.stack([x.ravel() + 40.0 * k, y.ravel(), np.zeros(x.size)], axis=1)
        sf.Scan(points, reflectance=np.full(points.shape, 0.5 * (1 - k))).save(tmp_path / f"{k}.laz")
    with pytest.warns(UserWarning, match=r"tiles: 800 of 1600 colours are black \(0, 0, 0\), as where a scan has none"):
        sf.solve_tiles([tmp_path / "0.laz", tmp_path / "1.laz"], tmp_path / "out")
