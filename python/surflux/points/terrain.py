"""Normals of terrain, seen from above: upwards, and of facades outwards."""

import numpy as np

from surflux.geometry.estimates import estimated_normals
from surflux.geometry.facing import facing_of
from surflux.points.layers import mean_spacing

_OUTER = 0.01  # of the points on either side do not count
_STEEP, _LEVEL = 0.5, 0.7  # z of the normals of facades, at most, and of ground and roofs, at least
_AT_GROUND = 0.25  # widths of a cell, which is two spacings: as near to the ground around is part of it
_HIGH = 100.0  # extents: from so far above all of a terrain is seen


def normals_of_terrain(points, fitted=None):
    """(n, 3) unit normals of points (n, 3) of a terrain, see estimated_normals: upwards, and of facades outwards."""
    normals, is_open = _normals_towards(points, high_above(points.min(axis=0), points.max(axis=0)), fitted)
    down = np.flatnonzero(normals[:, 2] < -_LEVEL)
    heights = _Heights(points[normals[:, 2] > _LEVEL])
    is_ground = np.abs(points[down, 2] - heights.lowest(points[down])) < _AT_GROUND * heights.width
    normals[down[is_ground]] *= -1.0  # no underside, but what a body touches
    return np.where(is_open[:, None], facades_outwards(points, normals), normals)  # of bodies rays have told


def normals_towards(points, place, fitted=None):
    """The same, towards a place (3,), which has seen all of them."""
    return _normals_towards(points, place, fitted)[0]


def _normals_towards(points, place, fitted):
    """(The same; (n,) which of them are on open surfaces.)"""
    normals = np.array(estimated_normals(points, place, fitted))
    found = facing_of(points, normals, place[None], estimated=True)
    return np.where((found.turned & ~found.open)[:, None], -normals, normals), found.open  # both sides of a plate


def facades_outwards(points, normals):
    """Normals (n, 3) of a terrain's points that face upwards, with those of facades on the side where it lies lower.

    Which side that is cannot be told from above: normals of walls lie across the way to there.
    """
    steep = np.abs(normals[:, 2]) < _STEEP
    if not np.any(steep):
        return normals
    grid = _Heights(points[normals[:, 2] > _LEVEL])
    walls, ahead = points[steep], normals[steep, :2] / np.linalg.norm(normals[steep, :2], axis=1, keepdims=True)
    before, behind = (grid.around(walls, side * ahead) for side in (1.0, -1.0))
    out = normals.copy()
    out[steep] = np.where((before > behind)[:, None], -normals[steep], normals[steep])
    return out


def high_above(low, high):
    """(3,) from where all of a terrain is seen that lies between two corners (3,)."""
    return 0.5 * (low + high) + [0.0, 0.0, _HIGH * np.linalg.norm(high - low)]


class _Heights:
    """Mean heights z, in cells some points wide, of points that are level: ground and roofs.

    Cells are powers of two wide and begin at 0, so that those of a tile are those of the whole.
    """

    def __init__(self, points):
        places = points[:, :2]
        apart = mean_spacing(places) if len(points) else 0.0
        self.width = 2.0 ** np.round(np.log2(2.0 * apart)) if apart > 0.0 else 0.0
        if not self.width > 0.0:
            return
        low, high = np.quantile(places, [_OUTER, 1.0 - _OUTER], axis=0)
        margin = 0.1 * (high - low)  # strays lie farther out
        self.low = np.floor((low - margin) / self.width)
        self.shape = (np.ceil((high + margin) / self.width) - self.low).astype(np.int64) + 1
        at, inside = self._cell(places)
        count = np.bincount(at[inside], minlength=self.shape.prod())
        total = np.bincount(at[inside], points[inside, 2], minlength=self.shape.prod())
        self.heights = np.where(count > 0, total / np.maximum(1, count), np.nan)

    def _cell(self, places):
        """((n,) the cell of each place, (n,) whether there is one)."""
        cells = np.clip(np.floor(places / self.width) - self.low, -1, self.shape).astype(np.int64)
        inside = np.all((cells >= 0) & (cells < self.shape), axis=1)
        return np.ravel_multi_index(np.where(inside[:, None], cells, 0).T, self.shape), inside

    def lowest(self, points):
        """(n,) the lowest height up to two cells away each way; infinity where there is none."""
        out = np.full(len(points), np.inf)
        if not self.width > 0.0:
            return out
        for x in (-2, -1, 0, 1, 2):
            for y in (-2, -1, 0, 1, 2):
                at, inside = self._cell(points[:, :2] + self.width * np.array([x, y]))
                out = np.fmin(out, np.where(inside, self.heights[at], np.inf))
        return out

    def around(self, points, ahead):
        """(n,) mean height up to two cells away in the directions (n, 2); where there is none, the point's own."""
        if not self.width > 0.0:
            return points[:, 2]
        total, known = np.zeros((2, len(points)))
        for away in (0.5, 1.0, 1.5, 2.0):
            at, inside = self._cell(points[:, :2] + away * self.width * ahead)
            found = np.where(inside, self.heights[at], np.nan)
            total += np.nan_to_num(found)
            known += np.isfinite(found)
        return np.where(known > 0, total / np.maximum(1, known), points[:, 2])
