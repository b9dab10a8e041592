"""What surfels of a solution send in a direction: a method of Solution."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.passes import thread_limit
from surflux._base.types import Floats
from surflux._base.warn import warn


def radiance_towards(self: Any, directions: ArrayLike, *, threads: int | None = None) -> Floats:
    """Radiance that leaves each surfel in a direction, emission included.

    Of diffuse surfels B / pi. Those of `DistantTransfer.relight` that are glossy also send what their lobes have
    (see Surfels.specular), which depends on the direction; files and pickles leave lobes out, and a warning says so.

    Args:
        directions: (3,) for all, or (n, 3), away from the surfels, of any length but 0.
        threads: at most this many; None for all.

    Returns:
        (n, 3) in W/(m2 sr) for lights in W; 0 from behind.

    Raises:
        ValueError: directions of another shape, or of zero length.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))
    >>> print(solution.radiance_towards([0, 0, 1]).round(3)[0], solution.radiance_towards([1, 0, -1]).max())
    [0.5 0.5 0.5] 0.0
    """
    n = len(self.surfels)
    given = check.numeric("directions", directions)
    given = np.broadcast_to(given, (n, 3)) if given.shape == (3,) else given
    towards = check.unit_vectors("directions", check.finite_array("directions", given, (n, 3)))
    with thread_limit(threads):
        radiance = self.radiosity / np.pi + glossy(self, towards)
    return np.where((towards * self.surfels.normals).sum(axis=1)[:, None] > 0.0, radiance, 0.0)


def towards_eye(points, camera):
    """(n, 3) from each of points (n, 3) to where a Camera stands, of any length; of an orthographic one all alike."""
    towards = np.subtract(camera.eye, points if camera.height is None else camera.target)
    return np.broadcast_to(towards, points.shape)


def has_lobes(solution):
    return solution._mirrored is not None and bool(solution._mirrored[1].any())


def without_lobes(solution, where):
    """What a file or a pickle has of the light that is glossy, of which a warning says that it is none."""
    if has_lobes(solution):
        warn(
            f"{os.fsdecode(where)}: what surfels reflect as mirrors do is left out, they are matt there; "
            "a transfer that is saved has it (DistantTransfer.save)"
        )
    return {"_mirrored": None, "_lobes_lost": lobes_lost(solution)}


def lobes_lost(solution):
    """Whether what is kept of a solution is matt where that one is glossy, or was before it was kept itself."""
    return solution._lobes_lost or has_lobes(solution)


def warn_of_lost_lobes(solution):
    """Says, once of each solution, that a file or a pickle left out what surfels reflect as mirrors do."""
    if solution._lobes_lost and not solution._lobes_told:
        solution._lobes_told = True
        warn(
            "specular is left out: files and pickles of solutions have no lobes, surfels are matt here; "
            "relight a transfer (load_transfer) for what is glossy"
        )


def glossy(solution, towards):
    """What lobes have of radiance_towards, for directions (n, 3), also of length 0, where it is 0; 0 of no lobes."""
    if solution._mirrored is None:
        warn_of_lost_lobes(solution)
        return 0.0
    incident, specular, exponent = solution._mirrored
    length = np.linalg.norm(towards, axis=1, keepdims=True)
    towards = np.divide(towards, np.where((length > 0.0) & specular.any(axis=1, keepdims=True), length, np.inf))
    return specular * np.asarray(incident.mirrored(towards, exponent))
