"""How far a solution is from path tracing: a method of Solution."""

from __future__ import annotations

import math
from typing import Any

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage, watched
from surflux._base.types import Progress

RAYS = 1 << 20


def estimate_error(
    self: Any, *, rays: int = RAYS, seed: int = 0, threads: int | None = None, progress: Progress = False
) -> float:
    """Estimates how far `irradiance` is from path tracing, all bounces and direct light included, by fresh rays.

    What `solve` does of what it finds, for solutions that nobody has checked yet, as those of relit scenes: rays from
    surfels drawn by area find what they should receive from all others as the solution has these, and a coarse system
    what the differences bring over all bounces. It reads `irradiance`, wherever that is from: solutions that are
    altered or added up are checked alike. Light of glossy surfaces is left out.

    Args:
        rays: at most this many, as often as not half of them; the more, the smaller an error they can tell.
        seed: of the rays; others give an independent estimate.
        threads, progress: see `solve`.

    Returns:
        `error`: the relative RMS error of H; NaN where no light arrives at all. It becomes that of the solution, and
        the last entry of its `history` gets error, error_uncertainty, local_error and local_error_p90 (see there): a
        dim room beside a bright one is seen in these alone.

    Raises:
        ValueError: an argument, by name; a solution from a file, which holds no scene.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.02)]))
    >>> solution = transfer.relight(sf.PointLight([0.5, 0.5, 0.5], 1.0))
    >>> solution.estimate_error() < 0.05, solution.history[-1]["local_error_p90"] < 0.05
    (True, True)
    """
    rays, seed = check.count("rays", rays), check.seed("seed", seed)
    if self._scene is None:
        raise ValueError("estimate_error: wanted a solution with its scene, which a file does not hold")
    with watched(threads, progress):
        core = self._scene._to_core()
        light = self.surfels._core, self.parents, self.irradiance, self.direct
        found = _core.error_of(core, *light, rays, seed, stage("self-check"))
    found["error"] = found["error"] if math.isfinite(found["error"]) else math.nan
    if not self.history:
        self.history = [{}]
    last = self.history[-1]
    found["rays"] += last.get("rays", 0)
    last.update(found)
    self.error = found["error"]
    return self.error
