"""Patches of polygonal models, one surfel each (D04 section 7.3): the geometry behind Surfels.from_mesh."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.passes import report, stage
from surflux._base.warn import warn
from surflux.meshes.triangulation import triangles_of_polygons

# Faces with less area than this fraction of their longest edge squared are lines or points, not faces.
_DEGENERATE = 1e-12
# Sines and cosines below this are rounding: single-precision files place corners of a flat wall this badly.
_FLAT = 1e-4
# More are a slip in patch_area: they would take gigabytes before anything could be said about them.
_MOST = 20_000_000
_STEPS = 7  # of the stage "faces": each a fraction of a second for a million of them


class Pairs(NamedTuple):
    """Triangles that became quadrilaterals: first and second of the `faces` (p, 2), and of the first the corners.

    halves (p, 3, 3): the corner that only the first has, then the two that both have.
    """

    faces: np.ndarray
    halves: np.ndarray


@dataclass(frozen=True, eq=False)
class Patches:
    """Per patch: centroid, unit normal, exact area, distance to the farthest corner, the face it came from.

    Of a quadrilateral that was two triangles, that is the first of them, and `pair` (n,) the row of `pairs`; -1 of
    others.

    The triangles (t, 3, 3) of patch triangle_patch (t,), ascending, cover it exactly.
    """

    centroids: np.ndarray
    normals: np.ndarray
    areas: np.ndarray
    radii: np.ndarray
    faces: np.ndarray
    triangles: np.ndarray
    triangle_patch: np.ndarray
    pair: np.ndarray
    pairs: Pairs


NO_PAIRS = Pairs(np.zeros((0, 2), np.int64), np.zeros((0, 3, 3)))


def make_patches(vertices, offsets, indices, patch_area=None, material=None, paired=True, divided=False, go_on=None):
    """Patches of the polygons whose corners are vertices[indices[offsets[f]:offsets[f + 1]]].

    Pairs of coplanar triangles that make a convex quadrilateral become one, unless their rows of material (f, k)
    differ, go_on(faces (p,), faces beside (p,)) is False, or `paired` is. With patch_area, faces are cut into pieces of
    at most that area: quadrilaterals into a grid of near-square cells, triangles into k^2 congruent ones, larger
    polygons by way of a fan of triangles. Where `divided`, what another face stands on is cut along it.
    """
    told = stage("faces")
    report(told, 0, _STEPS)
    rings = _rings(
        vertices, offsets, indices
    )  # polygons of equal corner count together: (face (m,), corners (m, k, 3))
    report(told, 1, _STEPS)
    dropped = sum(int(np.count_nonzero(_degenerate(corners))) for _, corners in rings)
    if dropped:
        text = f"mesh: {counted(dropped, 'degenerate face')} dropped (no area)"
        warn(text)
        rings = [(face[keep], corners[keep]) for face, corners in rings for keep in [~_degenerate(corners)]]
    if any(len(face) for face, _ in rings):
        rings = [ring for ring in _only_convex(rings) if len(ring[0])]
    # Cutting polygons that are not convex may leave nothing of those that go over themselves.
    if not any(len(face) for face, _ in rings):
        raise ValueError("mesh: wanted faces with an area, got none")
    report(told, 2, _STEPS)

    triangles = [ring for ring in rings if ring[1].shape[1] == 3]
    others = [ring for ring in rings if ring[1].shape[1] > 3]
    count, pairs = len(offsets) - 1, NO_PAIRS
    if triangles and paired:
        quads, triangles, pairs = _pair_triangles(triangles, material, go_on, told)
        others += [(count + np.arange(len(quads)), quads)] if len(quads) else []
    report(told, _STEPS, _STEPS)
    rings = triangles + others
    pieces = rings if patch_area is None else _cut(rings, patch_area)
    return assemble_patches(_divided(pieces, rings) if divided else pieces, count, pairs)


def _rings(vertices, offsets, indices):
    counts = np.diff(offsets)
    rings = []
    for count in np.unique(counts):
        face = np.flatnonzero(counts == count)
        if count >= 3:
            rings.append((face, vertices[indices[offsets[face][:, None] + np.arange(count)]]))
        else:
            rings.append((face, np.zeros((len(face), 3, 3))))  # a line or a point: degenerate
    return rings


def _vector_areas(corners):
    """Area times normal of polygons (m, k, 3), exact for planar ones (Newell)."""
    local = corners - corners[:, :1]
    return 0.5 * np.cross(local[:, 1:-1], local[:, 2:]).sum(axis=1)


def _degenerate(corners):
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1, initial=0.0)
    return np.linalg.norm(_vector_areas(corners), axis=1) <= _DEGENERATE * longest**2


def _unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _corner_sines(corners):
    """Sine of the turn at each corner about the polygon's normal (m, k); all positive means convex."""
    normal = _unit(_vector_areas(corners))
    forward = np.roll(corners, -1, axis=1) - corners
    backward = np.roll(corners, 1, axis=1) - corners
    lengths = np.linalg.norm(forward, axis=2) * np.linalg.norm(backward, axis=2)
    turn = np.einsum("mkc,mc->mk", np.cross(forward, backward), normal)
    return turn / np.maximum(lengths, np.finfo(float).tiny)


