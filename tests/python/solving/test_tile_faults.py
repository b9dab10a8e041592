"""solve_tiles: records and outputs that others have altered, what its messages name, and normals estimated once."""

import json
import logging

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.points.shades import Shades
from surflux.scans.tiling import tile_header
from surflux.solving.tile_result import SolvedTile, SolvedTiles
from surflux.solving.tile_scene import TileScene, thinned_parts
from surflux.solving.tile_survey import Survey, TileOptions

FIGURES = {"points": 9, "left_out": 0, "surfels": 9, "around": 0, "error": 0.01, "seconds": 1.0}
ENTRY = {"key": "k", "file": [1, 2], "figures": FIGURES}


def waves(count=4000, seed=0):
    """Points of a wavy surface of 40 m, twice as long in x, and its normals."""
    xy = np.random.default_rng(seed).uniform(0.0, [80.0, 40.0], (count, 2))
    normals = np.column_stack([-0.3 * np.cos(xy[:, 0] / 10.0), np.zeros(count), np.ones(count)])
    return np.column_stack([xy, 3.0 * np.sin(xy[:, 0] / 10.0)]), normals / np.linalg.norm(normals, axis=1)[:, None]


def saved(folder, points, normals=None):
    """Paths of two tiles of points, left and right."""
    left = points[:, 0] < 40.0
    for k, of in enumerate((left, ~left)):
        sf.Scan(points[of], None if normals is None else normals[of]).save(folder / f"{k}.laz")
    return [folder / "0.laz", folder / "1.laz"]


def survey_of(paths, **options):
    """The Survey of tiles and its options, as solve_tiles makes them."""
    usual = {"halo": 10.0, "far": 4.0, "points": 1_000_000, "viewpoint": None, "normals": "check"}
    usual |= {"keep_outliers": False, "raw_colors": False, "seed": 0}
    return Survey([tile_header(path) for path in paths], paths[0].parent, TileOptions(**usual | options))


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


@pytest.mark.parametrize("text", ["[", "[]", '{"tiles": 3}', '{"tile": {}}', "[" * 100_000])
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


def test_normals_are_estimated_once_for_each_point_of_a_tile(tmp_path, monkeypatch):
    """The first pass has those of the thinned surface alone, and looks for no side: it is known."""
    paths = saved(tmp_path, waves()[0])
    counts, real = [], _core.estimate_normals

    def counted(points, neighbors, viewpoint, **more):
        assert viewpoint is not None
        counts.append(len(points))
        return real(points, neighbors, viewpoint, **more)

    monkeypatch.setattr(_core, "estimate_normals", counted)
    survey = survey_of(paths)
    first, counts[:] = sum(counts), []
    for k in range(2):
        TileScene(survey, k)
    survey.far.close()
    assert 4000 <= sum(counts) <= 6000  # a halo of 10 m beside 40
    assert 200 <= first <= 4000 / 16  # far = 4


@pytest.mark.parametrize("seed", range(3))
def test_normals_of_what_lies_far_are_those_of_the_surface(tmp_path, seed):
    """Fitted to points of a 40 m tile 3.9 m apart: the slope over as much differs by half of that times .03 / m."""
    paths = saved(tmp_path, waves(seed=seed)[0])
    survey = survey_of(paths)
    points, normals, _, _ = thinned_parts(survey, survey.far.around(*survey.far._boxes[0]))
    survey.far.close()
    assert np.all(points[:, 0] > 50.0)
    slope = 0.3 * np.cos(points[:, 0] / 10.0)
    true = np.column_stack([-slope, np.zeros(len(slope)), np.ones(len(slope))]) / np.sqrt(1.0 + slope**2)[:, None]
    angle = np.degrees(np.arccos(np.clip(np.sum(true * normals, axis=1), -1.0, 1.0)))
    assert np.median(angle) < np.degrees(0.5 * 3.9 * 0.03)
    assert np.all(normals[:, 2] > 0.0)


def test_normals_that_a_file_has_stay_and_those_that_it_lacks_face_as_they_do(tmp_path):
    points, normals = waves()
    normals = -normals
    normals[::50] = 0.0
    survey = survey_of(saved(tmp_path, points, normals), normals="keep")
    _, found, _, _ = thinned_parts(survey, survey.overview)
    survey.far.close()
    assert len(found) > 100
    assert np.all(found[:, 2] < 0.0)


def test_few_points_have_normals_of_all_that_there_are(tmp_path):
    """A tile of which the thinned surface has too few points for fits."""
    points = waves(120)[0]
    survey = survey_of(saved(tmp_path, points), viewpoint=np.array([40.0, 20.0, 1000.0]))
    _, found, _, _ = thinned_parts(survey, survey.overview)
    survey.far.close()
    assert 3 < len(found) < 100
    assert np.all(found[:, 2] > 0.8)
