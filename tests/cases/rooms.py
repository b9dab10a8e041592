"""Rooms joined by an opening."""

import numpy as np

import surflux as sf
from cases import closed_forms
from cases.builders import rectangle, strips
from cases.case import Case, Problem, Wanted, knobs

# The slit in the partition at x = 1 of the black rooms: y and z, low and high.
SLIT = np.array([[0.2, 0.4], [0.8, 0.6]])


def behind_a_slit(n):
    """A lamp, the wall x = 0, seen through a slit in a partition at x = 1 from the wall x = 2 and the floor behind.

    Seen from a point behind, the slit frames a rectangle of the lamp (closed_forms.shadow with x for z).
    """
    x, y, z = np.eye(3)
    lamp = rectangle([0, 0, 0], y, z, (n, n), emission=1.0)
    (y0, z0), (y1, z1) = SLIT
    m = n // 5
    parts = [((0, 0), (1, z0), (n, 2 * m)), ((0, z1), (1, 1), (n, 2 * m))]
    parts += [((0, z0), (y0, z1), (m, m)), ((y1, z0), (1, z1), (m, m))]
    partition = []
    for (a, b), (c, d), cells in parts:
        partition.append(rectangle([1, a, b], (c - a) * y, (d - b) * z, cells))
    wall = rectangle([2, 0, 0], z, y, (n, n))
    ground = rectangle([1, 0, 0], x, y, (n, n))

    def through(points, normals):
        turned = points[:, [1, 2, 0]]
        low, high = closed_forms.intersection(
            closed_forms.shadow(turned, SLIT[0], SLIT[1], 1.0, 0.0), (np.zeros(2), np.ones(2))
        )
        corners = np.zeros((len(points), 4, 3))
        corners[:, :, 1] = np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], axis=1)
        corners[:, :, 2] = np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], axis=1)
        return closed_forms.element_to_polygon(points, normals, corners)

    first = len(lamp) + sum(len(p) for p in partition)
    wanted = [Wanted(slice(first, None), through)]
    return Problem(sf.Scene([lamp, *partition, wall, ground]), wanted, 1 / n, knobs(8 * n * n))


# Of the walls of two_long_rooms: the partition as the first room has it, and as the second has it, which is its back.
FRONTS, BACKS = (2, 3), (8, 9)


def two_long_rooms(n):
    """Two rooms, 1 x 1 and without end along y, joined by a slit .2 high; rho = .5, and the far left wall glows.

    Solved in the cross-section by crossed strings, on 50 cells per unit. The scene is 40 long and open at its ends;
    what is asked for is the middle of the second room.
    """
    at = [-20.0, -6.0, -1.5, -0.5, 0.5, 1.5, 6.0, 20.0]
    # Cross-section (x, z), counter-clockwise around each room: the front is on the left.
    walls = [
        ((0, 1), (0, 0), 5, 0),
        ((0, 0), (1, 0), 5, 0),
        ((1, 0), (1, 0.4), 2, 0),
        ((1, 0.6), (1, 1), 2, 0),
        ((1, 1), (0, 1), 5, 0),
        ((1, 0), (2, 0), 5, 1),
        ((2, 0), (2, 1), 5, 1),
        ((2, 1), (1, 1), 5, 1),
        ((1, 1), (1, 0.6), 2, 1),
        ((1, 0.4), (1, 0), 2, 1),
    ]
    fine = closed_forms.Cells([(a, b, 10 * k, room) for a, b, k, room in walls], ((1, 0.4), (1, 0.6)))
    glow = np.where(fine.wall == 0, 1.0, 0.0)
    radiosity = fine.radiosity(np.full(len(glow), 0.5), glow)

    def of_section(points, normals):
        return fine.factors(points[:, [0, 2]], normals[:, [0, 2]], 1) @ radiosity

    objects, wanted, first = [], [], 0
    for w, (a, b, k, room) in enumerate(walls):
        if w in BACKS:
            continue
        a, b = np.array([a[0], 0, a[1]]), np.array([b[0], 0, b[1]])
        # (b - a) turned to the left is where the front is: -y x (b - a).
        s = strips(a, [0, -1, 0], at, b - a, k * n // 5, 0.5, float(w == 0), two_sided=w in FRONTS)
        middle = np.abs(s.points[:, 1]) < 0.5
        if w in FRONTS:
            middle[: len(s) // 2] = False  # their backs follow them
        if room == 1 or w in FRONTS:
            known = first + np.flatnonzero(middle)
            wanted.append(Wanted(slice(known[0], known[-1] + 1), of_section))
        objects.append(s)
        first += len(s)
    return Problem(sf.Scene(objects), wanted, 1 / n, knobs(256))


SEEN_THROUGH = (
    "From a point behind, the slit frames a rectangle of the lamp, as the two are parallel: Lambert's polygon of what "
    "is left of it. The solver finds pairs on either side of the partition free or not by few rays each: order 1. "
)
CROSSED_STRINGS = (
    "Hottel's crossed strings between cells of the cross-section, through the slit as far as it is open, and the "
    "linear system of their radiosity. What the open ends take away is 1 / 20^2 of it. Errors are those of the second "
    "room, where all light comes through the slit by few rays for each pair. "
)

CASES = [
    Case("behind a slit", behind_a_slit, (5, 10, 20), SEEN_THROUGH, 5e-2, 0.9, factors=8e-3),
    Case("two long rooms", two_long_rooms, (5, 10, 15), CROSSED_STRINGS, 1.3e-2, 0.8, off=5e-3),
]
