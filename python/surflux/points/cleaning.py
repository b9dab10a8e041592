"""Points of a scan that are not of its surface: repeated ones, and those that stand alone."""

import numpy as np

from surflux import _core

_NEIGHBORS = 8
_ALONE = 4.0  # times the distance that is usual around
_MOST = 0.01  # of all points: where more stand alone, the sampling is uneven, and none of them strays
_MIXED = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xD6E8FEB86659FD93], dtype=np.uint64)


def first_of_each(points, normals=None):
    """(n,) int64: for each point the first at the very same place, itself where none was before it.

    With normals, those that face the other way than the first at their place are the back of a sheet, and no repeats.
    """
    n = len(points)
    first = np.arange(n)
    left = first
    while len(left):
        lead = _lead(points[left])
        same = lead != np.arange(len(left))
        if normals is not None:
            with np.errstate(invalid="ignore"):
                facing = np.einsum("ij,ij->i", normals[left], normals[left][lead]) < 0.0
            backs = same & facing
        else:
            backs = np.zeros(len(left), dtype=bool)
        first[left] = np.where(backs, left, left[lead])
        left = left[backs] if np.any(backs) and np.count_nonzero(backs) < len(left) else left[:0]
    return first


def _lead(points):
    """(n,): the first row that is equal."""
    bits = (points + 0.0).view(np.uint64)  # -0 becomes 0
    key = (bits * _MIXED).sum(axis=1, dtype=np.uint64)
    key ^= key >> np.uint64(29)
    order = np.argsort(key, kind="stable")
    begins = np.ones(len(points), dtype=bool)
    begins[1:] = np.any(points[order[1:]] != points[order[:-1]], axis=1)
    lead = np.empty(len(points), dtype=np.int64)
    lead[order] = order[np.flatnonzero(begins)][np.cumsum(begins) - 1]
    return lead


def isolated(points):
    """(n,) booleans: points that stand alone, four times as far from their eighth neighbour as these are from theirs.

    After the local outlier factor (Breunig and others 2000), by medians: a scan may thin out with distance, and what is
    sparse all around is not alone. Places count once. None where more than a hundredth of all would: such a cloud is
    sampled unevenly.
    """
    none = np.zeros(len(points), dtype=bool)
    first = first_of_each(points)
    places = np.flatnonzero(first == np.arange(len(points)))
    if len(places) <= 4 * _NEIGHBORS:
        return none
    at = points[places]
    neighbors = np.asarray(_core.nearest_points(at, _NEIGHBORS + 1)).astype(np.int64)
    reach = np.linalg.norm(at[neighbors[:, -1]] - at, axis=1)
    middle = np.sort(reach[neighbors[:, 1:]], axis=1)[:, _NEIGHBORS // 2 - 1 : _NEIGHBORS // 2 + 1]
    alone = reach > _ALONE * middle.mean(axis=1)  # the median
    found = none.copy()
    found[places] = alone
    found = found[first]
    return found if np.count_nonzero(found) <= _MOST * len(points) else none
