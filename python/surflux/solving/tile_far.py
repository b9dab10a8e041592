"""What lies far from a tile: points of all tiles, the sparser the farther, in a file that nobody else sees."""

import pickle
import tempfile

import numpy as np

from surflux._base.files import file_error
from surflux.scans.thinning import joined

_MOST_LEVELS = 24  # the last is sixteen million halos away


class FarField:
    """Thinned points of each tile, level by level: cells of each are twice as wide as those of the level before.

    Attributes:
        cell: of level 0.
        levels: how many there are.

    Level 0 is for points up to twice the halo away, level 1 for those up to four times, and so on: what a cell hides of
    the sky is the same at all of them, and each adds about as many points.
    """

    def __init__(self, folder, lattice, cell, halo, reach):
        """folder: where the file is, without a name, so that it goes with the process. reach: of the farthest point."""
        self._lattice, self.cell, self._halo = lattice, cell, halo
        self.levels = int(np.clip(np.ceil(np.log2(max(reach / halo, 1.0))), 1, _MOST_LEVELS))
        try:
            self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115
        except OSError as error:
            raise file_error(folder, f"cannot be written to: {error.strerror or error}") from error
        self._places, self._boxes = [], []

    def close(self):
        """Frees the disk."""
        self._file.close()

    def thinned(self, columns, level=0):
        """Columns of one point in each cell of a level, and "top": the height of the highest that it stands for."""
        tops = columns.get("top", columns["points"][:, 2])
        turned = self._lattice.turned(columns["points"])
        rows, tops = self._lattice.nearest_and_most(turned, self.cell * 2.0**level, tops)
        return {name: values[rows] for name, values in columns.items()} | {"top": tops}

    def add(self, columns):
        """Takes the next tile: its columns of level 0."""
        found = []
        self._boxes.append((columns["points"][:, :2].min(axis=0), columns["points"][:, :2].max(axis=0)))
        for level in range(self.levels):
            columns = self.thinned(columns, level) if level else columns
            found.append(self._file.tell())
            pickle.dump(columns, self._file, protocol=5)
        self._places.append(found)

    def around(self, low, high):
        """Columns of what is farther than the halo from the box of a tile, the larger of x and y; None if nothing is.

        low, high: (2,) corners.
        """
        kept = []
        for (its_low, its_high), places in zip(self._boxes, self._places, strict=True):
            nearest = np.max(np.maximum(its_low - high, low - its_high))
            farthest = np.max(np.maximum(low - its_low, its_high - high))
            if farthest <= self._halo:
                continue
            first, last = self._level(np.array([max(nearest, self._halo), farthest]))
            for level in range(first, last + 1):
                self._file.seek(places[level])
                columns = pickle.load(self._file)
                at = columns["points"][:, :2]
                away = np.max(np.maximum(low - at, at - high), axis=1)
                rows = (away > self._halo) & (self._level(away) == level)
                if np.any(rows):
                    kept.append({name: values[rows] for name, values in columns.items()})
        return joined(kept) if kept else None

    def _level(self, away):
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.ceil(np.log2(np.maximum(away, self._halo) / self._halo)) - 1.0
        return np.clip(found, 0, self.levels - 1).astype(np.int64)
