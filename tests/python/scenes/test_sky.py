"""Sun and sky: the all-weather model against Radiance's numbers, what a level plane receives, and where things are."""

import datetime
import sys

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import perez

NORTH, EAST, UP = [0, 1, 0], [1, 0, 0], [0, 0, 1]
# Of Radiance's gendaylit -ang ALTITUDE 30 -W DIRECT DIFFUSE -O 1, which takes the first of January: altitude of the
# sun, direct normal, diffuse; radiance of the diffuse part in units of the model's, and a, b, c, d, e. All eight bins.
GENDAYLIT = [
    (20, 0, 120, 20.6, [0.539937, -0.489997, 1.317759, -0.872631, 0.041362]),
    (35, 5, 200, 31.1, [0.700149, -0.482429, 1.212057, -0.795819, 0.009929]),
    (30, 60, 250, 48.55, [-1.127026, -1.207097, 9.385389, -2.699237, 0.097659]),
    (45, 150, 300, 58.77, [-1.025859, -0.934649, 11.354288, -3.246494, 0.104757]),
    (40, 300, 280, 54.35, [-1.020344, -0.859756, 12.206387, -3.117502, 0.142534]),
    (50, 450, 220, 49.5, [-1.026699, -0.562705, 14.322238, -3.267, 0.025067]),
    (45, 600, 150, 52.47, [-0.987797, -0.310477, 13.033068, -3.460981, 0.236428]),
    (25, 800, 80, 39.16, [-0.986475, -0.234853, 13.204923, -3.880375, 0.512052]),
    (60, 850, 90, 41.35, [-0.989814, -0.207278, 22.213997, -6.015554, 1.321415]),
    (5, 100, 40, 15.07, [-1.305384, -0.71868, 10.570727, -3.116696, -0.062881]),
]


def sky_of(altitude=35.0, azimuth=140.0, direct_normal=500.0, diffuse=150.0, **options):
    return sf.Sky.from_sun(altitude, azimuth, direct_normal, diffuse, **options)


@pytest.mark.parametrize(("altitude", "direct", "diffuse", "unit", "expected"), GENDAYLIT)
def test_the_model_is_that_of_gendaylit(altitude, direct, diffuse, unit, expected):
    """Its brightness has four digits; its scale is a sum over 145 directions, ours an integral: .4 to 1.1 % more."""
    zenith = np.radians([90.0 - altitude])
    clear = perez.clearness(zenith, direct, diffuse)
    found = perez.shape(zenith, clear, perez.brightness(zenith, diffuse, 1))
    np.testing.assert_allclose(found[0], expected, atol=2e-4)
    sky = sky_of(altitude, 30.0, direct, diffuse, day=1)
    directions = np.random.default_rng(0).normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    directions[:, 2] = np.abs(directions[:, 2])
    relative = perez.relative_radiance(np.array([expected]), sky.sun_direction[None, :], directions)[0]
    ratio = sky.radiance(directions) / (unit * relative)
    assert np.ptp(ratio) < 2e-3
    assert ratio[0] == pytest.approx(1.0075, abs=0.005)


def test_every_bin_of_clearness_is_among_them():
    clear = [perez.clearness(np.radians(90.0 - alt), direct, diffuse) for alt, direct, diffuse, _, _ in GENDAYLIT]
    edges = (1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200)
    assert set(np.searchsorted(edges, clear, side="right")) == set(range(8))


