"""The measuring stick: irradiance by unbiased path tracing, with its standard error."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage, watched
from surflux._base.types import Floats, Progress
from surflux.cluster.engines import shared_out
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.scene import Scene
from surflux.solving.close_lamps import warn_of_close_lamps
from surflux.solving.darkness import warn_of_noise


@shared_out
def reference_irradiance(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    samples: int = 4096,
    seed: int = 0,
    *,
    cluster: Any = None,
    threads: int | None = None,
    progress: Progress = False,
) -> tuple[Floats, Floats]:
    """Irradiance at points of a scene, direct and indirect, by unbiased path tracing (Kajiya 1986).

    What solvers are judged by: without bias, with its standard error. What it is a reference for is the scene as it is
    given, not the surface that the points were taken from:

    - The surfaces are the disks of the surfels, and the triangles of those that come from a mesh. Where disks overlap,
      the one that a ray meets first counts, with its reflectance and emission; the rims of disks that stand off a
      curved surface are seen where they are. Disks end where their areas do: at creases, and at borders of an object's
      sampling, unless another object adjoins.
    - From the front of a surfel comes the radiance (E + rho H) / pi, with H at the very place that is met, on the
      surfel's normal; specular reflectance is left out (reference_radiance has it). Back faces absorb. What leaves the
      scene meets the Environments. Lights neither occlude nor reflect.
    - Leaving a place on a surfel, a ray ignores that surfel, disks of the same object within 2 R of their centres
      that face the same side and that it crosses from behind, as between surfels, and what it crosses from behind
      within 2e-6 of the size of the scene over the place, unless that faces the place. Patches that face opposite
      ways and are as close are the sides of one sheet.
    - A point given by the caller belongs to the surfel nearest to it along its normal, among disks no farther than
      half their radius and mesh patches that touch it, facing its way. So points between surfels, slightly over or
      under the disks, are not in their shadow. Points that rounding puts behind their surface, by no more than a
      thousandth of a surfel's radius, are moved up to it. Other points are in the air.

    Next event estimation from every vertex of a path samples lights, images of the sky and emissive surfels that cover
    at most 15 % of all surface, or shine eight times as strongly as the mean of them, each of the first seven by itself
    and all others together; they are combined with the rays that meet them by multiple importance sampling (balance
    heuristic, Veach and Guibas 1995). Russian roulette ends paths whose throughput has fallen below 1/16.

    Args:
        scene: Scene. Its areas are not used.
        points: (m, 3).
        normals: (m, 3), of any length but 0; light comes from the side they point to.
        samples: paths per point, 16 or more, rounded up to equal batches. Each batch is spread evenly and randomized on
            its own; there are about sqrt(samples) of them, at least 16: 64 batches of 64 paths for 4096.
        seed: of all that is random; the result is the same for the same seed, whatever the number of threads.
        cluster, threads: see `solve`.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        (irradiance, error), (m, 3) each, in the unit of the lights (W/m2): the estimate and its standard error. The
        difference to the truth, divided by the error, follows Student's t with one degree of freedom less than there
        are batches, from some thousand samples on; with a few hundred, estimates of what rare bright paths bring (a
        bulb under a ceiling) are skewed: they lie beyond 95 % bounds in 8 to 12 % of cases. Where a lamp stands so
        close to a surface that few paths meet its spot there, that holds for far more samples alone, and a warning says
        so.

    Raises:
        ValueError: an argument out of range, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    >>> scene = sf.Scene([floor], lights=[sf.PointLight([0.5, 0.5, 1.0], 8.0), sf.Environment(1.0)])
    >>> irradiance, error = sf.reference_irradiance(scene, [[0.5, 0.5, 0.0]], [[0, 0, 1]], samples=64)
    >>> print(f"{irradiance[0, 0]:.3f}")  # 8 / 1^2 from the light, pi from the sky
    11.142
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: wanted a Scene, got {type(scene).__name__}")
    points = check.finite_array("points", points, (None, 3))
    normals = check.unit_vectors("normals", check.finite_array("normals", normals, (len(points), 3)))
    samples = check.count("samples", samples, 16)
    seed = check.seed("seed", seed)
    options = {"points": points, "normals": normals, "samples": samples, "seed": seed}
    with watched(threads, progress):
        core = scene._to_core()
        warn_of_layers(scene)
        warn_of_noise(core)
        warn_of_close_lamps(scene, points, samples)
        return cluster.call(_program, scene, options, stage("reference"))


def _program(core, options, team, progress):
    """What each process of a cluster runs."""
    irradiance, error, _ = _core.reference_irradiance(core, **options, progress=progress, team=team)
    return np.asarray(irradiance), np.asarray(error)
