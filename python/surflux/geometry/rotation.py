"""Rotations as matrices."""

import numpy as np


def rotation_about(axis, angle):
    """(3, 3): a turn about the direction `axis` (3,) by `angle` in radians, counter-clockwise seen from its tip.

    By the formula of Rodrigues.
    """
    axis = axis / np.linalg.norm(axis)
    cross = np.cross(axis, np.eye(3)).T  # cross @ v = axis x v
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def rotation_matrices(quaternions):
    """(n, 3, 3) of unit quaternions (n, 4), as (w, x, y, z); columns are what the axes become."""
    w, x, y, z = quaternions.T
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=1)
