"""What the core makes of positions where normals or radii are missing, and what cannot be made of them."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage

# Neighbours that a normal is fitted to.
NORMAL_NEIGHBORS = 16


def estimated_normals(points, viewpoint):
    """(n, 3) unit normals of checked points."""
    if len(points) < 3:
        few = check.counted(len(points), "point")
        raise ValueError(f"normals: wanted (n, 3), since a plane cannot be fitted to {few}; got None")
    return _core.estimate_normals(points, min(NORMAL_NEIGHBORS, len(points) - 1), viewpoint, progress=stage("normals"))


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
