"""Faces of a mesh that are wound the other way than the faces beside them."""

import numpy as np

from surflux._base.check import counted, listed
from surflux._base.warn import warn
from surflux.geometry.adjacency import connected, following_corners, numbers_of_places, vector_areas

_LISTED = 10  # numbers of faces in a warning
_ALIKE = 1e-3  # relative difference of two areas that are one size, for vertices in float32 or of six decimals


def opposite_edges(mesh):
    """Edges that two faces share and run along in the same direction, so that the two face opposite sides.

    Vertices at one place count as one, as files without shared vertices need it (STL), and faces without area as none.
    Edges of more than two faces, as of sheets with both sides, tell nothing.

    Args:
        mesh: Mesh, as read_mesh gives it.

    Returns:
        (k, 2, 3): ends of each.
    """
    ends, _, is_opposite = _edges_of_two(mesh, np.linalg.norm(vector_areas(mesh), axis=1))
    return mesh.vertices[ends[is_opposite]]


def faces_against(mesh):
    """(f,) booleans: faces that are wound against most, by area, of those that they hang together with.

    What hangs together shares edges, as in opposite_edges. Where both sides of a closed piece are of one size, those
    that face its inside are. In an open one, or where no two sides can be told apart, as in a Moebius strip, there are
    none.
    """
    count, along = len(mesh.offsets) - 1, vector_areas(mesh)
    areas = np.linalg.norm(along, axis=1)
    _, pairs, is_opposite = _edges_of_two(mesh, areas)
    # Each face as it is, f, and turned over, count + f: what is connected is wound alike.
    a, b = pairs.T
    other = np.where(is_opposite, count, 0)
    alike = np.stack([np.concatenate([a, a + count]), np.concatenate([b + other, b + count - other])], axis=1)
    piece = connected(2 * count, alike.ravel(), np.arange(0, alike.size, 2), 2)
    as_is, turned = piece[:count], piece[count:]
    area = np.bincount(as_is, areas, 2 * count)
    more = area[as_is] - area[turned]
    is_alike = np.abs(more) <= _ALIKE * area[turned]
    if np.any(is_alike & (as_is != turned)):
        piece, sign = np.minimum(as_is, turned), np.where(as_is < turned, 1.0, -1.0)
        at_border = np.bincount(pairs.ravel(), minlength=count) < np.diff(mesh.offsets)
        is_closed = (np.bincount(piece, at_border & (areas > 0.0)) == 0.0)[piece]
        more = np.where(is_alike, is_closed * sign * _volumes(mesh, along, areas, piece, sign)[piece], more)
    return (as_is != turned) & (more < 0.0)


def _volumes(mesh, along, areas, piece, sign):
    """Of each piece, three times the volume inside, below 0 if faces of sign 1, and backs of sign -1, face that."""
    middle = mesh.mean_of_corners(mesh.vertices)
    total = np.maximum(np.bincount(piece, areas), np.finfo(float).tiny)
    center = np.stack([np.bincount(piece, areas * m) for m in middle.T], axis=1) / total[:, None]
    return np.bincount(piece, sign * np.sum((middle - center[piece]) * along, axis=1))


def wound_alike(mesh):
    """(the Mesh with the faces of faces_against turned over, how many these are)."""
    against = faces_against(mesh)
    first, end = (np.repeat(ends, np.diff(mesh.offsets)) for ends in (mesh.offsets[:-1], mesh.offsets[1:]))
    corner = np.arange(len(mesh.indices))
    turned = np.repeat(against, np.diff(mesh.offsets))
    order = np.where(turned, first + end - 1 - corner, corner)
    places = None if mesh.places is None else mesh.places[order]
    return mesh._replace(indices=mesh.indices[order], places=places), int(against.sum())


def warn_of_winding(mesh, name, have_backs=False):
    """Says which faces of what is called `name` are wound against the others, but for those that have backs, too."""
    against = np.flatnonzero(faces_against(mesh) & ~np.asarray(have_backs))
    if len(against):
        faces, one = counted(len(mesh.offsets) - 1, "face"), len(against) == 1
        warn(
            f"{name}: {len(against)} of {faces} {'is' if one else 'are'} wound against most of those beside, and "
            f"{'faces' if one else 'face'} the other side (from 0: {listed(against, _LISTED)}); their corners in "
            "reverse order mend it, as trimesh.repair.fix_winding has them"
        )


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
