"""Polygons that are not convex: all of their area, also where an outline touches itself."""

import numpy as np
import pytest

import surflux as sf

RING = [[0, 0], [4, 0], [4, 4], [0, 4]]
HOLE = [[1, 1], [1, 3], [3, 3], [3, 1]]
FROM_THE_RIGHT = [[3, 2], [2.5, 3], [3, 3], [3, 2], [4, 0], [4, 4], [0, 4]]
OUTLINES = {  # corners and area
    "a hole that a bridge leads to": ([*RING, RING[0], *HOLE, HOLE[0]], 12),
    "two holes": (
        [[0, 0], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1], [0, 0], [4, 0], *FROM_THE_RIGHT],
        14.75,
    ),
    "a spike": ([[0, 0], [2, 0], [2, 1], [3, 1], [2, 1], [2, 2], [0, 2]], 4),
    "a spike at its first corner": ([[3, 1], [2, 1], [2, 2], [0, 2], [0, 0], [2, 0], [2, 1]], 4),
    "a corner that stands twice": ([[0, 0], [2, 0], [2, 0], [1, 1], [2, 2], [0, 2], [0, 0]], 3),
    "an L that is a millimetre wide": ([[0, 0], [1e3, 0], [1e3, 1e-3], [1e-3, 1e-3], [1e-3, 1e3], [0, 1e3]], 2 - 1e-6),
}


@pytest.mark.parametrize("patch_area", [None, 0.1])
@pytest.mark.parametrize("start", [0, 1, 4])
@pytest.mark.parametrize("name", OUTLINES)
def test_all_of_a_polygon_is_there(name, start, patch_area):
    """A wall with a window as one polygon was no wall at all."""
    outline, area = OUTLINES[name]
    ring = np.roll(np.c_[outline, np.zeros(len(outline))], start, axis=0)
    turn = np.linalg.qr(np.random.default_rng(start).normal(size=(3, 3)))[0]
    surfels = sf.Surfels.from_mesh((ring @ turn.T + 5.0, [list(range(len(ring)))]), None if area > 20 else patch_area)
    assert surfels.areas.sum() == pytest.approx(area, rel=1e-6)
    up = turn[:, 2] * np.sign(np.linalg.det(turn))
    np.testing.assert_allclose(surfels.normals, np.tile(up, (len(surfels), 1)), atol=1e-6)


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize(("columns", "storeys"), [(2, 1), (3, 2), (5, 3)])
def test_a_facade_with_windows_as_one_polygon(columns, storeys, turns):
    """Bridges to the nearest corner of what is there, some in line with others, as exporters write them."""
    ring = [np.array(p, float) for p in ([0, 0], [3 * columns, 0], [3 * columns, 3 * storeys], [0, 3 * storeys])]
    for x, y in ((3 * i + 0.9, 3 * j + 0.8) for i in range(columns) for j in range(storeys)):
        hole = [np.array(p) for p in ([x, y], [x, y + 1.4], [x + 1.2, y + 1.4], [x + 1.2, y])]
        k = min(range(len(ring)), key=lambda k: np.linalg.norm(ring[k] - hole[0]) + 1e9 * (ring[k][0] > x))
        ring = [*ring[: k + 1], *hole, hole[0], *ring[k:]]
    corners = np.c_[ring, np.zeros(len(ring))]
    if turns:
        corners = corners @ np.linalg.qr(np.random.default_rng(columns).normal(size=(3, 3)))[0].T
    surfels = sf.Surfels.from_mesh((corners, [list(range(len(ring)))]))
    assert surfels.areas.sum() == pytest.approx(columns * storeys * (9 - 1.68), rel=1e-9)


def test_light_comes_through_the_hole():
    """A floor below a wall of which the middle is open, as seen from a lamp."""
    wall = np.c_[OUTLINES["a hole that a bridge leads to"][0], np.ones(10)]
    floor = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]]
    faces = [list(range(10))[::-1], [10, 11, 12, 13]]
    surfels = sf.Surfels.from_mesh((np.concatenate([wall, floor]), faces), 0.01)
    solution = sf.solve(sf.Scene([surfels], [sf.DirectionalLight([0, 0, -1], 1.0)]), insert=False)
    below = surfels.points[:, 2] == 0
    lit = (np.abs(surfels.points[below, :2] - 2) < 0.97).all(axis=1)
    np.testing.assert_allclose(solution.direct[below, 0][lit], 1.0, atol=1e-6)
    assert surfels.areas[below] @ solution.direct[below, 0] == pytest.approx(4.0, rel=0.02)


def test_outlines_that_cross_themselves_are_told():
    crossing = [[0, 0, 0], [3, 0, 0], [3, 2, 0], [1, -1, 0], [1, 3, 0], [0, 3, 0]]
    square = [[9, 0, 0], [10, 0, 0], [10, 1, 0], [9, 1, 0]]
    with pytest.warns(UserWarning, match=r"1 face \(the first: 1\) with outlines that cannot be cut"):
        sf.Surfels.from_mesh((square + crossing, [[0, 1, 2, 3], [4, 5, 6, 7, 8, 9]]))
