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
_CENTRED = 0.002  # of the extent that the middle, and the lowest, are off the origin
_OPEN = 0.1  # of a side of the bounding box: covered by less, it has no wall


def why_y_is_up(surfels):
    """Why y is taken for up, in words; None where nothing tells, and z is."""
    if stands_along_y(surfels):
        return "there, and on no side else, the body has a base"
    if len(surfels.triangles) and furniture_stands_along_y(surfels):
        return "there, and on no side else, things stand on a floor"
    if len(surfels.triangles) and lamps_hang_along_y(surfels):
        return "there lamps hang at a ceiling, and along z the room is open"
    if is_modelled_on_y(surfels):
        return "a model has its lowest point at y = 0 and the origin in the middle of x and z"
    return None


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
    room = _Room.of(surfels)
    if room is None:
        return False
    standing = {}
    for axis in range(3):
        walls = np.delete(room.is_inside, axis, axis=1).all(axis=1) & (np.abs(room.normals[:, axis]) < _UPRIGHT)
        for up in (1, -1):
            standing[axis, up] = room.share(axis, walls & (room.height(axis, up) < _TOUCHES))
    along_y = standing.pop((1, 1))
    return room.wall(1, 1) > _FLOOR and along_y > max(_STANDING, _CLEARLY * max(standing.values()))


def lamps_hang_along_y(surfels):
    """Whether what shines in a room, a mesh, hangs at a ceiling over a floor along y, and z has no ceiling or no floor.

    An empty room that shows its inside is open to one side, hardly ever to the one where its lamps are.
    """
    room = _Room.of(surfels)
    power = 0.0 if room is None else room.areas * surfels.emission.mean(axis=1)
    if not np.any(power):
        return False
    x, y, z = np.average(room.places, axis=0, weights=power)
    hangs = y > 1.0 - _TOUCHES and all(_TOUCHES < v < 1.0 - _TOUCHES for v in (x, z))
    is_open = min(room.wall(2, 1), room.wall(2, -1)) < _OPEN
    return bool(hangs and is_open and min(room.wall(1, 1), room.wall(1, -1)) > _FLOOR)


def is_modelled_on_y(surfels):
    """Whether a mesh begins at y = 0, and 0 is in the middle of its extents along x and z: whoever made it took the
    floor beneath its middle for the origin.
    """
    if not len(surfels.triangles):
        return False
    corners = surfels.triangles.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = high - low
    off = np.array([low[0] + high[0], low[1], low[2] + high[2]])
    return bool(np.all(size > 0.0) and np.all(np.abs(off) < _CENTRED * size))


class _Room:
    """A mesh within its bounding box.

    Attributes:
        places: (n, 3) from 0 to 1 along the sides of the box.
        is_inside: (n, 3) booleans: away from both walls across an axis.
    """

    @classmethod
    def of(cls, surfels):
        """None of what is too little, no mesh, or flat."""
        low, high = surfels.bounds if len(surfels) >= _FEW and surfels.areas is not None else (0.0, 0.0)
        return cls(surfels, low, high) if np.all(high > low) else None

    def __init__(self, surfels, low, high):
        self.normals, self.areas, self._size = surfels.normals, surfels.areas, high - low
        self.places = (surfels.points - low) / self._size
        self.is_inside = (self.places > _WALL) & (self.places < 1.0 - _WALL)

    def height(self, axis, up):
        """(n,) over the lowest, where an axis or its opposite (up -1) is up."""
        return self.places[:, axis] if up > 0 else 1.0 - self.places[:, axis]

    def share(self, axis, some):
        """The area of some, over that of the side of the box across an axis."""
        return self.areas[some].sum() / np.prod(np.delete(self._size, axis))

    def wall(self, axis, up):
        """How much of the lowest side is covered by what faces inwards there."""
        faces = up * self.normals[:, axis] > 1.0 - _UPRIGHT
        return self.share(axis, faces & (self.height(axis, up) < _WALL))
