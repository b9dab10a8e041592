"""Irradiation by sun and sky: closed forms, sums, hours by `solve`, and Perez's transposition."""

import numpy as np
import pytest

import surflux as sf
from canyons import canyon, floor_view, wall_view
from quick import quick
from weather_files import level_sun, write_epw

EVEN = sf.Sky.from_sun(-5.0, 0.0, 0.0, 100.0, albedo=0.3)  # no sun: the same from everywhere
DAY = [
    sf.Sky.from_sun(12.0, 110.0, 300.0, 60.0),
    sf.Sky.from_sun(48.0, 170.0, 800.0, 90.0),
    sf.Sky.from_sun(35.0, 240.0, 100.0, 250.0),
    EVEN.from_sun(-4.0, 300.0, 0.0, 5.0),
]


def tilted(angle, azimuth=180.0):
    """A square of 2 x 2 that faces azimuth, tilted by an angle, in degrees, of 9 patches."""
    b, a = np.radians(angle), np.radians(azimuth)
    normal = np.array([np.sin(b) * np.sin(a), np.sin(b) * np.cos(a), np.cos(b)])
    u = np.array([np.cos(a), -np.sin(a), 0.0])
    v = np.cross(normal, u)
    return sf.Surfels.from_mesh(([-u - v, u - v, u + v, v - u], [[0, 1, 2, 3]]), 0.5)


def steps(rho=0.5, area=0.004):
    """A stair of two steps beside a wall that faces west."""
    profile = [(0, 0), (0.6, 0), (0.6, 0.4), (1.0, 0.4), (1.0, 1.0)]
    corners = [(x, y, z) for y in (0.0, 1.0) for x, z in profile]
    return sf.Surfels.from_mesh((corners, [[k, k + 1, k + 6, k + 5] for k in range(4)]), area, rho)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 90.0])
def test_open_planes_under_an_even_sky(angle):
    """(1 + cos b) / 2 of the sky, (1 - cos b) / 2 of the ground, which reflects .3 of it.

    The patches that the plane's horizon runs through are integrated by parts 1.5 degrees wide, to 1e-3 of the whole
    (test_free_directions.cpp)."""
    found = sf.solar_irradiation(tilted(angle), skies=EVEN, hours=10.0)
    cosine = np.cos(np.radians(angle))
    np.testing.assert_allclose(found.diffuse, 0.5 * (1.0 + cosine), atol=1e-3)
    np.testing.assert_allclose(found.reflected, 0.3 * 0.5 * (1.0 - cosine), rtol=1e-9, atol=1e-9)
    assert found.beam.max() == 0.0
    np.testing.assert_allclose(found.mean, 100.0 * found.total, rtol=1e-12)


def test_a_level_plane_has_what_was_given():
    """Sum over the day of direct sin(altitude), and of what is diffuse: both exactly."""
    found = sf.solar_irradiation(tilted(0.0), skies=DAY)
    beam = sum(sky.direct_normal * sky.sun_direction[2] for sky in DAY) / 1000.0
    np.testing.assert_allclose(found.beam, beam, rtol=1e-6)
    np.testing.assert_allclose(found.diffuse, sum(sky.diffuse for sky in DAY) / 1000.0, rtol=1e-9)
    assert found.reflected.max() < 1e-6
    assert found.hours == 4.0
    assert found.times is None


@pytest.mark.parametrize("length", quick(400.0, of=[40.0, 400.0]))
@pytest.mark.parametrize("seed", quick(0, of=[0, 1, 2]))
def test_a_canyon_under_an_even_sky(length, seed):
    """Black, so that walls reflect nothing: what strips see of the sky, in the mean within 1 %, in any long street.

    At single strips 577 rays have an RMS error of .5 % of the sky (`solar_irradiation`)."""
    surfels, at = canyon(8, 41, reflectance=0.0, length=length)
    found = sf.solar_irradiation(surfels, skies=EVEN, hours=10.0, seed=seed)
    assert found.diffuse[:8].mean() == pytest.approx(np.sqrt(2.0) - 1.0, rel=0.01)
    assert found.diffuse[8:24].mean() == pytest.approx(1.0 - np.sqrt(0.5), rel=0.01)
    off = np.concatenate([found.diffuse[:8] - floor_view(at), found.diffuse[8:16] - wall_view(at)])
    assert np.sqrt(np.mean(off**2)) < 0.01
    assert found.reflected[:8].max() < 1e-6


