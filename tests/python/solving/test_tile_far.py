"""What lies far from a tile of solve_tiles: its normals, estimated once, and how high its disks stand."""

import numpy as np
import pytest

from small_tiles import saved, survey_of, waves
from surflux import _core
from surflux.geometry.estimates import estimated_radii
from surflux.scans.lattice import Lattice
from surflux.solving.tile_scene import TileScene, thinned_parts


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


def walls(seed):
    """Level ground of 80 m by 40, 1.5 points a square metre, and six walls 6 m high, a quarter as dense; normals."""
    random = np.random.default_rng(seed)
    parts, normals = (
        [np.column_stack([random.uniform(0.0, [80.0, 40.0], (4800, 2)), np.zeros(4800)])],
        [[0.0, 0.0, 1.0]],
    )
    for x in (44.0, 49.5, 50.5, 56.0, 63.0, 71.0):
        parts.append(np.column_stack([np.full(72, x), random.uniform([5.0, 0.0], [35.0, 6.0], (72, 2))]))
        normals.append([-1.0, 0.0, 0.0])
    return np.concatenate(parts), np.repeat(normals, [len(part) for part in parts], axis=0)


@pytest.mark.parametrize("seed", range(3))
def test_no_disk_of_what_lies_far_stands_above_all_that_is_there(tmp_path, seed):
    """Disks of walls threw shadows that the whole survey has not: their radii were made of near and far points."""
    survey = survey_of(saved(tmp_path, *walls(seed)))
    tile = TileScene(survey, 0)
    survey.far.close()
    s = tile.surfels
    steep = np.sqrt(1.0 - s.normals[:, 2] ** 2)
    top, is_far = s.points[:, 2] + s.radii * steep, s.points[:, 0] > 50.0
    assert np.count_nonzero(is_far & (steep > 0.9)) >= 10
    assert top[is_far].max() <= 6.0 + survey.spacing
    near = ~is_far
    np.testing.assert_array_equal(s.radii[near], estimated_radii(s.points[near], s.normals[near]))


def test_each_point_of_a_lattice_knows_the_most_of_its_cell():
    random = np.random.default_rng(0)
    points, values = random.normal(size=(500, 3)), random.normal(size=500)
    lattice = Lattice(0, np.zeros(3))
    turned = lattice.turned(points)
    rows, most = lattice.nearest_and_most(turned, 0.7, values)
    np.testing.assert_array_equal(rows, lattice.nearest(turned, 0.7))
    cells = lattice.cells(turned, 0.7)
    assert len(rows) == len(np.unique(cells))
    np.testing.assert_array_equal(most, [values[cells == cells[row]].max() for row in rows])
