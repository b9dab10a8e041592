"""An even sample of points that come in chunks, without ever holding more than a few times as many."""

import numpy as np

from surflux.scans.lattice import Lattice

# Shares of the limit between which as many points are kept: while others may come, and in the end.
_WHILE_READING, _AT_LAST = (1.0, 1.3), (0.97, 1.0)
_FULL = 2.0  # times the limit, beyond which what is kept is thinned
_TRIES = 40


class EvenSample:
    """At most `limit` of all points that are added, one in each cell of a grid: the nearest to its middle.

    So a surface is sampled evenly, however dense the scanner was. The grid is turned and shifted at random; its cells
    grow while points come, and leave more than `limit` until all have come. The same chunks and seed give the same
    points, and up to `limit` points are all kept; of more there are 97 % of it at least, but where points coincide.
    """

    def __init__(self, limit, seed=0):
        self._limit = limit
        self._lattice, self._cell = Lattice(seed), None
        self._kept, self._count = [], 0

    @property
    def cell(self):
        """Of the grid; None while all are kept."""
        return self._cell

    def add(self, chunk):
        """Takes a chunk of columns, "points" among them."""
        if self._cell is not None:
            chunk = _rows(chunk, self._nearest(self._lattice.turned(chunk["points"])))
        self._kept.append(chunk)
        self._count += len(chunk["points"])
        if self._count > _FULL * self._limit:
            self._thin(*_WHILE_READING)

    def columns(self):
        """The columns of what is kept, in the order in which it came."""
        if self._count > self._limit:
            self._thin(*_AT_LAST)
        return joined(self._kept)

    def _thin(self, least, most):
        columns = joined(self._kept)
        self._kept = []
        if self._cell is None:
            points = columns["points"]
            self._lattice.origin = np.median(points[:: max(1, len(points) // 10_000)], axis=0)
        turned = self._lattice.turned(columns["points"])
        if self._cell is not None:
            keep = self._nearest(turned)
            columns, turned = _rows(columns, keep), turned[keep]
        if len(turned) > most * self._limit:
            self._cell = self._grown(turned, least * self._limit, most * self._limit)
            columns = _rows(columns, self._nearest(turned))
        self._kept, self._count = [columns], len(columns["points"])

    def _grown(self, turned, least, most):
        """A cell of which points are in no more than `most`, and no fewer than `least` where one is found.

        Cells of a surface are as many as its area holds, so the logarithms of cell and number lie nearly on a line:
        the next cell is where the line through the last two goes through what is wanted.
        """
        some = turned[:: max(1, len(turned) // 10_000)]
        span = float(np.max(np.quantile(some, 0.95, axis=0) - np.quantile(some, 0.05, axis=0)))  # but for strays
        span = span or float(np.max(np.ptp(turned, axis=0))) or 1.0
        wanted = np.log(0.5 * (least + most))
        low, high = self._cell or 0.0, np.inf  # of too many cells, of few enough
        cell, slope, last = max(low, span / np.sqrt(self._limit)), -2.0, None
        for _ in range(_TRIES):
            found = _different(self._lattice.cells(turned, cell))
            if least <= found <= most:
                return cell
            low, high = (cell, high) if found > most else (low, cell)
            if cell < 1e-9 * span or high < 1.001 * low:
                break
            place = np.log(cell), np.log(found)
            if last is not None and place[0] != last[0]:
                slope = np.clip((place[1] - last[1]) / (place[0] - last[0]), -3.0, -0.5)
            last = place
            cell = float(np.exp(place[0] + np.clip((wanted - place[1]) / slope, -2.0, 2.0)))
            if not low < cell < high:
                cell = np.sqrt(low * high) if low and np.isfinite(high) else (2.0 * low if low else 0.5 * high)
        return high if np.isfinite(high) else 2.0 * low

    def _nearest(self, turned):
        return self._lattice.nearest(turned, self._cell)


class UniformSample:
    """At most `limit` of all points (n, 3) that are added, each with the same chance: as dense as the scanner was, but
    for a factor, which an EvenSample does not tell.
    """

    def __init__(self, limit, seed=0):
        self._limit, self._random = limit, np.random.default_rng(seed)
        self._keys, self._points = np.zeros(0), np.zeros((0, 3))

    def add(self, points):
        """Takes points (k, 3)."""
        keys = self._random.random(len(points))
        if len(self._keys) == self._limit:
            taken = keys < self._keys.max()
            keys, points = keys[taken], points[taken]
        keys, points = np.concatenate([self._keys, keys]), np.concatenate([self._points, points])
        if len(keys) > self._limit:
            least = np.argpartition(keys, self._limit)[: self._limit]
            keys, points = keys[least], points[least]
        self._keys, self._points = keys, points

    def points(self):
        """(m, 3) those that are kept."""
        return self._points


def _different(numbers):
    """How many different ones there are."""
    numbers.sort()
    return 1 + int(np.count_nonzero(numbers[1:] != numbers[:-1]))


def joined(chunks):
    """Chunks of columns as one."""
    if len(chunks) == 1:
        return chunks[0]
    return {name: np.concatenate([chunk[name] for chunk in chunks]) for name in (chunks[0] if chunks else ())}


def _rows(columns, rows):
    return {name: values[rows] for name, values in columns.items()}
