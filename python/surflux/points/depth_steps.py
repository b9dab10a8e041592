"""Depth in steps, as depth cameras measure it, and points without them."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.passes import LOG, stage
from surflux.points.layers import layer_of

_POINTS, _LEVELS = 64, 16  # points of one depth at least, on average, and depths
_ALIKE = 1.6  # times or so much less than the median half of the steps of 1 / |z| may be


def depth_step(points):
    """The step of 1 / |z| (1/m) of points (n, 3) that are the frame of a depth camera at the origin; None of others.

    Structured light and stereo measure a disparity, which is in proportion to that, in whole pixels or parts of them.
    """
    if layer_of(points) != "frame":
        return None
    depths = np.unique(np.abs(points[:, 2]))
    if not _LEVELS <= len(depths) <= len(points) / _POINTS or depths[0] == 0.0:
        return None
    low, median, high = np.percentile(-np.diff(1.0 / depths), [25, 50, 75])
    return float(median) if low * _ALIKE >= median and high <= median * _ALIKE else None


def without_steps(points, keep_off=False, undo="", undo_off=""):
    """(points (n, 3) moved along their rays to the planes that pixels around follow, (n,) booleans: which are kept);
    None where depth has no steps.

    What hardly any pixel around is about as far as stays where it is, and is not kept, but with keep_off. Both are
    logged, and how they are undone.
    """
    step = depth_step(points)
    if step is None:
        return None
    moved, off = _core.without_depth_steps(points, step, progress=stage("depth"))
    near, far = step * np.percentile(np.abs(points[:, 2]), [1, 99]) ** 2
    LOG.info(
        "depth is in steps, of %s to %s here, as depth cameras measure it: points are moved along their rays, by %s on "
        "average, to the planes that they are steps of%s",
        *(f"{value:.2g}" for value in (near, far, np.linalg.norm(moved - points, axis=1).mean())),
        undo,
    )
    kept = np.ones(len(points), dtype=bool) if keep_off else off == 0
    if not np.all(kept):
        many = check.counted(int(np.count_nonzero(~kept)), "point")
        LOG.info("nearer or farther than all around them, left out: %s of %d%s", many, len(kept), undo_off)
    return moved, kept
