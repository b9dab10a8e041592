"""What the points of an aerial LiDAR tile see of the sky: a case of `surflux bench`, and `surflux bench --site FOLDER
--only sky_view`.
"""

import os
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf
from surflux import _core
from surflux.bench import scenes
from surflux.bench.areas import percent
from surflux.solving.sky_view import SightLines, even_directions, unobstructed_view

NAME = "sky view of a LiDAR tile"
REFERENCE_RAYS = 4096
RAYS = 64, 256
SEEDS = 0, 1
COMPARED = 2000  # points of the tile


def tile(threads):
    """(surfels, seconds, error, against, seconds by stage) of sky_view_factor as it comes, reading included."""
    start = perf_counter()
    surfels = _surfels()
    read = perf_counter() - start
    view = sf.sky_view_factor(surfels, threads=threads)
    seconds = perf_counter() - start
    some, expected = compared(sf.Scene([surfels]), COMPARED)
    error = np.sqrt(np.mean((view[some] - expected) ** 2) / np.mean(expected**2))
    stages = {"reading, normals, radii": read, "sky view": seconds - read}
    return len(surfels), seconds, error, f"{REFERENCE_RAYS} rays of another seed, RMS", stages


def rows(threads=None):
    """For numbers of rays the RMS error over SEEDS, of the whole sky and of what is seen, against REFERENCE_RAYS others
    at some of the points; and the mean over all points, by each seed."""
    if not scenes.scans_for("sky_view"):
        return []
    scene = sf.Scene([_surfels()])
    some, right = compared(scene, COMPARED)
    found = []
    for rays in RAYS:
        views = [sf.sky_view_factor(scene, rays=rays, seed=seed, threads=threads) for seed in SEEDS]
        error = np.sqrt(np.mean([(view[some] - right) ** 2 for view in views]))
        row = {"rays": rays, "error, % of the sky": percent(error)}
        row["error, % of what is seen"] = percent(error / np.sqrt(np.mean(right**2)))
        found.append(row | {"mean by seed": ", ".join(f"{view.mean():.4f}" for view in views)})
    return found


def compared(scene, count, weighting="cosine", seed=1000):
    """(count of the scene's surfels, their sky-view factors by REFERENCE_RAYS)."""
    lines = SightLines(scene)
    some = np.unique(np.linspace(0, len(lines.normals) - 1, min(count, len(lines.normals))).astype(int))
    directions = even_directions(REFERENCE_RAYS, seed)
    free = _core.free_directions(lines._core, directions, None, some.astype(np.uint32))
    seen, whole = _core.direction_sums(lines.normals[some], free, directions, weighting == "cosine")
    return some, unobstructed_view(lines.normals[some], weighting) * seen / np.maximum(whole, 1e-12)


def _surfels():
    return sf.read_scan(Path(os.environ["SURFLUX_DATA"]) / "scans" / "autzen_trim.laz").surfels()
