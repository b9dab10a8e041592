"""Faces of a mesh that are wound the other way than the faces beside them."""

import numpy as np

from surflux._base.check import counted
from surflux._base.warn import warn
from surflux.geometry.adjacency import connected, following_corners, numbers_of_places, vector_areas

_LISTED = 10  # numbers of faces in a warning


def opposite_edges(mesh):
    """Edges that two faces share and run along in the same direction, so that the two face opposite sides.

    Vertices at one place count as one, as files without shared vertices need it (STL), and faces without area as none.
    Edges of more than two faces, as of sheets with both sides, tell nothing.

    Args:
        mesh: Mesh, as read_mesh gives it.

    Returns:
        (k, 2, 3): ends of each.
    """
    ends, _, is_opposite = _edges_of_two(mesh, _areas(mesh))
    return mesh.vertices[ends[is_opposite]]


def faces_against(mesh):
    """(f,) booleans: faces that are wound against most, by area, of those that they hang together with.

    What hangs together shares edges, as in opposite_edges. In a piece in which no two sides can be told apart, as in a
    Moebius strip, and where both are of one size, there are none.
    """
    count, areas = len(mesh.offsets) - 1, _areas(mesh)
    _, pairs, is_opposite = _edges_of_two(mesh, areas)
    # Each face as it is, f, and turned over, count + f: what is connected is wound alike.
    a, b = pairs.T
    other = np.where(is_opposite, count, 0)
    alike = np.stack([np.concatenate([a, a + count]), np.concatenate([b + other, b + count - other])], axis=1)
    piece = connected(2 * count, alike.ravel(), np.arange(0, alike.size, 2), 2)
    as_is, turned = piece[:count], piece[count:]
    area = np.bincount(as_is, areas, 2 * count)
    return (as_is != turned) & (area[as_is] < area[turned] * (1.0 - 1e-9))


def wound_alike(mesh):
    """(the Mesh with the faces of faces_against turned over, how many these are)."""
    against = faces_against(mesh)
    first, end = (np.repeat(ends, np.diff(mesh.offsets)) for ends in (mesh.offsets[:-1], mesh.offsets[1:]))
    corner = np.arange(len(mesh.indices))
    turned = np.repeat(against, np.diff(mesh.offsets))
    return mesh._replace(indices=mesh.indices[np.where(turned, first + end - 1 - corner, corner)]), int(against.sum())


def warn_of_winding(mesh, name):
    """Says which faces of what is called `name` are wound against the others, if any."""
    against = np.flatnonzero(faces_against(mesh))
    if len(against):
        faces, one = counted(len(mesh.offsets) - 1, "face"), len(against) == 1
        listed = ", ".join(map(str, against[:_LISTED])) + (", ..." if len(against) > _LISTED else "")
        warn(
            f"{name}: {len(against)} of {faces} {'is' if one else 'are'} wound against most of those beside, and "
            f"{'faces' if one else 'face'} the other side (from 0: {listed}); their corners in reverse order, as "
            "trimesh.repair.fix_winding has them, or two_sided mend it"
        )


def _areas(mesh):
    return np.linalg.norm(vector_areas(mesh), axis=1)


def _edges_of_two(mesh, areas):
    """((k, 2) vertices at ends of edges that two faces share, (k, 2) these faces, (k,) whether both run one way)."""
    place = numbers_of_places(mesh.vertices)[mesh.indices]
    following = following_corners(mesh)
    begin, end = place, place[following]
    face = np.repeat(np.arange(len(areas)), np.diff(mesh.offsets))
    edge = np.minimum(begin, end) * len(mesh.vertices) + np.maximum(begin, end)
    order = np.argsort(edge, kind="stable")
    order = order[((begin != end) & (areas > 0.0)[face])[order]]
    first = np.flatnonzero(np.diff(edge[order], prepend=-1))
    first = first[np.diff(first, append=len(order)) == 2]
    one, two = order[first], order[first + 1]
    ends = np.stack([mesh.indices[one], mesh.indices[following[one]]], axis=1)
    return ends, np.stack([face[one], face[two]], axis=1), begin[one] == begin[two]
