"""Polygons that are not convex as triangles, by ear clipping: that of VTK, which is quick, and where it fails ours."""

import numpy as np

_STRAIGHT = 1e-12  # of twice the area
_OFF = 1e-6  # of a polygon's area, that its triangles may be off by


def triangles_of_polygons(corners):
    """(polygon (t,), triangles (t, 3, 3), lost (m,)) of polygons (m, k, 3); which of these are not whole in them.

    Outlines may touch themselves, as around a hole that a bridge leads to, or go out and back.
    """
    import pyvista

    m, k, _ = corners.shape
    cells = np.hstack([np.full((m, 1), k), np.arange(m * k).reshape(m, k)])
    mesh = pyvista.PolyData(corners.reshape(-1, 3), faces=cells.ravel())
    mesh.cell_data["polygon"] = np.arange(m)
    mesh = mesh.triangulate()
    triangles = mesh.points.astype(float)[mesh.faces.reshape(-1, 4)[:, 1:]]
    polygon = np.asarray(mesh.cell_data["polygon"])
    off = _is_off(corners, polygon, triangles)
    whole = ~off[polygon]
    parts = [(polygon[whole], triangles[whole])]
    lost = np.zeros(m, bool)
    for row in np.flatnonzero(off):
        found = _by_ears(_without_spikes(corners[row]))
        lost[row] = _is_off(corners[row : row + 1], np.zeros(len(found), int), found)[0]
        if lost[row]:
            found = triangles[polygon == row]
        parts.append((np.full(len(found), row), found))
    return *(np.concatenate(part) for part in zip(*parts, strict=True)), lost


def _is_off(corners, polygon, triangles):
    local = corners - corners[:, :1]
    wanted = 0.5 * np.cross(local[:, 1:-1], local[:, 2:]).sum(axis=1)
    a, b, c = triangles.transpose(1, 0, 2)
    each = 0.5 * np.cross(b - a, c - a)
    found = np.stack([np.bincount(polygon, values, len(corners)) for values in each.T], axis=1)
    return np.linalg.norm(found - wanted, axis=1) > _OFF * np.linalg.norm(wanted, axis=1)


def _without_spikes(ring):
    """A ring (k, 3) without corners that stand twice in a row, or from which it goes back to where it came from."""
    kept = []
    for corner in map(tuple, ring):
        kept.append(corner)
        if len(kept) > 1 and kept[-1] == kept[-2]:
            del kept[-1]
        if len(kept) > 2 and kept[-1] == kept[-3]:
            del kept[-2:]
    while len(kept) > 3:  # where it closes
        if kept[0] == kept[-1]:
            del kept[-1]
        elif kept[0] == kept[-2]:
            del kept[-2:]
        elif kept[1] == kept[-1]:
            kept = kept[1:-1]
        else:
            break
    return np.array(kept)


def _by_ears(ring):
    """(t, 3, 3): ears of a ring (k, 3) that are cut off one after the other; all of it, unless it crosses itself.

    Where it touches itself, corners in the place of one of an ear's are not in its way.
    """
    local = ring - ring[0]
    normal = np.cross(local[1:-1], local[2:]).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    flat = np.delete(local, axis, axis=1)  # as it stands: what coincides still does
    if (normal[axis] < 0.0) != (axis == 1):
        flat = flat[:, ::-1]
    none = _STRAIGHT * np.abs(normal[axis])
    left, ears = list(range(len(ring))), []
    while len(left) >= 3:
        corners = flat[left]
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        turns = _turn(before, corners, after)
        back = ((before - corners) * (after - corners)).sum(axis=1) >= 0.0
        for k in np.flatnonzero((turns > none) | ((np.abs(turns) <= none) & back)):
            a, b, c = before[k], corners[k], after[k]
            if turns[k] <= none:  # a spike, or a corner that stands twice
                break
            apart = np.all([(corners != corner).any(axis=1) for corner in (a, b, c)], axis=0)
            p = corners[apart]
            if not np.any((_turn(a, b, p) >= -none) & (_turn(b, c, p) >= -none) & (_turn(c, a, p) >= -none)):
                ears.append([left[k - 1], left[k], left[(k + 1) % len(left)]])
                break
        else:
            break
        del left[k]
    return ring[np.array(ears, int).reshape(-1, 3)]


def _turn(a, b, c):
    """Twice the areas of triangles in the plane, above 0 where they are wound to the left."""
    return (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
