"""Light from one surface to others, open all around: plates, disks, small elements; free, and with something between.

All is black, and one surface glows with M = 1, so that H is the form factor from there to it.
"""

import numpy as np

import surflux as sf
from cases import closed_forms
from cases.builders import disk, elements, rectangle
from cases.case import Case, Problem, Wanted, knobs


def rays(kind, n):
    """Where pairs are blocked in part, their noise falls with h in patches; it is far below other errors in points."""
    return knobs(8 * n * n if kind == "patches" else 256)


def plates(kind):
    """1 x 2 at distance .5; the lower one glows."""

    def build(n):
        low = rectangle([0, 0, 0], [1, 0, 0], [0, 2, 0], (n, 2 * n), kind, emission=1.0)
        high = rectangle([0, 0, 0.5], [0, 2, 0], [1, 0, 0], (2 * n, n), kind)

        def from_below(points, _):
            return closed_forms.element_to_parallel_rectangle(points[:, 0], points[:, 1], (0, 0), (1, 2), 0.5)

        top = slice(len(low), None)
        wanted = [Wanted(top, from_below), Wanted(top, 0.5089886690, mean=True), Wanted(slice(0, len(low)), 0.0)]
        return Problem(sf.Scene([low, high]), wanted, quality=rays(kind, n))

    return build


def disks(kind, radius):
    """Coaxial, at distance 1: the lower one of radius 1 glows, and the upper one has the radius given."""

    def build(n):
        low = disk(1.0, 0.0, 1, n, kind, emission=1.0)
        high = disk(radius, 1.0, -1, n, kind)

        def from_below(points, _):
            return closed_forms.element_to_parallel_disk(np.hypot(points[:, 0], points[:, 1]), 1.0, 1.0)

        mean = {1.0: 0.3819660113, 0.5: 0.1172177815 / 0.25}[radius]  # A1 F12 = A2 F21
        top = slice(len(low), None)
        wanted = [Wanted(top, from_below), Wanted(top, mean, mean=True)]
        return Problem(sf.Scene([low, high]), wanted, quality=rays(kind, n))

    return build


def elements_and_disk(kind):
    """Elements under a disk: on its axis, and around it halfway to the rim."""

    def build(n):
        lamp = disk(1.0, 1.0, -1, n, kind, emission=1.0)
        angle = 2 * np.pi * (np.arange(8) + 0.3) / 8
        around = 0.5 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        small = elements(np.concatenate([[[0, 0, 0]], around]), [[0, 0, 1]] * 9)
        m = len(lamp)
        wanted = [Wanted(slice(m, m + 1), 0.5), Wanted(slice(m + 1, None), 0.4379826327)]
        return Problem(sf.Scene([lamp, *small]), wanted, quality=rays(kind, n))

    return build


def elements_and_square(kind, upright):
    """Elements under the corners of a square, parallel to it or at a right angle."""

    def build(n):
        lamp = rectangle([0, 0, 1], [0, 1, 0], [1, 0, 0], (n, n), kind, emission=1.0)
        normals = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]] if upright else [[0, 0, 1]] * 4
        small = elements([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], normals)
        wanted = [Wanted(slice(len(lamp), None), 0.0557341970 if upright else 0.1385316060)]
        return Problem(sf.Scene([lamp, *small]), wanted, quality=rays(kind, n))

    return build


def squares_with_one_between(kind):
    """A square lamp over a square floor, and a smaller square halfway, which hides part of the lamp from all of it."""
    height, plane = 0.5, 1.0
    low, high = np.array([0.3, 0.3]), np.array([0.7, 0.7])

    def build(n):
        lamp = rectangle([0, 0, plane], [0, 1, 0], [1, 0, 0], (n, n), kind, emission=1.0)
        floor = rectangle([0, 0, 0], [1, 0, 0], [0, 1, 0], (n, n), kind)
        m = round(0.4 * n) if kind == "patches" else n  # so that its disks do not overhang more than they must
        between = rectangle([0.3, 0.3, height], [0.4, 0, 0], [0, 0.4, 0], (m, m), kind)

        def free_part(points, _):
            x, y = points[:, 0], points[:, 1]
            hidden = closed_forms.shadow(points, low, high, height, plane)
            left, right = closed_forms.intersection(hidden, (np.zeros(2), np.ones(2)))
            of = closed_forms.element_to_parallel_rectangle
            return of(x, y, (0, 0), (1, 1), plane) - of(x, y, left.T, right.T, plane)

        wanted = [Wanted(slice(n * n, 2 * n * n), free_part)]
        return Problem(sf.Scene([lamp, floor, between]), wanted, quality=rays(kind, n))

    return build


