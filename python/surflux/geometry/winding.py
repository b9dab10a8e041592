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
    ends, _, is_opposite = _edges_of_two(mesh)
    return ends[is_opposite]


def faces_against(mesh):
    """(f,) booleans: faces that are wound against most, by area, of those that they hang together with.

    What hangs together shares edges, as in opposite_edges. In a piece in which no two sides can be told apart, as in a
    Moebius strip, and where both are of one size, there are none.
    """
    count = len(mesh.offsets) - 1
    _, pairs, is_opposite = _edges_of_two(mesh)
    # Each face as it is, f, and turned over, count + f: what is connected is wound alike.
    a, b = pairs.T
    other = np.where(is_opposite, count, 0)
    piece = _pieces(2 * count, np.concatenate([a, a + count]), np.concatenate([b + other, b + count - other]))
    as_is, turned = piece[:count], piece[count:]
    area = np.bincount(as_is, _areas(mesh), 2 * count)
    return (as_is != turned) & (area[as_is] < area[turned] * (1.0 - 1e-9))


def _edges_of_two(mesh):
    """((k, 2, 3) ends of edges that two faces share, (k, 2) these faces, (k,) whether both run along one way)."""
    points, number = np.unique(mesh.vertices, axis=0, return_inverse=True)
    begin = number.reshape(-1)[mesh.indices].astype(np.int64)
    following = np.arange(1, len(begin) + 1)
    following[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    end = begin[following]
    face = np.repeat(np.arange(len(mesh.offsets) - 1), np.diff(mesh.offsets))
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    edge = low * len(points) + high
    order = np.argsort(edge, kind="stable")
    order = order[(low < high)[order]]
    first = np.flatnonzero(np.diff(edge[order], prepend=-1))
    first = first[np.diff(first, append=len(order)) == 2]
    one, two = order[first], order[first + 1]
    return (
        points[np.stack([low[one], high[one]], axis=1)],
        np.stack([face[one], face[two]], axis=1),
        begin[one] == begin[two],
    )


def _pieces(count, a, b):
    """(count,) the least number of what each number is connected with, by pairs a and b (k,)."""
    label = np.arange(count)
    while True:
        low, high = np.minimum(label[a], label[b]), np.maximum(label[a], label[b])
        if np.array_equal(low, high):
            return label
        np.minimum.at(label, high, low)
        while not np.array_equal(label, label[label]):
            label = label[label]


def _areas(mesh):
    """(f,) of polygons."""
    corners = mesh.vertices[mesh.indices]
    following = np.arange(1, len(corners) + 1)
    following[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    origin = np.repeat(corners[mesh.offsets[:-1]], np.diff(mesh.offsets), axis=0)
    across = np.cross(corners - origin, corners[following] - origin)
    return 0.5 * np.linalg.norm(np.add.reduceat(across, mesh.offsets[:-1]), axis=1)
