"""A street between two walls so long that its ends do not count, and what its middle sees of the sky."""

import numpy as np

import surflux as sf

LENGTH = 400.0  # of a street as wide as its walls are high


def canyon(across=16, along=9, reflectance=0.3, length=LENGTH):
    """(surfels, middles of strips): floor from x = 0 to 1 and walls up to z = 1, along y.

    The first 3 * across surfels are the middle of the street: strips of the floor by x, of the left and the right wall
    by z.
    """
    cuts = length * (np.arange(along + 1) / along - 0.5)
    strips = []
    for k in range(across):
        low, high = k / across, (k + 1) / across
        strips.append(([low, 0.0], [high, 0.0]))
    for k in range(across):
        strips.append(([0.0, (k + 1) / across], [0.0, k / across]))
    for k in range(across):
        strips.append(([1.0, k / across], [1.0, (k + 1) / across]))
    points, faces = [], []
    order = sorted(range(along), key=lambda j: abs(j - along // 2))
    for j in order:
        for (x0, z0), (x1, z1) in strips:
            first = len(points)
            points += [[x0, cuts[j], z0], [x1, cuts[j], z1], [x1, cuts[j + 1], z1], [x0, cuts[j + 1], z0]]
            faces.append([first, first + 1, first + 2, first + 3])
    surfels = sf.Surfels.from_mesh((points, faces), reflectance=reflectance)
    return surfels, (np.arange(across) + 0.5) / across


def floor_view(x):
    """Cosine-weighted, of the floor at x: (sin a + sin b) / 2, the walls' tops a and b off the zenith."""
    return 0.5 * (x / np.hypot(x, 1.0) + (1.0 - x) / np.hypot(1.0 - x, 1.0))


def wall_view(z):
    """Of a wall at height z, across from one whose top is 1 - z above: (1 - sin e) / 2, e its elevation."""
    return 0.5 * (1.0 - (1.0 - z) / np.hypot(1.0 - z, 1.0))
