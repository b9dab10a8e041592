"""Small scenes for tests."""

import numpy as np

import surflux as sf
from surflux import shapes


def cube_inside(n, rho=0.5, emission=0.0):
    """The inside of the unit cube, n x n patches per face: left, right, front, back, floor, ceiling."""
    vertices, faces, _ = shapes.box(1.0, n, inward=True)
    return sf.Surfels.from_mesh((vertices, faces), reflectance=rho, emission=emission)


def surfels_of(points, normals, rho=0.5, emission=0.0, **options):
    return sf.Surfels(points, normals, reflectance=rho, emission=emission, **options)


def ball_inside(n, radius=1.0, center=(0, 0, 0), rho=0.5, emission=0.0, sign=-1):
    """n surfels on a sphere that face its inside; sign=1 its outside."""
    unit = shapes.sphere(n)
    return surfels_of(radius * unit.points + np.array(center), sign * unit.normals, rho, emission)


def cloud_room(n, rho=0.5, emission=0.0, size=(1.0, 1.0, 1.0)):
    """Six clouds, one per wall of a room, that face its inside; n surfels per unit length."""
    out, size = [], np.array(size)
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        across = [(np.arange(k) + 0.5) / k * size[a] for a, k in ((a, round(n * size[a])) for a in others)]
        for side in (0, 1):
            points = np.zeros((len(across[0]), len(across[1]), 3))
            points[..., others[0]], points[..., others[1]] = across[0][:, None], across[1]
            points[..., axis] = side * size[axis]
            normal = np.zeros(3)
            normal[axis] = 1 - 2 * side
            points = points.reshape(-1, 3)
            out.append(surfels_of(points, [normal] * len(points), rho, emission))
    return out


def patch(corner, u, v, rho=0.5, emission=0.0, patch_area=None):
    """A rectangle that faces along u x v."""
    corner, u, v = (np.array(x, dtype=float) for x in (corner, u, v))
    corners = np.array([corner, corner + u, corner + u + v, corner + v])
    return sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area, rho, emission)


def rms(a, b, areas):
    """|a - b| / |b| by area, all channels together (DESIGN section 3)."""
    return np.sqrt((areas[:, None] * (a - b) ** 2).sum() / (areas[:, None] * b**2).sum())
