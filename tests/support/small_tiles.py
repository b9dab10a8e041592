"""Two small tiles side by side, and the survey that solve_tiles makes of them."""

import numpy as np

import surflux as sf
from surflux.scans.tiling import tile_header
from surflux.solving.tile_survey import Survey, TileOptions


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
