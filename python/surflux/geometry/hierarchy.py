"""Hierarchies of surfels: groups of neighbours that face alike, groups of groups, and so on (D04 section 6)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surflux import _core
from surflux._base import check
from surflux._base.passes import progress_callback, thread_limit
from surflux._base.types import Floats, Progress, SurfelsLike
from surflux.geometry.areas import effective_areas


class Hierarchy:
    """Groups of surfels, on levels: every surfel is in one group of each level, and groups lie in groups.

    All attributes are lists with one entry per level, finest first; the surfels themselves are no level. With g
    groups on a level:

    Attributes:
        levels: (n,) integers: the group of each surfel, from 0 to g - 1.
        positions: (g, 3) averages by area, in the unit of the surfels' positions.
        normals: (g, 3) averages by area, of unit length.
        radii: (g,) of spheres around the positions that enclose the disks of all surfels of the group (D03 section 6).
        areas: (g,) sums.
        representatives: (g,) of each group the surfel that is nearest to the averages, by place and by normal.
        counts: g.
    """

    levels: list[NDArray[np.uint32]]
    positions: list[Floats]
    normals: list[Floats]
    radii: list[Floats]
    areas: list[Floats]
    representatives: list[NDArray[np.uint32]]
    counts: list[int]

    def __init__(self, surfels: Any, levels: list[dict[str, Any]]) -> None:
        self._surfels = surfels
        for level in levels:
            for array in level.values():
                array.flags.writeable = False
        self.levels = [level["groups"] for level in levels]
        self.positions = [level["positions"] for level in levels]
        self.normals = [level["normals"] for level in levels]
        self.radii = [level["radii"] for level in levels]
        self.areas = [level["areas"] for level in levels]
        self.representatives = [level["representatives"] for level in levels]
        self.counts = [len(areas) for areas in self.areas]

    def __len__(self) -> int:
        return len(self.levels)

    def __repr__(self) -> str:
        groups = " > ".join(str(count) for count in self.counts)
        return f"<Hierarchy of {check.counted(len(self._surfels), 'surfel')}: {groups}>"

    def plot(self, level: int = 0, **options: Any) -> Any:
        """Shows the surfels, each group of that level in a colour of its own (D03 fig. 6b).

        Args:
            level: 0 is the finest, -1 the coarsest.
            options: as Surfels.plot takes them.
        """
        level = check.count("level", level, -len(self), len(self) - 1)
        colors = np.random.default_rng(0).uniform(0.1, 1.0, (self.counts[level], 3))
        return self._surfels.plot(color="group", values={"group": colors[self.levels[level]]}, **options)


def build_hierarchy(
    s: SurfelsLike,
    epsilon: float = 0.8,
    max_levels: int | None = None,
    seed: int = 0,
    *,
    threads: int | None = None,
    progress: Progress = False,
) -> Hierarchy:
    """Groups surfels that are close and face alike, then the groups, and so on (D04 section 6): Hierarchy.

    A surfel i chosen at random takes all that have no group yet, lie within twice its radius and have n_i . n_j above
    epsilon (D04 eq. 10); then another one that is left does, until none is. The groups are grouped in the same way, by
    their average positions and normals, and by the radii of spheres that enclose all disks (D03 section 6). This ends
    with one group, or where a level would have over 95 % of the groups of the one before it.

    Args:
        s: Surfels. Where they have no areas, "curved" effective_areas are taken; s stays as it is.
        epsilon: cosine between normals above which surfels are of one group; above -1, below 1.
        max_levels: at most so many; None for as many as there are.
        seed: of the order in which surfels are chosen, and so of the groups.
        threads: at most this many; None for all. The groups are the same for any number.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

    Raises:
        ValueError: an argument out of range, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> grid = sf.Surfels([[x, y, 0] for y in range(32) for x in range(32)], normals=[[0, 0, 1]] * 1024)
    >>> tree = sf.build_hierarchy(grid)
    >>> tree.levels[0].shape, tree.counts[-1], len(tree) == len(tree.counts)
    ((1024,), 1, True)
    >>> bool(abs(tree.areas[0].sum() - sf.effective_areas(grid).sum()) < 1e-9)
    True
    """
    check.some_surfels("s", s)
    epsilon = check.number("epsilon", epsilon, -1.0, 1.0, low_open=True, high_open=True)
    max_levels = 0 if max_levels is None else check.count("max_levels", max_levels)
    seed = check.seed("seed", seed)
    if s.areas is None:
        areas = effective_areas(s, threads=threads, progress=progress)
        s = s[:]
        s.areas = areas
    with thread_limit(threads), progress_callback(progress, "hierarchy") as callback:
        alone = np.zeros(len(s), np.uint32)
        levels = _core.build_hierarchy(s._core, alone, epsilon, max_levels, seed, progress=callback)
    return Hierarchy(s, levels)
