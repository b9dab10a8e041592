"""What single layer points are of which nobody says from where they were seen: a frame, a terrain, a turn, or none."""

import numpy as np

from surflux import _core

_FEW = 1000  # points: their columns do not tell a layer from a body
_PER_COLUMN = 16  # points
# Of the columns with points in them, those that hold half as many, at least: fewer do where objects are sampled finer
# than their floor, by 3 a seventh, evenly sampled or scanned from above .7 to 1. Columns are then up to so much wider.
_FILLED, _WIDEST = 0.7, 16.0
_THIN = 3.0  # widths of a column that its points may spread along it
_SINGLE = 0.7  # of the columns have to be thin
_OUTER = 0.01  # of the points on either side do not count
_LOWEST = 0.3  # of its narrower side a terrain rises, at most: tiles of LiDAR .2, a piece of a room .4
_STEEPEST = 1.2  # tangent of the widest angle at which depth cameras see
_NARROW = 0.3  # tangent of a cone that what stands far above the origin fills as well
# Numbers of points in cells, so many on average, vary .87 times as much over the picture of a depth camera as over its
# plane, or less; .9 times as much or more where the origin sees a terrain above or below it.
_PER_CELL, _EVENER = 8, 0.89
_IN_REACH = 10.0  # metres that depth cameras see, at most
_IN_VIEW = 0.15  # tangents that a depth camera sees at least, one way or the other
_UPRIGHT = 1.5  # widths of a column along which points of a wall lie, at least
_ASKED, _NEAR = 30_000, 4  # points of which the distance to the fourth neighbour is looked at
# How the logarithm of that distance follows the one of the distance from a scanner: by 1.2, with a correlation of .9,
# in a room that a scanner turned in; by .5 at most from elsewhere, and by 0 on bodies, which are sampled evenly.
_SLOPES, _CORRELATION, _SPREAD = (0.7, 1.6), 0.6, 0.15


def layer_of(points):
    """What single layer points (n, 3) are: the "frame" of a depth camera, a "terrain", a scanner's "turn", or None.

    A layer that the origin sees once in each direction, in a cone about z, is what a depth camera there sees; but hills
    and roofs, which have one height at each place, fill a narrow cone, too. Such a layer that is low is a terrain, or a
    tile of airborne LiDAR, seen from above, z up, however far above the origin it lies; unless that is within a depth
    camera's reach, or the points are more even as the origin sees them, as a camera's pixels are. Points that lie apart
    as far as they are from the origin, but for a factor, were seen by a scanner there, which turns by even angles.
    Bodies and rooms otherwise are none of these: their columns go through more than one wall.
    """
    if len(points) < _FEW:
        return None
    low = is_terrain(points)
    widest = _cone_seen_from_origin(points)
    if widest is not None:
        if low:  # a wall or a table that a camera looks at straight on, or ground in any frame of coordinates
            in_reach = widest >= _NARROW and np.median(np.abs(points[:, 2])) <= _IN_REACH
            is_frame = in_reach or _is_even_from_origin(points)
        else:
            is_frame = widest >= _NARROW or not _has_one_height(points)
        if is_frame:
            return "frame"
    if low:
        return "terrain"
    return "turn" if _thin_out_from_origin(points) else None


def is_terrain(points):
    """Whether points (n, 3) have, nearly everywhere, one height z, and little of it."""
    return len(points) >= _FEW and _is_low(points) and _has_one_height(points) and len(_some_places(points)) >= _FEW


def is_terrain_of(points, up):
    """Whether points (n, 3) are a terrain by layer_of, and the direction that is up (3,) is z; None is z, too."""
    upright = up is None or (up[0] == 0.0 and up[1] == 0.0 and up[2] > 0.0)
    return upright and layer_of(points) == "terrain"


def up_of_frame(points):
    """(3,) what is up in the frame of a depth camera: -y where it looks along z, y where it looks back."""
    return (0.0, -1.0, 0.0) if points[0, 2] > 0.0 else (0.0, 1.0, 0.0)


def mean_spacing(places):
    """Width of a square in which one of places (n, 2) lies, on average."""
    low, high = np.quantile(places, [_OUTER, 1.0 - _OUTER], axis=0)
    return np.sqrt(np.prod(high - low) / len(places))


def _has_one_height(points):
    return _is_layer(points[:, :2], points[:, 2])


def _is_low(points):
    x, y, z = np.diff(np.quantile(_evenly(points), [_OUTER, 1.0 - _OUTER], axis=0), axis=0)[0]
    return z <= _LOWEST * min(x, y)