def _is_convex_and_flat(corners):
    normal = _unit(_vector_areas(corners))
    local = corners - corners.mean(axis=1, keepdims=True)
    height = np.abs(np.einsum("mkc,mc->mk", local, normal)).max(axis=1)
    size = np.linalg.norm(local, axis=2).max(axis=1)
    # A corner of 180 degrees is fine; what turns the other way is not. A star that winds twice turns more than once.
    sines = _corner_sines(corners)
    edges = _unit_or_zero(np.roll(corners, -1, axis=1) - corners)
    cosines = np.einsum("mkc,mkc->mk", edges, np.roll(edges, 1, axis=1))
    turning = np.arctan2(np.maximum(sines, 0.0), cosines).sum(axis=1)
    return (height <= _FLAT * size) & (sines >= -_FLAT).all(axis=1) & (turning < 3.0 * np.pi)


def _unit_or_zero(vectors):
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


def _only_convex(rings):
    """The same surface with every polygon that is bent or not convex replaced by triangles."""
    result = []
    for face, corners in rings:
        if corners.shape[1] == 3:
            result.append((face, corners))
            continue
        good = _is_convex_and_flat(corners)
        if good.any():
            result.append((face[good], corners[good]))
        if not good.all():
            result.append(_triangulate(face[~good], corners[~good]))
    return result


def _triangulate(face, corners):
    row, triangles, lost = triangles_of_polygons(corners)
    if lost.any():
        what = f"{counted(np.count_nonzero(lost), 'face')} (the first: {face[lost].min()})"
        warn(f"mesh: {what} with outlines that cannot be cut into triangles, as where they cross: parts are missing")
    keep = ~_degenerate(triangles)
    return face[row[keep]], triangles[keep]


