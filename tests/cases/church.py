"""A church as one mesh: thin, doubled, open and curved walls, and dark rooms behind them."""

import itertools

import numpy as np

import surflux as sf

X, Y, Z = np.eye(3)

# Rooms that no light gets into, low and high corner: a sacristy behind panes of 3 cm, a crypt 3 cm below the floor, a
# cupboard of boards with two faces 3 cm apart, a confessional of single sheets that face in, and a shrine of sheets
# without thickness that have a face each way.
DARK_ROOMS = {
    "sacristy": ((0.0, 3.4, 0.0), (4.0, 6.0, 5.0)),
    "crypt": ((8.0, -2.0, -2.5), (14.0, 2.0, -0.03)),
    "cupboard": ((17.03, 5.23, 0.03), (18.17, 5.77, 1.97)),
    "confessional": ((10.0, -5.8, 0.0), (11.5, -4.6, 2.2)),
    "shrine": ((20.5, -1.0, 0.0), (21.5, 1.0, 1.5)),
}


class _Masonry:
    def __init__(self, seed, size):
        self.random = np.random.default_rng(seed)
        self.size = size
        self.corners = []  # of triangles

    def quad(self, a, b, c, d):
        a, b, c, d = (np.asarray(p, dtype=float) for p in (a, b, c, d))
        if self.random.random() < 0.5:
            a, b, c, d = b, c, d, a
        self.corners += [(a, b, c), (a, c, d)]

    def panel(self, corner, u, v, size=None):
        """A rectangle that faces along u x v, cut at random until no side is longer than about a size."""
        size = size or self.size
        corner, u, v = (np.asarray(w, dtype=float) for w in (corner, u, v))
        longest = max(np.linalg.norm(u), np.linalg.norm(v))
        if longest <= size * self.random.uniform(0.5, 1.5):
            return self.quad(corner, corner + u, corner + u + v, corner + v)
        share = self.random.uniform(0.3, 0.7)
        if np.linalg.norm(u) >= np.linalg.norm(v):
            self.panel(corner, share * u, v, size)
            self.panel(corner + share * u, (1 - share) * u, v, size)
        else:
            self.panel(corner, u, share * v, size)
            self.panel(corner + share * v, u, (1 - share) * v, size)

    def tiled(self, corner, u, v, along_u, along_v):
        """A panel in rows and columns that end at given lengths."""
        corner = np.asarray(corner, dtype=float)
        p, q = (np.asarray(w, dtype=float) / np.linalg.norm(w) for w in (u, v))
        rows, columns = ([0.0, *a, np.linalg.norm(w)] for a, w in ((along_u, u), (along_v, v)))
        for a, b in itertools.pairwise(rows):
            for c, d in itertools.pairwise(columns):
                self.panel(corner + a * p + c * q, (b - a) * p, (d - c) * q)

    def pierced(self, corner, u, v, holes, size=None):
        """A panel with rectangular holes, given in shares of u: (from, to), and of v: the same for all holes."""
        corner, u, v = (np.asarray(w, dtype=float) for w in (corner, u, v))
        (along, (low, high)) = holes
        self.panel(corner, u, low * v, size)
        self.panel(corner + high * v, u, (1 - high) * v, size)
        last = 0.0
        for begin, end in [*along, (1.0, 1.0)]:
            if begin > last:
                self.panel(corner + last * u + low * v, (begin - last) * u, (high - low) * v, size)
            last = end

    def box(self, low, high, size=None, inwards=False):
        low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        e = np.diag(high - low)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            a, b = (e[i], e[j]) if inwards else (e[j], e[i])
            self.panel(low, a, b, size)
            self.panel(low + e[k], b, a, size)

    def both_ways(self, since):
        """Gives what was added since then a back at the same place."""
        self.corners += [(a, c, b) for a, b, c in self.corners[since:]]

    def mesh(self):
        corners = np.array(self.corners).reshape(-1, 3)
        return corners, np.arange(len(corners)).reshape(-1, 3)


