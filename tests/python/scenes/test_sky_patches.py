"""The sky in patches: against Radiance's numbers, closed forms, and the path tracer under the same sky."""

import numpy as np
import pytest

import surflux as sf


@pytest.mark.parametrize(("count", "rows"), [(145, 7), (577, 14), (1297, 21), (2305, 28)])
def test_numbers_of_gendaymtx(count, rows):
    """Its rh_init: rows of (pi / 2) / (rows + .5), the ground first and the cap at the zenith last."""
    patches = sf.SkyPatches(count)
    m, height = rows // 7, np.pi / 2 / (rows + 0.5)
    altitude, azimuth, angles = [-np.pi / 2], [0.0], [2 * np.pi]
    for row in range(rows):
        n = [30, 30, 24, 24, 18, 12, 6][row // m] * m
        for k in range(n):
            altitude.append(height * (row + 0.5))
            azimuth.append(2 * np.pi * k / n)
            angles.append(2 * np.pi * (np.sin(height * (row + 1)) - np.sin(height * row)) / n)
    altitude, azimuth = np.array([*altitude, np.pi / 2]), np.array([*azimuth, 0.0])
    angles.append(2 * np.pi * (1 - np.cos(height / 2)))
    assert len(patches) == count + 1
    np.testing.assert_allclose(patches.solid_angles, angles, atol=1e-15)
    r = np.cos(altitude)
    expected = np.c_[r * np.sin(azimuth), r * np.cos(azimuth), np.sin(altitude)]
    np.testing.assert_allclose(patches.directions, expected, atol=1e-15)
    np.testing.assert_array_equal(patches.index(2 * patches.directions), np.arange(count + 1))
    assert patches.solid_angles[1:].sum() == pytest.approx(2 * np.pi, rel=1e-13)
    assert repr(patches) == f"SkyPatches({count})"


def test_irradiance_by_middles_is_too_much_by_a_known_factor():
    """A row from a to b has the irradiance pi (sin^2 b - sin^2 a); its middle makes 1 / cos((b - a) / 2) times that."""
    for count, height in ((145, np.radians(12)), (2305, np.radians(90 / 28.5))):
        patches = sf.SkyPatches(count)
        radiance = patches.radiance(sf.Environment(2.0))[:, 0]
        level = np.sum((radiance * patches.solid_angles * patches.directions[:, 2])[1:-1])
        rows = 2 * np.pi * np.sin(np.pi / 2 - height / 2) ** 2
        assert level == pytest.approx(rows / np.cos(height / 2), rel=1e-12)


def test_the_sun_is_in_its_patch():
    image = np.zeros((180, 360, 3))
    image[40, 90] = 1e4  # 40.5 degrees from the zenith, towards +y: north
    patches = sf.SkyPatches(145)
    radiance = patches.radiance(sf.Environment(image))
    north = patches.index([[0, np.sin(np.radians(40.5)), np.cos(np.radians(40.5))]])[0]
    assert radiance[:, 0].argmax() == north
    power = 1e4 * (np.cos(np.radians(40)) - np.cos(np.radians(41))) * np.radians(1)
    assert np.sum(radiance[:, 0] * patches.solid_angles) == pytest.approx(power, rel=0.036)  # test_sky_patches.cpp


@pytest.mark.parametrize("count", [145, 577])
def test_an_environment_of_even_patches(count):
    patches = sf.SkyPatches(count)
    radiances = np.random.default_rng(0).uniform(0.0, 3.0, (count + 1, 3))
    sky = patches.environment(radiances)
    np.testing.assert_allclose(patches.radiance(sky), radiances, rtol=1e-12)
    floor = sf.Scene([sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, areas=1.0)], [sky])
    level, error = sf.reference_irradiance(floor, [[0.0, 0.0, 0.0]], [[0, 0, 1]])
    assert np.all(np.abs(level[0] - patches.projected @ radiances) < 5 * error[0] + 1e-9)
    np.testing.assert_array_equal(patches.environment(radiances[:, 0]).image[..., 2], sky.image[..., 0])
    for wrong in (radiances[1:], -radiances, radiances * np.nan, "bright"):
        with pytest.raises(ValueError, match=r"^radiances: "):
            patches.environment(wrong)


@pytest.mark.parametrize("count", [144, 0, -1, 2306, 145.0, "145", True, None])
def test_counts_that_there_are_not(count):
    with pytest.raises(ValueError, match=r"^count: wanted"):
        sf.SkyPatches(count)


@pytest.mark.parametrize("directions", [[0, 0, 1], [[0, 0, 0]], [[np.nan, 0, 1]], "up", np.zeros((0, 3))])
def test_what_is_no_direction(directions):
    with pytest.raises(ValueError, match=r"^directions: wanted"):
        sf.SkyPatches().index(directions)


def test_what_is_no_sky():
    with pytest.raises(ValueError, match=r"^environment: wanted an Environment, got float$"):
        sf.SkyPatches().radiance(1.0)
