"""From where points were seen whose file does not say: one layer of them has a front, for a scanner saw it."""

import numpy as np

from surflux._base.passes import LOG
from surflux.geometry.estimates import outward_normals
from surflux.points.layers import is_terrain, layer_of
from surflux.points.terrain import high_above, normals_of_terrain, normals_towards

# What faces the place of viewed_from, in words.
FACED = {
    "frame": "the origin, as if a depth camera were there",
    "terrain": "upwards, as of a terrain seen from above",
    "turn": "the origin, as if a scanner had turned there",
}
FACING = "%s: estimated normals face %s (viewpoint: elsewhere)"


def viewed_from(points):
    """(what layer_of finds; (3,) from where that was seen, or None)."""
    kind = layer_of(points)
    if kind is None:
        return None, None
    return kind, high_above(points.min(axis=0), points.max(axis=0)) if kind == "terrain" else np.zeros(3)


def normals_of_seen(name, points, places=None, fitted=None):
    """(n, 3) unit normals of points (n, 3), see estimated_normals, of which nobody says from where they were seen.

    They face the place of viewed_from, or else outwards (outward_normals); what was taken for granted is logged.
    """
    kind, place = viewed_from(points)
    if kind is None:
        return outward_normals(points, name, places, fitted=fitted)
    LOG.info(FACING, name, FACED[kind])
    return normals_of_terrain(points, fitted) if kind == "terrain" else normals_towards(points, place, fitted)


def normals_of_array(points):
    """The same of points that are no file's: of these the origin says nothing, and terrain alone faces a place."""
    if not is_terrain(points):
        return outward_normals(points)
    LOG.info(FACING, "points", FACED["terrain"])
    return normals_of_terrain(points)
