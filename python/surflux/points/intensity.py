"""Grey by the intensity of what a scanner got back, which has no unit: what is white, and what is no measurement."""

from typing import NamedTuple

import numpy as np

from surflux._base.color import WHITE, rgb_of_grey
from surflux._base.passes import LOG
from surflux.geometry.estimates import percent

_MEAN = 0.5
_MANY = 0.005  # of the points
_FAR = 2.0  # distances from the least of the others to their median
_MOST_LEVELS = 1 << 20  # different intensities that are kept apart
_BITS = 16  # of those of more


class IntensityScale(NamedTuple):
    """What intensities mean: their reflectance is (intensity - zero) factor, at most .98, and .5 where not known."""

    least: float  # what is below is no measurement
    zero: float
    factor: float
    unknown: int  # points
    white: int  # points that are cut off at .98
    count: int  # points, all of them
    mean: float  # reflectance of those that are known

    def reflectance(self, intensity):
        """(n, 3) of intensities (n,)."""
        values = np.asarray(intensity, dtype=np.float64)
        known = np.isfinite(values) & (values >= self.least)
        grey = np.full(len(values), _MEAN)
        grey[known] = np.clip((values[known] - self.zero) * self.factor, 0.0, WHITE)
        return rgb_of_grey(grey)

    def tell(self, name):
        """Logs what is not as usual, under `name`."""
        if self.unknown:
            below = f", or below {self.least:g}" if self.least > -np.inf else ""
            words = "%s: intensity not known (not finite%s) of %d of %d points, which are grey, .5"
            LOG.info(words, name, below, self.unknown, self.count)
        if self.white > _MANY * self.count:
            words = "%s: the intensity of %s of the points is cut off at white, .98: the mean of all is %.2f with them"
            LOG.info(words, name, percent(self.white / self.count), self.mean)
        elif self.mean < _MEAN - _MANY:
            LOG.info("%s: reflectance by intensity has a mean of %.2f: many have next to none", name, self.mean)


class Levels:
    """Which intensities there are, and how often: of chunks, as many as there may be."""

    def __init__(self):
        self._levels, self._counts, self._unknown, self._coarse = np.zeros(0), np.zeros(0, np.int64), 0, False

    def add(self, intensity):
        """Takes those of a chunk (n,)."""
        levels, counts, unknown = _levels_of(intensity)
        self._unknown += unknown
        self._merge(np.concatenate([self._levels, levels]), np.concatenate([self._counts, counts]))

    def _merge(self, levels, counts):
        self._levels, where = np.unique(_rounded(levels) if self._coarse else levels, return_inverse=True)
        self._counts = np.bincount(where, counts, len(self._levels)).astype(np.int64)
        if len(self._levels) > _MOST_LEVELS and not self._coarse:
            self._coarse = True
            self._merge(self._levels, self._counts)

    def scale(self):
        """The IntensityScale of all; None where they say nothing."""
        return _scale(self._levels, self._counts, self._unknown)


def scale_of_intensity(intensity):
    """The IntensityScale of intensities (n,); None where they say nothing: all the same, or none known."""
    return None if np.ndim(intensity) != 1 else _scale(*_levels_of(intensity))


def _levels_of(intensity):
    """(different finite values, ascending, how many points have each, how many have others)."""
    values = np.asarray(intensity)
    if values.dtype.kind == "u" and values.dtype.itemsize <= 2:
        counts = np.bincount(values)
        levels = np.flatnonzero(counts)
        return levels.astype(np.float64), counts[levels], 0
    values = values.astype(np.float64)
    known = np.isfinite(values)
    levels, counts = np.unique(values[known], return_counts=True)
    return levels, counts, len(values) - int(counts.sum())


def _rounded(levels):
    fractions, exponents = np.frexp(levels)
    return np.ldexp(np.rint(fractions * 2.0**_BITS), exponents - _BITS)


def _scale(levels, counts, unknown):
    first = _first_measured(levels, counts)
    total, unknown = unknown + int(counts.sum()), unknown + int(counts[:first].sum())
    # Halfway, so that rounded levels tell the same values apart.
    least = 0.5 * levels[first - 1] + 0.5 * levels[first] if first else -np.inf
    levels, counts = levels[first:], counts[first:]
    if len(levels) < 2:
        return None
    zero = min(0.0, float(levels[0]))
    levels = levels - zero
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        factor = float(_factor(levels, counts))
    if not 0.0 < factor < np.inf:  # of numbers at the ends of what floats hold
        return None
    grey, known = np.minimum(levels * factor, WHITE), int(counts.sum())
    white = int(counts[levels * factor > WHITE].sum())
    return IntensityScale(float(least), zero, factor, unknown, white, total, float(counts @ grey) / known)


def _first_measured(levels, counts):
    """How many of the ascending values, all below 0, stand for no data, such as -9999.

    On a logarithmic scale there are many values below 0, near each other: one is no data if it is the only one below
    0, or far below all others.
    """
    first = 0
    while len(levels) - first > 1 and levels[first] < 0.0:
        rest = levels[first + 1 :]
        spread = _median(rest, counts[first + 1 :]) - rest[0]
        if rest[0] < 0.0 and not 0.0 < _FAR * spread < rest[0] - levels[first]:
            break
        first += 1
    return first


def _factor(levels, counts):
    """What makes the mean of min(factor levels, white) .5, levels being ascending and not below 0.

    Without it reflectors, hundreds of times as bright as all else, would make everything else dark. At most half of
    the levels above 0 become white: where half the points have none, no factor would do.
    """
    count = counts.sum()
    factor = _MEAN / (float(counts @ levels) / count)
    if factor * levels[-1] <= WHITE:
        return factor
    above = levels > 0.0
    levels, counts = levels[above], counts[above]
    below = np.concatenate([[0.0], np.cumsum(counts * levels)])  # sum of the levels before each
    cut = np.concatenate([np.cumsum(counts[::-1])[::-1], [0]])  # how many have this level or more
    # The mean where each level is just white falls from level to level: the last that is .5 or more is not cut off.
    means = (WHITE / levels * below[:-1] + WHITE * cut[:-1]) / count
    last = int(np.count_nonzero(means >= _MEAN)) - 1
    most = WHITE / _median(levels, counts)
    if last < 0:
        return most
    return min(most, float((_MEAN * count - WHITE * cut[last + 1]) / below[last + 1]))


def _median(levels, counts):
    return float(levels[np.searchsorted(np.cumsum(counts), 0.5 * counts.sum())])
