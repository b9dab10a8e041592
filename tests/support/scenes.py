"""Small scenes for tests, which cases are built from as well."""

import numpy as np

import surflux as sf
from cases.builders import ball_inside, cloud_room, cube_inside, patch, rms, surfels_of

__all__ = ["ball_inside", "cloud_room", "cube_inside", "patch", "rms", "same_bits", "solve_own", "surfels_of", "up"]


def solve_own(scene, **options):
    """Irradiance of the scene's own surfels by all pairs: what tests compare surfel by surfel, and to many digits."""
    return sf.solve(scene, transport="pairs", insert=False, **options)


def up(points):
    """A normal along +z for each of some points."""
    return np.tile([0.0, 0.0, 1.0], (len(points), 1))


def same_bits(found, wanted):
    """Whether two solutions have the same light, to the last bit."""
    return found.error == wanted.error and all(
        np.array_equal(getattr(found, name), getattr(wanted, name)) for name in ("irradiance", "direct", "parents")
    )


def cell(low, high):
    """A box that faces in."""
    low, edges = np.array(low), np.diag(np.subtract(high, low))
    for k in range(3):
        u, v, w = edges[(k + 1) % 3], edges[(k + 2) % 3], edges[k]
        yield from ([low, low + u, low + u + v, low + v], [low + w, low + w + v, low + w + u + v, low + w + u])


def two_cells():
    """Of one mesh, 3 cm apart, and a lamp in one."""
    quads = [*cell([0, 0, 0], [0.985, 1, 1]), *cell([1.015, 0, 0], [2, 1, 1])]
    mesh = np.array(quads).reshape(-1, 3), np.arange(4 * len(quads)).reshape(-1, 4)
    cells = sf.Surfels.from_mesh(mesh, patch_area=0.002, reflectance=0.7)
    return sf.Scene([cells], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])
