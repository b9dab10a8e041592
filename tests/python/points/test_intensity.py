"""Grey by intensity: .5 on average, whatever else is among the values, of one file and of tiles."""

import logging

import numpy as np
import pytest

import surflux as sf
from surflux.points.intensity import Levels, scale_of_intensity
from surflux.points.shades import Shades


def grey_of(intensity):
    """By a scan and by the chunks of tiles, which agree."""
    count = len(intensity)
    points = np.stack([np.arange(count), np.zeros(count), np.zeros(count)], axis=1)
    one = sf.Scan(points, np.tile([0.0, 0, 1], (count, 1)), attributes={"intensity": intensity}, name="a.npz")
    found = one.surfels().reflectance
    shades = Shades()
    chunks = [{"points": points[part], "intensity": intensity[part]} for part in np.array_split(np.arange(count), 3)]
    for chunk in chunks:
        shades.add(chunk)
    np.testing.assert_allclose(np.concatenate([shades.reflectance(chunk) for chunk in chunks]), found, rtol=1e-12)
    assert np.all(found == found[:, :1])
    return found[:, 0]


def test_where_nothing_is_white_reflectance_is_half_the_intensity_by_its_mean():
    values = np.random.default_rng(0).uniform(100.0, 180.0, 300)
    np.testing.assert_allclose(grey_of(values), 0.5 * values / values.mean(), rtol=1e-12)


@pytest.mark.parametrize("many", [1, 3, 10])
def test_reflectors_do_not_make_all_else_dark(caplog, many):
    """They are .98, and (100 - many) others make up for it: those of 100 are two thirds of those of 150 as before."""
    values = np.full(100, 65535.0)
    values[many:] = np.where(np.arange(100 - many) % 2, 100.0, 150.0)
    with caplog.at_level(logging.INFO, "surflux"):
        grey = grey_of(values.astype(np.uint16))
    np.testing.assert_array_equal(grey[:many], 0.98)
    assert grey.mean() == pytest.approx(0.5, rel=1e-12)
    np.testing.assert_allclose(grey[many:], (50 - 0.98 * many) * values[many:] / values[many:].sum(), rtol=1e-12)
    said = f"the intensity of {many} % of the points is cut off at white, .98: the mean of all is 0.50"
    assert f"a.npz: {said}" in caplog.text
    assert f"tiles: {said}" in caplog.text


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.0])
def test_the_mean_is_a_half_however_skewed_intensities_are(seed, sigma):
    assert grey_of(np.random.default_rng(seed).lognormal(5.0, sigma, 2000)).mean() == pytest.approx(0.5, rel=1e-9)


@pytest.mark.parametrize(
    ("none", "below"), [(np.nan, ""), (np.inf, ""), (-9999.0, ", or below -"), (-1.0, ", or below ")]
)
@pytest.mark.parametrize("many", [1, 80])
def test_what_is_not_known_is_a_half_and_leaves_the_others_alone(caplog, none, below, many):
    values = np.random.default_rng(1).uniform(0.0, 30000.0, 200)
    with_none = np.where(np.arange(200) < many, none, values)
    with caplog.at_level(logging.INFO, "surflux"):
        grey = grey_of(with_none)
    np.testing.assert_array_equal(grey[:many], 0.5)
    np.testing.assert_allclose(grey[many:], grey_of(values[many:]), rtol=1e-12)
    assert f"intensity not known (not finite{below}" in caplog.text
    assert f" of {many} of 200 points, which are grey, .5" in caplog.text


def test_decibels_count_from_the_least_and_what_is_far_below_is_no_datum():
    values = np.random.default_rng(2).triangular(-30.0, -8.0, -5.0, 200)
    low = values.min()
    known = 0.5 * (values - low) / np.mean(values - low)
    assert known.max() < 0.98
    np.testing.assert_allclose(grey_of(values), known, rtol=1e-12)
    grey = grey_of(np.append(values, -9999.0))
    assert grey[-1] == 0.5
    np.testing.assert_allclose(grey[:-1], grey_of(values), rtol=1e-12)


def test_where_most_points_have_none_half_of_the_others_are_white(caplog):
    """With 70 of 100 at 0 no factor makes the mean a half: of 1 to 30 the 15 largest are white, the others below."""
    values = np.append(np.zeros(70), np.arange(1.0, 31.0))
    with caplog.at_level(logging.INFO, "surflux"):
        grey = grey_of(values)
    np.testing.assert_allclose(grey, np.minimum(0.98 * values / 15.0, 0.98), rtol=1e-12)


def test_intensities_that_are_all_the_same_or_no_measure_say_nothing():
    beyond = np.array([1e308] * 8 + [5e307]), np.array([0.0] * 8 + [5e-324])  # sums and factors are not finite
    for values in (np.full(9, 7.0), np.zeros(9), np.full(9, np.nan), np.array([5.0] * 8 + [-9999.0]), *beyond):
        np.testing.assert_array_equal(grey_of(values), 0.5)


def test_intensities_of_more_values_than_are_kept_apart():
    """Rounded to 16 bits, they have the scale of all of them to within 2^-17, and the same values are no datum."""
    values = np.append(np.random.default_rng(3).uniform(0.0, 1.0, 1_200_000), -9999.0)
    levels = Levels()
    for chunk in np.array_split(values, 4):
        levels.add(chunk)
    found, exact = levels.scale(), scale_of_intensity(values)
    assert found.factor == pytest.approx(exact.factor, rel=2.0**-17)
    assert (found.unknown, found.count) == (exact.unknown, exact.count) == (1, 1_200_001)
    np.testing.assert_array_equal(found.reflectance(np.array([-9999.0, np.nan])), 0.5)
