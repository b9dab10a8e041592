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


def room_with_a_window(area, reflectance):
    """(walls of a room of 6 by 5 by 3 m that face inwards, with a hole to the south, +y being north; its corners)."""
    corners = [[x, y, z] for z in (0, 3) for y in (0, 5) for x in (0, 6)]
    window = [[1.5, 0, 1.0], [4.5, 0, 1.0], [4.5, 0, 2.4], [1.5, 0, 2.4]]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 2, 6, 4], [1, 5, 7, 3], [2, 3, 7, 6]]
    faces += [[0, 8, 9, 1], [1, 9, 10, 5], [5, 10, 11, 4], [4, 11, 8, 0]]
    return sf.Surfels.from_mesh((corners + window, faces), area, reflectance), np.array(window)
