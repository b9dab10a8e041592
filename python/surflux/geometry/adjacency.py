"""What of a mesh hangs together: corners at one place, and what they connect."""

import numpy as np


def numbers_of_places(vertices):
    """A number for each vertex (v, 3), the same for those at the same place."""
    order = np.lexsort(vertices.T)
    apart = np.any(np.diff(vertices[order], axis=0) != 0.0, axis=1)
    place = np.empty(len(vertices), np.int64)
    place[order] = np.concatenate([[0], np.cumsum(apart)])
    return place


def following_corners(mesh):
    """(k,): of each entry of mesh.indices, the one that comes next around its face."""
    following = np.arange(1, len(mesh.indices) + 1)
    following[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    return following


def vector_areas(mesh):
    """(f, 3): normals of the faces, as long as their areas."""
    first, sizes = mesh.offsets[:-1], np.diff(mesh.offsets)
    corners = mesh.vertices[mesh.indices]
    local = corners - corners[first].repeat(sizes, axis=0)
    return 0.5 * np.add.reduceat(np.cross(local, local[following_corners(mesh)]), first)


def connected(count, members, first, sizes):
    """(count,): the lowest of all numbers that hang together with each, by groups of `members` that do."""
    lowest = np.arange(count)
    if not len(first):
        return lowest
    while True:
        of_group = np.minimum.reduceat(lowest[members], first)
        before = lowest.copy()
        np.minimum.at(lowest, before[members], of_group.repeat(sizes))  # what stood for a member follows the group too
        while not np.array_equal(lowest, lowest[lowest]):
            lowest = lowest[lowest]
        if np.array_equal(lowest, before):
            return lowest
