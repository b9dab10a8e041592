"""Means of textures over triangles of places on them: exact area integrals along the triangles' sides."""

import numpy as np

_ROWS = (512, 256, 128, 64, 32, 16)  # so many of texels under a triangle count one by one
_OF_ALL = 1 << 23  # rows of all triangles together, beyond which each has fewer
_AT_ONCE = 1 << 16  # pieces: these stay in caches
_TEXELS = 1 << 21  # in a table of sums, but for the rows of one triangle
_FARTHEST = 1e9
_FEW, _MANY = 4, 16  # places along a side where there is no area
_BARE = 1e-4  # of a triangle: if less is there, it has no colour of its own
_WHOLE = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float64)


def mean_texels(texture, corners):
    """(f, 3): linear means of a Texture over triangles of places on it (f, 3, 2); it repeats itself, and v goes up.

    By area, exact up to 512 rows of texels under a triangle (16 where hundreds of thousands have more), beyond which
    rows are taken together; where a triangle has so many repeats under it, all rows. Triangles without an area, or
    next to none over many repeats, have the mean of places on them. Places that are not finite, or beyond
    1e9, count as 0.

    With a cover, texels count by what is there of them, for those that are not are black in many files. A triangle
    where nothing is has the mean of the whole texture.
    """
    means = _means(texture, corners)
    if texture.cover is None:
        return means
    bare = means[:, 3] < _BARE
    if bare.any():
        whole = _means(texture, _WHOLE).mean(axis=0)
        if whole[3] < _BARE:
            return _means(texture._replace(cover=None), corners)
        means[bare] = whole
    return np.clip(np.round(means[:, :3] / means[:, 3:], 6), 0.0, 1.0)


def _means(texture, corners):
    """(f, 3) means of mean_texels; with a cover (f, 4), of colours times it, and of itself."""
    size = np.array(texture.pixels.shape[1::-1], np.float64)
    places = np.where(np.abs(corners) < _FARTHEST, corners, 0.0) * [1.0, -1.0]  # rows go down
    places = (places - np.floor(places.min(axis=1, keepdims=True))) * size  # in texels, from the first tile on
    first, last = places.min(axis=1), places.max(axis=1)
    a, b = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    # Sums along rows are rounded: what is thinner would be off by more than 1e-4.
    reach, length = size[0] + last[:, 0], (last - first).max(axis=1)
    thin = ~(np.abs(areas) > length * reach * (1e-9 + 1e-12 * reach))
    means = np.empty((len(corners), _channels(texture)))
    for some, count in ((thin & (length <= _FEW), _FEW), (thin & (length > _FEW), _MANY)):
        means[some] = _of_places(texture, places[some], count)
    means[~thin] = _of_areas(texture, places[~thin], areas[~thin])
    # Equal ones are equal to the last bit, so that two triangles of a plane become one patch.
    return np.clip(np.round(means, 9), 0.0, 1.0)


def _channels(texture):
    return 3 if texture.cover is None else 4


def _of_places(texture, places, count):
    """(f, 3 or 4): means of the texels in the middles of the count^2 triangles that parts of the sides make."""
    height, width = texture.pixels.shape[:2]
    upright = [(3 * i + 1, 3 * j + 1) for i in range(count) for j in range(count - i)]
    middles = upright + [(3 * i + 2, 3 * j + 2) for i in range(count - 1) for j in range(count - 1 - i)]
    total = np.zeros((len(places), _channels(texture)))
    for a, b in middles if len(places) else ():
        whole = 3 * count
        x, y = ((whole - a - b) * places[:, 0] + a * places[:, 1] + b * places[:, 2]).T / whole
        column, row = np.floor(x).astype(np.int64) % width, np.floor(y).astype(np.int64) % height
        for channel in range(total.shape[1]):
            total[:, channel] += texture.values(row, column, channel)
    return total / len(middles)


def _of_areas(texture, places, areas):
    """(f, 3 or 4): means over triangles that have an area (f,), with a sign, of places (f, 3, 2) in texels."""
    height, width = texture.pixels.shape[:2]
    top, bottom = places[:, :, 1].min(axis=1), places[:, :, 1].max(axis=1)
    most = next((rows for rows in _ROWS if np.minimum(bottom - top, rows).sum() <= _OF_ALL), _ROWS[-1])
    # Rows of a triangle that go together: a power of two of them, or all of the texture.
    steps = np.exp2(np.ceil(np.log2(np.maximum((bottom - top) / most, 1.0))))
    steps = np.minimum(steps, height).astype(np.int64)
    # Together go triangles that lie in the same rows, so that few rows are summed, and each of them seldom.
    band = (top / steps).astype(np.int64) // max(_TEXELS // width, 1)
    order = np.lexsort((top, band, steps))
    pieces = np.cumsum(2.0 * (bottom - top)[order] / steps[order] + 6.0) // _AT_ONCE
    cuts = np.diff(np.stack([steps[order], band[order], pieces]), axis=1).any(axis=0)
    means = np.empty((len(places), _channels(texture)))
    for some in np.split(order, np.flatnonzero(cuts) + 1) if len(order) else ():
        means[some] = _integrals(texture, places[some], int(steps[some[0]])) / areas[some, None]
    return means