@pytest.mark.slow
def test_walls_of_a_canyon_reflect():
    lit = sf.solar_irradiation(canyon(8, 41, 0.6, 40.0)[0], skies=EVEN, hours=10.0, bounces=None)
    assert lit.reflected[:8].min() > 0.05


@pytest.mark.slow
def test_threads_do_not_change_bits():
    surfels = canyon(4, 5, length=10.0)[0]
    one, two = (sf.solar_irradiation(surfels, skies=DAY, threads=threads, patches=145) for threads in (1, 2))
    for part in ("beam", "diffuse", "reflected"):
        np.testing.assert_array_equal(getattr(one, part), getattr(two, part))
    assert one.diffuse.max() > 0.0


@pytest.mark.slow
def test_the_sun_in_a_canyon():
    """From the west, 45 degrees up: the wall on that side hides it from all of the floor, the other wall has it all."""
    surfels, _ = canyon(reflectance=0.0)
    sun = sf.Sky.from_sun(50.0, 270.0, 1000.0, 0.0, albedo=0.0)
    beam = sf.solar_irradiation(surfels, skies=sun).beam
    left, right = beam[16:32], beam[32:48]
    shadow = 1.0 / np.tan(np.radians(50.0))  # .84 of the floor's width
    at = (np.arange(16) + 0.5) / 16
    np.testing.assert_allclose(beam[:16], np.where(at > shadow, np.sin(np.radians(50.0)), 0.0), atol=1e-9)
    assert left.max() == 0.0
    reached = at > 1.0 - np.tan(np.radians(50.0))
    np.testing.assert_allclose(right, np.where(reached, np.cos(np.radians(50.0)), 0.0), atol=1e-9)


@pytest.fixture(scope="module")
def stair():
    scene = sf.Scene([steps()])
    return scene, sf.solar_irradiation(scene, skies=DAY, bounces=None)


@pytest.mark.slow
def test_hours_add_up(stair):
    _, found = stair
    each = found.hourly([0, 40, 99, 5])
    chosen = [0, 40, 99, 5]
    for part in ("beam", "diffuse", "reflected", "total"):
        sums = getattr(each, part).sum(axis=1) / 1000.0
        np.testing.assert_allclose(sums, getattr(found, part)[chosen], rtol=2e-3, atol=1e-5)
    np.testing.assert_allclose(found.total, found.beam + found.diffuse + found.reflected)
    assert each.beam[:, 3].max() == 0.0  # the sun is down
    assert len(found.hourly().beam) == len(found.surfels)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_hour_of_a_room_has_its_reflected_light_at_all_surfels(seed):
    """What the basis has below 0 of the sun's light came off what is reflected: at the worst surfels all of that."""
    corners = [[x, y, z] for z in (0, 3) for y in (0, 5) for x in (0, 6)]
    window = [[x, 0, z] for z in (1.0, 2.4) for x in (1.5, 4.5)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 2, 6, 4], [1, 5, 7, 3], [2, 3, 7, 6]]
    faces += [[0, 8, 9, 1], [1, 9, 11, 5], [5, 11, 10, 4], [4, 10, 8, 0]]
    room = sf.Surfels.from_mesh((corners + window, faces), 0.1, reflectance=0.5)
    found = sf.solar_irradiation(sf.Scene([room]), skies=[sf.Sky.from_sun(35, 190, 700, 120)], seed=seed)
    hour = found.hourly().reflected[:, 0] / 1000.0
    np.testing.assert_allclose(found.reflected, hour, atol=0.02 * hour.mean())


