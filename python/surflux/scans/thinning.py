"""An even sample of points that come in chunks, without ever holding more than a few times as many."""

import numpy as np

_BITS = 18  # of a cell's number along an axis
_NEAR_BITS = 63 - 3 * _BITS  # of how near a point is to the middle of its cell
_ENOUGH = 0.97  # of what is wanted: no finer cells are tried then


class EvenSample:
    """At most `limit` of all points that are added, one in each cell of a grid: the nearest to its middle.

    So a surface is sampled evenly, however dense the scanner was. The grid is turned and shifted at random; its cells
    grow while points come. The same chunks and seed give the same points, and up to `limit` points are all kept.
    """

    def __init__(self, limit, seed=0):
        self._limit = limit
        random = np.random.default_rng(seed)
        self._turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        self._shift = random.random(3)
        self._origin = self._cell = None
        self._kept, self._count = [], 0

    def add(self, chunk):
        """Takes a chunk of columns, "points" among them."""
        if self._cell is not None:
            chunk = _rows(chunk, self._nearest(chunk["points"]))
        self._kept.append(chunk)
        self._count += len(chunk["points"])
        if self._count > 2 * self._limit:
            self._thin()

    def columns(self):
        """The columns of what is kept, in the order in which it came."""
        if self._count > self._limit:
            self._thin()
        return joined(self._kept)

    def _thin(self):
        columns = joined(self._kept)
        points = columns["points"]
        if self._cell is None:
            self._origin = np.median(points[:: max(1, len(points) // 10_000)], axis=0)
        keep = np.arange(len(points)) if self._cell is None else self._nearest(points)
        if len(keep) > self._limit:
            self._cell = self._grown(points[keep])
            keep = keep[self._nearest(points[keep])]
        self._kept, self._count = [_rows(columns, keep)], len(keep)

    def _grown(self, points):
        """The least cell, to some per cent, of which points are in no more than `limit`."""
        span = float(np.max(np.ptp(points, axis=0)))
        low, high = self._cell or 0.0, None
        cell = low or (span or 1.0) / np.sqrt(self._limit)
        for _ in range(60):
            found = len(np.unique(self._cells(points, cell)[0]))
            if found > self._limit:
                low = cell
                cell = np.sqrt(low * high) if high else cell * max(1.02, np.sqrt(found / self._limit))
            else:
                high = cell
                if found >= _ENOUGH * self._limit or (low and high < 1.01 * low) or high < 1e-9 * span:
                    break
                cell = np.sqrt(low * high) if low else 0.7 * cell
        return high

    def _cells(self, points, cell):
        """(number of the cell of each point, its place in there, 0 to 1 along each axis)."""
        place = (points - self._origin) @ self._turn / cell + self._shift
        whole = np.floor(place)
        place -= whole
        half = float(1 << (_BITS - 1))
        whole = (np.clip(whole, -half, half - 1.0) + half).astype(np.int64)
        return (whole[:, 0] << 2 * _BITS) | (whole[:, 1] << _BITS) | whole[:, 2], place

    def _nearest(self, points):
        """Indices, ascending: of the point in each cell that is nearest to its middle, the first of equal ones."""
        number, place = self._cells(points, self._cell)
        place -= 0.5
        near = np.sum(place * place, axis=1) * ((1 << _NEAR_BITS) / 0.76)
        number = (number << _NEAR_BITS) | near.astype(np.int64)
        order = np.argsort(number, kind="stable")
        number = number[order] >> _NEAR_BITS
        first = np.ones(len(number), dtype=bool)
        first[1:] = number[1:] != number[:-1]
        return np.sort(order[first])


def joined(chunks):
    """Chunks of columns as one."""
    if len(chunks) == 1:
        return chunks[0]
    return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in (chunks[0] if chunks else ())}


def _rows(columns, rows):
    return {name: values[rows] for name, values in columns.items()}
