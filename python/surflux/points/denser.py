"""Normals of points that were thinned, fitted to those that were there before."""

import numpy as np

from surflux import _core
from surflux._base.passes import stage
from surflux.geometry.estimates import NORMAL_NEIGHBORS, estimated_normals, turned_by
from surflux.points.depth_steps import depth_step
from surflux.points.layers import layer_of
from surflux.scans.thinning import EvenSample

_BLOCK = 2_000_000  # points among which normals are fitted at once: memory is theirs
_MARGIN = 3.0  # cells of the thinned points around a block
_PIECES, _PIECE, _BESIDE = 16, 1000, 4  # stretches along a curve, places in each, the neighbour compared with
# Degrees between normals of places beside each other, on average, up to which they do not follow noise, whatever those
# of fewer points have: on scans these have more, of noise wider than places are apart less.
_STEADY = 6.0
# Neighbours that a normal is fitted to, times the root of how much denser they are. Noise turns a fit the less the
# more there are and the wider they reach; so it stays about that of fits to fewer points, at half the reach.
_NEIGHBORS = 8.0
_ELSEWHERE = 0.5  # cosine of two fits at one place, up to which one does not tell the side of the other


def denser_normals(points, read):
    """(n, 3) unit normals of points (n, 3), by fits to those around them that were read besides; consistent, as of
    estimate_normals.

    Where noise is wider than these are apart, a fit to the nearest follows it: normals beside each other differ by more
    than those of fits to the points themselves. Then fewer are taken. None where too few are left to tell more than the
    points, where they have no plane, or depths in steps.

    Args:
        read: Columns, with points around.
    """
    around, margin = read.around, _MARGIN * read.cell
    if layer_of(read.uniform) == "frame" and depth_step(around) is not None:
        return None
    usual = None
    while len(around) > len(points):
        try:
            normals, apart, is_parted = _by_blocks(points, around, margin)
            if usual is None and (is_parted or apart > _STEADY):
                usual = estimated_normals(points, None)
        except ValueError:  # fewer than three, or all on a line
            return None
        if apart <= _STEADY or apart <= _apart(points, usual):
            if is_parted:  # blocks know nothing of each other's sides
                normals = turned_by(points, normals, np.sum(normals * usual, axis=1), _ELSEWHERE)
            return normals
        sample = EvenSample(max(2, len(around) // 4))
        sample.add({"points": around})
        around = sample.columns()["points"]
    return None


def _by_blocks(points, around, margin):
    """(the normals, degrees between those of places beside each other, whether they are of several blocks)."""
    told, out, apart = stage("normals"), np.empty(points.shape), []
    neighbors = max(NORMAL_NEIGHBORS, round(_NEIGHBORS * np.sqrt(len(around) / len(points))))
    blocks = _blocks(points, np.arange(len(points)), len(points) * _BLOCK // len(around))
    for k, rows in enumerate(blocks):
        near = around
        if len(blocks) > 1:
            low, high = points[rows].min(axis=0) - margin, points[rows].max(axis=0) + margin
            near = around[np.all((around >= low) & (around <= high), axis=1)]
        both = np.concatenate([points[rows], near])
        part = told and _Part(told, k, len(blocks))
        stretches = _stretches(both)
        wanted = np.arange(len(both)) < len(rows)  # of others the fits are looked at in stretches alone
        wanted[np.concatenate(stretches)] = True
        normals = _core.estimate_normals(both, min(neighbors, len(both) - 1), None, wanted, progress=part)
        out[rows] = normals[: len(rows)]
        apart.append(_apart(both, normals, stretches))
    return out, np.mean(apart), len(blocks) > 1


class _Part:
    """Progress of one of several passes that count as one."""

    def __init__(self, told, k, count):
        self._told, self._k, self._count = told, k, count

    def __call__(self, done, total):
        return self._told(self._k * total + done, self._count * total)


def _blocks(points, rows, most):
    """Rows in compact blocks of at most so many, halved across their longest side."""
    if len(rows) <= max(most, 1000):
        return [rows]
    some = points[rows]
    axis, half = int(np.argmax(np.ptp(some, axis=0))), len(rows) // 2
    order = np.argpartition(some[:, axis], half)
    return [block for part in (order[:half], order[half:]) for block in _blocks(points, rows[part], most)]


def _stretches(points):
    """List of rows of some stretches along a curve through points (n, 3)."""
    order = _core.morton_order(points)
    begins = np.linspace(0, max(0, len(order) - _PIECE), _PIECES).astype(np.int64)
    return [order[begin : begin + _PIECE] for begin in begins]


def _apart(points, normals, stretches=None):
    """Degrees between normals of some places and of those beside them, on average."""
    found = []
    for rows in _stretches(points) if stretches is None else stretches:
        rows = rows[np.unique(points[rows], axis=0, return_index=True)[1]]
        if len(rows) > _BESIDE:
            beside = rows[_core.nearest_points(np.ascontiguousarray(points[rows]), _BESIDE + 1)[:, _BESIDE]]
            found.append(np.abs(np.sum(normals[rows] * normals[beside], axis=1)))
    return np.mean(np.degrees(np.arccos(np.clip(np.concatenate(found), 0.0, 1.0)))) if found else 0.0
