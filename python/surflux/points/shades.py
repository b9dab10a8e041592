"""Reflectance by colours or intensity, decided for all tiles of a survey together."""

import numpy as np

from surflux._base.color import reflectance_of_colors
from surflux.points.exposure import exposed_by, exposure_of_colors, warn_of_so_many_black
from surflux.points.intensity import Levels

_LEVELS = 65536  # of 16 bits


class Shades:
    """What colours and intensities of all chunks amount to, and what reflectance those of any chunk mean by that."""

    def __init__(self, raw_colors=False):
        """raw_colors: leaves colours as bright as they are."""
        self._raw, self._factor = raw_colors, None
        self._channels = np.zeros(_LEVELS, np.int64)  # how many have each value, but for black points
        self._brightest = np.zeros(_LEVELS, np.int64)
        self._black = 0
        self._intensities, self._scale, self._scaled = Levels(), None, False

    def add(self, columns):
        """Takes a chunk: "colors" (n, 3) of 16 bits and "intensity" (n,), whatever there is of these."""
        colors, intensity = columns.get("colors"), columns.get("intensity")
        if colors is not None:
            most = colors.max(axis=1)
            self._channels += np.bincount(colors[most > 0].ravel(), minlength=_LEVELS)
            self._brightest += np.bincount(most[most > 0], minlength=_LEVELS)
            self._black += int(np.count_nonzero(most == 0))
        if intensity is not None and len(intensity):
            self._intensities.add(intensity)

    @property
    def has_colors(self):
        """Whether any point has a colour; records have room for them that may not be filled in."""
        return bool(np.any(self._brightest))

    def warn_of_black(self, name):
        """Where many of the colours are exactly black, under `name`."""
        warn_of_so_many_black(name, self._black, self._black + int(self._brightest.sum()))

    def of_colors(self, colors):
        """(n, 3) linear reflectance of colours as they are: .98 is white, of 8 or of 16 bits."""
        return reflectance_of_colors(colors, self._white())

    def reflectance(self, columns):
        """(n, 3) linear reflectance of a chunk: of exposed colours, else grey by intensity, .5 on average, else .5."""
        count = len(columns["points"])
        if self.has_colors:
            self._factor = self._exposure() if self._factor is None else self._factor
            return exposed_by(self._factor, self.of_colors(columns["colors"]))
        scale, intensity = self._intensity_scale(), columns.get("intensity")
        return np.full((count, 3), 0.5) if scale is None or intensity is None else scale.reflectance(intensity)

    def _intensity_scale(self):
        if not self._scaled:
            self._scale, self._scaled = self._intensities.scale(), True
            if self._scale is not None:
                self._scale.tell("tiles")
        return self._scale

    def _white(self):
        return 255.0 if np.flatnonzero(self._brightest)[-1] <= 255 else 65535.0

    def _exposure(self):
        if self._raw:
            return 1.0
        levels = reflectance_of_colors(np.arange(_LEVELS), self._white())
        mean = self._channels @ levels / self._channels.sum()
        bright = np.searchsorted(np.cumsum(self._brightest), 0.99 * self._brightest.sum())
        return exposure_of_colors(mean, levels[bright], "raw_colors")
