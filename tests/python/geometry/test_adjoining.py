"""Clouds that adjoin are one surface: no seam that light gets through, and none where it is lost."""

import numpy as np
import pytest

import surflux as sf
from cases import closed_forms
from cases.builders import rectangle
from quick import quick
from scenes import patch, solve_own, surfels_of

X, Y = [1, 0, 0], [0, 1, 0]


def floor(pieces, n=20, emission=0.0):
    """n x n points of the unit square, as 1, 2 or 4 clouds."""
    x, y = (a.ravel() for a in np.meshgrid(*[(np.arange(n) + 0.5) / n] * 2))
    which = (x > 0.5) * (pieces > 1) + 2 * (y > 0.5) * (pieces > 2)
    points = np.stack([x, y, 0 * x], axis=1)
    parts = [points[which == k] for k in np.unique(which)]
    assert len(parts) == pieces
    return [surfels_of(p, [[0, 0, 1]] * len(p), 0.5, emission) for p in parts]


@pytest.mark.parametrize("pieces", [1, 2, 4])
@pytest.mark.parametrize("n", quick(10, of=[10, 20]))
def test_no_light_comes_through_a_seam(pieces, n):
    """A lamp right under the middle of a floor, a square right above: what joins them meets the floor's middle only."""
    lamp = patch([0.4, 0.4, -0.1], [0.2, 0, 0], [0, 0.2, 0], 0.0, 1.0, 0.0025)
    above = patch([0.4, 0.4, 0.1], [0, 0.2, 0], [0.2, 0, 0], 0.0, 0.0, 0.0025)
    alone = solve_own(sf.Scene([lamp, above])).irradiance[len(lamp) :]
    assert alone.min() > 0.1
    solution = solve_own(sf.Scene([lamp, above, *floor(pieces, n)]))
    assert solution.irradiance[len(lamp) : len(lamp) + len(above)].max() == 0.0


def under_a_ceiling(parts):
    """The floor and a ceiling half a unit above it glow, both black: H of the floor's points, and its flux."""
    ceiling = patch([0, 0, 0.5], Y, X, 0.0, 1.0, 0.01)
    solution = solve_own(sf.Scene([ceiling, *parts]))
    h, m = solution.irradiance[:, 0], len(ceiling)
    return solution.surfels.points[m:], h[m:], (solution.surfels.areas * h)[:m].sum()


@pytest.mark.parametrize("pieces", [1, 2, 4])
def test_points_at_a_seam_see_what_they_would_without(pieces):
    """The next point of another cloud is as far as that of its own: each by the polygon of the ceiling."""
    points, h, _ = under_a_ceiling(floor(pieces, emission=1.0))
    ceiling = np.array([[0, 0, 0.5], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0.5]])
    expected = closed_forms.element_to_polygon(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), ceiling)
    inside = np.all(np.abs(points[:, :2] - 0.5) < 0.4, axis=1)
    np.testing.assert_allclose(h[inside], expected[inside], rtol=0.03)


def touching(pieces):
    """The floor in strips whose areas meet: their outermost points are a tenth of a spacing apart."""
    u, v = np.array([1 / pieces, 0, 0]), np.array([0, 1.0, 0])
    return [rectangle(i * u, u, v, (20 // pieces, 20), "points", emission=1.0) for i in range(pieces)]


@pytest.mark.parametrize("pieces", [1, 2])
def test_pieces_whose_areas_meet(pieces):
    """Both ways it is F = .4152533 of unit squares half a unit apart."""
    _, _, flux = under_a_ceiling(touching(pieces))
    assert flux == pytest.approx(closed_forms.parallel_rectangles(2.0, 2.0), rel=0.01)
