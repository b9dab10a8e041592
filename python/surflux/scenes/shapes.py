"""Shapes that scene files can name, as polygons or as points with exact normals."""

from itertools import combinations

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage
from surflux.points.surfels import Surfels

MOST_SURFELS = 20_000_000
SAMPLES_AT_ONCE = 1 << 18  # of shapes that are made from formulas, whose evaluation takes some hundred bytes each
SIDES = ("left", "right", "front", "back", "floor", "ceiling")


def box(size=(1.0, 1.0, 1.0), patches=1, inward=False):
    """A box from the origin to size, each side a grid of quadrilaterals.

    Args:
        size: (3,) or one number.
        patches: cells along each edge: one number, or three for the edges along x, y and z.
        inward: True for a room: the sides face its inside.

    Returns:
        (vertices (v, 3), faces (f, 4), side (f,)), where side indexes SIDES: left is low x, right high x, front low
        y, back high y, floor low z, ceiling high z.
    """
    size = _size("size", size, 3)
    cells = _cells("patches", patches, 3)
    vertices, faces, sides = [], [], []
    first = 0
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3  # a x b points along +axis
        for high in (False, True):
            edge_a, edge_b = np.zeros(3), np.zeros(3)
            edge_a[a], edge_b[b] = size[a], size[b]
            corner = np.zeros(3)
            corner[axis] = size[axis] if high else 0.0
            if high != inward:
                grid = _grid(corner, edge_a, edge_b, cells[a], cells[b])
            else:
                grid = _grid(corner, edge_b, edge_a, cells[b], cells[a])
            vertices.append(grid[0])
            faces.append(grid[1] + first)
            sides.append(np.full(len(grid[1]), 2 * axis + high))
            first += len(grid[0])
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(sides)


def rectangle(corner=(0.0, 0.0, 0.0), edge_u=(1.0, 0.0, 0.0), edge_v=(0.0, 1.0, 0.0), patches=1):
    """A rectangle that faces along edge_u x edge_v: (vertices, faces (f, 4)); patches along u and v, or one number."""
    cells = _cells("patches", patches, 2)
    u, v = check.positions("edge_u", edge_u), check.positions("edge_v", edge_v)
    if np.linalg.norm(np.cross(u, v)) <= 1e-9 * max(np.linalg.norm(u), np.linalg.norm(v)) ** 2:
        raise ValueError("edge_v: wanted a vector that spans an area with edge_u")
    return _grid(check.positions("corner", corner), u, v, *cells)


def icosphere(level):
    """The unit icosphere: (points (10 * 4^level + 2, 3), faces (20 * 4^level, 3))."""
    golden = (1 + np.sqrt(5)) / 2
    points = np.array([(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)], float)
    points = np.concatenate([points, np.roll(points, 1, axis=1), np.roll(points, 2, axis=1)])
    # The faces of an icosahedron are its triples of corners at edge length 2, turned to the outside.
    edge = np.linalg.norm(points[:, None] - points[None], axis=2) < 2.1
    i, j, k = np.nonzero(np.ones((12, 12, 12), bool))
    keep = (i < j) & (j < k) & edge[i, j] & edge[j, k] & edge[i, k]
    faces = np.stack([i[keep], j[keep], k[keep]], axis=1)
    turned = np.linalg.det(points[faces]) < 0
    faces[turned] = faces[turned][:, ::-1]
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(level):
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, middle = np.unique(edges, axis=0, return_inverse=True)
        middle = middle.reshape(-1, 3) + len(points)
        new = points[unique].sum(axis=1)
        points = np.concatenate([points, new / np.linalg.norm(new, axis=1, keepdims=True)])
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        faces = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return points, faces


def icosphere_level(points):
    """The level whose icosphere has that many points, or None."""
    level = round(np.log(max(points - 2, 1) / 10) / np.log(4))
    return level if level >= 0 and 10 * 4**level + 2 == points else None


