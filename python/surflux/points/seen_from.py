"""From where points were seen whose file does not say: one layer of them has a front, for a scanner saw it."""

import numpy as np

from surflux._base.passes import LOG

_FEW = 1000  # points: their columns do not tell a layer from a body
_PER_COLUMN = 16  # points
_THIN = 3.0  # widths of a column that its points may spread along it
_SINGLE = 0.7  # of the columns have to be thin
_OUTER = 0.01  # of the points on either side do not count
_STEEPEST = 1.2  # tangent of the widest angle at which depth cameras see
_HIGH = 100.0  # extents: from so far above all of a terrain is seen


def seen_from(path, points):
    """(3,) from where points without normals were seen, or None; what was taken for granted is logged.

    A layer that the origin sees once in each direction, in a cone about z, is what a depth camera there sees. One that
    has one height at each place is a terrain, or a tile of airborne LiDAR, seen from above, z up. Bodies and rooms are
    neither: their columns go through more than one wall.
    """
    if len(points) < _FEW:
        return None
    if _faces_origin(points):
        LOG.info("%s: estimated normals face the origin, as if a depth camera were there (viewpoint: elsewhere)", path)
        return np.zeros(3)
    if is_terrain(points):
        LOG.info("%s: estimated normals face upwards, as of a terrain seen from above (viewpoint: elsewhere)", path)
        low, high = points.min(axis=0), points.max(axis=0)
        return 0.5 * (low + high) + [0.0, 0.0, _HIGH * np.linalg.norm(high - low)]
    return None


def is_terrain(points):
    """Whether points (n, 3) have, nearly everywhere, one height, z up."""
    return len(points) >= _FEW and _is_layer(points[:, :2], points[:, 2])


def _faces_origin(points):
    depth = points[:, 2]
    if not (np.all(depth > 0.0) or np.all(depth < 0.0)):
        return False
    slopes = points[:, :2] / depth[:, None]
    widest = np.quantile(np.linalg.norm(slopes, axis=1), 1.0 - _OUTER)
    return widest < _STEEPEST and _is_layer(slopes, np.log(np.abs(depth)))


def _is_layer(places, depth):
    """Whether points at places (n, 2) have, nearly everywhere, one depth (n,) in the unit of places."""
    low, high = np.quantile(places, [_OUTER, 1.0 - _OUTER], axis=0)
    size = high - low
    if np.min(size) <= 0.0:
        return False
    width = np.sqrt(size[0] * size[1] * _PER_COLUMN / len(places))
    inside = np.all((places >= low) & (places <= high), axis=1)
    cells = np.floor((places[inside] - low) / width).astype(np.int64)
    column = cells[:, 0] * (1 + cells[:, 1].max()) + cells[:, 1]
    order = np.lexsort((depth[inside], column))
    column, sorted_depth = column[order], depth[inside][order]
    begin = np.flatnonzero(np.diff(column, prepend=-1))
    count = np.diff(begin, append=len(column))
    full = count >= _PER_COLUMN // 2
    if np.count_nonzero(full) < 8:
        return False
    tenth = (0.1 * count[full]).astype(np.int64)
    spread = sorted_depth[begin[full] + count[full] - 1 - tenth] - sorted_depth[begin[full] + tenth]
    return np.mean(spread < _THIN * width) >= _SINGLE
