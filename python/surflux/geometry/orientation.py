"""Which side is out: patches of surfels whose normals point inwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surflux import _core
from surflux._base import check
from surflux._base.passes import progress_callback, thread_limit
from surflux._base.types import Progress, SurfelsLike


def inward_patches(
    s: SurfelsLike,
    *,
    rooms: bool = False,
    smallest: int = 20,
    rays: int = 8,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> NDArray[np.int64]:
    """Finds connected patches of surfels whose normals point inwards: (n,) numbers, 0 for a surfel that is right.

    Neighbours that continue each other, whichever way their normals point, make a sheet; in a sheet two surfels face
    the same side or do not (Hoppe et al. 1992, with normals mirrored as by Xie et al. 2003). Where the sheet closes
    around a body, rays tell which side is out: there they leave the scene (see `facing`). An open scan is seen from
    both sides; in it the side that most surfels of the sheet face counts as right. A patch is one where the normals on
    its border say so with one voice. Nothing is changed: `s.flipped(sf.inward_patches(s) > 0)` gives surfels that are
    turned round.

    A sheet that closes around bodies is a room, and right where it is seen from inside. An empty one that faces
    inwards as a whole, as a body does that is turned inside out, is reported, for points do not tell them apart,
    unless `rooms` says that it is a room.

    Args:
        s: Surfels.
        rooms: True where sheets that close around something may be rooms, seen from inside. The side that most
            surfels of a sheet face counts as right there, too.
        smallest: number of surfels that make a patch, at least 1; fewer are taken for noise.
        rays: from each side of up to 2000 surfels of a sheet.
        seed: of the rays.
        threads: at most this many; None for all.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

    Returns:
        (n,) int64: 0, or the number of the patch that the surfel is in; 1 is the largest. Surfels of two_sided pairs
        are always 0.

    Raises:
        ValueError: an argument out of range, by name.
        Cancelled: the callback returned False.

    >>> import numpy as np
    >>> import surflux as sf
    >>> rng = np.random.default_rng(0)
    >>> d = rng.normal(size=(2000, 3))
    >>> d /= np.linalg.norm(d, axis=1, keepdims=True)
    >>> s = sf.Surfels(d, normals=np.where(d[:, 2:] > 0.8, -d, d))  # a cap of the ball points inwards
    >>> patches = sf.inward_patches(s)
    >>> print(patches.max(), np.array_equal(patches > 0, d[:, 2] > 0.8))
    1 True
    >>> print(sf.inward_patches(s.flipped(patches > 0)).max())
    0
    """
    check.surfels("s", s)
    rooms = check.flag("rooms", rooms)
    smallest = check.count("smallest", smallest)
    rays = check.count("rays", rays, 1, 65536)
    seed = check.seed("seed", seed)
    with thread_limit(threads), progress_callback(progress, "inward") as callback:
        return inward_and_unsure(s, rooms, smallest, rays, seed, callback)[0]


def inward_and_unsure(s, rooms, smallest, rays=8, seed=0, callback=None):
    """What inward_patches gives, and (n,) booleans: where normals change sides, and nothing tells which."""
    patches, unsure = _core.inward_patches(s._core, smallest, rays, seed, rooms, progress=callback)
    return patches.astype("int64"), unsure.astype(bool)
