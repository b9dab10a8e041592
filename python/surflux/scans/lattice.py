"""Cubic cells in space, and one point of each: even samples that go by places alone."""

import numpy as np

_NEAR_BITS = 9  # of how near a point is to the middle of its cell
# Odd numbers: sums of three whole numbers times these, modulo 2^64, tell cells apart by their upper 54 bits. Two of ten
# million cells are taken for one with a probability of .3 %, and then one point fewer is kept.
_MIXED = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xD6E8FEB86659FD93], dtype=np.uint64)


class Lattice:
    """Cells around an origin, turned and shifted at random: the same for an origin and a seed, whatever points come.

    So which point of a place is the nearest to the middle of its cell does not depend on the other points that were
    read with it.
    """

    def __init__(self, seed=0, origin=None):
        random = np.random.default_rng(seed)
        self._turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        self._shift = random.random(3)
        self.origin = origin

    def turned(self, points):
        """Points (n, 3) in the directions of the cells, from the origin."""
        return (points - self.origin) @ self._turn

    def cells(self, turned, cell):
        """The number of the cell of each point, uint64 with as many bits as are mixed; cell: its side."""
        number = np.zeros(len(turned), dtype=np.uint64)
        for axis in range(3):
            whole = np.floor(turned[:, axis] / cell + self._shift[axis])
            number += np.clip(whole, -1e18, 1e18).astype(np.int64).view(np.uint64) * _MIXED[axis]
        return number >> np.uint64(_NEAR_BITS + 1)

    def nearest(self, turned, cell):
        """Indices, ascending: of the point in each cell that is nearest to its middle, the first of equal ones."""
        order, first = self._in_cells(turned, cell)
        return np.sort(order[first])

    def nearest_and_most(self, turned, cell, values):
        """(the indices of `nearest`, the largest of the values (n,) of the points in each one's cell)."""
        order, first = self._in_cells(turned, cell)
        rows, most = order[first], np.maximum.reduceat(values[order], first)
        ascending = np.argsort(rows)
        return rows[ascending], most[ascending]

    def _in_cells(self, turned, cell):
        """(an order of the points by cells, the nearest to its middle first; where in it each cell begins)."""
        near = np.zeros(len(turned))
        for axis in range(3):
            place = turned[:, axis] / cell + self._shift[axis]
            near += (place - np.floor(place) - 0.5) ** 2
        near *= (1 << _NEAR_BITS) / 0.76
        number = (self.cells(turned, cell) << np.uint64(_NEAR_BITS)) | near.astype(np.uint64)
        order = np.argsort(number, kind="stable")
        number = number[order] >> np.uint64(_NEAR_BITS)
        first = np.ones(len(number), dtype=bool)
        first[1:] = number[1:] != number[:-1]
        return order, np.flatnonzero(first)