def sphere(points=642, radius=1.0):
    """Surfels on a sphere around the origin with exact normals: an icosphere where points = 10 * 4^k + 2, else a
    Fibonacci lattice."""
    points = check.count("points", points, 12, MOST_SURFELS)
    radius = check.length("radius", radius)
    level = icosphere_level(points)
    if level is not None:
        unit = icosphere(level)[0]
    else:
        k = np.arange(points) + 0.5
        z, phi = 1.0 - 2.0 * k / points, np.pi * (1 + np.sqrt(5)) * k
        ring = np.sqrt(1.0 - z * z)
        unit = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=1)
    return Surfels(radius * unit, unit)


def blob(points=3000, radius=1.0, bumps=0.25, seed=0):
    """Surfels on a rounded boulder: a sphere around the origin whose radius swells by smooth seeded waves.

    radius (1 + bumps w(d)) in direction d, where w is a mean of waves sin(f . d + p) with seeded f and p.
    """
    radius = check.length("radius", radius)
    bumps = check.number("bumps", bumps, 0.0, 0.9)
    random = np.random.default_rng(check.seed("seed", seed))
    wave = random.normal(size=(12, 3)) * 2.2
    phase = random.uniform(0, 2 * np.pi, 12)

    def evaluate(d):
        d = d / np.linalg.norm(d, axis=1, keepdims=True)
        angle = d @ wave.T + phase
        r = radius * (1 + bumps * np.sin(angle).mean(axis=1))
        gradient = radius * bumps * (np.cos(angle) @ wave) / len(wave)
        # The surface is where |p| - r(p / |p|) is 0; its gradient is d minus what r changes sideways, over |p|.
        sideways = gradient - (gradient * d).sum(axis=1, keepdims=True) * d
        normal = d - sideways / r[:, None]
        return r[:, None] * d, normal / np.linalg.norm(normal, axis=1, keepdims=True)

    directions, faces = icosphere(5)
    return _sampled(evaluate, directions[faces], points, seed)


def knot(points=3000, radius=1.0, tube=0.28, swelling=0.3, windings=(2, 3), seed=0):
    """Surfels on a tube around a torus knot whose thickness swells along it, around the origin.

    Args:
        radius: of the torus that the knot lies on; its tube has 0.45 of it.
        tube: mean radius of the knot's own tube, in the same unit; 1e-4 to 1e4 times radius.
        swelling: share, 0 to below 1, by which the tube's radius rises and falls, five times around.
        windings: coprime (p, q), up to 1000: p turns around the axis, q around the torus.
    """
    radius = check.length("radius", radius)
    tube = check.number("tube", tube, 1e-4 * radius, 1e4 * radius)  # thinner, its parameters are lost in rounding
    swelling = check.number("swelling", swelling, 0.0, 1.0, high_open=True)
    if not isinstance(windings, tuple | list) or len(windings) != 2:
        raise ValueError(f"windings: wanted two whole numbers, got {windings!r}")
    p, q = (check.count("windings", w, 1, 1000) for w in windings)
    if np.gcd(p, q) != 1:
        raise ValueError(f"windings: wanted two numbers without a common divisor, got {p} and {q}")
    minor = 0.45 * radius

    def surface(t, phi):
        cos_p, sin_p, cos_q, sin_q = np.cos(p * t), np.sin(p * t), np.cos(q * t), np.sin(q * t)
        ring, zero = radius + minor * cos_q, np.zeros_like(t)
        center = np.stack([ring * cos_p, ring * sin_p, minor * sin_q], axis=1)
        # The torus's normal is perpendicular to the curve everywhere, so it carries a frame without a twist or seam.
        out = np.stack([cos_q * cos_p, cos_q * sin_p, sin_q], axis=1)
        along_p = np.stack([-sin_p, cos_p, zero], axis=1) * (p * ring)[:, None]
        along_q = np.stack([-sin_q * cos_p, -sin_q * sin_p, cos_q], axis=1) * (q * minor)
        tangent = along_p + along_q
        side = np.cross(tangent / np.linalg.norm(tangent, axis=1, keepdims=True), out)
        thick = tube * (1 + swelling * np.sin(5 * t + 1.0))
        return center + thick[:, None] * (np.cos(phi)[:, None] * out + np.sin(phi)[:, None] * side)

    def evaluate(uv):
        t, phi, step = uv[:, 0], uv[:, 1], 1e-5
        by_t = surface(t + step, phi) - surface(t - step, phi)
        by_phi = surface(t, phi + step) - surface(t, phi - step)
        normal = np.cross(by_phi, by_t)
        return surface(t, phi), normal / np.linalg.norm(normal, axis=1, keepdims=True)

    along, around = 360, 36
    i, j = np.divmod(np.arange(along * around), around)
    corner = [
        np.stack([(i + a) * 2 * np.pi / along, (j + b) * 2 * np.pi / around], axis=1) for a in (0, 1) for b in (0, 1)
    ]
    triangles = np.concatenate([np.stack([corner[k] for k in ks], axis=1) for ks in ((0, 1, 3), (0, 3, 2))])
    return _sampled(evaluate, triangles, points, seed)


