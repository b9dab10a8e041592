"""Cloth, leaves and other thin sheets among the pieces of a mesh: what is seen from both sides."""

import numpy as np

from surflux import _core
from surflux.geometry.adjacency import connected, numbers_of_places, vector_areas

# |sum of the faces' vector areas| / area: 0 for a closed surface, 1 for a flat sheet, 1/2 for half a sphere.
_OPEN = 0.5


def sheet_faces(mesh):
    """(f,) booleans: the faces of a Mesh that belong to sheets.

    Faces with corners at the same places hang together and make a piece. A piece whose vector areas add up to more
    than half its area is a sheet; of a closed surface, thin as it may be, they cancel.
    """
    first, sizes = mesh.offsets[:-1], np.diff(mesh.offsets)
    vector_area = vector_areas(mesh)
    place = numbers_of_places(mesh.vertices)[mesh.indices]
    piece = connected(place.max() + 1, place, first, sizes)[place[first]]
    area = np.bincount(piece, np.linalg.norm(vector_area, axis=1))
    total = np.stack([np.bincount(piece, component) for component in vector_area.T], axis=-1)
    return (np.linalg.norm(total, axis=1) > _OPEN * area)[piece]


def with_backs(core, chosen):
    """The compiled surfels and behind them, facing the other way, copies of those in the mask."""
    rows = np.flatnonzero(chosen).astype(np.uint32)
    if not len(rows):
        return core
    pairs = core.select(rows).two_sided()
    return _core.Scene([core, pairs.select(np.arange(len(rows), 2 * len(rows), dtype=np.uint32))], []).surfels
