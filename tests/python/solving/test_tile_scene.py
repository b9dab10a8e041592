"""What counts of the points of a tile and its neighbours."""

import numpy as np
import pytest

import surflux as sf
from small_tiles import saved, survey_of, waves
from surflux.solving.tile_scene import TileScene


def test_withheld_copies_of_a_neighbours_points_do_not_take_their_place(tmp_path):
    """Tiles with a buffer, as programs for LiDAR cut them: 5 m of the neighbour's points again, withheld."""
    points = np.round(waves()[0], 2)
    left = points[:, 0] < 40.0
    near = np.abs(points[:, 0] - 40.0) < 5.0
    surfels = {}
    for name, buffer in (("plain", False), ("buffered", True)):
        paths = []
        for k, own in enumerate((left, ~left)):
            rows = np.concatenate([np.flatnonzero(own), np.flatnonzero(~own & near & buffer)])
            withheld = np.repeat([0, 1], [own.sum(), len(rows) - own.sum()]).astype(np.uint8)
            paths.append(tmp_path / f"{name}{k}.laz")
            sf.Scan(points[rows], attributes={"withheld": withheld}).save(paths[-1])
        survey = survey_of(paths)
        scene = TileScene(survey, 0)
        survey.far.close()
        surfels[name] = scene.surfels.points[np.lexsort(scene.surfels.points.T)]
        assert np.array_equal(scene.alone, np.arange(len(scene.alone)) >= left.sum())
        assert np.all(scene.of_row[scene.alone] == -1)
    at_border = [np.count_nonzero(np.abs(at[:, 0] - 42.5) < 2.495) for at in surfels.values()]
    assert at_border[0] > 200
    assert at_border[0] == at_border[1]


@pytest.mark.parametrize("count", [3, 1])
def test_what_cannot_be_solved_of_a_tile_is_said_of_that_tile(tmp_path, count):
    """Points on a line, that have no plane, and a tile far from all others."""
    sf.Scan(np.column_stack([np.arange(count) + 500.0, np.zeros((count, 2))])).save(tmp_path / "2.laz")
    paths = [*saved(tmp_path, waves()[0]), tmp_path / "2.laz"]
    with pytest.raises(sf.FileError, match=r"2\.laz: (the points lie|normals: the points lie|has 1 point)"):
        survey_of(paths)


def with_header(path, points, step, offset):
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(version="1.4", point_format=7)
    header.scales, header.offsets = np.full(3, step), offset
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.T
    las.write(path)
    return path


@pytest.mark.parametrize("steps", [(0.01, 0.01), (0.01, 0.004)])
@pytest.mark.parametrize("shift", [0.0, 0.0037])
def test_points_that_two_tiles_have_count_once_however_their_files_round_them(tmp_path, steps, shift):
    """X * step + offset is not bit by bit the same of another offset: both counted, and light was up to 40 % off."""
    places = np.array([5e5, 1e5, 300.0]) + np.round(waves()[0], 2)
    x = places[:, 0] - 5e5
    paths = [
        with_header(tmp_path / f"{k}.laz", places[of], step, places[of].min(axis=0) + k * shift)
        for k, (of, step) in enumerate(zip((x < 45.0, x >= 35.0), steps, strict=True))
    ]
    survey = survey_of(paths)
    for k, of in enumerate((x < 45.0, x >= 35.0)):
        scene = TileScene(survey, k)
        found, wanted = (
            np.count_nonzero(np.abs(at[:, 0] - 500040.005) < 8.0)
            for at in (scene.surfels.points, np.unique(places, axis=0))
        )
        assert wanted > 700
        assert found == wanted
        # Each row has the light of a surfel at its place, also where that is of another row.
        at = scene.surfels.points[scene.of_row]
        assert np.abs(at - places[of]).max() < 0.02
    survey.far.close()


@pytest.mark.parametrize("rows", [1, 2, 9])
def test_a_tile_of_a_point_or_a_line_has_normals_by_its_halo(tmp_path, rows):
    """The last tile of a survey; it stopped all of them."""
    points, _ = waves()
    line = np.array([[40.0, 20.0, 3.0 * np.sin(4.0)]]) + np.linspace([0.0, 0.0, 0.0], [0.0, 3.0, 0.0], rows)
    paths = saved(tmp_path, np.concatenate([points[points[:, 0] < 40.0], line]))
    survey = survey_of(paths)
    scene = TileScene(survey, 1)
    survey.far.close()
    slope = np.array([-0.3 * np.cos(4.0), 0.0, 1.0]) / np.hypot(0.3 * np.cos(4.0), 1.0)
    assert np.all(scene.normals @ slope > 0.99)
    assert len(scene.surfels) > 100  # with the halo


def test_tiles_of_a_point_beside_each_other_alone_are_refused_at_the_start(tmp_path):
    """Each counted as the other's halo; the survey ended in its middle, with one tile written."""
    far = np.array([[500.0, 20.0, 0.0], [503.0, 20.0, 0.0]])
    points, _ = waves()
    paths = [tmp_path / f"{k}.laz" for k in range(3)]
    for path, part in zip(paths, (points, far[:1], far[1:]), strict=True):
        sf.Scan(part).save(path)
    with pytest.raises(sf.FileError, match=r"1\.laz: has 1 point; wanted at least 3, or normals"):
        survey_of(paths)
