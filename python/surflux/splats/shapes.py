"""The Gaussians that stand for surfels: where they are, how wide, how turned."""

import numpy as np

from surflux import _core
from surflux.geometry.rotation import rotation_matrices
from surflux.splats import turning

OPACITY = 0.99
"""Of a Gaussian at its centre: the most that renderers blend (Kerbl and others 2023 cut alpha off at .99)."""

DILOGARITHM = 1.588625448
"""Li2(OPACITY): the integral of -ln(1 - OPACITY exp(-r^2/2)) over the plane is 2 pi of it."""

SHOWS_THROUGH = 0.01
"""What of the light behind a surface its Gaussians let through, in the mean of its logarithm."""

THIN = 0.01
"""Third standard deviation over the geometric mean of the two others: files hold logarithms."""

_NEAREST = 8  # neighbours among which one that stands back to back is looked for


def shapes_of(surfels):
    """(positions (n, 3), scales (n, 3), rotations (n, 4), opacities (n,)) of Gaussians that stand for surfels.

    Each covers as much as its surfel's share of the surface, S: Gaussians of N surfels to the area, of standard
    deviations s1 and s2, let through exp(-N 2 pi s1 s2 Li2(OPACITY)) in the mean of the logarithm, whatever their
    places (Campbell's theorem). N is 1/S, and s1 s2 = S ln(1/SHOWS_THROUGH) / (2 pi Li2(OPACITY)). Disks are round;
    patches have the axes, and the ratio, of the second moments of their triangles. Surfels without a share, as those
    that others cover, become transparent.
    """
    points, normals, areas = surfels.points, surfels.normals, surfels.areas
    rotations, ratio = _patch_axes(surfels, turning.to_normals(normals))
    seen = areas > 0.0
    mean = np.sqrt(np.where(seen, -np.log(SHOWS_THROUGH) / (2.0 * np.pi * DILOGARITHM) * areas, surfels.radii**2 / 4.0))
    scales = np.stack([mean * ratio, mean / ratio, THIN * mean], axis=1)
    positions = points + _lift(points, normals, mean)[:, None] * normals
    return positions, scales, rotations, np.where(seen, OPACITY, 0.0)


def _patch_axes(surfels, rotations):
    """Rotations whose x is along the longest axis of each patch, and (n,) the fourth root of the ratio of moments."""
    of, n = surfels.triangle_surfel, len(surfels)
    ratio = np.ones(n)
    if not len(of):
        return rotations, ratio
    corners = surfels.triangles - surfels.points[of][:, None]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    x, y = np.moveaxis(corners @ rotation_matrices(rotations[of])[:, :, :2], -1, 0)

    def moment(a, b):  # of a triangle's area over its corners: (sum a sum b + sum a b) / 12, times the area
        return np.bincount(of, area * (a.sum(axis=1) * b.sum(axis=1) + (a * b).sum(axis=1)), n)

    xx, xy, yy = moment(x, x), moment(x, y), moment(y, y)
    spread = np.hypot(0.5 * (xx - yy), xy)
    long = 0.5 * (xx + yy) + spread
    patch = long > 0.0
    short = np.maximum(0.5 * (xx + yy) - spread, 1e-12 * long)
    ratio[patch] = (long[patch] / short[patch]) ** 0.25
    half = 0.25 * np.arctan2(2.0 * xy, xx - yy)
    none = np.zeros(n)
    return turning.product(rotations, np.stack([np.cos(half), none, none, np.sin(half)], axis=1)), ratio


def _lift(points, normals, size):
    """(n,) how far to move Gaussians along their normals, so that those of two sides of a sheet are not mixed.

    Renderers draw whole Gaussians, sorted by their centres. Of two sides at one place half of what is seen is of the
    far one, blended between the Gaussians of the near one; a standard deviation apart, a twentieth is.
    """
    lift = np.zeros(len(points))
    for other in _core.nearest_points(points, min(_NEAREST, len(points))).T:  # each is among its own
        back = np.flatnonzero(np.einsum("nc,nc->n", normals, normals[other]) < -0.5)
        way, normal, most = points[back] - points[other[back]], normals[back], size[back]
        thick = (way * normal).sum(axis=1)
        aside = np.linalg.norm(way - thick[:, None] * normal, axis=1)
        near = (aside < most) & (thick > -THIN * most)
        lift[back[near]] = np.maximum(lift[back], 0.5 * (most - thick))[near]
    return lift
