"""Faces of a mesh that are wound the other way than the faces beside them."""

import numpy as np


def opposite_edges(mesh):
    """Edges that two faces share and run along in the same direction, so that the two face opposite sides.

    Vertices at one place count as one, as files without shared vertices need it (STL). Edges of more than two faces, as
    of sheets with both sides, tell nothing.

    Args:
        mesh: Mesh, as read_mesh gives it.

    Returns:
        (k, 2, 3): ends of each.
    """
    points, number = np.unique(mesh.vertices, axis=0, return_inverse=True)
    begin = number.reshape(-1)[mesh.indices].astype(np.int64)
    following = np.arange(1, len(begin) + 1)
    following[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    end = begin[following]
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    is_edge = low < high
    edges, which, faces = np.unique((low * len(points) + high)[is_edge], return_inverse=True, return_counts=True)
    upwards = np.bincount(which.reshape(-1), (begin < end)[is_edge], len(edges))
    found = edges[(faces == 2) & (upwards != 1.0)]
    return points[np.stack([found // len(points), found % len(points)], axis=1)]
