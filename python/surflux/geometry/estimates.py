"""What the core makes of positions where normals or radii are missing, and what cannot be made of them."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.passes import LOG, stage
from surflux.geometry.facing import facing_of

# Neighbours that a normal is fitted to.
NORMAL_NEIGHBORS = 16
# Cosine of a normal with the way to where it was seen from, up to which that does not tell its side; those around do.
_EDGE_ON = 0.1
_VOTERS = 8
_ONE_SIDE = 0.6  # of the rays that meet bodies, in front less behind: as of light that comes to a closed sheet
_SAID = 0.05  # of the points in rooms, or on open surfaces: less is noise


def estimated_normals(points, viewpoint, fitted=None):
    """(n, 3) unit normals of checked points.

    fitted: (n, 3) those of a fit to more points, see `Scan.fitted`: all that is left is to turn them; None to fit.
    """
    if len(points) < 3:
        few = check.counted(len(points), "point")
        raise ValueError(f"normals: wanted (n, 3), since a plane cannot be fitted to {few}; got None")
    if fitted is None:
        count = min(NORMAL_NEIGHBORS, len(points) - 1)
        return _core.estimate_normals(points, count, viewpoint, progress=stage("normals"))
    if viewpoint is None:
        return fitted
    way = viewpoint - points
    length = np.maximum(np.linalg.norm(way, axis=1), np.finfo(float).tiny)
    return turned_by(points, fitted, np.sum(way * fitted, axis=1) / length, _EDGE_ON)


def turned_by(points, normals, side, least):
    """Normals (n, 3), those turned over whose side (n,) is below 0; where it is within `least` of 0, those around tell:
    normals continue each other if one is that of the other, mirrored at the plane halfway between the two points.
    """
    normals = np.where(side[:, None] < 0.0, -normals, normals)
    unsure = np.flatnonzero(np.abs(side) <= least)
    if len(unsure) == 0 or len(unsure) == len(points):
        return normals
    near = _core.nearest_points(points, min(_VOTERS + 1, len(points)))[unsure, 1:]
    way = points[near] - points[unsure, None]
    squared = np.maximum(np.sum(way**2, axis=2), np.finfo(float).tiny)
    own, others = normals[unsure, None], normals[near]
    mirrored = np.sum(own * others, axis=2) - 2.0 * np.sum(own * way, axis=2) * np.sum(others * way, axis=2) / squared
    votes = np.sum(np.where(np.abs(side[near]) > least, mirrored, 0.0), axis=1)
    normals[unsure[votes < 0.0]] *= -1.0
    return normals


def outward_normals(points, name="points", places=None, towards=None, place="", fitted=None):
    """(n, 3) unit normals of checked points of which nothing says from where they were seen.

    They face the side from which rays see each sheet; what closes around one of the places (k, 3) is seen from there.
    Most of an open sheet faces `towards` (3,), where it is given: `place` in words. What was taken for granted is
    logged, under that name. fitted: as estimated_normals takes it.
    """
    normals = np.array(estimated_normals(points, None, fitted))
    found = facing_of(points, normals, places, estimated=True)
    normals[found.turned] *= -1.0
    normals[found.open & (found.bodies < -_ONE_SIDE)] *= -1.0  # a floor faces what stands on it
    if towards is not None:
        _, sheet = np.unique(found.margin, return_inverse=True)  # one of each sheet
        facing = np.bincount(sheet, weights=np.sum((towards - points) * normals, axis=1))[sheet]
        normals[found.open & (facing < 0.0)] *= -1.0
    unsure = np.mean(found.open)
    rooms = np.mean(found.room)
    if rooms > _SAID:
        where = "inwards, as of a room" if rooms > 0.5 else "outwards, in rooms inwards"
    else:
        where = "outwards, as of bodies seen from outside"
    if unsure > _SAID:
        may = f"are taken to face {place}" if towards is not None else "may face either way"
        where += f"; {percent(unsure)} of the points are on open surfaces, which {may}"
    LOG.info("%s: estimated normals face %s (viewpoint: elsewhere)", name, where)
    return normals


def percent(share):
    """A share for a sentence: 12 %, .3 %."""
    return f"{100 * share:.0f} %" if share >= 0.01 else f"{100 * share:.1g} %".removeprefix("0")


def estimated_radii(points, normals):
    """(n,) radii of checked points with normals."""
    if len(points) < 2:
        raise ValueError("radii: must be given for a single point, which has no neighbours; got None")
    radii = _core.estimate_radii(points, normals, progress=stage("radii"))
    flat = np.flatnonzero(~(radii > 0))
    if len(flat):
        raise ValueError(
            f"radii: must be given, since {check.counted(len(flat), 'point')} (the first at index {flat[0]}) "
            f"{'coincides' if len(flat) == 1 else 'coincide'} with all of the nearest neighbours; got None"
        )
    return radii
