"""Points of a scan that are not of its surface: repeated ones, and strays."""

from itertools import product

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.passes import LOG

MOST_ALONE = 0.01  # of all points: where more stand alone, the sampling is uneven, and none of them strays
_MIXED = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0xD6E8FEB86659FD93], dtype=np.uint64)


def cleaned(scan, keep_outliers=False, say=True, undo="--keep-outliers keeps them"):
    """(rows of a Scan to be used, (n,) the first at each point's place, (n,) booleans: points that are left out).

    Rows are ascending, one for each place that first_of_each tells apart; what is isolated is not among them, nor what
    a LAS file withholds, but with keep_outliers, where nothing is left out. What is left out is logged, if `say`, and
    `undo`, how it is kept.
    """
    count = len(scan)
    withheld = np.asarray(scan.attributes.get("withheld", np.zeros(count))) == 1
    withheld &= not keep_outliers
    taken = np.flatnonzero(~withheld)
    first, alone = first_among(taken, scan.points, scan.normals), np.zeros(count, dtype=bool)
    if not keep_outliers:
        alone[taken] = isolated(scan.points[taken])
    own = first == np.arange(count)
    if say and not np.all(own):
        repeats = check.counted(int(np.count_nonzero(~own)), "point")
        LOG.info("counted once, for another one stands at their place: %s", repeats)
    if say and np.any(alone):
        many = check.counted(int(np.count_nonzero(alone)), "point")
        LOG.info("isolated, left out of light and picture: %s of %d (%s)", many, count, undo)
    if say and np.any(withheld):
        many = check.counted(int(np.count_nonzero(withheld)), "point")
        LOG.info("withheld by their file, left out: %s of %d (%s)", many, count, undo)
    alone |= withheld
    return np.flatnonzero(own & ~alone), first, alone


def first_among(taken, points, normals=None):
    """(n,) first_of_each among the rows `taken`, ascending, of (n, 3) points; the others are their own.

    So a point that is left out, as withheld ones are, does not stand for one at its place that is not.
    """
    first = np.arange(len(points))
    if len(taken):
        first[taken] = taken[first_of_each(points[taken], None if normals is None else normals[taken])]
    return first


def first_across(group, points, tolerance):
    """(n,) int64: for each point the first at its place in another group (n,), itself where none was before it.

    At its place is what is no farther in x, y and z than `tolerance`; up to four times as far, a few are, too.
    """
    first = np.arange(len(points))
    # Along each axis one at least of two lattices of cells, half a cell apart, has both of two such points in one cell.
    cells = (points - points.min(axis=0, initial=np.inf)) / (2.0 * tolerance)
    for moved in product((0.0, 0.5), repeat=3):
        lead = _lead(np.floor(cells + moved))
        found = (group[lead] != group) & (first == np.arange(len(first)))
        first[found] = lead[found]
    while np.any(first != first[first]):
        first = first[first]
    return first


def known_classes(path, classes):
    """(n,) int64 of a column of classes; what is no whole number, such as NaN, counts as 0, never classified, and is
    logged.
    """
    values = np.asarray(classes)
    if values.dtype.kind in "biu":
        return values.astype(np.int64)
    known = (np.abs(values) < 2.0**53) & (values == np.floor(values))
    if not np.all(known):
        many = check.counted(int(np.count_nonzero(~known)), "point")
        row = int(np.argmin(known))
        text = "%s: %s of %d without a class (at index %d: %g) count as class 0, never classified"
        LOG.info(text, path, many, len(values), row, values[row])
    return np.where(known, values, 0).astype(np.int64)


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
        left = left[backs]  # never all of them: the first at a place is none
    return first


def numbers_of_rows(used, first):
    """(n,) the number that each row of a cloud has in `used`, repeats that of their `first`; -1 of those with none."""
    number = np.full(len(first), -1)
    number[used] = np.arange(len(used))
    return number[first]


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
    """(n,) booleans: points that stand alone, or float with few others, four times as far from all else as is usual.

    Places count once. None where more than a hundredth of all would: such a cloud is sampled unevenly.
    """
    found = standing_alone(points)
    return found if some_stray(np.count_nonzero(found), len(points)) else np.zeros(len(points), dtype=bool)


def some_stray(alone, count):
    """Whether so many of all points that stand alone are strays: of an uneven sampling none is."""
    return alone <= MOST_ALONE * count


def standing_alone(points):
    """The same however many these are."""
    first = first_of_each(points)
    places = np.flatnonzero(first == np.arange(len(points)))
    found = np.zeros(len(points), dtype=bool)
    found[places] = _core.find_strays(points[places])
    return found[first]
