"""Polygons as fans of triangles around their first corner, over each of which what corners have is linear."""

import numpy as np

from surflux import _core

_ROUNDING = 1e-6  # of the height of a triangle over a line
_MOST_CORNERS = 64  # of faces that are cut: parts are as many as triangles times lines


def fans_of_faces(vertices, offsets, indices, faces):
    """(of (t,), corners (t, 3), shares (t,)) of triangles: the row in `faces`, corners of polygons, shares of its area.

    The corners of face f are indices[offsets[f]:offsets[f + 1]]. Beyond a concave corner shares are below 0.
    """
    first, counts = offsets[faces], np.diff(offsets)[faces]
    of = np.repeat(np.arange(len(faces)), counts - 2)
    second = first[of] + 1 + np.arange(len(of)) - np.repeat(np.cumsum(counts - 2) - (counts - 2), counts - 2)
    corners = np.stack([first[of], second, second + 1], axis=1)
    a, b, c = vertices[indices[corners]].transpose(1, 0, 2)
    crosses = np.cross(b - a, c - a)
    weights = np.einsum("tk,tk->t", crosses, sums_of_rows(of, crosses, len(faces))[of])
    return of, corners, shares_of_rows(of, weights, len(faces))


def shares_of_rows(of, weights, count):
    """(t,): weights (t,) over the sum of those that are of the same (t,); alike where that is not above 0."""
    weights = np.where(np.bincount(of, weights, count)[of] > 0.0, weights, 1.0)
    return weights / np.bincount(of, weights, count)[of]


def sums_of_rows(of, values, count):
    """(count, k): sums of the rows of values (t, k) that are of the same (t,)."""
    return np.stack([np.bincount(of, channel, count) for channel in values.T], axis=1)


def cut_along_fans(vertices, offsets, indices, face, triangles):
    """(of (m,), parts (m, 3, 3)): parts of triangles (t, 3, 3) on faces (t,), each in one triangle of the fan.

    On faces of more corners than _MOST_CORNERS triangles stay whole.
    """
    counts = np.diff(offsets)
    number = np.arange(len(indices)) - np.repeat(offsets[:-1], counts)  # of each corner in its face
    values = np.stack([number, number > 0], axis=1).astype(np.float64)
    whole = (counts[face] == 3) | (counts[face] > _MOST_CORNERS)
    found, of, triangles = [(np.flatnonzero(whole), triangles[whole])], np.flatnonzero(~whole), triangles[~whole]
    least, most = np.zeros(len(of), np.int64), counts[face[of]]
    before = np.full(len(of), -1)  # the line along which each was cut
    while len(of):
        points = np.concatenate([triangles, triangles.mean(axis=1, keepdims=True)], axis=1)
        at = face[of].repeat(4)
        places = _core.polygon_values(vertices, offsets, indices, values, at, points.reshape(-1, 3)).reshape(-1, 4, 2)
        beyond = places[:, 3, 0] > before * places[:, 3, 1]
        least = np.where(beyond, np.maximum(least, before + 1), least)
        most = np.where(beyond, most, np.minimum(most, before - 1))
        line, last = _lines_between(places[:, :3], counts[face[of]])
        line, last = np.maximum(line, least), np.minimum(last, most)
        cut = line <= last
        found.append((of[~cut], triangles[~cut]))
        of, line = of[cut], (line[cut] + last[cut]) // 2  # the middle one, for few rounds
        first = offsets[face[of]]
        row, triangles = _cut_along_lines(triangles[cut], vertices[indices[first]], vertices[indices[first + line]])
        of, least, most, before = of[row], least[cut][row], most[cut][row], line[row]
    return tuple(np.concatenate(each) for each in zip(*found, strict=True))


def _lines_between(places, counts):
    """First and last (t,) of the lines from a face's first corner to its others that go through triangles.

    places (t, 3, 2): numbers of the face's corners, of which there are counts (t,), at corners of a triangle, and how
    far from the first these are.
    """
    number, far = np.moveaxis(places, 2, 0)
    known = far > _ROUNDING  # all lines go through the first corner
    number = number / np.where(known, far, 1.0)
    number = np.clip(number, 1.0, counts[:, None] - 1.0)
    low, high = np.where(known, number, counts[:, None]).min(axis=1), np.where(known, number, 0.0).max(axis=1)
    return np.floor(low + _ROUNDING).astype(np.int64) + 1, np.ceil(high - _ROUNDING).astype(np.int64) - 1


def _cut_along_lines(triangles, begin, end):
    """(row (m,), parts (m, 3, 3)) of triangles (t, 3, 3), cut by lines in their planes through two points, or whole."""
    a, b, c = triangles.transpose(1, 0, 2)
    sideways = np.cross(np.cross(b - a, c - a), end - begin)
    heights = np.einsum("tkc,tc->tk", triangles - begin[:, None], sideways)
    heights[np.abs(heights) < _ROUNDING * np.abs(heights).max(axis=1, keepdims=True)] = 0.0
    is_cut = (heights.min(axis=1) < 0.0) & (heights.max(axis=1) > 0.0)
    row = np.flatnonzero(is_cut)
    below = heights[row] < 0.0
    alone = np.argmax(below == (below.sum(axis=1) == 1)[:, None], axis=1)  # the corner on one side by itself
    turned = (alone[:, None] + np.arange(3)) % 3
    h = np.take_along_axis(heights[row], turned, axis=1)[:, :, None]
    a, b, c = np.take_along_axis(triangles[row], turned[:, :, None], axis=1).transpose(1, 0, 2)
    p, q = a + h[:, 0] / (h[:, 0] - h[:, 1]) * (b - a), a + h[:, 0] / (h[:, 0] - h[:, 2]) * (c - a)
    parts = np.concatenate([np.stack(corners, axis=1) for corners in ((a, p, q), (p, b, c), (p, c, q))])
    a, b, c = parts.transpose(1, 0, 2)
    kept = np.cross(b - a, c - a).any(axis=1)  # where the line goes through a corner one is empty
    kept |= np.tile(~kept.reshape(3, -1).any(axis=0), 3)  # of slivers all may be, by rounding
    return (
        np.concatenate([np.flatnonzero(~is_cut), np.tile(row, 3)[kept]]),
        np.concatenate([triangles[~is_cut], parts[kept]]),
    )
