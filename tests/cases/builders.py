"""Surfaces for cases and tests, as patches of a mesh or as points whose areas and radii are left to surflux."""

import numpy as np

import surflux as sf
from surflux.scenes import shapes

GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


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


def together(*clouds):
    """Points of one object: where their surfaces meet, effective areas end at the crease."""
    arrays = (np.concatenate([getattr(s, name) for s in clouds]) for name in ("points", "normals"))
    rho, emission = (np.concatenate([getattr(s, name) for s in clouds]) for name in ("reflectance", "emission"))
    return surfels_of(*arrays, rho, emission)


def rectangle(corner, u, v, cells, kind="patches", rho=0.0, emission=0.0):
    """cells[0] x cells[1] patches of a rectangle that faces along u x v; or as many points, an open border around them.

    Effective areas take a cloud to end .05 of its spacing beyond the outermost points, so that is where these stand.
    """
    if kind == "patches":
        return sf.Surfels.from_mesh(shapes.rectangle(corner, u, v, cells), reflectance=rho, emission=emission)
    s, t = ((np.arange(n) + 0.05) / (n - 0.9) for n in cells)
    corner, u, v = (np.array(x, dtype=float) for x in (corner, u, v))
    points = (corner + s[:, None, None] * u + t[None, :, None] * v).reshape(-1, 3)
    normal = np.cross(u, v)
    return surfels_of(points, np.tile(normal / np.linalg.norm(normal), (len(points), 1)), rho, emission)


def strips(corner, along, at, across, cells, rho=0.0, emission=0.0, two_sided=False):
    """A long wall: cells along `across`, cut along the unit vector `along` at the given coordinates; patches.

    Faces along `along` x `across`.
    """
    along, across, corner = (np.array(x, dtype=float) for x in (along, across, corner))
    at, t = np.asarray(at, dtype=float), np.linspace(0, 1, cells + 1)
    vertices = corner + at[:, None, None] * along + t[None, :, None] * across
    i, j = (x.ravel() for x in np.meshgrid(np.arange(len(at) - 1), np.arange(cells), indexing="ij"))
    first = i * (cells + 1) + j
    faces = np.stack([first, first + cells + 1, first + cells + 2, first + 1], axis=1)
    mesh = (vertices.reshape(-1, 3), faces)
    return sf.Surfels.from_mesh(mesh, reflectance=rho, emission=emission, two_sided=two_sided)


def disk(radius, height, facing, n, kind="patches", rho=0.0, emission=0.0):
    """A disk around the z axis that faces along z (1) or against it (-1).

    Patches: n rings of quadrilaterals between regular polygons of as much area as the circles (6 n corners), with
    triangles in the middle. Points: 3 n^2 of them on a sunflower, which stand for equal areas.
    """
    if kind == "points":
        k = np.arange(3 * n * n) + 0.5
        r, angle = radius * np.sqrt(k / len(k)), GOLDEN_ANGLE * k
        points = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(len(k), height)], axis=1)
        return surfels_of(points, np.tile([0.0, 0.0, facing], (len(k), 1)), rho, emission)
    sides = 6 * n
    vertices = [np.zeros((1, 2))]
    vertices += [radius * (k + 1) / n * equal_area_polygon(sides) for k in range(n)]
    ring = np.arange(sides)
    after = (ring + 1) % sides
    faces = [[0, 1 + a, 1 + b] for a, b in zip(ring, after, strict=True)]
    for k in range(n - 1):
        low, high = 1 + k * sides, 1 + (k + 1) * sides
        faces += [[low + a, high + a, high + b, low + b] for a, b in zip(ring, after, strict=True)]
    vertices = np.concatenate(vertices)
    vertices = np.column_stack([vertices, np.full(len(vertices), height)])
    return sf.Surfels.from_mesh((vertices, turned(faces, facing)), reflectance=rho, emission=emission)


def tube(radius, height, n, kind="patches", rho=0.0, emission=0.0):
    """The side of a cylinder around the z axis from 0 to height, facing its inside.

    Patches: a prism of 6 n sides, of the polygon that disk() has. Points: on a grid of as many.
    """
    sides, rows = 6 * n, max(1, round(n * height / radius))
    if kind == "points":
        j, i = np.divmod(np.arange(sides * rows), sides)
        angle = 2 * np.pi * (i + 0.5 * (j % 2)) / sides
        out = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
        return surfels_of(radius * out + np.outer((j + 0.5) * height / rows, [0, 0, 1]), -out, rho, emission)
    around = radius * equal_area_polygon(sides)
    vertices = np.concatenate([np.column_stack([around, np.full(sides, height * k / rows)]) for k in range(rows + 1)])
    j, i = np.divmod(np.arange(sides * rows), sides)
    a, b = j * sides + i, j * sides + (i + 1) % sides
    faces = np.stack([a, a + sides, b + sides, b], axis=1)
    return sf.Surfels.from_mesh((vertices, faces), reflectance=rho, emission=emission)


def ball(n, radius=1.0, center=(0, 0, 0), sign=1, kind="points", rho=0.0, emission=0.0):
    """A sphere that faces outwards (1) or inwards (-1): n Fibonacci points, or the faces of an icosphere, level n."""
    if kind == "points":
        return ball_inside(n, radius, center, rho, emission, sign)
    points, faces = shapes.icosphere(n)
    vertices = radius * points + np.array(center, dtype=float)
    return sf.Surfels.from_mesh((vertices, turned(faces, sign)), reflectance=rho, emission=emission)


def equal_area_polygon(sides):
    """Corners of the regular polygon that has the unit circle's area (sides, 2)."""
    angle = 2 * np.pi * np.arange(sides) / sides
    reach = np.sqrt(2 * np.pi / (sides * np.sin(2 * np.pi / sides)))
    return reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def turned(faces, sign):
    return [face[::-1] for face in faces] if sign < 0 else faces


def elements(points, normals, size=1e-3, rho=0.0):
    """Square patches so small that they are points to all else (n, 3), each of its own object."""
    out = []
    for p, n in zip(np.atleast_2d(points), np.atleast_2d(normals), strict=True):
        n = np.asarray(n, dtype=float)
        u = np.cross(n, [0, 0, 1] if abs(n[2]) < 0.5 else [1, 0, 0])
        u *= size / np.linalg.norm(u)
        v = np.cross(n, u)
        out.append(patch(np.asarray(p, dtype=float) - 0.5 * (u + v), u, v, rho))
    return out
