"""What is known exactly: form factors from a point of a surface, factors between surfaces, irradiance by lights.

Arrays of points (m, 3) in, (m,) out. Each function says where it is from; test_cases.py checks them against each other
and against the figures of tables.
"""

import numpy as np


def element_to_polygon(points, normals, corners):
    """Factor from elements to a polygon, (k, 3) or one for each element (m, k, 3), all of it above their horizons.

    Lambert 1760: 1 / (2 pi) sum of angle(v_k, v_k+1) n . unit(v_k x v_k+1), by either orientation.
    """
    v = np.broadcast_to(corners, (len(points), *np.shape(corners)[-2:])) - points[:, None]
    w = np.roll(v, -1, axis=1)
    across = np.cross(v, w)
    sine = np.linalg.norm(across, axis=2)
    angle = np.arctan2(sine, (v * w).sum(axis=2))
    part = angle * (across * normals[:, None]).sum(axis=2) / np.maximum(sine, 1e-300)
    return np.abs(part.sum(axis=1)) / (2 * np.pi)


def element_to_corner(a, b, c):
    """Factor from an element under the corner of a parallel rectangle a x b at distance c (Hottel 1931; Howell B-3)."""
    x, y = np.hypot(a, c), np.hypot(b, c)
    return (a / x * np.arctan(b / x) + b / y * np.arctan(a / y)) / (2 * np.pi)


def element_to_parallel_rectangle(x, y, low, high, distance):
    """The same from an element anywhere at (x, y): four corners, with signs. low, high: (x, y), or arrays of each."""
    (x0, y0), (x1, y1) = low, high
    total = 0.0
    for edge_x, sign_x in ((x1, 1), (x0, -1)):
        for edge_y, sign_y in ((y1, 1), (y0, -1)):
            a, b = edge_x - x, edge_y - y
            total = total + sign_x * sign_y * np.sign(a * b) * element_to_corner(np.abs(a), np.abs(b), distance)
    return total


def element_to_parallel_disk(offset, radius, distance):
    """Factor from an element to a parallel disk, its axis `offset` beside the element (Howell B-14)."""
    z = offset**2 + distance**2 + radius**2
    return 0.5 * (1 - (z - 2 * radius**2) / np.sqrt(z**2 - 4 * radius**2 * offset**2))


def parallel_rectangles(x, y):
    """Factor between equal parallel rectangles of sides x and y over their distance (Howell C-11)."""
    a, b = 1 + x * x, 1 + y * y
    return (
        2
        / (np.pi * x * y)
        * (
            0.5 * np.log(a * b / (1 + x * x + y * y))
            + x * np.sqrt(b) * np.arctan(x / np.sqrt(b))
            + y * np.sqrt(a) * np.arctan(y / np.sqrt(a))
            - x * np.arctan(x)
            - y * np.arctan(y)
        )
    )


def coaxial_disks(from_radius, to_radius, distance):
    """Factor between coaxial disks (Howell C-41)."""
    a, b = from_radius / distance, to_radius / distance
    s = 1 + (1 + b * b) / (a * a)
    return 0.5 * (s - np.sqrt(s * s - 4 * (b / a) ** 2))


def shadow(points, low, high, height, plane):
    """Where the rectangle low..high at `height` stands, seen from points, on the parallel plane z = `plane`.

    Points are at z = points[:, 2]. A parallel plane keeps its shape: scaled by the ratio of distances from the point.
    """
    scale = ((plane - points[:, 2]) / (height - points[:, 2]))[:, None]
    xy = points[:, :2]
    return xy + scale * (np.asarray(low) - xy), xy + scale * (np.asarray(high) - xy)


def intersection(a, b):
    """Of two boxes, (low, high) each, (m, k) or (k,): empty ones have no extent."""
    low = np.maximum(a[0], b[0])
    return low, np.maximum(low, np.minimum(a[1], b[1]))


def smoothstep(x):
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3 - 2 * x)


