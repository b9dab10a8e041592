"""Colours of numbers."""

import numpy as np
import pytest

import surflux as sf
from surflux.drawing.colors import Shown, label_digits, range_of, screen_bytes, surface_property, trimmed_range


def test_numbers_that_differ_by_rounding_have_one_colour():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [3, 0, 0], [3, 3, 0], [0, 3, 0]], [[0, 1, 2, 3]]), patch_area=0.05)
    area = floor.areas[0]
    assert 0.0 < np.ptp(floor.areas) < 1e-12  # 182 of them, all 9 / 182
    assert range_of(floor.areas) == pytest.approx((0.5 * area, 1.5 * area))
    colors = screen_bytes(surface_property(floor, "area")).astype(int)
    assert np.ptp(colors, axis=0).max() <= 1  # the middle lies between two entries of the table
    kept = np.float32(area) * np.array([1.0, 1.0 + 1e-7, 1.0 - 1e-7], np.float32)
    assert np.ptp(screen_bytes(Shown("area", "number", "", kept)).astype(int), axis=0).max() <= 1


def test_what_differs_among_equal_numbers_is_seen():
    values = 1.0 + 1e-15 * np.arange(1000)
    values[0] = 2.0
    assert trimmed_range(values) == (values[1], 2.0, False)
    colors = screen_bytes(Shown("a", "number", "", values))
    assert (colors[1:] == colors[1]).all()
    assert (colors[0] != colors[1]).any()


def test_what_differs_in_its_last_digits_is_seen():
    """GPS times of a flight, and northings: differences are far below a millionth of them."""
    for values in (3e8 + np.linspace(0.0, 60.0, 500), 5.4e6 + np.linspace(0.0, 5.0, 500), np.arange(500) + 2**40):
        low, high = range_of(values)
        assert values.min() <= low < high <= values.max()
        assert len(np.unique(screen_bytes(Shown("t", "number", "", values)), axis=0)) > 100
    for largest in (1.7e308, np.float32(3e38)):
        assert np.isfinite(range_of(np.full(3, largest))).all()


@pytest.mark.parametrize(
    ("low", "high"), [(293.15, 293.45), (1100.0, 1180.0), (0.0, 1.0), (-3e-7, 5e-7), (1.7e9, 1.7e9 + 3), (2.0, 2.0)]
)
@pytest.mark.parametrize("steps", [4, 10])
def test_labels_of_a_scale_can_be_told_apart(low, high, steps):
    marks = np.linspace(low, high, steps + 1)
    labels = [f"{x:.{label_digits(low, high, steps)}g}" for x in marks]
    assert len(set(labels)) == len(set(marks))
    np.testing.assert_allclose([float(x) for x in labels], marks, atol=0.1 * (high - low) / steps)  # evenly, too


def test_labels_of_a_scale_have_digits_where_numbers_are_as_large_as_they_may_be():
    with np.errstate(all="raise"):
        assert label_digits(-1.7e308, 1.7e308) == 4
