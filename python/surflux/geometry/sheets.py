"""Cloth, leaves and other thin sheets among the pieces of a mesh: what is seen from both sides."""

import numpy as np

from surflux import _core

# |sum of the faces' vector areas| / area: 0 for a closed surface, 1 for a flat sheet, 1/2 for half a sphere.
_OPEN = 0.5


def sheet_faces(mesh):
    """(f,) booleans: the faces of a Mesh that belong to sheets.

    Faces with corners at the same places hang together and make a piece. A piece whose vector areas add up to more
    than half its area is a sheet; of a closed surface, thin as it may be, they cancel.
    """
    first, sizes = mesh.offsets[:-1], np.diff(mesh.offsets)
    corners = mesh.vertices[mesh.indices]
    local = corners - corners[first].repeat(sizes, axis=0)
    following = np.arange(1, len(mesh.indices) + 1)
    following[mesh.offsets[1:] - 1] = first
    vector_area = 0.5 * np.add.reduceat(np.cross(local, local[following]), first)
    piece = _pieces(_places(mesh.vertices)[mesh.indices], first, sizes)
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


def _places(vertices):
    """A number for each vertex, the same for those at the same place."""
    order = np.lexsort(vertices.T)
    apart = np.any(np.diff(vertices[order], axis=0) != 0.0, axis=1)
    place = np.empty(len(vertices), np.int64)
    place[order] = np.concatenate([[0], np.cumsum(apart)])
    return place


def _pieces(place, first, sizes):
    """The piece of each face, by the lowest of the places that hang together with its corners."""
    lowest = np.arange(place.max() + 1)
    while True:
        of_face = np.minimum.reduceat(lowest[place], first)
        before = lowest.copy()
        np.minimum.at(lowest, before[place], of_face.repeat(sizes))  # what stood for a corner follows the face too
        while not np.array_equal(lowest, lowest[lowest]):
            lowest = lowest[lowest]
        if np.array_equal(lowest, before):
            return of_face
