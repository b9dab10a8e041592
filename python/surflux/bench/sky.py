"""`surflux bench`: what the points of an aerial LiDAR tile see of the sky."""

import functools
import os
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf

NAME = "sky view of a LiDAR tile"
REFERENCE_RAYS = 4096


def tile(threads):
    """(surfels, seconds, error, against, seconds by stage) of sky_view_factor as it comes, reading included."""
    start = perf_counter()
    surfels = _surfels()
    read = perf_counter() - start
    view = sf.sky_view_factor(surfels, threads=threads)
    seconds = perf_counter() - start
    expected = _reference(threads)
    error = np.sqrt(np.mean((view - expected) ** 2) / np.mean(expected**2))
    stages = {"reading, normals, radii": read, "sky view": seconds - read}
    return len(surfels), seconds, error, f"{REFERENCE_RAYS} rays of another seed, RMS", stages


@functools.cache
def _reference(threads):
    return sf.sky_view_factor(_surfels(), rays=REFERENCE_RAYS, seed=1, threads=threads)


def _surfels():
    return sf.read_scan(Path(os.environ["SURFLUX_DATA"]) / "scans" / "autzen_trim.laz").surfels()
