"""The measuring stick of glossy reflection: outgoing radiance by unbiased path tracing, with its standard error."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage, watched
from surflux._base.types import Floats, Progress
from surflux.geometry.gloss import MOST, require_energy
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.scene import Scene


def reference_radiance(
    scene: Scene,
    points: ArrayLike,
    normals: ArrayLike,
    directions: ArrayLike,
    *,
    reflectance: ArrayLike | None = None,
    specular: ArrayLike | None = None,
    exponent: ArrayLike | None = None,
    glossy_bounces: bool = True,
    samples: int = 4096,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> tuple[Floats, Floats]:
    """Radiance that leaves points of a scene in given directions, diffuse and glossy, by unbiased path tracing.

    From the front of a surface with normal n comes, in the direction o, with r its mirror image 2 (n o) n - o,

        E / pi + integral of L(w) [rho / pi (n w) + k (s + 1) / (2 pi) max(r w, 0)^s] over w with n w > 0,

    with E the emission of the surfel, L the radiance that comes from w, rho the reflectance, k the specular reflectance
    and s the exponent. As a BRDF the second part is k (s + 1) / (2 pi) cos(r, w)^s / cos(n, w): Phong's lobe of the
    light that arrives, without a cosine, so that spherical harmonics convolve with it (Sloan, Kautz and Snyder 2002;
    L07 sec. 6.4 after Kautz, Sloan and Snyder 2002). It is not reciprocal. The lobe integrates to k where all of it is
    above the surface; what is below is lost, half of it towards the horizon. Backs are black: 0 from behind.

    Geometry, lights and the rest are those of reference_irradiance, which leaves `specular` out, as solvers do; where
    specular is 0 everywhere, this is (E + rho H) / pi with its H. Directions come from the lobe or from the
    diffuse part, in proportion to k and rho, and light samples from lights, combined by multiple importance sampling
    (balance heuristic). An Environment of spherical harmonics counts where it is below 0, too.

    Args:
        scene: Scene. Its areas are not used.
        points: (m, 3).
        normals: (m, 3), of any length but 0; n above, which need not be that of the surfel.
        directions: (m, 3), of any length but 0, away from the surface: to the eye.
        reflectance, specular: of the points, linear: one number, RGB (3,), (m,) or (m, 3), with a sum below 1; None
            for those of the surfels that the points lie on (see reference_irradiance).
        exponent: of the points, one number or (m,), at least 0; None likewise.
        glossy_bounces: False has surfels send on by their diffuse reflectance alone what paths find on them, as
            solvers do; only the last reflection, at the points, is glossy then.
        samples: paths per point, 16 or more, rounded up to equal batches.
        seed: of all that is random; the result is the same for the same seed, whatever the number of threads.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        (radiance, error), (m, 3) each, in W/(m2 sr) for lights in W: the estimate and its standard error, from as many
        batches as those of reference_irradiance.

    Raises:
        ValueError: an argument out of range, by name; a point that lies on no surfel, where a material is None.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> mirror = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, reflectance=0.1, specular=0.6, exponent=1000)
    >>> scene = sf.Scene([mirror], lights=[sf.Environment(2.0)])
    >>> radiance, error = sf.reference_radiance(scene, [[0, 0, 0]], [[0, 0, 1]], [[1, 0, 1]], samples=64)
    >>> print(f"{radiance[0, 0]:.3f}")  # (0.1 + 0.6) times the radiance of an even sky
    1.400
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: wanted a Scene, got {type(scene).__name__}")
    points = check.finite_array("points", points, (None, 3))
    n = len(points)
    normals = check.unit_vectors("normals", check.finite_array("normals", normals, (n, 3)))
    directions = check.unit_vectors("directions", check.finite_array("directions", directions, (n, 3)))
    if reflectance is not None:
        reflectance = check.per_surfel_rgb("reflectance", reflectance, n, high=1.0, high_open=True, what="point")
    if specular is not None:
        specular = check.per_surfel_rgb("specular", specular, n, high=1.0, high_open=True, what="point")
        if reflectance is not None:
            require_energy(reflectance, {"specular": specular})
    if exponent is not None:
        exponent = check.in_range("exponent", check.per_surfel("exponent", exponent, n), high=MOST)
    glossy_bounces = check.flag("glossy_bounces", glossy_bounces)
    samples = check.count("samples", samples, 16)
    seed = check.seed("seed", seed)
    with watched(threads, progress):
        core = scene._to_core()
        warn_of_layers(scene)
        materials = (reflectance, specular, exponent)
        radiance, error, _ = _core.reference_radiance(
            core, points, normals, directions, *materials, glossy_bounces, samples, seed, progress=stage("reference")
        )
    return np.asarray(radiance), np.asarray(error)
