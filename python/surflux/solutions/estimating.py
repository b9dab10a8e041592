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
    self: Any, *, rays: int = RAYS, seed: int = 1, threads: int | None = None, progress: Progress = False
) -> float:
    """Estimates how far `irradiance` is from path tracing, all bounces and direct light included, by fresh rays.

    What `solve` does of what it finds, for solutions that nobody has checked yet, as those of relit scenes: rays from
    surfels drawn by area find what they should receive from all others as the solution has these, and a coarse system
    what the differences bring over all bounces. It reads `irradiance` and `direct`, wherever they are from, beside the
    lights of the solution's scene. Reflections that were left out (`bounces`) are missed, and so are those of glossy
    surfaces, which it does not follow.

    Args:
        rays: about this many at most, best a million or more: some 600 000 are needed, the more, the smaller an error
            they can tell.
        seed: of the rays. Of what a solver found its own seed repeats the check that gave it its `error`.
        threads, progress: see `solve`.

    Returns:
        `error`: the relative RMS error of H; NaN where no light arrives at all. It becomes that of the solution, and
        the last entry of its `history` gets error, error_uncertainty, local_error and local_error_p90 (see there): a
        dim room beside a bright one is seen in these alone. Its rays are added to those that were there.

    Raises:
        ValueError: an argument, by name; irradiance that is not finite; a solution from a file, which holds no scene.
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
    light = [check.finite_array(name, getattr(self, name), (len(self.surfels), 3)) for name in ("irradiance", "direct")]
    with watched(threads, progress):
        core = self._scene._to_core()
        found = _core.error_of(core, self.surfels._core, self.parents, *light, rays, seed, stage("self-check"))
    found["error"] = found["error"] if math.isfinite(found["error"]) else math.nan
    *before, last = self.history or [{}]
    self.history = [*before, last | found | {"rays": last.get("rays", 0) + found["rays"]}]  # of copies, too
    self.error = found["error"]
    return self.error
