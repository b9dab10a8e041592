"""Rotations as unit quaternions (w, x, y, z), and what they do to spherical harmonics."""

import numpy as np

from surflux import _core


def to_normals(normals):
    """(n, 4): the shortest rotations that take +z to unit vectors (n, 3)."""
    x, y, z = normals.T
    none = np.zeros_like(x)
    # From -z where that is closer, after half a turn about x: 1 + z would lose its digits.
    upper = np.stack([1.0 + z, -y, x, none], axis=1)
    lower = np.stack([-y, 1.0 - z, none, x], axis=1)
    found = np.where(z[:, None] >= 0.0, upper, lower)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def product(first, second):
    """The rotations `second`, then `first`: (n, 4) each, or (4,) for all."""
    w, x, y, z = np.moveaxis(first, -1, 0)
    s, a, b, c = np.moveaxis(second, -1, 0)
    parts = (
        w * s - x * a - y * b - z * c,
        w * a + x * s + y * c - z * b,
        w * b - x * c + y * s + z * a,
        w * c + x * b - y * a + z * s,
    )
    return np.stack(parts, axis=-1)


def of_matrix(rotation):
    """(4,) of a rotation (3, 3): its quaternion is the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    k = [[a + e + i, h - f, c - g, d - b], [0, a - e - i, b + d, c + g], [0, 0, e - a - i, f + h], [0, 0, 0, i - a - e]]
    found = np.linalg.eigh(np.array(k), "U")[1][:, -1]
    return found if found[0] >= 0.0 else -found


def turned_harmonics(harmonics, rotation):
    """Functions by their harmonics (n, k, channels), turned by one matrix: what was in direction d is in rotation @ d.

    Without the Condon-Shortley phase, as _core has them.
    """
    n, k, channels = harmonics.shape
    columns = np.ascontiguousarray(harmonics.transpose(1, 0, 2).reshape(k, n * channels))
    return np.asarray(_core.rotate_harmonics(columns, rotation)).reshape(k, n, channels).transpose(1, 0, 2)