def _sampled(evaluate, triangles, points, seed):
    """Blue-noise surfels on the surface evaluate(parameters) -> (points, normals), meshed by triangles (t, 3, k)."""
    points, seed = check.count("points", points, 12, MOST_SURFELS), check.seed("seed", seed)
    corners = evaluate(triangles.reshape(-1, triangles.shape[2]))[0].reshape(-1, 3, 3)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    flat, index = _core.sample_triangles(corners, 5 * points, seed)

    def at(samples):
        return evaluate(_parameters(flat[samples], corners[index[samples]], triangles[index[samples]]))

    position = np.empty_like(flat)
    for first in range(0, len(flat), SAMPLES_AT_ONCE):
        block = slice(first, first + SAMPLES_AT_ONCE)
        position[block] = at(block)[0]
    kept = _core.eliminate_samples(position, points, float(area), seed, progress=stage("samples"))
    del position
    return Surfels(*at(kept))


def _parameters(points, corners, parameters):
    """Parameters at points of triangles, interpolated between those of the corners."""
    e1, e2, d = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    a11, a12, a22 = ((x * y).sum(axis=1) for x, y in ((e1, e1), (e1, e2), (e2, e2)))
    b1, b2 = (d * e1).sum(axis=1), (d * e2).sum(axis=1)
    det = a11 * a22 - a12 * a12
    u, v = ((a22 * b1 - a12 * b2) / det)[:, None], ((a11 * b2 - a12 * b1) / det)[:, None]
    return (1 - u - v) * parameters[:, 0] + u * parameters[:, 1] + v * parameters[:, 2]


def _grid(corner, edge_u, edge_v, m, n):
    """m x n quadrilaterals of the rectangle, counter-clockwise about edge_u x edge_v."""
    i, j = np.divmod(np.arange((m + 1) * (n + 1)), n + 1)
    vertices = corner + (i / m)[:, None] * edge_u + (j / n)[:, None] * edge_v
    i, j = np.divmod(np.arange(m * n), n)
    first = i * (n + 1) + j
    return vertices, np.stack([first, first + n + 1, first + n + 2, first + 1], axis=1)


def _size(name, value, sides):
    array = check.numeric(name, value)
    array = check.positions(name, array.reshape(1).repeat(sides) if array.ndim == 0 else array, (sides,))
    return check.in_range(name, array, 0.0, low_open=True)


def _cells(name, value, sides):
    values = [value] * sides if np.ndim(value) == 0 else list(value)
    if len(values) != sides:
        raise ValueError(f"{name}: wanted one whole number or {sides}, got {len(values)}")
    cells = [check.count(name, v, 1, 10_000) for v in values]
    if (total := sum(a * b for a, b in combinations(cells, 2)) * (2 if sides == 3 else 1)) > MOST_SURFELS:
        raise ValueError(f"{name}: wanted at most {MOST_SURFELS} cells in all, got {total}")
    return cells
