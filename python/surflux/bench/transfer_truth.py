"""What `surflux bench --transfer` measures against: path tracing at random places, and how far a transfer is from it.

A surfel that is a patch stands for the mean over it, one that is a disk for its centre; surfels are drawn by area. Each
has rounds of paths from places of its own, so that variances, which errors are to be without, are known.
"""

from dataclasses import dataclass

import numpy as np

import surflux as sf
from surflux import _core
from surflux._base.passes import thread_limit
from surflux.bench.truth import LEAST_PATHS, area_sample, places_on
from surflux.solutions.towards import towards_eye

MEASURED = 6000  # surfels for each lamp
ROUNDS = 8  # of each, from one place
PATHS = 32  # of each round
PATHS_A_SURFEL = 128  # of each of two pictures
SUBPIXELS = 2  # each way


@dataclass(eq=False)
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
    """sf.reference_irradiance; without areas, and what coincides, of meshes alone: in Sponza those take longer than all
    the paths.
    """
    if any(len(s.triangles) == 0 for s in objects):
        return sf.reference_irradiance(sf.Scene(objects, [lamp]), *places, paths, seed)[0]
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


def traced_pictures(solution, scene, camera, size, *, glossy_bounces, paths=PATHS_A_SURFEL, threads=None):
    """Two pictures (2, h, w, 3), independent of each other, of surfels that are path traced towards the eye.

    They are drawn as those of the solution are, at whose surfels scene has its own: what drawing itself adds is in
    all of them, for flat facets that are traced at each pixel are another surface than surfels that blend. Lobes
    below 0, which an Environment of spherical harmonics makes, are none, as in pictures of solutions.
    """
    own, towards = scene.surfels, towards_eye(scene.surfels.points, camera)
    front = np.flatnonzero((towards * own.normals).sum(axis=1) > 0.0)
    rest = {name: getattr(solution, name) for name in ("parents", "objects", "irradiance", "direct")}

    def reflected(reflectance, specular, seed):
        radiance, _ = sf.reference_radiance(
            scene,
            own.points[front],
            own.normals[front],
            towards[front],
            reflectance=reflectance,
            specular=specular,
            exponent=own.exponent[front],
            glossy_bounces=glossy_bounces,
            samples=paths,
            seed=seed,
            threads=threads,
        )
        return radiance

    out = []
    for seed in (0, 2):
        radiance = np.zeros((len(own), 3))
        radiance[front] = reflected(own.reflectance[front], 0.0, seed)
        radiance[front] += np.maximum(reflected(0.0, own.specular[front], seed + 1), 0.0)
        diffuse = own.replace(specular=0.0)
        known = sf.Solution(diffuse, radiosity=np.pi * radiance, **rest)
        out.append(known.render(camera, size, samples=SUBPIXELS))
    return np.array(out)


def picture_error(picture, traced):
    """RMS over what is seen, relative to that of the traced, without their variance; and its standard error."""
    one, other = np.asarray(traced, float)
    seen = (one + other).any(axis=-1)
    off = ((picture - one) * (picture - other)).sum(axis=-1)[seen]
    return relative(off, (one * other).sum(axis=-1)[seen])