def _column(build, x, y, radius, height, sides=12):
    angles = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles)], axis=1)
    for p, q in itertools.pairwise(ring):
        for low, high in ((0.0, 0.4 * height), (0.4 * height, height)):
            build.quad([*p, low], [*q, low], [*q, high], [*p, high])


def _arcade(build, y, bays, width, spring, top, half):
    """Columns, arches with a barrel below each, and a spandrel with a face on either side; without backs in between."""
    steps = 12
    angles = np.pi - np.pi * np.arange(steps + 1) / steps
    for bay in range(bays):
        left = bay * width
        if bay + 1 < bays:
            _column(build, left + width, y, half, spring)
        middle, radius = left + 0.5 * width, 0.5 * width - half
        arc = np.stack([middle + radius * np.cos(angles), spring + radius * np.sin(angles)], axis=1)
        for p, q in itertools.pairwise(arc):
            build.quad([p[0], y - half, p[1]], [p[0], y + half, p[1]], [q[0], y + half, q[1]], [q[0], y - half, q[1]])
            low, high = [p[0], 0, p[1]], [q[0], 0, q[1]]
            for at, front in ((y + half, True), (y - half, False)):
                a, b = np.array(low) + at * Y, np.array(high) + at * Y
                c, d = np.array([q[0], at, top]), np.array([p[0], at, top])
                build.quad(b, a, d, c) if front else build.quad(a, b, c, d)
        for begin, end in ((left, left + half), (left + width - half, left + width)):
            for at, sign in ((y + half, -1), (y - half, 1)):
                corner = [begin if sign > 0 else end, at, spring]
                build.panel(corner, sign * (end - begin) * X, (top - spring) * Z)
            build.panel([begin, y - half, spring], 2 * half * Y, (end - begin) * X)


def _apse(build, x, radius, height, top, steps=10):
    """A half cylinder and a half dome on it, single sheets that face in, and the wall that they open in."""
    angles = np.pi / 2 - np.pi * np.arange(steps + 1) / steps
    tilts = np.pi / 2 * np.arange(6) / 5

    def at(angle, tilt):
        flat = radius * np.cos(tilt)
        return np.array([x + flat * np.cos(angle), flat * np.sin(angle), height + radius * np.sin(tilt)])

    levels = np.linspace(0.0, 1.0, 4)
    for a, b in itertools.pairwise(angles):
        p, q = at(a, 0), at(b, 0)
        ground = np.array([1.0, 1.0, 0.0])
        for low, high in itertools.pairwise(levels):
            low, high = np.array([1, 1, low]), np.array([1, 1, high])
            build.quad(p * low, q * low, q * high, p * high)
        build.corners.append((x * X, q * ground, p * ground))
        for s, t in itertools.pairwise(tilts[:-1]):
            build.quad(at(a, s), at(b, s), at(b, t), at(a, t))
        build.corners.append((at(a, tilts[-2]), at(b, tilts[-2]), (height + radius) * Z + x * X))
        y, z = radius * np.sin([a, b]), height + radius * np.cos([a, b])
        build.quad([x, y[0], z[0]], [x, y[1], z[1]], [x, y[1], top], [x, y[0], top])


