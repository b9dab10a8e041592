"""Who shares the disk of one surfel: the weights of D04 eq. 5 and 6 over its pixels."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class AreaShares:
    """The share of each neighbour at each pixel of a surfel's disk; see area_shares."""

    neighbors: np.ndarray
    shares: np.ndarray
    frame: np.ndarray
    area: float
    extent: float


def area_shares(s, index, *, method="curved", kappa=3.0, resolution=32, epsilon=0.8):
    """AreaShares of surfel `index`: weights exp(-kappa r_j / R_j) on the disks of D04 eq. 6, divided by their sum."""
    x, n, r = s.points, s.normals, s.radii
    near = (np.linalg.norm(x - x[index], axis=1) < r + r[index]) & (n @ n[index] > epsilon)
    if len(s.triangle_surfel):
        near[np.unique(s.triangle_surfel)] = False
    near[index] = False
    neighbors = np.concatenate([[index], np.flatnonzero(near)])
    w = n[index]
    sign = np.copysign(1.0, w[2])
    a = -1.0 / (sign + w[2])
    b = w[0] * w[1] * a
    u, v = np.array([1 + sign * w[0] ** 2 * a, sign * b, -sign * w[0]]), np.array([b, sign + w[1] ** 2 * a, -w[1]])
    at = (np.arange(resolution) + 0.5) * 2 / resolution - 1
    t, q = np.meshgrid(at, at)
    p = r[index] * (t[..., None] * u + q[..., None] * v)
    d = p[None] - (x[neighbors] - x[index])[:, None, None]
    cosine = n[neighbors] @ w
    height = np.einsum("jabc,jc->jab", d, n[neighbors]) / cosine[:, None, None]
    distance = np.linalg.norm(d - height[..., None] * w, axis=-1) / r[neighbors, None, None]
    weight = np.where(distance <= 1, np.exp(-kappa * distance), 0.0)
    inside = t**2 + q**2 <= 1
    shares = np.where(inside, weight / np.where(inside, weight.sum(axis=0), 1), np.nan)
    stretch = (shares / cosine[:, None, None]).sum(axis=0)
    pixel = (2 * r[index] / resolution) ** 2
    return AreaShares(neighbors, shares, np.array([u, v, w]), float(np.nansum(shares[0] * stretch) * pixel), r[index])
