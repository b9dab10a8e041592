"""An even sample of points that come in chunks, without ever holding more than a few times as many."""

import numpy as np

from surflux.scans.lattice import Lattice

# The share of the limit with which no finer cells are tried: while points come, and in the end.
_ROUGHLY, _CLOSELY = 0.85, 0.97
_TRIES = 40


class EvenSample:
    """At most `limit` of all points that are added, one in each cell of a grid: the nearest to its middle.

    So a surface is sampled evenly, however dense the scanner was. The grid is turned and shifted at random; its cells
    grow while points come. The same chunks and seed give the same points, and up to `limit` points are all kept.
    """

    def __init__(self, limit, seed=0):
        self._limit = limit
        self._lattice, self._cell = Lattice(seed), None
        self._kept, self._count = [], 0

    def add(self, chunk):
        """Takes a chunk of columns, "points" among them."""
        if self._cell is not None:
            chunk = _rows(chunk, self._nearest(self._lattice.turned(chunk["points"])))
        self._kept.append(chunk)
        self._count += len(chunk["points"])
        if self._count > 2 * self._limit:
            self._thin(_ROUGHLY)

    def columns(self):
        """The columns of what is kept, in the order in which it came."""
        if self._count > self._limit:
            self._thin(_CLOSELY)
        return joined(self._kept)

    def _thin(self, share):
        columns = joined(self._kept)
        self._kept = []
        if self._cell is None:
            points = columns["points"]
            self._lattice.origin = np.median(points[:: max(1, len(points) // 10_000)], axis=0)
        turned = self._lattice.turned(columns["points"])
        if self._cell is not None:
            keep = self._nearest(turned)
            columns, turned = _rows(columns, keep), turned[keep]
        if len(turned) > self._limit:
            self._cell = self._grown(turned, share)
            columns = _rows(columns, self._nearest(turned))
        self._kept, self._count = [columns], len(columns["points"])

    def _grown(self, turned, share):
        """A cell of which points are in no more than `limit`, and no fewer than that share of it where one is found.

        Cells of a surface are as many as its area holds, so the logarithms of cell and number lie nearly on a line:
        the next cell is where the line through the last two goes through what is wanted.
        """
        some = turned[:: max(1, len(turned) // 10_000)]
        span = float(np.max(np.quantile(some, 0.95, axis=0) - np.quantile(some, 0.05, axis=0)))  # but for strays
        span = span or float(np.max(np.ptp(turned, axis=0))) or 1.0
        wanted = np.log(0.5 * (1.0 + share) * self._limit)
        low, high = self._cell or 0.0, np.inf  # of too many cells, of few enough
        cell, slope, last = max(low, span / np.sqrt(self._limit)), -2.0, None
        for _ in range(_TRIES):
            found = _different(self._lattice.cells(turned, cell))
            if share * self._limit <= found <= self._limit:
                return cell
            low, high = (cell, high) if found > self._limit else (low, cell)
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