@pytest.mark.slow
def test_hours_are_those_of_solve(stair):
    """Each hour by `solve` under the same Sky: 2 % in the RMS of all hours together, and 1 % in the mean.

    Patches through which a shadow runs are left out of the RMS: they have the sun at their middles or not at all."""
    scene, found = stair
    each = found.hourly()
    areas = scene.surfels.areas
    true = np.stack(
        [sf.solve(sf.Scene(scene.objects, [sky]), insert=False).irradiance.mean(axis=1) for sky in DAY[:3]], axis=1
    )
    direct = np.stack(
        [
            sf.solve(sf.Scene(scene.objects, [sky.sun]), insert=False).direct.mean(axis=1) if sky.sun else 0.0 * areas
            for sky in DAY[:3]
        ],
        axis=1,
    )
    whole = np.isclose(each.beam[:, :3], direct, rtol=0.02, atol=0.5)
    assert whole.mean() > 0.9
    weights = areas[:, None] * whole
    error = np.sqrt((weights * (each.total[:, :3] - true) ** 2).sum() / (weights * true**2).sum())
    assert error < 0.02
    means = (areas[:, None] * each.total[:, :3]).sum(axis=0), (areas[:, None] * true).sum(axis=0)
    np.testing.assert_allclose(*means, rtol=0.02)


def test_a_transfer_is_taken_again(stair):
    scene, found = stair
    again = sf.solar_irradiation(scene, skies=DAY, bounces=None, transfer=found.transfer, threads=1)
    np.testing.assert_array_equal(again.total, found.total)
    twice = sf.solar_irradiation(scene, skies=DAY, bounces=None, transfer=found.transfer, hours=2.0)
    np.testing.assert_allclose(twice.total, 2.0 * found.total, rtol=1e-6)
    other = sf.Scene([steps()])
    with pytest.raises(ValueError, match=r"^transfer: wanted a SkyTransfer of this very scene"):
        sf.solar_irradiation(other, skies=DAY, transfer=found.transfer)


def test_what_shines_by_itself_is_no_irradiation():
    lamp = sf.Surfels.from_mesh(([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]], [[0, 1, 2, 3]]), 0.3, 0.0, emission=50.0)
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.3, 0.0)
    found = sf.solar_irradiation(sf.Scene([floor, lamp]), skies=[EVEN.from_sun(-5.0, 0.0, 0.0, 1.0, albedo=0.0)])
    assert found.reflected.max() < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", quick(180.0, of=[0.0, 90.0, 180.0]))
def test_a_year_is_that_of_perez_on_open_planes(azimuth, tmp_path):
    """Sums of beam, diffuse and reflected within 3 % of the transposition that pvlib has (Perez and Driesse 2024)."""
    pvlib = pytest.importorskip("pvlib", reason="needs surflux[solar]")
    from surflux.scenes import perez, weather

    above = level_sun(47.4, 8.5, 1.0)
    share = 0.5 + 0.4 * np.sin(np.arange(8760) / 37.0)  # clear and overcast days, and all between
    normal, diffuse = 0.75 * share * np.where(above > 60.0, 1000.0, 0.0), above * (0.28 - 0.16 * share)
    path = write_epw(tmp_path / "year.epw", above, normal, diffuse)
    hours = weather.read_weather(path)
    altitude, turn = weather.sun_angles(hours.times, 47.4, 8.5, 400.0)
    zenith = 90.0 - altitude
    beam = np.where(altitude > 0.0, hours.direct_normal, 0.0)
    top = perez.extraterrestrial(weather.day_of_year(hours.times))
    mass = pvlib.atmosphere.get_relative_airmass(zenith)
    level = hours.diffuse + beam * np.cos(np.radians(zenith)).clip(0.0)
    for angle in (30.0, 60.0):
        sky = pvlib.irradiance.perez_driesse(angle, azimuth, hours.diffuse, beam, top, zenith, turn, mass)
        sun = beam * np.cos(np.radians(pvlib.irradiance.aoi(angle, azimuth, zenith, turn))).clip(0.0)
        ground = 0.2 * level * 0.5 * (1.0 - np.cos(np.radians(angle)))
        found = sf.solar_irradiation(tilted(angle, azimuth), epw=path, steps=1, patches=145)
        np.testing.assert_allclose(found.beam, sun.sum() / 1000.0, rtol=1e-3)
        np.testing.assert_allclose(found.total, (np.nan_to_num(sky) + sun + ground).sum() / 1000.0, rtol=0.03)
        assert found.hours == 8760.0