def disks_with_one_between(n):
    """A lamp of radius 1 over a floor of radius .45 at distance 1, and a disk of radius .25 halfway."""
    lamp = disk(1.0, 1.0, -1, n, emission=1.0)
    floor = disk(0.45, 0.0, 1, n // 2)
    between = disk(0.25, 0.5, 1, n // 2)

    def free_part(points, _):
        a = np.hypot(points[:, 0], points[:, 1])
        of = closed_forms.element_to_parallel_disk
        # From (a, 0) the disk stands before one of radius .5 around (-a, 0): all of it within the lamp for a <= .5.
        return of(a, 1.0, 1.0) - of(2 * a, 0.5, 1.0)

    wanted = [Wanted(slice(len(lamp), len(lamp) + len(floor)), free_part)]
    return Problem(sf.Scene([lamp, floor, between]), wanted, quality=rays("patches", n))


EXACT = "The exchange of patches is exact to some 1e-7 and kept in float; rows of patches tell what escapes. "
FLOATS = "rounding to float, and in elements their own size, 1e-3, squared"
POLYGONS = "The regular polygons have the disks' areas, and differ from them by h^4. "
BORDERS = (
    "Beyond the outermost points disks are black, as no area stands for what reaches past them; areas and rims of a "
    "cloud are themselves found to order 1. "
)
PLATES = "Howell C-11: .5089886690 for 1 x 2 at .5; B-3 by corners from every point. "
DISKS = "Howell C-41: .3819660113 for radii 1 and 1 at distance 1, .1172177815 from 1 to .5; B-14 from every point. "
ELEMENTS = "Howell B-14: .5 on axis, .4379826327 halfway to the rim. "
PARALLEL, UPRIGHT = "Howell B-3: .1385316060. ", "Howell B-4: .0557341970. "
BETWEEN = (
    "What is between hides from a point the part of the lamp on which it stands from there, its own shape enlarged as "
    "planes are parallel: the factor to the lamp less the factor to that part (closed_forms.shadow). "
)
PARTLY = "Pairs that see each other in part are found free or not by few rays each. "
FEW_RAYS = "noise of so few rays per pair, which hardly falls before there are many pairs"

CASES = [
    Case("plates, patches", plates("patches"), (4, 8, 16), PLATES + EXACT, 6e-6, floor=FLOATS, factors=4e-10),
    Case("plates, points", plates("points"), (6, 10, 16), PLATES + BORDERS, 1.3e-2, 0.5, off=None),
    Case("equal disks, patches", disks("patches", 1.0), (3, 5, 9), DISKS + POLYGONS, 2.5e-6, 2.5),
    Case("equal disks, points", disks("points", 1.0), (5, 8, 13), DISKS + BORDERS, 2.5e-2, 1.1, off=None),
    Case("unequal disks, patches", disks("patches", 0.5), (3, 5, 9), DISKS + POLYGONS, 1.2e-6, 2.5),
    Case("unequal disks, points", disks("points", 0.5), (5, 8, 13), DISKS + BORDERS, 2e-2, 1.1, off=None),
    Case("elements under a disk, patches", elements_and_disk("patches"), (3, 6, 12), ELEMENTS + POLYGONS, 6e-7, 2.5),
    Case(
        "elements under a disk, points",
        elements_and_disk("points"),
        (5, 9, 16),
        ELEMENTS + BORDERS,
        4e-3,
        1.5,
        off=None,
    ),
    Case(
        "elements under a square, patches",
        elements_and_square("patches", False),
        (4, 8, 16),
        PARALLEL + EXACT,
        3e-7,
        floor=FLOATS,
    ),
    Case(
        "elements under a square, points",
        elements_and_square("points", False),
        (6, 12, 24),
        PARALLEL + BORDERS,
        7e-3,
        0.6,
        off=None,
    ),
    Case(
        "upright elements under a square, patches",
        elements_and_square("patches", True),
        (4, 8, 16),
        UPRIGHT + EXACT,
        6e-6,
        floor=FLOATS,
        factors=3e-7,
    ),
    Case(
        "upright elements under a square, points",
        elements_and_square("points", True),
        (6, 12, 24),
        UPRIGHT + BORDERS,
        4e-3,
        0.6,
        off=None,
    ),
    Case(
        "squares with one between, patches",
        squares_with_one_between("patches"),
        (5, 10, 20),
        BETWEEN + PARTLY,
        2.5e-2,
        0.4,
        factors=2e-3,
    ),
    Case(
        "squares with one between, points",
        squares_with_one_between("points"),
        (11, 15, 20),
        BETWEEN + BORDERS,
        1.8e-2,
        1.4,
        off=None,
    ),
    Case(
        "disks with one between, patches",
        disks_with_one_between,
        (4, 8, 12),
        BETWEEN + PARTLY,
        2.5e-2,
        floor=FEW_RAYS,
        factors=1.2e-3,
    ),
]