def _evenly(points):
    """Of points (n, 3) one in each cube as wide as they are apart on average: parts count by area, not by points."""
    width = mean_spacing(points[:, :2])
    if not width > 0.0:
        return points
    cells = np.clip(np.floor((points - np.median(points, axis=0)) / width), -(2**20), 2**20 - 1).astype(np.int64)
    _, some = np.unique(cells @ [1 << 42, 1 << 21, 1], return_index=True)
    return points[some]


def _some_places(points):
    """At most _ASKED of points (n, 3), without copies, as dropped returns at the origin are."""
    if len(points) > _ASKED:
        points = points[np.random.default_rng(0).choice(len(points), _ASKED, replace=False)]
    return np.unique(points, axis=0)


def _thin_out_from_origin(points):
    some = _some_places(points)
    if len(some) < _FEW:
        return False
    apart = np.linalg.norm(some[_core.nearest_points(some, _NEAR + 1)[:, _NEAR]] - some, axis=1)
    away = np.linalg.norm(some, axis=1)
    known = (apart > 0.0) & (away > 0.0)
    apart, away = np.log(apart[known]), np.log(away[known])
    if np.std(away) < _SPREAD:
        return False
    ((_, mixed), (_, own)) = np.cov(away, apart)
    slope = mixed / np.var(away)
    return _SLOPES[0] < slope < _SLOPES[1] and mixed > _CORRELATION * np.std(away) * np.sqrt(own)


def _cone_seen_from_origin(points):
    """Tangent of the angle around z of a layer that the origin sees once in each direction; None for other points."""
    depth = points[:, 2]
    if not (np.all(depth > 0.0) or np.all(depth < 0.0)):
        return None
    slopes = points[:, :2] / depth[:, None]
    widest = np.quantile(np.linalg.norm(slopes, axis=1), 1.0 - _OUTER)
    return widest if widest < _STEEPEST and _is_layer(slopes, np.log(np.abs(depth))) else None


def _is_even_from_origin(points):
    """Whether points (n, 3) lie more evenly over what the origin sees along z than over x and y, but for walls."""
    upright = _is_in_wall(points)
    if np.mean(upright) < 1.0 - _SINGLE:
        points = points[~upright]
    places, slopes = points[:, :2], points[:, :2] / points[:, 2:]
    in_view = np.ptp(np.quantile(slopes, [_OUTER, 1.0 - _OUTER], axis=0), axis=0)
    return bool(in_view.max() > _IN_VIEW) and _unevenness(slopes) < _EVENER * _unevenness(places)


def _is_in_wall(points):
    """(n,) whether points in the same column along z are far apart."""
    width, middle = _column_width(points[:, :2]), np.median(points[:, :2], axis=0)
    cells = np.clip(np.floor((points[:, :2] - middle) / width), -1e9, 1e9).astype(np.int64)
    _, column = np.unique(cells[:, 0] * (1 << 31) + cells[:, 1], return_inverse=True)
    highest, lowest = np.full((2, column.max() + 1), -np.inf)
    np.maximum.at(highest, column, points[:, 2])
    np.maximum.at(lowest, column, -points[:, 2])
    return (highest + lowest)[column] > _UPRIGHT * width


def _column_width(places):
    """Of square columns over places (n, 2), so wide that _PER_COLUMN of them are in one on average."""
    return np.sqrt(_PER_COLUMN) * mean_spacing(places)


def _unevenness(places):
    """Of how many of places (n, 2) are in a cell, the standard deviation over the mean."""
    low, high = np.quantile(places, [_OUTER, 1.0 - _OUTER], axis=0)
    cells = np.maximum(1, np.round((high - low) / (np.sqrt(_PER_CELL) * mean_spacing(places)))).astype(int)
    counts, _, _ = np.histogram2d(*places.T, bins=cells, range=np.c_[low, high])
    return np.std(counts) / np.mean(counts)


def _is_layer(places, depth):
    """Whether points at places (n, 2) have, nearly everywhere, one depth (n,) in the unit of places."""
    low, high = np.quantile(places, [_OUTER, 1.0 - _OUTER], axis=0)
    if np.min(high - low) <= 0.0:
        return False
    width = _column_width(places)
    inside = np.all((places >= low) & (places <= high), axis=1)
    column = _filled_columns(places[inside] - low, width)
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


def _filled_columns(places, width):
    """(n,) the column of each of places (n, 2) from 0, of so wide ones, or of wider ones of which most are filled."""
    widest = _WIDEST * width
    while True:
        cells = np.floor(places / width).astype(np.int64)
        cells = cells[:, 0] * (1 + cells[:, 1].max()) + cells[:, 1]
        _, column, count = np.unique(cells, return_inverse=True, return_counts=True)  # of a line cells are countless
        if np.mean(count >= _PER_COLUMN // 2) >= _FILLED or width >= widest:
            return column
        width *= np.sqrt(2.0)
