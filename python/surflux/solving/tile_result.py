"""What solve_tiles gives: a line for each tile, and a map of all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from surflux._base import check
from surflux._base.files import file_error
from surflux._base.passes import watched
from surflux._base.types import Image, Integer, Progress
from surflux.pictures.plan import Plan
from surflux.scans.tiling import points_around, tile_header
from surflux.solutions.lit_points import LIGHT

_FULL = 1.5  # points of a pixel, where nobody says how wide a map is
_WIDEST = 1600


@dataclass(frozen=True)
class SolvedTile:
    """One tile of solve_tiles.

    Attributes:
        path, output: of the tile and of what was written.
        points, left_out: how many the tile has, and how many of these have no light.
        surfels, around: how many were solved, and how many of these are not the tile's own.
        error: of the irradiance, estimated, relative to its RMS (Solution.error).
        seconds: of wall-clock time, from reading to writing.
        kept: whether it was finished before.
    """

    path: Path
    output: Path
    points: int
    left_out: int
    surfels: int
    around: int
    error: float
    seconds: float
    kept: bool


@dataclass(frozen=True, repr=False)
class SolvedTiles:
    """What solve_tiles has written: a sequence of SolvedTile, in the order of the paths.

    Attributes:
        tiles: tuple of SolvedTile.
    """

    tiles: tuple[SolvedTile, ...]

    def __len__(self) -> int:
        return len(self.tiles)

    def __iter__(self) -> Iterator[SolvedTile]:
        return iter(self.tiles)

    def __getitem__(self, index: int) -> SolvedTile:
        return self.tiles[index]

    def __repr__(self) -> str:
        points = check.counted(sum(tile.points for tile in self), "point")
        kept = sum(tile.kept for tile in self)
        return f"SolvedTiles({check.counted(len(self), 'tile')}, {points}{f', {kept} kept' if kept else ''})"

    def map(
        self,
        of: Literal["irradiance", "direct", "radiosity"] = "radiosity",
        *,
        width: Integer | None = None,
        progress: Progress = False,
    ) -> Image:
        """A picture of all tiles from above, from what is written: each pixel has its highest point.

        Args:
            of: "irradiance", "direct" or "radiosity".
            width: in pixels; None for one and a half points a pixel, at most 1600.
            progress: True for bars on stderr, or a callback (done, total) -> bool, called for one output after another;
                False cancels.

        Returns:
            (h, w, 3) float32, W/m2, +y up: what write_image takes. Where no point is near 0.

        Raises:
            ValueError: an argument, by name.
            FileError: an output that cannot be read, or that holds no light any more.
            Cancelled: the callback returned False.
        """
        check.choice("of", of, LIGHT)
        headers = [tile_header(tile.output) for tile in self]
        low, high = np.min([h.low for h in headers], axis=0)[:2], np.max([h.high for h in headers], axis=0)[:2]
        if width is None:
            area = sum(float(np.prod((h.high - h.low)[:2])) for h in headers)
            pixel = np.sqrt(_FULL * area / sum(h.count for h in headers))
            width = int(np.clip(np.ceil((high[0] - low[0]) / pixel) if pixel > 0.0 else 1, 1, _WIDEST))
        plan = Plan(low, high, check.count("width", width, 1, 16384))
        names = [f"{of}_{c}" for c in "rgb"]
        with watched(None, progress):
            for tile in self:
                columns = points_around(tile.output, -np.inf, np.inf, {*names}, "map") or {}
                for name in names:
                    if name not in columns:
                        raise file_error(tile.output, f"has no {name}, as solve_tiles wrote it; wanted it solved again")
                plan.add(columns["points"], np.stack([columns[name] for name in names], axis=-1))
        return np.nan_to_num(plan.image())