def point_light(points, normals, position, intensity):
    """I cos / r^2."""
    d = np.asarray(position) - points
    r = np.linalg.norm(d, axis=1)
    return intensity * np.maximum(0.0, (d * normals).sum(axis=1)) / r**3


def spot_light(points, normals, position, direction, intensity, cone, penumbra):
    """I cos / r^2 times smoothstep in angle, from 0 at cone / 2 to 1 at (cone - penumbra) / 2 (DESIGN section 4)."""
    d = points - np.asarray(position)
    cosine = (d @ np.asarray(direction)) / (np.linalg.norm(d, axis=1) * np.linalg.norm(direction))
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    share = smoothstep((cone / 2 - angle) / (penumbra / 2))
    return share * point_light(points, normals, position, intensity)


class Cells:
    """Walls of a scene that goes on for ever along y, in cells of its cross-section (x, z): factors by crossed strings.

    Seen from a point, a segment has the factor (sin b - sin a) / 2 of its angles to the normal, which is Hottel's rule
    for an element. Walls belong to rooms; a cell of another room is seen through the opening between the two as far as
    its angles are those of the opening.
    """

    def __init__(self, walls, opening=None):
        """walls: (from (2,), to (2,), cells, room); their fronts are on the left. opening: two points (2,)."""
        self.ends = np.concatenate(
            [np.array(a) + np.linspace(0, 1, n + 1)[:, None] * (np.array(b) - np.array(a)) for a, b, n, _ in walls]
        )
        first = np.cumsum([0] + [n + 1 for _, _, n, _ in walls])
        index = np.concatenate([f + np.arange(n) for f, (_, _, n, _) in zip(first[:-1], walls, strict=True)])
        self.begin, self.end = self.ends[index], self.ends[index + 1]
        self.wall = np.repeat(np.arange(len(walls)), [n for _, _, n, _ in walls])
        self.room = np.array([room for *_, room in walls])[self.wall]
        self.opening = opening

    def factors(self, points, normals, room):
        """From elements in a room to all cells (m, cells)."""
        low, high = self._sines(points, normals, self.begin, self.end)
        # Of a wall in its own plane nothing is seen, wherever its ends are.
        flat = np.abs(((self.begin - points[:, None]) * normals[:, None]).sum(axis=2)) < 1e-12
        flat &= np.abs(((self.end - points[:, None]) * normals[:, None]).sum(axis=2)) < 1e-12
        high[flat] = low[flat]
        if self.opening is not None:
            a, b = (np.asarray(p, dtype=float)[None] for p in self.opening)
            left, right = self._sines(points, normals, a, b)
            other = self.room != room
            low[:, other] = np.maximum(low[:, other], left)
            high[:, other] = np.minimum(high[:, other], right)
        return 0.5 * np.maximum(0.0, high - low)

    @staticmethod
    def _sines(points, normals, begin, end):
        """Sines of the angles between normals and the way to both ends, the lower first; (m, n) each."""

        def sine(to):
            d = to[None] - points[:, None]
            along = np.stack([-normals[:, 1], normals[:, 0]], axis=1)[:, None]
            above = (d * normals[:, None]).sum(axis=2)
            beside = (d * along).sum(axis=2)
            # Below the horizon is as far as the horizon goes.
            return np.where(above > 1e-12, beside / np.maximum(np.hypot(above, beside), 1e-300), np.sign(beside))

        a, b = sine(begin), sine(end)
        return np.minimum(a, b), np.maximum(a, b)

    @property
    def normals(self):
        d = self.end - self.begin
        return np.stack([-d[:, 1], d[:, 0]], axis=1) / np.linalg.norm(d, axis=1)[:, None]

    def radiosity(self, rho, emission):
        """B of every cell, from B = E + rho F B; rho and emission (cells,)."""
        middle, normals = 0.5 * (self.begin + self.end), self.normals
        f = np.zeros((len(middle), len(middle)))
        for room in np.unique(self.room):
            here = self.room == room
            f[here] = self.factors(middle[here], normals[here], room)
        return np.linalg.solve(np.eye(len(f)) - rho[:, None] * f, emission)
