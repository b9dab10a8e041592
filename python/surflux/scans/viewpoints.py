"""Where points were seen from, in files that have no field for it: comments of PLY, an array of NPZ."""

import numpy as np

from surflux._base.warn import warn

NAME = "viewpoints"  # of the array
_WORD = "viewpoint"  # that begins a comment


def comments_of(viewpoints):
    """Lines of text, one for each scan: NaN where it is not known; none where all are not."""
    rows = rows_of_places(places_of(viewpoints))
    if not np.any(np.isfinite(rows)):
        return []
    return [f"{_WORD} {' '.join(repr(float(v)) for v in row)}" for row in rows]


def viewpoints_of(comments):
    """What comments_of wrote, among other lines: a list of (3,), None where not known."""
    found = []
    for words in (line.split() for line in comments):
        if len(words) == 4 and words[0] == _WORD:
            try:
                found.append([float(word) for word in words[1:]])
            except ValueError:
                continue
    return places_of(found)


def places_of(rows):
    """A list of (3,) of rows (k, 3), None where one is not finite."""
    return [[float(v) for v in row] if np.all(np.isfinite(row)) else None for row in rows]


def rows_of_places(places):
    """(k, 3) of such a list: NaN for None."""
    return np.array([[np.nan] * 3 if place is None else place for place in places], np.float64).reshape(-1, 3)


def warn_of_lost(path, viewpoints):
    """Says that a format has no room for them, where points without normals would be seen from there."""
    if any(np.all(np.isfinite(place)) for place in viewpoints):
        warn(
            f"{path}: where the points were seen from is left out: normals that are estimated of them may face the "
            "other way; .ply and .npz keep it"
        )
