"""Points on surfaces whose area is known, for `surflux bench` and the tests.

Each function returns a Cloud. Where `cells` is there it is the area that belongs to each point: of its Voronoi cell on
the sphere, or in the polygon that the points sample (these need scipy).
"""

from dataclasses import dataclass, replace

import numpy as np

from surflux.points.surfels import Surfels
from surflux.scenes import shapes


@dataclass(frozen=True, eq=False)
class Cloud:
    """points (n, 3), unit normals (n, 3), the surface's true area, and the area of each point's cell (n,), or None."""

    points: np.ndarray
    normals: np.ndarray
    area: float
    cells: np.ndarray | None = None

    def surfels(self, **options):
        """Surfels with these normals and the default radii."""
        return Surfels(self.points, self.normals, **options)


def sphere(points):
    """The unit sphere, sampled at these directions (n, 3)."""
    return Cloud(points, points, 4 * np.pi, spherical_cells(points))


def fibonacci_sphere(n):
    """Evenly on a spiral."""
    return sphere(spiral(n))


def spiral(n):
    """The points (n, 3) of the Fibonacci sphere alone: Voronoi cells of a million take minutes."""
    k = np.arange(n) + 0.5
    z, angle = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


def icosphere(n):
    """642, 2562, ... points: the corners of a subdivided icosahedron."""
    return sphere(shapes.sphere(n).points)


def random_sphere(n, seed=0):
    """Uniformly at random, which leaves clusters and gaps."""
    p = np.random.default_rng(seed).normal(size=(n, 3))
    return sphere(p / np.linalg.norm(p, axis=1, keepdims=True))


def uneven_sphere(n, ratio=20, seed=0):
    """At random, `ratio` times denser at one pole than at the other."""
    rng = np.random.default_rng(seed)
    # Density 1 + (ratio - 1) u with u = (z + 1) / 2: the inverse of its integral.
    v = rng.uniform(size=n)
    z = 2 * (np.sqrt(1 + v * (ratio**2 - 1)) - 1) / (ratio - 1) - 1
    angle, r = rng.uniform(0, 2 * np.pi, n), np.sqrt(1 - z * z)
    return sphere(np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1))


def random_torus(n, seed=0, big=1.0, small=0.4):
    """Uniformly at random by area."""
    rng = np.random.default_rng(seed)
    v = rng.uniform(0, 2 * np.pi, 4 * n)
    v = v[rng.uniform(size=4 * n) < (big + small * np.cos(v)) / (big + small)][:n]
    u = rng.uniform(0, 2 * np.pi, n)
    normals = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=1)
    ring = big * np.stack([np.cos(u), np.sin(u), 0 * u], axis=1)
    return Cloud(ring + small * normals, normals, 4 * np.pi**2 * big * small)


def open_square(n, seed=0):
    """The unit square in z = 0, blue noise (sample elimination)."""
    p = _blue_noise(n, seed)
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    return Cloud(np.insert(p, 2, 0.0, axis=1), normals, 1.0, square_cells(p))


def cube(n, seed=0):
    """The unit cube with n points of blue noise on each face, and its sharp normals."""
    points, normals, cells = [], [], []
    for axis in range(3):
        for side in (0, 1):
            p = _blue_noise(n, 6 * seed + 2 * axis + side)
            points.append(np.insert(p, axis, side, axis=1))
            normals.append(np.tile((2.0 * side - 1.0) * np.eye(3)[axis], (n, 1)))
            cells.append(square_cells(p))
    known = None if cells[0] is None else np.concatenate(cells)
    return Cloud(np.concatenate(points), np.concatenate(normals), 6.0, known)


def noisy(cloud, jitter=0.1, tilt=10.0, seed=0):
    """The same with each point moved along its normal by a normal deviate of `jitter` spacings, and each normal turned
    by `tilt` degrees, whichever way."""
    rng = np.random.default_rng([seed, 1])  # another stream than the one that made the cloud
    n = len(cloud.points)
    across = np.cross(cloud.normals, rng.normal(size=(n, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    points = cloud.points + jitter * np.sqrt(cloud.area / n) * rng.normal(size=(n, 1)) * cloud.normals
    angle = np.radians(tilt)
    return replace(cloud, points=points, normals=np.cos(angle) * cloud.normals + np.sin(angle) * across)


def twice(cloud):
    """Every point stored twice."""
    cells = None if cloud.cells is None else np.concatenate([cloud.cells, cloud.cells]) / 2
    return Cloud(np.concatenate([cloud.points] * 2), np.concatenate([cloud.normals] * 2), cloud.area, cells)


def vertex_normals(vertices, faces):
    """Area-weighted means of the normals of the faces (f, 3) around each vertex: unit (v, 3), 0 where there is none."""
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], cross)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=normals, where=length > 0)


def harmonics(points):
    """The real spherical harmonics of degree 1 to 4 at unit vectors: (24, n), or None where scipy is missing.

    Each integrates to 0 over the sphere.
    """
    try:
        from scipy.special import sph_harm_y
    except ImportError:
        return None
    theta, phi = np.arccos(np.clip(points[:, 2], -1, 1)), np.arctan2(points[:, 1], points[:, 0])
    degrees = [(degree, order) for degree in range(1, 5) for order in range(-degree, degree + 1)]
    parts = ((sph_harm_y(d, abs(o), theta, phi), o) for d, o in degrees)
    return np.array([(v.real if o >= 0 else v.imag) * (np.sqrt(2) if o else 1.0) for v, o in parts])


def spherical_cells(points):
    """Areas of the Voronoi cells on the unit sphere, or None where scipy is missing."""
    try:
        from scipy.spatial import SphericalVoronoi
    except ModuleNotFoundError:
        return None
    return SphericalVoronoi(points).calculate_areas()


def square_cells(points):
    """Areas of the Voronoi cells (n,) of points (n, 2) in the unit square, or None where scipy is missing."""
    try:
        from scipy.spatial import ConvexHull, Voronoi
    except ModuleNotFoundError:
        return None
    mirrored = [points]
    for axis in range(2):
        for side in (0.0, 1.0):
            image = points.copy()
            image[:, axis] = 2 * side - image[:, axis]
            mirrored.append(image)
    cells = Voronoi(np.concatenate(mirrored))
    corners = (cells.vertices[cells.regions[cells.point_region[k]]] for k in range(len(points)))
    return np.array([ConvexHull(c).volume for c in corners])


def _blue_noise(n, seed):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    return Surfels.sample_mesh((vertices, np.array([[0, 1, 2, 3]])), n, seed=seed).points[:, :2]
