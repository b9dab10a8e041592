"""What is up: a body stands on a base, flat or open, as statues do, and what is in a room on its floor."""

import numpy as np

from surflux.geometry.areas import effective_areas
from surflux.points.surfels import Surfels

_FEW, _ASKED = 1000, 60_000  # points: fewer do not tell, and no more are looked at
_STRAY = 0.002  # of the points on each side do not count
_THIN = 0.02  # of the extent along an axis: what lies lower is the base
_SHARP = 8  # power of the cosine by which what faces down counts
# Shares of the bounding box's cross section, by the best and the next of six sides: happy buddha .07 and .04, armadillo
# .06 and .01, bunny .18 and .03, dragon .16 and .01, the lion, which is open below, .6 and .36.
_LEAST, _CLEAR = 0.04, 1.4
# Of rooms: how far from a side of the bounding box its wall reaches, and what touches it, in extents; which faces are
# walls of what stands there; how much of the side the floor covers; areas of walls that touch it, over that of the
# side, and over the largest of other sides: .27 and none in Cornell's box.
_WALL, _TOUCHES, _UPRIGHT, _FLOOR, _STANDING, _CLEARLY = 0.03, 0.1, 0.3, 0.5, 0.05, 3.0


def stands_along_y(surfels):
    """Whether a body stands along y, as meshes of statues often do: there is its base, and on no side else.

    A base is what is flat, lowest and faces down, or a hole: normals of a closed surface weighed by area add up to
    nothing, and those of one that is open to the normal of what would close it, turned round. But where the lowest is
    flat and faces up, it is a floor, or a wall of a room that is open on the other side.
    """
    if len(surfels) < _FEW:
        return False
    some = np.arange(len(surfels))
    if len(surfels) > _ASKED:
        some = np.random.default_rng(0).choice(len(surfels), _ASKED, replace=False)
    points, normals = surfels.points[some], surfels.normals[some]
    areas = effective_areas(Surfels(points, normals))
    low, high = np.quantile(points, [_STRAY, 1.0 - _STRAY], axis=0)
    size = high - low
    if not np.all(size > 0.0):
        return False
    open_to = areas @ normals
    bases = {}
    for axis in range(3):
        across = np.prod(np.delete(size, axis))
        for up in (1, -1):
            height = points[:, axis] - low[axis] if up > 0 else high[axis] - points[:, axis]
            lowest = height < _THIN * size[axis]
            down, inwards = (
                (areas * np.clip(side * up * normals[:, axis], 0.0, 1.0) ** _SHARP)[lowest].sum() for side in (-1, 1)
            )
            bases[axis, up] = (down + max(0.0, up * open_to[axis] - inwards)) / across
    along_y = bases.pop((1, 1))
    return along_y > max(_LEAST, _CLEAR * max(bases.values()))


def furniture_stands_along_y(surfels):
    """Whether what is in a room, a mesh, stands on a floor below it along y, and on (or at) no side else.

    A floor and a ceiling alone tell nothing: two walls look the same.
    """
    if len(surfels) < _FEW or surfels.areas is None:
        return False
    points, normals, areas = surfels.points, surfels.normals, surfels.areas
    low, high = surfels.bounds
    if not np.all(high > low):
        return False
    places = (points - low) / (high - low)
    is_inside = (places > _WALL) & (places < 1.0 - _WALL)
    standing = {}
    for axis in range(3):
        across = np.prod(np.delete(high - low, axis))
        walls = np.delete(is_inside, axis, axis=1).all(axis=1) & (np.abs(normals[:, axis]) < _UPRIGHT)
        for up in (1, -1):
            height = places[:, axis] if up > 0 else 1.0 - places[:, axis]
            standing[axis, up] = areas[walls & (height < _TOUCHES)].sum() / across
    floor = areas[(places[:, 1] < _WALL) & (normals[:, 1] > 1.0 - _UPRIGHT)].sum() / np.prod((high - low)[[0, 2]])
    along_y = standing.pop((1, 1))
    return floor > _FLOOR and along_y > max(_STANDING, _CLEARLY * max(standing.values()))