def test_years_and_times_of_a_place():
    pytest.importorskip("pvlib", reason="needs surflux[solar]")
    times = [f"2025-06-21T{hour:02}:30+01:00" for hour in range(24)]
    day = sf.solar_irradiation(tilted(0.0), (47.4, 8.5), times, patches=145)
    assert 6.0 < day.total[0] < 9.0  # kWh/m2 of a clear day in June
    fine = sf.solar_irradiation(tilted(0.0), (47.4, 8.5), times, patches=145, steps=6, sun_step=1.0)
    assert fine.total[0] == pytest.approx(day.total[0], rel=0.01)
    assert day.times[0] == np.datetime64("2025-06-20T23:30")
    given = sf.solar_irradiation(tilted(0.0), (47.4, 8.5), times, patches=145, direct_normal=0.0, diffuse=100.0)
    np.testing.assert_allclose(given.total, 2.4, rtol=2e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scene": "roof"}, "^scene: wanted a Scene or Surfels, got str"),
        ({"skies": None}, "^times: wanted one of times, epw and skies, got none"),
        ({"times": 2025}, "^times: wanted one of times, epw and skies, got times and skies"),
        ({"place": (47.4, 8.5)}, "^place: goes with times; skies cannot take it"),
        ({"diffuse": 1.0}, "^diffuse: goes with times; skies cannot take it"),
        ({"altitude": 500.0}, "^altitude: goes with times; skies cannot take it"),
        ({"albedo": 0.5}, "^albedo: goes with times and epw; skies have their own"),
        ({"hours": 0.5, "skies": None, "times": 2025, "place": (47.4, 8.5)}, "^hours: goes with times one by one"),
        ({"skies": []}, "^skies: wanted a Sky or a list of at least one"),
        ({"skies": [EVEN, DAY[0]]}, "^skies: wanted one albedo in all of them"),
        ({"skies": None, "times": 2025, "place": 47.4}, r"^place: wanted \(latitude, longitude\) in degrees"),
        ({"skies": None, "times": 2025, "place": (99, 8.5)}, "^latitude: wanted values in"),
        ({"skies": None, "times": 1000, "place": (47.4, 8.5)}, "^year: wanted a whole number from 1950"),
        ({"hours": 0.0}, "^hours: wanted values in"),
        ({"steps": 0}, "^steps: wanted a whole number"),
        ({"steps": 4}, "^steps: goes with times and epw"),
        ({"sun_step": 45.0}, "^sun_step: wanted values in"),
        ({"bounces": -1}, "^bounces: wanted a whole number"),
        ({"patches": 146}, "^patches: wanted one of"),
        ({"albedo": 2.0, "skies": None, "times": 2025, "place": (47.4, 8.5)}, "^albedo: wanted values in"),
    ],
)
def test_arguments_are_checked(options, message):
    with pytest.raises(ValueError, match=message):
        sf.solar_irradiation(**({"scene": tilted(0.0), "skies": DAY} | options))


def test_a_transfer_used_again_has_the_bounces_that_are_asked_for():
    """None took those of the transfer: 17 % of what a street reflects was missing."""
    scene = sf.Scene([canyon(8, 41, 0.6, 40.0)[0]])
    three = sf.solar_irradiation(scene, skies=DAY, patches=145)
    every = sf.solar_irradiation(scene, skies=DAY, patches=145, bounces=None)
    again = sf.solar_irradiation(scene, skies=DAY, bounces=None, transfer=three.transfer)
    assert every.reflected.mean() > 1.02 * three.reflected.mean()
    np.testing.assert_allclose(again.reflected, every.reflected, rtol=1e-6)
    chosen = [0, 5]
    np.testing.assert_allclose(*(of.hourly(chosen).reflected for of in (again, every)), rtol=1e-6)
    assert three.transfer.bounces == 3
    assert len(again.transfer.patches) == len(three.transfer.patches)
    with pytest.raises(ValueError, match=r"^patches: transfer has 145, which count; got 577"):
        sf.solar_irradiation(scene, skies=DAY, patches=577, transfer=three.transfer)


def test_plots_refuse_what_is_no_part(stair):
    with pytest.raises(ValueError, match=r"^part: wanted one of 'total', 'beam', 'diffuse', 'reflected', got 'all'"):
        stair[1].plot("all")


def test_a_summary_has_the_means(stair):
    _, found = stair
    assert repr(found).startswith(f"SolarIrradiation({len(found.surfels)} surfels, 4 h, mean of beam ")
