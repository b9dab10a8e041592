"""Rotations as matrices."""

import numpy as np


def rotation_about(axis, angle):
    """(3, 3): a turn about the direction `axis` (3,) by `angle` in radians, counter-clockwise seen from its tip.

    By the formula of Rodrigues.
    """
    axis = axis / np.linalg.norm(axis)
    cross = np.cross(axis, np.eye(3)).T  # cross @ v = axis x v
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
