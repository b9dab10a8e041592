"""Who shares the disk of a picked surfel, as colours, pictures and words."""

import colorsys
from dataclasses import dataclass

import numpy as np

from surflux._base import check
from surflux.drawing.colors import coverage
from surflux.geometry.areas import AreaShares, area_shares
from surflux.geometry.cores import disks_among

PICKED = (230, 0, 90)  # kept apart from viridis and from the hues of the neighbours
_GOLDEN = 0.6180339887


@dataclass(frozen=True, eq=False)
class Picked:
    """One surfel and those that share its disk, itself first.

    members: (m,) indices. colors: (m, 3) uint8. parts: (m,) the part that falls to each of what the disk counts.
    shares: AreaShares, or None for a patch of a mesh, which shares nothing.
    """

    index: int
    members: np.ndarray
    colors: np.ndarray
    parts: np.ndarray
    shares: AreaShares | None

    def leaders(self):
        """(h, w, 3) uint8: each pixel in the colour of the member with the largest share; white off the disk."""
        xi = self.shares.shares
        outside = np.isnan(xi[0])
        leading = np.argmax(np.where(outside, 0.0, xi), axis=0)
        return np.where(outside[..., None], np.uint8(255), self.colors[leading])


def pick(s, index, method):
    """Picked surfel `index` of s, shared by `method` as effective_areas takes it."""
    if np.any(s.triangle_surfel == index):
        return Picked(index, np.array([index]), np.array([PICKED], np.uint8), np.ones(1), None)
    found = area_shares(s, index, method=method)
    members = np.asarray(found.neighbors)
    counted = found.shares[:, ~np.isnan(found.shares[0])]
    parts = counted.mean(axis=1) if counted.size else np.zeros(len(members))
    away = (s.points[members] - s.points[index]) @ found.frame[:2].T
    return Picked(index, members, colors_around(away), parts, found)


def colors_around(away):
    """The picked surfel's own colour, then one for each neighbour, far in hue from those beside it around the disk."""
    # Rounded: of those in one direction, rounding errors would sort one way here and another way elsewhere.
    order = np.argsort(np.round(np.arctan2(away[1:, 1], away[1:, 0]), 5), kind="stable")
    colors = np.empty((len(away), 3), np.uint8)
    colors[0] = PICKED
    for place, member in enumerate(order):
        hue = 0.1 + 0.72 * ((place * _GOLDEN) % 1.0)  # from orange to violet
        value = (0.95, 0.8)[place % 2]
        colors[1 + member] = np.round(255 * np.array(colorsys.hsv_to_rgb(hue, 0.6, value)))
    return colors


def disks_of(s):
    """Indices of the surfels whose area over disk area is worth a look: disks, or patches where all are."""
    disks = disks_among(s)
    return disks if len(disks) else np.arange(len(s))


def words(s, areas, picked):
    """What there is to say about the picked surfel, in lines of at most 38 characters."""
    i = picked.index
    if picked.shares is None:
        sharing = "a patch of a mesh: exact area"
    else:
        sharing = f"disk shared with {check.counted(np.count_nonzero(picked.parts[1:]), 'neighbour')}"
    digits = decimals(s.radii[i])
    lines = [
        f"surfel {i}",
        sharing,
        "",
        f"area         {areas[i]:.5g}",
        f"radius R     {s.radii[i]:.5g}",
        f"area/disk    {coverage(s, areas)[i]:.4f}",
        *_keeps(s, picked),
        "",
        f"  {'position':>16} {'normal':>10}",
    ]
    for axis, x, n in zip("xyz", s.points[i], s.normals[i], strict=True):
        lines.append(f"{axis} {x:>16.{digits}f} {n:>10.4f}")
    return lines


def _keeps(s, picked):
    """What the percentages on the neighbours are of, and the surfel's own."""
    if picked.shares is None:
        return []
    ratio = picked.shares.extent / s.radii[picked.index]
    circle = "its disk" if ratio < 1.001 else f"the circle of {ratio:.1f} R"
    return [f"keeps {100 * picked.parts[0]:.0f}% of {circle}"]


def summary(s, areas):
    """What there is to say about all of the areas."""
    ratio = coverage(s, areas)[disks_of(s)]
    patches = len(np.unique(s.triangle_surfel))
    lines = [check.counted(len(s), "surfel")]
    if patches:
        lines.append(f"{patches} of them {'a patch' if patches == 1 else 'patches'}, exact")
    lines += [
        "",
        f"total area   {areas.sum():.6g}",
        f"smallest     {areas.min():.4g}",
        f"largest      {areas.max():.4g}",
        "",
        "area/disk area",
        f"  median     {np.median(ratio):.4f}",
        f"  from       {ratio.min():.4f}",
        f"  to         {ratio.max():.4f}",
    ]
    return lines


def decimals(length):
    """Decimals that show a thousandth of a length."""
    return int(np.clip(3 - np.floor(np.log10(length)), 0, 12))


def surfel_under(s, start, direction):
    """The surfel that a ray from start meets first from in front, or None.

    Where disks overlap there, it is the one whose centre is nearest to the place that was met.
    """
    direction = direction / np.linalg.norm(direction)
    first, found = np.inf, None
    slope = s.normals @ direction
    patch = np.zeros(len(s), bool)
    patch[s.triangle_surfel] = True
    facing = np.flatnonzero((slope < 0) & ~patch)
    away = s.points[facing] - start
    distance = np.einsum("ij,ij->i", away, s.normals[facing]) / slope[facing]
    off = np.linalg.norm(distance[:, None] * direction - away, axis=1)
    met = np.flatnonzero((distance > 0) & (off <= s.radii[facing]))
    if len(met):
        nearest = met[np.argmin(distance[met])]
        first = distance[nearest]
        place = first * direction
        # Of the disks that overlap where the ray comes in: those within the reach of the first.
        close = met[distance[met] <= first + s.radii[facing[nearest]]]
        aim = np.linalg.norm(place - away[close], axis=1)
        found = int(facing[close[np.argmin(aim)]])
    if len(s.triangles):
        distance = _distance_to_triangles(s.triangles - start, direction)
        nearest = np.argmin(distance)
        if distance[nearest] < first:
            found = int(s.triangle_surfel[nearest])
    return found


def _distance_to_triangles(triangles, direction):
    """(t,) how far along a ray from the origin each triangle is met from in front; inf where it is not."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    # The ray's volume with each edge: all of one sign inside (Pluecker).
    sides = [np.cross(p, q) @ direction for p, q in ((a, b), (b, c), (c, a))]
    inside = np.all(np.array(sides) <= 0, axis=0)
    normal = np.cross(b - a, c - a)
    slope = normal @ direction
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = np.einsum("ij,ij->i", normal, a) / slope
    return np.where(inside & (slope < 0) & (distance > 0), distance, np.inf)