def _integrals(texture, places, step):
    """(f, 3 or 4): integrals over triangles (f, 3, 2) in texels: of sums along rows by Green's theorem on the sides."""
    width = texture.pixels.shape[1]
    side, row, top, bottom, left, right = _pieces(places, texture.pixels.shape[0], step)
    rows, row = np.unique(row, return_inverse=True)
    row = row.ravel()
    columns = np.floor(np.stack([left, right]))
    tiles = np.floor(columns / width)
    at = row * (width + 1) + (columns - tiles * width).astype(np.int64)
    parts = np.stack([left, right]) - columns
    # Sums are bent where a piece of a side passes from texel to texel; where it does so twice, sums of them count.
    far = np.flatnonzero(columns[1] - columns[0] > 1.0)
    passes = columns[1] > columns[0]
    bend = np.zeros(len(row))
    border, before, behind = columns[1][passes], left[passes], right[passes]
    bend[passes] = (behind - border) * (border - before) / (behind - before)
    heights = bottom - top
    found = np.empty((len(places), _channels(texture)))
    for channel in range(found.shape[1]):
        texels = _rows(texture, channel, rows, step)
        sums = np.zeros((len(rows), width + 1))
        np.cumsum(texels, axis=1, out=sums[:, 1:])
        flat = sums.ravel()
        start = flat[at]
        texel = flat[at + 1] - start
        whole = sums[row, -1]
        ends = start + parts * texel + tiles * whole
        mean = 0.5 * (ends[0] + ends[1] - (texel[1] - texel[0]) * bend)
        if len(far):
            of_sums = np.zeros_like(sums)
            np.cumsum(sums[:, :-1] + 0.5 * texels, axis=1, out=of_sums[:, 1:])
            part, tile, row_sum = parts[:, far], tiles[:, far], whole[far]
            inside = columns[:, far] - tile * width + part
            ends = of_sums.ravel()[at[:, far]] + part * (start[:, far] + 0.5 * part * texel[:, far])
            ends += tile * (of_sums[row[far], -1] + row_sum * (inside + 0.5 * width * (tile - 1.0)))
            mean[far] = (ends[1] - ends[0]) / (right - left)[far]
        found[:, channel] = np.bincount(side // 3, heights * mean, len(places))
    return found


def _pieces(places, height, step):
    """Sides of triangles (f, 3, 2) cut at borders of rows: (side, row, top, bottom, left, right), (n,) each.

    Side 3 f + k runs from corner k of triangle f; a row is one of `step` rows of texels. Bottom is less than top where
    the side runs up.
    """
    x0, y0 = places.reshape(-1, 2).T
    x1, y1 = np.roll(places, -1, axis=1).reshape(-1, 2).T
    low, high = np.minimum(y0, y1), np.maximum(y0, y1)
    if step == height:  # all rows are one
        side = np.flatnonzero(high > low)
        row, top, bottom = np.zeros(len(side), np.int64), low[side], high[side]
    else:
        of_tile = -(-height // step)

        def row_of(y):
            tile = np.floor(y / height)
            return (tile * of_tile + np.floor((y - tile * height) / step)).astype(np.int64)

        def begin_of(row):
            return row // of_tile * height + row % of_tile * step

        first = row_of(low)
        counts = np.where(high > low, row_of(high) - first + 1, 0)
        side = np.repeat(np.arange(len(first)), counts)
        row = first[side] + np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)
        top, bottom = np.maximum(begin_of(row), low[side]), np.minimum(begin_of(row + 1), high[side])
        row %= of_tile
    slope = (x1 - x0)[side] / (y1 - y0)[side]
    ends = x0[side] + slope * (np.stack([top, bottom]) - y0[side])
    up = (y1 < y0)[side]
    return side, row, np.where(up, bottom, top), np.where(up, top, bottom), ends.min(axis=0), ends.max(axis=0)


def _rows(texture, channel, rows, step):
    """(len(rows), w): linear texels of a channel, means of `step` rows each."""
    if step == 1:
        return texture.values(rows, slice(None), channel)
    total = np.zeros((len(rows), texture.pixels.shape[1]))
    for k in range(step):
        below = rows * step + k
        inside = below < texture.pixels.shape[0]
        total[inside] += texture.values(below[inside], slice(None), channel)
    return total / np.minimum(step, texture.pixels.shape[0] - rows * step)[:, None]