def mesh(size=1.5, seed=0, aligned=True):
    """(vertices, faces). Nave along x from 0 to 24, 9 high; aisles to |y| = 6, 5 high; an apse at x = 24."""
    build = _Masonry(seed, size)
    # Floor, below all that stands on it, and ceilings that face down. What the dark rooms have of them ends with them.
    rooms = [DARK_ROOMS[name] for name in ("sacristy", "cupboard", "confessional", "shrine")]
    beside_x, beside_y = (sorted({p[k] for room in rooms for p in room} - {0.0, 6.0}) for k in (0, 1))
    beside_y.append(5.97)  # the panelling
    if aligned:
        build.tiled([0, -6, 0], 24 * X, 12 * Y, beside_x, [y + 6 for y in beside_y])
    else:
        build.panel([0, -6, 0], 24 * X, 12 * Y)
    build.tiled([0, -3, 9], 6 * Y, 24 * X, [0.3, 5.7], [])
    build.tiled([0, -6, 5], 3.3 * Y, 24 * X, [2.7], [])
    build.tiled([0, 2.7, 5], 3.3 * Y, 24 * X, [0.6, 0.7], [4.0])
    # Walls with a face inside and one outside, .4 m apart, and windows with nothing in them to the south.
    windows = [(k / 6 + 0.05, k / 6 + 0.11) for k in range(6)], (0.4, 0.8)
    build.pierced([0, -6.4, 0], 24 * X, 5 * Z, windows)
    build.pierced([24, -6, 0], -24 * X, 5 * Z, ([(1 - b, 1 - a) for a, b in windows[0][::-1]], windows[1]))
    build.tiled([0, 6, 0], 24 * X, 5 * Z, [4.0], [])
    build.panel([24, 6.4, 0], -24 * X, 5 * Z)
    build.tiled([0, -3, 0], 6 * Y, 9 * Z, [0.3, 5.7], [])
    build.panel([-0.4, 3, 0], -6 * Y, 9 * Z)
    build.tiled([0, -6, 0], 3 * Y, 5 * Z, [2.7], [])
    build.tiled([0, 3, 0], 3 * Y, 5 * Z, [0.3, 0.4], [])
    # Panelling 3 cm before a wall that goes on behind it: both face the same way. It ends at the wall.
    build.panel([5, 5.97, 0], 2.5 * X, 2 * Z)
    for corner, u, v in (
        ([5, 6, 0], -0.03 * Y, 2 * Z),
        ([7.5, 5.97, 0], 0.03 * Y, 2 * Z),
        ([5, 5.97, 2], 2.5 * X, 0.03 * Y),
    ):
        build.panel(corner, u, v)
    for y in (-6, 2.7):
        build.panel([24, y, 0], 5 * Z, 3.3 * Y)
    for y in (-3, 3):
        _arcade(build, y, bays=6, width=4.0, spring=2.4, top=5.0, half=0.3)
    # The clerestory: faces both ways, without thickness, and windows to the south.
    since = len(build.corners)
    build.pierced([24, -2.7, 5], -24 * X, 4 * Z, windows)
    build.panel([0, 2.7, 5], 24 * X, 4 * Z)
    build.both_ways(since)
    _apse(build, 24.0, 2.7, 6.0, 9.0)
    # Panes of 3 cm: between bays of the north aisle, open above, and around the sacristy.
    for x in (8.0, 12.0, 16.0):
        build.box([x, 3.3, 0], [x + 0.03, 6, 3])
    build.box([4, 3.37, 0], [4.03, 6, 5])
    build.box([0, 3.37, 0], [4, 3.4, 5])
    build.box(*DARK_ROOMS["crypt"], inwards=True)
    build.box([17, 5.2, 0], [18.2, 5.8, 2], 0.5)
    build.box(*DARK_ROOMS["cupboard"], 0.5, inwards=True)
    build.box(*DARK_ROOMS["confessional"], 0.6, inwards=True)
    since = len(build.corners)
    build.box(*DARK_ROOMS["shrine"], 0.6)
    build.panel([19, -2.2, 0], 4.4 * Y, 2.5 * Z)  # a screen before it
    build.both_ways(since)
    return build.mesh()


def lights():
    """The sun through the south windows, a lamp below the ceiling of the nave and one in the apse."""
    return [
        sf.DirectionalLight([0.2, 0.75, -0.6], 20.0),
        sf.AreaLight([6, -1, 8.9], 2 * Y, 4 * X, 30.0),
        sf.PointLight([25.5, 0, 4], 40.0),
    ]


def scene(size=1.5, patch_area=None, seed=0, reflectance=0.6, aligned=True):
    """The church in its light."""
    church = sf.Surfels.from_mesh(mesh(size, seed, aligned), patch_area=patch_area, reflectance=reflectance)
    return sf.Scene([church], lights())