def _pair_triangles(triangles, material, go_on, told):
    """Pairs of coplanar triangles as quadrilaterals: (these (p, 4, 3), the other triangles, Pairs)."""
    face = np.concatenate([f for f, _ in triangles])
    corners = np.concatenate([c for _, c in triangles])
    # Edges are matched by position: many formats store the corners of each face anew.
    vertex = _places(corners.reshape(-1, 3), told).reshape(-1, 3)
    start, end = vertex.ravel(), np.roll(vertex, -1, axis=1).ravel()
    # Half-edge h of triangle h // 3 runs from corner h % 3 to the next; its twin runs the other way.
    key = np.minimum(start, end).astype(np.int64) * (vertex.max() + 1) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    _, first, uses = np.unique(key[order], return_index=True, return_counts=True)
    report(told, 6, _STEPS)
    h, twin = order[first[uses == 2]], order[first[uses == 2] + 1]
    ok = start[h] == end[twin]  # same sense of rotation on both sides
    h, twin = h[ok], twin[ok]
    if material is not None:
        ok = (material[face[h // 3]] == material[face[twin // 3]]).all(axis=1)
        h, twin = h[ok], twin[ok]
    normals = _unit(_vector_areas(corners))
    ok = np.einsum("ij,ij->i", normals[h // 3], normals[twin // 3]) > 1.0 - 0.5 * _FLAT**2
    h, twin = h[ok], twin[ok]
    # The apex of h's triangle, the start of h, the apex of its twin's, the end of h: in the triangles' sense.
    flat = corners.reshape(-1, 3)
    apex, other = h // 3 * 3 + (h + 2) % 3, twin // 3 * 3 + (twin + 2) % 3
    quads = np.stack([flat[apex], flat[h], flat[other], flat[h // 3 * 3 + (h + 1) % 3]], axis=1)
    sines = _corner_sines(quads) if len(quads) else np.zeros((0, 4))
    ok = (sines > _FLAT).all(axis=1)
    h, twin, quads, sines = h[ok], twin[ok], quads[ok], sines[ok]
    if go_on is not None:
        ok = go_on(face[h // 3], face[twin // 3])
        h, twin, quads, sines = h[ok], twin[ok], quads[ok], sines[ok]
    pairs = _best_pairs(h // 3, twin // 3, 1.0 - sines.min(axis=1, initial=1.0), len(face))
    paired = np.zeros(len(face), bool)
    paired[h[pairs] // 3] = paired[twin[pairs] // 3] = True
    rest = [(face[~paired], corners[~paired])] if not paired.all() else []
    faces = np.stack([face[h[pairs] // 3], face[twin[pairs] // 3]], axis=1)
    return quads[pairs], rest, Pairs(faces, quads[pairs][:, [0, 1, 3]])


def _places(points, told):
    """(n,) numbers of points (n, 3): the same where all three coordinates are, in the order of x, then y, then z."""
    number = np.zeros(len(points), np.int64)
    # One coordinate after the other, with a report after each: numpy's axis=0 compares rows, four times as long.
    for axis in range(3):
        values, rank = np.unique(points[:, axis], return_inverse=True)
        _, number = np.unique(number * len(values) + rank.ravel(), return_inverse=True)
        report(told, 3 + axis, _STEPS)
    return number.ravel()


def _best_pairs(a, b, cost, count):
    """Indices of pairs (a[i], b[i]) that share no member, each the cheapest left to both of its members."""
    rank = np.empty(len(a), np.int64)
    rank[np.lexsort((b, a, np.round(cost, 6)))] = np.arange(len(a))
    chosen, left = [], np.arange(len(a))
    while len(left):
        best = np.full(count, len(a))
        np.minimum.at(best, a[left], rank[left])
        np.minimum.at(best, b[left], rank[left])
        mutual = left[(best[a[left]] == rank[left]) & (best[b[left]] == rank[left])]
        chosen.append(mutual)
        taken = np.zeros(count, bool)
        taken[a[mutual]] = taken[b[mutual]] = True
        left = left[~taken[a[left]] & ~taken[b[left]]]
    return np.sort(np.concatenate(chosen)) if chosen else np.zeros(0, np.int64)


def _cut(rings, patch_area):
    """Pieces of at most patch_area: a list of (face, corners) rings."""
    rings = [part for ring in rings for part in _fanned(*ring, patch_area)]
    cells = [_cells(corners, patch_area) for _, corners in rings]
    total = sum(float((m * n).sum()) for m, n in cells)
    if not total <= _MOST:
        many = f"{total:.0f}" if total < 1e15 else f"{total:.3g}"
        raise ValueError(f"patch_area: wanted at most {_MOST} patches, got {many} with {patch_area:g}")
    cut = {3: _cut_triangles, 4: _cut_quads}
    return [
        cut[corners.shape[1]](face, corners, m.astype(np.int64), n.astype(np.int64))
        if corners.shape[1] in cut
        else (face, corners)
        for (face, corners), (m, n) in zip(rings, cells, strict=True)
    ]


def _fanned(face, corners, patch_area):
    """A ring as rings; polygons of 5 corners or more that are larger than patch_area become fans of triangles."""
    k = corners.shape[1]
    if k <= 4:
        return [(face, corners)]
    large = np.linalg.norm(_vector_areas(corners), axis=1) > patch_area * (1 + 1e-9)
    pieces = [(face[~large], corners[~large])] if not large.all() else []
    if large.any():
        some = corners[large]
        fan = np.stack([some[:, :1].repeat(k - 2, axis=1), some[:, 1:-1], some[:, 2:]], axis=2).reshape(-1, 3, 3)
        fan_face = face[large].repeat(k - 2)
        keep = ~_degenerate(fan)  # a corner of 180 degrees beside the fan's first
        pieces.append((fan_face[keep], fan[keep]))
    return pieces


def _cells(corners, patch_area):
    """How often each face of a ring is cut along its two directions, as floats, which hold any number."""
    k = corners.shape[1]
    if k > 4:
        return np.ones(len(corners)), np.ones(len(corners))
    with np.errstate(over="ignore"):
        if k == 3:
            area = np.linalg.norm(_vector_areas(corners), axis=1)
            m = np.maximum(np.ceil(np.sqrt(area / patch_area) * (1 - 1e-9)), 1)
            return m, m
        # The bilinear map stretches area most at a corner, so this many cells keep each of them below patch_area.
        forward, backward = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
        largest = np.linalg.norm(np.cross(forward, backward), axis=2).max(axis=1)
        cells = np.clip(largest / patch_area * (1 - 1e-9), 1e-9, 1e300)
    p0, p1, p2, p3 = np.moveaxis(corners, 1, 0)
    u = 0.5 * (np.linalg.norm(p1 - p0, axis=1) + np.linalg.norm(p2 - p3, axis=1))
    v = 0.5 * (np.linalg.norm(p3 - p0, axis=1) + np.linalg.norm(p2 - p1, axis=1))
    m = np.maximum(np.round(np.sqrt(cells * (u / v))), 1)
    return m, np.ceil(cells / m)


def _numbered(repeats):
    """For runs of the given lengths: the run of each element and its number within the run."""
    run = np.repeat(np.arange(len(repeats)), repeats)
    return run, np.arange(len(run)) - np.repeat(np.cumsum(repeats) - repeats, repeats)


def _cut_quads(face, corners, m, n):
    run, number = _numbered(m * n)
    i, j = number // n[run], number % n[run]

    def point(i, j):
        s, t = (i / m[run])[:, None], (j / n[run])[:, None]
        c = corners[run]
        return (1 - s) * ((1 - t) * c[:, 0] + t * c[:, 3]) + s * ((1 - t) * c[:, 1] + t * c[:, 2])

    return face[run], np.stack([point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)], axis=1)


def _cut_triangles(face, corners, k, _):
    run, number = _numbered(k * k)
    # Row r, counted from the first corner, holds 2 r + 1 triangles, which stand upright and upside down in turn.
    row = np.floor(np.sqrt(number)).astype(np.int64)
    column = number - row * row
    upright, step = column % 2 == 0, column // 2

    def point(r, c):
        s, t = (r / k[run])[:, None], (c / k[run])[:, None]
        a = corners[run]
        return a[:, 0] + s * (a[:, 1] - a[:, 0]) + t * (a[:, 2] - a[:, 1])

    second = np.where(upright[:, None], point(row + 1, step), point(row + 1, step + 1))
    third = np.where(upright[:, None], point(row + 1, step + 1), point(row, step + 1))
    return face[run], np.stack([point(row, step), second, third], axis=1)


def _divided(rings, walls):
    """The rings, with what a face of `walls` stands on in pieces that end at it."""
    face = np.concatenate([face for face, _ in rings])
    of = _flat(rings)
    corners, offsets, source = _core.divide_patches(*of, *(of if walls is rings else _flat(walls)), stage("patches"))
    if not len(source):
        return rings
    whole = np.ones(len(face), bool)
    whole[source] = False
    result, first = [], 0
    for ring_face, ring_corners in rings:
        keep = whole[first : first + len(ring_face)]
        result.append((ring_face[keep], ring_corners[keep]))
        first += len(ring_face)
    result += [(face[source[piece]], c) for piece, c in _rings(corners, offsets, np.arange(len(corners)))]
    return [ring for ring in result if len(ring[0])]


def _flat(rings):
    """Corners (k, 3) of all polygons, and offsets."""
    counts = np.concatenate([np.full(len(face), corners.shape[1]) for face, corners in rings])
    return np.concatenate([corners.reshape(-1, 3) for _, corners in rings]), np.concatenate([[0], np.cumsum(counts)])


def assemble_patches(pieces, count=None, pairs=NO_PAIRS):
    """Patches of rings of convex polygons, in the order of the faces they came from; face count + p is pair p."""
    parts, first = [], 0
    for face, corners in pieces:
        k = corners.shape[1]
        fan = np.stack([corners[:, :1].repeat(k - 2, axis=1), corners[:, 1:-1], corners[:, 2:]], axis=2)
        local = fan - corners[:, None, :1]  # a coordinate that all corners share stays what it is
        vector_area = 0.5 * np.cross(local[:, :, 1], local[:, :, 2])
        area = np.linalg.norm(vector_area, axis=2)
        total = area.sum(axis=1)
        centroid = corners[:, 0] + (local.mean(axis=2) * area[:, :, None]).sum(axis=1) / total[:, None]
        radius = np.linalg.norm(corners - centroid[:, None], axis=2).max(axis=1)
        normal = _unit(vector_area.sum(axis=1))
        patch = np.arange(first, first + len(face))
        keep = area.ravel() > 0.0  # a corner of 180 degrees leaves an empty triangle in the fan
        parts.append((centroid, normal, total, radius, face, fan.reshape(-1, 3, 3)[keep], patch.repeat(k - 2)[keep]))
        first += len(face)
    centroids, normals, areas, radii, faces, triangles, owner = (
        np.concatenate(part) for part in zip(*parts, strict=True)
    )
    pair = np.full(len(faces), -1) if count is None else np.maximum(faces - count, -1)
    faces = np.where(pair < 0, faces, np.append(pairs.faces[:, 0], -1)[pair])
    order = np.argsort(faces, kind="stable")
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    by_patch = np.argsort(place[owner], kind="stable")
    return Patches(
        centroids[order],
        normals[order],
        areas[order],
        radii[order],
        faces[order],
        triangles[by_patch],
        place[owner][by_patch].astype(np.uint32),
        pair[order],
        pairs,
    )