def on_a_south_wall(sky):
    """Irradiance of a Sky without its sun, by pixels of 6 and of .2 degrees and by patches."""
    walls = []
    for height in (32, 1024):
        edges = np.pi * np.arange(height // 2 + 1) / height
        middle = 0.5 * (edges[1:] + edges[:-1])
        south = (2.0 * np.pi / (2 * height)) * (np.cos(edges[:-1]) - np.cos(edges[1:])) * np.sin(middle)
        around = np.cos(np.pi * (np.arange(2 * height) + 0.5) / height - 1.5 * np.pi).clip(0.0)
        walls.append(south @ sky.environment(height).image[: height // 2, :, 0] @ around)
    patches = sf.SkyPatches(577)
    south = patches.solid_angles * -patches.directions[:, 1].clip(None, 0.0)
    walls.append(sky.patch_radiances(patches)[1:] @ south[1:])
    return walls


@pytest.mark.parametrize(
    ("altitude", "direct", "diffuse"), [(64, 60, 25), (62, 60, 15.5), (66.3, 60, 35), (70.2, 60, 50.2), (60, 27, 12)]
)
def test_high_suns_in_dim_skies_leave_no_ring_and_no_sky_without_light(altitude, direct, diffuse):
    """Zeniths without radiance left a ring along the horizon, or nothing: images of not a number."""
    walls = on_a_south_wall(sky_of(altitude, 180.0, direct, diffuse))
    assert walls == pytest.approx([walls[1]] * 3, rel=0.03)
    assert 0.4 * diffuse < walls[1] < 0.8 * diffuse


@pytest.mark.parametrize(("altitude", "direct", "diffuse"), [(2, 400, 40), (3, 600, 60), (5, 800, 75)])
def test_low_suns_in_bright_skies_leave_no_ring_along_the_horizon(altitude, direct, diffuse):
    """Means over patches, pixels and their own directions are one sky, from 6 degrees to .2, also on a wall."""
    sky = sky_of(altitude, 180.0, direct, diffuse)
    walls = on_a_south_wall(sky)
    assert walls == pytest.approx([walls[1]] * 3, rel=0.03)
    assert diffuse < walls[1] < 1.5 * diffuse
    # Of the horizon across from the sun against the zenith.
    assert sky.radiance([[0, 1, 0.01]])[0] < 3 * sky.radiance([UP])[0]


@pytest.mark.parametrize(("altitude", "direct", "diffuse"), [(70, 100, 40), (65, 60, 20), (89, 200, 60), (80, 20, 5)])
def test_dim_skies_under_a_high_sun_are_skies(altitude, direct, diffuse):
    """Nothing was left of the first three: NaN."""
    sky = sky_of(altitude, 180.0, direct, diffuse)
    assert sky.radiance(np.array([UP, [0, 1, 0.2], [0, 1, 1]])).min() > 0.05 * diffuse / np.pi
    patches = sf.SkyPatches(145)
    assert sky.patch_radiances(patches) @ patches.projected == pytest.approx(diffuse)


@pytest.mark.parametrize("height", [64, 128])
@pytest.mark.parametrize(("direct", "diffuse"), [(0.0, 80.0), (300.0, 280.0), (900.0, 60.0)])
def test_a_level_plane_receives_what_was_given(height, direct, diffuse):
    """Of the image, pixel by pixel in closed form, and of patches; the ground reflects a fifth of all, evenly."""
    sky = sky_of(40.0, 75.0, direct, diffuse)
    image = sky.environment(height).image[..., 0]
    edges = np.sin(np.pi * np.arange(height + 1) / height) ** 2
    level = np.pi / height * 0.5 * np.diff(edges)[: height // 2]
    assert image[: height // 2].sum(axis=1) @ level == pytest.approx(diffuse, rel=1e-12)
    ground = 0.2 * (diffuse + direct * np.sin(np.radians(40.0))) / np.pi
    np.testing.assert_allclose(image[height // 2 :], ground, rtol=1e-12)
    for count in (145, 577):
        patches = sf.SkyPatches(count)
        found = sky.patch_radiances(patches)
        assert found @ patches.projected == pytest.approx(diffuse, rel=1e-12)
        assert found[0] == pytest.approx(ground, rel=1e-12)
    assert sky.global_horizontal == pytest.approx(ground * np.pi / 0.2)


def test_patches_image_and_function_are_one_sky():
    """Means over patches of 6 degrees against means of an image of .7 degrees, and the function at its pixels."""
    sky = sky_of()
    patches = sf.SkyPatches(577)
    image = sky.environment(256)
    by_image, by_sky = patches.radiance(image)[:, 0], sky.patch_radiances(patches)
    np.testing.assert_allclose(by_sky, by_image, rtol=0.05)
    assert np.median(np.abs(by_sky / by_image - 1.0)) < 2e-3
    rows, columns = [3, 60, 127], [0, 200, 400]
    theta, phi = np.pi * (np.array(rows) + 0.5) / 256, np.pi - 2 * np.pi * (np.array(columns) + 0.5) / 512
    directions = np.c_[np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
    np.testing.assert_allclose(sky.radiance(directions), image.image[rows, columns, 0], rtol=1e-6)


def test_projected_patches_make_pi_and_agree_with_their_middles():
    patches = sf.SkyPatches(577)
    assert patches.projected.sum() == pytest.approx(np.pi, rel=1e-14)
    by_middles = patches.solid_angles * patches.directions[:, 2]
    # A row of height h has cos(h / 2) of what its middle says, the cap (1 + cos(h / 2)) / 2.
    assert (patches.projected[1:-1] / by_middles[1:-1]) == pytest.approx(np.cos(np.radians(90 / 14.5) / 2), rel=1e-12)


def test_places_of_patches_lie_in_them():
    patches = sf.SkyPatches(145)
    found = patches.index(patches._places(3).reshape(-1, 3)).reshape(145, 9)
    np.testing.assert_array_equal(found, np.arange(1, 146)[:, None].repeat(9, axis=1))


@pytest.mark.parametrize(("azimuth", "towards"), [(0.0, NORTH), (90.0, EAST), (180.0, [0, -1, 0])])
def test_north_is_y_and_east_is_x(azimuth, towards):
    sky = sky_of(0.001, azimuth)
    np.testing.assert_allclose(sky.sun_direction, towards, atol=1e-4)
    np.testing.assert_allclose(sky.sun.direction, -sky.sun_direction)
    assert sky.sun_azimuth % 360.0 == pytest.approx(azimuth, abs=1e-9)
    around = sky_of(30.0, azimuth).radiance([np.add(towards, [0, 0, 0.6]), np.add(np.negative(towards), [0, 0, 0.6])])
    assert around[0] > 3 * around[1]


def test_the_sun_in_the_image_has_its_power_in_its_place():
    sky = sky_of(35.0, 222.0)
    added = sky.environment(128, sun=True).image - sky.environment(128).image
    ((row, column),) = np.argwhere(added[..., 0])
    angle = np.pi / 128 * (np.cos(np.pi * row / 128) - np.cos(np.pi * (row + 1) / 128))
    assert added[row, column] * angle == pytest.approx([500.0] * 3)
    theta, phi = np.pi * (row + 0.5) / 128, np.pi - np.pi * (column + 0.5) / 128
    middle = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    assert middle @ sky.sun_direction > np.cos(np.radians(1.0))
    assert sky.sun_radiance == pytest.approx(500.0 / 6.8e-5, rel=0.01)  # the sun's solid angle


def test_the_sun_in_patches_has_its_power_in_its_patch():
    patches = sf.SkyPatches(145)
    added = sky_of().patch_radiances(patches, sun=True) - sky_of().patch_radiances(patches)
    (which,) = np.flatnonzero(added)
    assert which == patches.index([sky_of().sun_direction])[0]
    assert added[which] * patches.solid_angles[which] == pytest.approx(500.0)


def test_skies_without_a_sun():
    """Down or hidden, it is no light; a sky of which the model knows nothing is even; a dark one is dark."""
    down, overcast, dark = sky_of(-3.0, direct_normal=20.0, diffuse=4.0), sky_of(direct_normal=0.0), sky_of(30, 0, 0, 0)
    assert down.direct_normal == 0.0
    assert [len(sky.lights) for sky in (down, overcast, dark)] == [1, 1, 1]
    np.testing.assert_allclose(down.radiance([UP, [1, 2, 0.1]]), 4.0 / np.pi, rtol=1e-6)
    assert np.isnan(down.clearness)
    assert np.isnan(down.brightness)
    assert overcast.clearness == 1.0
    assert overcast.radiance([UP])[0] > overcast.radiance([[0, 1, 0.01]])[0]
    assert dark.environment().image.max() == 0.0


def test_a_scene_takes_a_sky_as_the_two_that_it_is_made_of():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.25)
    sky = sky_of(30.0, 10.0, 400.0, 100.0)
    scene = sf.Scene([floor], lights=[sky, sf.PointLight([0, 0, 1], 1.0)])
    assert [type(light).__name__ for light in scene.lights] == ["Environment", "DirectionalLight", "PointLight"]
    found = sf.solve(sf.Scene([floor], lights=[sky])).irradiance
    np.testing.assert_allclose(found, 300.0, rtol=5e-3)
    transfer = sf.precompute_transfer(sf.Scene([floor]), "sky", patches=577)
    np.testing.assert_allclose(transfer.relight(sky).irradiance, 300.0, rtol=2e-3)
    # Spread over a patch 6 degrees wide the sun has up to tan(60) * 3 degrees = 9 % more or less of its level part.
    radiances = sky.patch_radiances(transfer.patches, sun=True)
    assert radiances @ transfer.patches.projected == pytest.approx(300.0, rel=0.06)
    np.testing.assert_allclose(
        transfer.relight(radiances).irradiance, radiances @ transfer.patches.projected, rtol=2e-3
    )


def test_skies_are_values():
    assert sky_of() == sky_of()
    assert hash(sky_of()) == hash(sky_of())
    assert sky_of() != sky_of(albedo=0.3)
    assert sky_of() != "sky"
    assert repr(sky_of()) == "Sky(sun 35.0 up at 140.0, direct 500 and diffuse 150 W/m2, albedo 0.2)"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"altitude": 91.0}, r"^altitude: wanted values in \[-90, 90\]"),
        ({"azimuth": np.inf}, "^azimuth: wanted a finite number"),
        ({"direct_normal": -1.0}, "^direct_normal: wanted values in"),
        ({"diffuse": 1e4}, "^diffuse: wanted values in"),
        ({"albedo": 1.5}, "^albedo: wanted values in"),
        ({"day": 0}, "^day: wanted a whole number from 1 to 366"),
    ],
)
def test_suns_that_are_none_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        sky_of(**options)


def test_arguments_of_methods_are_checked():
    with pytest.raises(ValueError, match=r"^height: wanted an even number"):
        sky_of().environment(65)
    with pytest.raises(ValueError, match=r"^sun: wanted True or False"):
        sky_of().environment(sun=1)
    with pytest.raises(ValueError, match=r"^patches: wanted SkyPatches, got int"):
        sky_of().patch_radiances(145)
    with pytest.raises(ValueError, match=r"^directions: wanted shape"):
        sky_of().radiance([0, 0, 1])


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ("2025-06-21T12:00", "^time: wanted a time with its time zone"),
        (datetime.datetime(2025, 6, 21, 12), "^time: wanted a time with its time zone"),
        ("noon", "^time: wanted text such as 2025-06-21T12:00"),
        (12, "^time: wanted a time or several, got int"),
        ([12], "^time: wanted a datetime, text or datetime64, got 12"),
        ([], "^time: wanted at least one time"),
        (np.datetime64("NaT", "s"), "^time: wanted a time, got NaT"),
        (["2025-06-21T12:00Z", "2025-06-21T13:00Z"], "^time: wanted one, got 2"),
    ],
)
def test_times_that_say_too_little_are_refused(time, message):
    with pytest.raises(ValueError, match=message):
        sf.Sky(47.4, 8.5, time, direct_normal=1.0, diffuse=1.0)


def test_without_pvlib_the_message_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pvlib", None)
    with pytest.raises(ImportError, match=r"need pvlib: pip install 'surflux\[solar\]'"):
        sf.Sky(47.4, 8.5, "2025-06-21T12:00Z")
