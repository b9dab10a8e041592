"""Faces of a mesh that are wound the other way than the faces beside them."""

from typing import NamedTuple

import numpy as np

from surflux._base.check import counted, listed
from surflux._base.warn import warn
from surflux.geometry.adjacency import connected, following_corners, numbers_of_places, vector_areas

_LISTED = 10  # numbers of faces in a warning
_MOST_OF = 3.0  # what tells of a piece, over what does not
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
    edges = _edges_of(mesh, np.linalg.norm(vector_areas(mesh), axis=1))
    one, two = _shared_by_two(edges)
    one = one[edges.begin[one] == edges.begin[two]]
    return mesh.vertices[mesh.indices[np.stack([one, edges.following[one]], axis=1)]]


def faces_against(mesh):
    """(f,) booleans: faces that are wound against most, by area, of those that they hang together with.

    What hangs together shares edges, as in opposite_edges, but not the few that bodies share that touch. Where both
    sides of a closed piece are of one size, those that face its inside are. In an open one, or where no two sides can
    be told apart, as in a Moebius strip, there are none.
    """
    count, along = len(mesh.offsets) - 1, vector_areas(mesh)
    areas = np.linalg.norm(along, axis=1)
    edges = _edges_of(mesh, areas)
    one, two = _shared_by_two(edges)
    pairs, is_opposite = np.stack([edges.face[one], edges.face[two]], axis=1), edges.begin[one] == edges.begin[two]
    if not np.any(is_opposite):
        return np.zeros(count, bool)
    kept = ~is_opposite | _along_borders(mesh, areas, edges, one, pairs, is_opposite)
    pairs, is_opposite = pairs[kept], is_opposite[kept]
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


def _along_borders(mesh, areas, edges, one, pairs, is_opposite):
    """(k,) booleans: edges along which the smaller side's piece runs against others for most of where it meets any.

    Pieces hang together by edges along which their faces are wound alike. Bodies that merely touch share edges with
    others, too, where one is cut otherwise than the other: besides they meet along edges of more than two faces, or
    along parts of edges.
    """
    count, alike = len(areas), pairs[~is_opposite]
    piece = connected(count, alike.ravel(), np.arange(0, alike.size, 2), 2)
    along = mesh.vertices[mesh.indices[edges.following]] - mesh.vertices[mesh.indices]
    lengths = np.linalg.norm(along, axis=1)
    against = np.zeros(count)
    for side in pairs[is_opposite].T:
        against += np.bincount(piece[side], lengths[one[is_opposite]], count)
    touching = np.bincount(piece[edges.face], lengths * _touch_others(edges, along, lengths), count)
    sides, area = piece[pairs], np.bincount(piece, areas, count)
    smaller = np.take_along_axis(sides, np.argmin(area[sides], axis=1)[:, None], axis=1)[:, 0]
    return (against > _MOST_OF * touching)[smaller]


def _touch_others(edges, along, lengths):
    """(c,) booleans: which edges more than two faces have, or one alone, and others parts of it."""
    rows = np.flatnonzero(edges.counts & (lengths > 0.0))
    begin, end, along = edges.begin[rows], edges.end[rows], along[rows] / lengths[rows, None]
    edge, faces = np.unique(edges.number[rows], return_inverse=True, return_counts=True)[1:]
    faces = faces[edge]
    # From either end of those of one face, the directions in which edges go: of two that go one way one is a part.
    is_end = np.zeros(edges.begin.max(initial=-1) + 1, bool)
    is_end[begin[faces == 1]] = is_end[end[faces == 1]] = True
    here = np.concatenate([begin, end])
    some = np.flatnonzero(is_end[here])
    ways = np.column_stack([here[some], np.concatenate([along, -along])[some].round(5) + 0.0])
    way = np.unique(ways, axis=0, return_inverse=True)[1].ravel()
    both = np.unique(np.column_stack([way, np.tile(edge, 2)[some]]), axis=0)
    several = np.zeros(2 * len(rows), bool)
    several[some] = np.bincount(both[:, 0], minlength=1)[way] > 1
    out = np.zeros(len(lengths), bool)
    out[rows] = (faces > 2) | ((faces == 1) & np.any(several.reshape(2, -1), axis=0))
    return out


def _volumes(mesh, along, areas, piece, sign):
    """Of each piece, three times the volume inside, below 0 if faces of sign 1, and backs of sign -1, face that."""
    middle = mesh.mean_over_faces(mesh.vertices)
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


class _Edges(NamedTuple):
    """Of each entry of mesh.indices the edge to the one that comes next around its face."""

    begin: np.ndarray  # numbers of places
    end: np.ndarray
    following: np.ndarray
    face: np.ndarray
    number: np.ndarray  # the same of all faces that have the edge
    counts: np.ndarray  # whether it has two ends, and its face an area


def _edges_of(mesh, areas):
    begin = numbers_of_places(mesh.vertices)[mesh.indices]
    following = following_corners(mesh)
    end = begin[following]
    face = np.repeat(np.arange(len(areas)), np.diff(mesh.offsets))
    number = np.minimum(begin, end) * len(mesh.vertices) + np.maximum(begin, end)
    return _Edges(begin, end, following, face, number, (begin != end) & (areas > 0.0)[face])


def _shared_by_two(edges):
    """Two of (k,) entries of mesh.indices: the same edge, of either of the two faces that share it."""
    order = np.argsort(edges.number, kind="stable")
    order = order[edges.counts[order]]
    first = np.flatnonzero(np.diff(edges.number[order], prepend=-1))
    first = first[np.diff(first, append=len(order)) == 2]
    return order[first], order[first + 1]
