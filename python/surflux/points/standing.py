"""What is up of a body: it stands on a base, flat or open, as statues and what is scanned on a table do."""

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


def stands_along_y(surfels):
    """Whether a body stands along y, as meshes of statues often do: there is its base, and on no side else.

    A base is what is flat, lowest and faces down, or a hole: normals of a closed surface weighed by area add up to
    nothing, and those of one that is open to the normal of what would close it, turned round.
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
            flat = areas * np.clip(-up * normals[:, axis], 0.0, 1.0) ** _SHARP
            bases[axis, up] = (flat[height < _THIN * size[axis]].sum() + max(0.0, up * open_to[axis])) / across
    along_y = bases.pop((1, 1))
    return along_y > max(_LEAST, _CLEAR * max(bases.values()))
