"""Faces of a mesh that are wound the other way than the faces beside them."""

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
    areas = np.linalg.norm(vector_areas(mesh), axis=1)
    ends, _, is_opposite = _edges_of_two(mesh, areas)
    return mesh.vertices[ends[is_opposite]]


def faces_against(mesh):
    """(f,) booleans: faces that are wound against most, by area, of those that they hang together with.

    What hangs together shares edges, as in opposite_edges, but not the few that bodies share that touch. Where both
    sides of a closed piece are of one size, those that face its inside are. In an open one, or where no two sides can
    be told apart, as in a Moebius strip, there are none.
    """
    count, along = len(mesh.offsets) - 1, vector_areas(mesh)
    areas = np.linalg.norm(along, axis=1)
    ends, pairs, is_opposite = _edges_of_two(mesh, areas)
    if not np.any(is_opposite):
        return np.zeros(count, bool)
    kept = ~is_opposite | _along_borders(mesh, areas, ends, pairs, is_opposite)
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


def _along_borders(mesh, areas, ends, pairs, is_opposite):
    """(k,) booleans: edges along which the smaller side's piece runs against others for most of where it meets any.

    Pieces hang together by edges along which their faces are wound alike. Bodies that merely touch share edges with
    others, too, where one is cut otherwise than the other: besides they meet along edges of more than two faces, or
    along parts of edges.
    """
    count, alike = len(areas), pairs[~is_opposite]
    piece = connected(count, alike.ravel(), np.arange(0, alike.size, 2), 2)
    against = np.zeros(count)
    lengths = np.linalg.norm(mesh.vertices[ends[:, 1]] - mesh.vertices[ends[:, 0]], axis=1)
    for side in pairs[is_opposite].T:
        against += np.bincount(piece[side], lengths[is_opposite], count)
    touching = np.bincount(piece[_face_of_corner(mesh)], _touching_lengths(mesh, areas), count)
    sides, area = piece[pairs], np.bincount(piece, areas, count)
    smaller = np.take_along_axis(sides, np.argmin(area[sides], axis=1)[:, None], axis=1)[:, 0]
    return (against > _MOST_OF * touching)[smaller]


def _touching_lengths(mesh, areas):
    """(c,): of the edge behind each corner its length, where more than two faces have it, or others parts of it."""
    place = numbers_of_places(mesh.vertices)[mesh.indices]
    following = following_corners(mesh)
    along = mesh.vertices[mesh.indices[following]] - mesh.vertices[mesh.indices]
    length = np.linalg.norm(along, axis=1)
    is_edge = (place != place[following]) & (areas > 0.0)[_face_of_corner(mesh)] & (length > 0.0)
    begin, end, along = place[is_edge], place[following][is_edge], along[is_edge] / length[is_edge, None]
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    edge, faces = np.unique(low * len(mesh.vertices) + high, return_inverse=True, return_counts=True)[1:]
    faces = faces[edge]
    is_touching = faces > 2
    # From either end of those of one face, the directions in which edges go: of two that go one way one is a part.
    is_end = np.zeros(len(mesh.vertices), bool)
    is_end[begin[faces == 1]] = is_end[end[faces == 1]] = True
    here, edges = np.concatenate([begin, end]), np.tile(edge, 2)
    some = np.flatnonzero(is_end[here])
    ways = np.column_stack([here[some], np.concatenate([along, -along])[some].round(5) + 0.0])
    way = np.unique(ways, axis=0, return_inverse=True)[1].ravel()
    both = np.unique(np.column_stack([way, edges[some]]), axis=0)
    several = np.zeros(2 * len(edge), bool)
    several[some] = np.bincount(both[:, 0], minlength=1)[way] > 1
    is_touching |= (faces == 1) & (several[: len(edge)] | several[len(edge) :])
    out = np.zeros(len(place))
    out[is_edge] = length[is_edge] * is_touching
    return out


def _face_of_corner(mesh):
    return np.repeat(np.arange(len(mesh.offsets) - 1), np.diff(mesh.offsets))


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
