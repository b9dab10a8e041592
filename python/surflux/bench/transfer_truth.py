"""What `surflux bench --transfer` measures against: path tracing at random places, and how far a transfer is from it.

A surfel that is a patch stands for the mean over it, one that is a disk for its centre; surfels are drawn by area. Each
has rounds of paths from places of its own, so that variances, which errors are to be without, are known.
"""

from dataclasses import dataclass

import numpy as np

import surflux as sf
from surflux import _core
from surflux._base.passes import thread_limit
from surflux.bench.pictures import unproject
from surflux.bench.truth import LEAST_PATHS, area_sample, places_on

MEASURED = 6000  # surfels for each lamp
ROUNDS = 8  # of each, from one place
PATHS = 32  # of each round
PIXELS = 3000
PATHS_A_PIXEL = 256


@dataclass
class LampTruth:
    """Irradiance of area-sampled surfels under one lamp: rows (m,), and (m, 3) each."""

    index: np.ndarray
    total: np.ndarray
    indirect: np.ndarray
    total_error: np.ndarray  # standard errors
    indirect_error: np.ndarray


def traced(scene, lamp, surfels, *, count=MEASURED, seed=0, threads=None):
    """The LampTruth of a scene's objects under a lamp; `surfels` are the scene's, with areas."""
    index = area_sample(surfels.areas, count, seed)
    rows = np.tile(index, ROUNDS)
    # At random, not evenly: rounds have to be independent of each other.
    places = places_on(surfels, rows, np.random.default_rng([seed, count]).random((len(rows), 2)))
    with thread_limit(threads):
        total, direct = (
            _reference(objects, lamp, places, paths, seed).reshape(ROUNDS, count, 3)
            for objects, paths in (
                (scene.objects, PATHS),
                ([s.replace(reflectance=0.0, emission=0.0) for s in scene.objects], LEAST_PATHS),
            )
        )
    found = total, total - direct
    errors = (values.std(axis=0, ddof=1) / np.sqrt(ROUNDS) for values in found)
    return LampTruth(index, *(values.mean(axis=0) for values in found), *errors)


def _reference(objects, lamp, places, paths, seed):
    """sf.reference_irradiance without areas, and what coincides: in Sponza those take longer than all the paths."""
    core = _core.Scene([s._core for s in objects], [lamp._to_core()])
    return np.asarray(_core.reference_irradiance(core, *places, paths, seed)[0])


def errors_of(found, truth):
    """Of indirect irradiance (n, 3): RMS relative to that of all, and to its own, and standard errors of both.

    RMS are over the surface, and without the variance of the truth. Standard errors are those of the choice of
    surfels.
    """
    noise = squares(truth.indirect_error)
    off = squares(found[truth.index] - truth.indirect) - noise
    total = squares(truth.total) - squares(truth.total_error)
    (of_all, doubt), (of_own, own_doubt) = (relative(off, level) for level in (total, squares(truth.indirect) - noise))
    return of_all, of_own, doubt, own_doubt


def relative(off, level):
    """sqrt(mean(off) / mean(level)) and its standard error, linearized as that of a ratio of means."""
    ratio = off.mean() / level.mean()
    doubt = np.std(off - ratio * level, ddof=1) / np.sqrt(len(off)) / level.mean()
    root = np.sqrt(max(0.0, ratio))
    return float(root), float(doubt / (2.0 * max(root, np.sqrt(doubt), np.finfo(float).tiny)))


def squares(values):
    """Of vectors (m, 3): their squared lengths (m,)."""
    return (np.asarray(values, float) ** 2).sum(axis=-1)


@dataclass
class PictureTruth:
    """Radiance of pixels drawn at random: (rows, columns), and (m, 3) each."""

    at: tuple
    radiance: np.ndarray
    error: np.ndarray


def traced_picture(scene, camera, size, drawn, *, glossy_bounces, count=PIXELS, threads=None):
    """The PictureTruth of what the middles of pixels see in `drawn`, layers of Solution.render(samples=1)."""
    rows, columns = np.nonzero(drawn["index"] >= 0)
    chosen = np.random.default_rng(0).choice(len(rows), min(count, len(rows)), replace=False)
    at = rows[chosen], columns[chosen]
    points, index, own = unproject(camera, drawn["depth"], size)[at], drawn["index"][at], scene.surfels
    radiance, error = sf.reference_radiance(
        scene,
        points,
        drawn["normal"][at],
        camera.eye - points,
        reflectance=own.reflectance[index],
        specular=own.specular[index],
        exponent=own.exponent[index],
        glossy_bounces=glossy_bounces,
        samples=PATHS_A_PIXEL,
        threads=threads,
    )
    return PictureTruth(at, radiance, error)


def picture_error(picture, truth):
    """RMS over pixels, relative to the truth's, without the variance of that; and its standard error."""
    noise = squares(truth.error)
    return relative(squares(picture[truth.at] - truth.radiance) - noise, squares(truth.radiance) - noise)
