"""Effective areas: what each surfel contributes to the area of its surface (D04 section 5)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surflux import _core
from surflux._base import check
from surflux._base.passes import progress_callback, stage, thread_limit
from surflux._base.types import Floats, Integer, Progress, SurfelsLike
from surflux.geometry.cores import make_core
from surflux.geometry.estimates import estimated_radii

METHODS = ("paper", "curved")
BACKENDS = ("auto", "cpu", "gl")
_ENOUGH = 50_000  # surfels to tell the area of a surface from


def effective_areas(
    s: SurfelsLike,
    *,
    method: Literal["paper", "curved"] = "curved",
    kappa: float = 3.0,
    resolution: int = 32,
    epsilon: float = 0.8,
    backend: Literal["auto", "cpu", "gl"] = "auto",
    threads: int | None = None,
    progress: Progress = False,
) -> Floats:
    """Effective areas S of surfels: (n,) float64, in the square of the unit of their positions. s stays as it is.

    Surfels that stand for mesh patches get the exact area of their triangles. All others get the integral of their
    share of their own tangent disk (D04 eq. 4 to 9).

    Args:
        s: Surfels.
        method: "curved", second order: weights are taken on a model of the surface around each surfel, which is exact
            on spheres, and a disk ends at sharp edges and where the sampling ends; or "paper", D04 eq. 9 as D03 eq. 9
            has it, on the tangent disks themselves, which lie outside a convex surface: areas come out too large.
        kappa: how fast a surfel's weight falls with distance, above 0: exp(-kappa r / R) on the disks (at most 80), or
            r^(-2 kappa) (1 - (r / R)^2) at the surface (at most 8).
        resolution: samples across the disk, 4 to 512: "paper" takes resolution x resolution pixels, "curved" that many
            directions with half as many points along each.
        epsilon: surfels are of one surface where the cosine between their normals is above epsilon; between 0 and 1.
        backend: where the shares are integrated. "cpu": kernels for this processor. "gl": OpenGL, as D04 5.3 draws
            them, neighbours blended additively into a float atlas. Its areas are those of "cpu" within 1e-6 for
            "curved"; for "paper", whose weights end in a step, within 1e-4, but where the centre of a pixel lies on
            the rim of a disk. "auto": the faster one by what the machine is. That is "cpu", unless a GPU draws
            (software such as llvmpipe is some four times slower than "cpu") and integrating takes the CPU more than
            half a second: from 150 000 surfels a thread for "paper" at resolution 32, from 135 000 for "curved" at 64.
            Below resolution 47 "curved" is always "cpu": finding neighbours takes longer there, for either. The
            environment's SURFLUX_GL chooses "egl" or "osmesa"; unset, EGL comes first.
        threads: at most this many; None for all. A software OpenGL starts its own besides.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

    Raises:
        ValueError: an argument out of range, by name.
        DeviceError: backend "gl", and there is no OpenGL; says what was tried and what to install.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> grid = sf.Surfels([[x, y, 0] for y in range(11) for x in range(11)], normals=[[0, 0, 1]] * 121)
    >>> print(f"{sf.effective_areas(grid)[60]:.2f}")  # in the middle, each surfel has a unit square to itself
    1.00
    """
    check.surfels("s", s)
    check.choice("backend", backend, BACKENDS)
    options = _options(method, kappa, resolution, epsilon)
    with thread_limit(threads), progress_callback(progress, "areas") as callback:
        return _core.effective_areas(
            s._core, **options, backend=_core.AreaBackend.__members__[backend], progress=callback
        )


@dataclass(frozen=True, eq=False)
class AreaShares:
    """Who shares the disk of one surfel: the influence functions xi_j of D04 eq. 5, as images.

    Arrays are read-only; what has the same contents is equal.

    Attributes:
        neighbors: (m,) indices, the surfel itself first.
        shares: (m, resolution, resolution) float64, between 0 and 1; over j they sum to 1 at every pixel. Columns run
            along frame[0], rows along frame[1]. NaN outside of what the disk counts: beyond its rim and, with
            "curved", beyond a crease or the border of the sampling.
        frame: (3, 3): the directions u and v of the images and the normal.
        extent: half the side of the images, in the unit of the positions: the surfel's radius, or with "curved", where
            a disk counts a little beyond its rim, 1.3 times it.
        area: the surfel's effective area.
    """

    neighbors: NDArray[np.uint32]
    shares: Floats
    frame: Floats
    extent: float
    area: float

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, AreaShares):
            return NotImplemented
        pairs = ((getattr(self, field.name), getattr(other, field.name)) for field in fields(self))
        return all(np.array_equal(mine, theirs, equal_nan=True) for mine, theirs in pairs)

    def __hash__(self) -> int:
        return hash((self.shares.shape, self.extent, self.area))


def area_shares(
    s: SurfelsLike,
    index: Integer,
    *,
    method: Literal["paper", "curved"] = "curved",
    kappa: float = 3.0,
    resolution: int = 32,
    epsilon: float = 0.8,
) -> AreaShares:
    """How surfel `index` and its neighbours share its disk (D04 eq. 5): AreaShares.

    Args:
        s: Surfels.
        index: of a surfel that is a disk; -1 is the last one.
        method, kappa, epsilon: as effective_areas takes them.
        resolution: pixels along each side of the images, 4 to 512.

    Raises:
        ValueError: an argument out of range, or the index of a mesh patch, whose area is exact.

    >>> import surflux as sf
    >>> grid = sf.Surfels([[x, y, 0] for y in range(11) for x in range(11)], normals=[[0, 0, 1]] * 121)
    >>> found = sf.area_shares(grid, 60)
    >>> len(found.neighbors), found.shares.shape[1:], f"{found.area:.2f}"
    (13, (32, 32), '1.00')
    """
    check.surfels("s", s)
    options = _options(method, kappa, resolution, epsilon)
    if not isinstance(index, (int, np.integer)) or isinstance(index, bool):
        raise ValueError(f"index: wanted an integer, got {index!r}")
    if not -len(s) <= index < len(s):
        raise ValueError(f"index: wanted below {len(s)}, the number of surfels, got {index}")
    found = AreaShares(*_core.area_shares(s._core, int(index) % len(s), **options))
    for array in (found.neighbors, found.shares, found.frame):
        array.setflags(write=False)
    return found


def _options(method, kappa, resolution, epsilon):
    check.choice("method", method, METHODS)
    return {
        "curved": method == "curved",
        "kappa": check.number("kappa", kappa, 0.0, 80.0 if method == "paper" else 8.0, low_open=True),
        "resolution": check.count("resolution", resolution, 4, 512),
        "epsilon": check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
    }


def area_of(areas):
    """The sum of areas (n,); ValueError where all of some surfels are 0."""
    area = float(areas.sum())
    if area == 0.0 and len(areas):
        raise ValueError("areas: wanted some above 0, got 0 for all surfels")
    return area


def surface_area(surfels):
    """The area of their surface: that given, else good to some per cent. Of very many surfels it looks at some.

    Raises ValueError where areas are given and all of them are 0.
    """
    if surfels.areas is not None:
        return area_of(surfels.areas)
    if len(surfels) < 2 * _ENOUGH:
        return float(effective_areas(surfels).sum())
    some = np.sort(np.random.default_rng(0).choice(len(surfels), _ENOUGH, replace=False))
    points, normals = surfels.points[some], surfels.normals[some]
    # Fewer of them stand farther apart: their disks reach as far.
    core = make_core(points, normals, estimated_radii(points, normals))
    backend = _core.AreaBackend.__members__["auto"]
    options = _options("curved", 3.0, 32, 0.8)
    return float(_core.effective_areas(core, **options, backend=backend, progress=stage("areas")).sum())
