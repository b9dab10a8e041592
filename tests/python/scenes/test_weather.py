"""Where the sun stands, clear skies, and files of weather: what takes pvlib."""

import datetime
import re
import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import weather
from weather_files import level_sun, write_epw

pytest.importorskip("pvlib", reason="needs surflux[solar]")

ABOVE = level_sun(47.4, 8.5, 1.0)


@pytest.fixture(scope="module")
def epw(tmp_path_factory):
    return write_epw(tmp_path_factory.mktemp("epw") / "here.epw", ABOVE, 0.5 * ABOVE, 0.1 * ABOVE)


def test_the_sun_of_the_almanac():
    """Noon at the summer solstice: 90 - latitude + 23.44 up (refraction adds .01), south; mornings, in the east."""
    sky = sf.Sky(47.4, 0.0, "2025-06-21T12:02Z")
    assert sky.sun_altitude == pytest.approx(90 - 47.4 + 23.44, abs=0.02)
    assert sky.sun_azimuth == pytest.approx(180.0, abs=0.5)
    east = sf.Sky(47.4, 8.5, "2025-06-21T08:00+02:00")
    assert 60.0 < east.sun_azimuth < 90.0
    assert east.sun_direction[0] > 0.5  # +x is east


@pytest.mark.filterwarnings("error")
def test_pvlib_s_own_calls_of_pandas_warn_nobody(epw):
    weather.read_weather(epw)
    times = weather.hours_of_year(2025, 8.5)[:48]
    assert weather.clear_sky(times, 47.4, 8.5, 400.0, None)[0].max() > 0.0
    assert weather.sun_angles(times, 47.4, 8.5, 400.0)[0].max() > 0.0


@pytest.mark.parametrize(
    "time",
    [
        "2025-03-01T10:30+01:00",
        datetime.datetime(2025, 3, 1, 9, 30, tzinfo=datetime.UTC),
        np.datetime64("2025-03-01T09:30"),
    ],
)
def test_one_time_said_in_several_ways(time):
    assert sf.Sky(47.4, 8.5, time) == sf.Sky(47.4, 8.5, "2025-03-01T09:30Z")


def test_clear_skies_go_by_height_and_turbidity():
    low, high = (sf.Sky(47.4, 8.5, "2025-07-01T12:00Z", turbidity=t) for t in (5.0, 2.0))
    assert high.direct_normal > 1.2 * low.direct_normal
    assert high.diffuse < low.diffuse
    assert high.clearness > 6.2  # the last bin
    given = sf.Sky(47.4, 8.5, "2025-07-01T12:00Z", direct_normal=low.direct_normal, diffuse=low.diffuse)
    assert given == low
    assert sf.Sky(47.4, 8.5, "2025-07-01T12:00Z", altitude=3000.0).direct_normal > high.direct_normal * 0.9
    night = sf.Sky(47.4, 8.5, "2025-07-01T00:00Z")
    assert (night.direct_normal, night.diffuse) == (0.0, 0.0)


@pytest.mark.slow
def test_hours_of_files(epw):
    """The row of 12 to 13 hours on 21 June: the sun is where it is at half past eleven in UTC."""
    row = 24 * 171 + 12
    sky = sf.Sky.from_epw(epw, row)
    assert sky.direct_normal == pytest.approx(0.5 * ABOVE[row], abs=0.06)
    assert sky.diffuse == pytest.approx(0.1 * ABOVE[row], abs=0.06)
    same = sf.Sky(47.4, 8.5, "2025-06-21T11:30Z", direct_normal=1.0, diffuse=1.0, altitude=400.0)
    assert sky.sun_direction @ same.sun_direction > np.cos(np.radians(0.2))  # of another year


@pytest.mark.slow
def test_a_time_zone_that_the_sun_contradicts_is_not_taken(tmp_path, epw):
    right = weather.read_weather(epw)
    wrong = write_epw(tmp_path / "wrong.epw", ABOVE, 0.5 * ABOVE, 0.1 * ABOVE, zone=-2.0)
    with pytest.warns(UserWarning, match=r"its header says UTC-2, but its sun is that of UTC\+1, which is taken"):
        found = weather.read_weather(wrong)
    np.testing.assert_array_equal(found.times, right.times)


@pytest.mark.slow
def test_half_hours_of_zones_count(tmp_path):
    above = level_sun(20.0, 77.0, 5.5)
    path = write_epw(tmp_path / "half.epw", above, above, above, 20.0, 77.0, 5.5)
    assert weather.read_weather(path).times[0] == np.datetime64("2006-12-31T19:00")


def test_records_of_parts_of_hours_last_as_long_as_they_do(tmp_path, epw):
    """Two records an hour make what the hours make; the sun is a quarter of an hour from their middles."""
    above = level_sun(47.4, 8.5, 1.0, 2)
    halves = write_epw(tmp_path / "halves.epw", above, 0.5 * above, 0.1 * above, parts=2)
    found, hourly = weather.read_weather(halves), weather.read_weather(epw)
    assert (found.hours, hourly.hours) == (0.5, 1.0)
    quarter = np.timedelta64(15, "m")
    np.testing.assert_array_equal(found.times, np.ravel(hourly.times[:, None] + [-quarter, quarter]))
    roof = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    one, two = (sf.solar_irradiation(roof, epw=path, patches=145) for path in (epw, halves))
    assert one.hours == two.hours == 8760.0
    assert two.total == pytest.approx(one.total, rel=5e-3)
    row = 2 * (24 * 171 + 12) + 1
    same = sf.Sky(47.4, 8.5, "2025-06-21T11:45Z", direct_normal=1.0, diffuse=1.0, altitude=400.0)
    assert sf.Sky.from_epw(halves, row).sun_direction @ same.sun_direction > np.cos(np.radians(0.2))
    rows = halves.read_text().splitlines(keepends=True)
    (tmp_path / "uneven.epw").write_text("".join(rows[:-1]))
    with pytest.raises(sf.FileError, match=r"uneven\.epw: wanted equal parts of hours, got 1 to 2 records an hour"):
        weather.read_weather(tmp_path / "uneven.epw")


@pytest.mark.parametrize(
    ("latitude", "longitude", "zone"),
    [(1.37, 103.98, 8.0), (39.7, -105.0, -7.0), (-0.2, -78.5, -5.0), (-1.3, 36.8, 3.0)],
)
def test_clouds_of_afternoons_are_no_time_zone(tmp_path, latitude, longitude, zone):
    """Without radiation above the air: the header that is right stays, and one that is an hour off does not."""
    above = level_sun(latitude, longitude, zone, 12).reshape(-1, 12).mean(axis=1)
    missing = np.full(8760, 9999.0)
    noon = 12.0 + zone - longitude / 15.0
    cloudy = (np.arange(8760) % 24 + 0.5 > noon + 0.5) & (np.random.default_rng(0).random(365).repeat(24) < 0.8)
    figures = np.where(cloudy, 0.1, 0.6) * above, np.where(cloudy, 0.15, 0.1) * above
    right, late = (
        write_epw(tmp_path / f"{said}.epw", missing, *figures, latitude, longitude, said, 0.0)
        for said in (zone, zone + 1.0)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = weather.read_weather(right)
    assert found.times[0] == np.datetime64("2007-01-01T00:30") - np.timedelta64(int(zone), "h")
    told = re.escape(f"its header says UTC{zone + 1.0:+g}, but its sun is that of UTC{zone:+g}, which is taken")
    with pytest.warns(UserWarning, match=told):
        np.testing.assert_array_equal(weather.read_weather(late).times, found.times)


def test_files_that_are_no_weather(tmp_path):
    with pytest.raises(sf.FileError, match=r"none\.epw: No such file"):
        sf.Sky.from_epw(tmp_path / "none.epw", 0)
    (tmp_path / "text.epw").write_text("ply\nformat ascii 1.0\n")
    with pytest.raises(sf.FileError, match=r"text\.epw: is no EPW file of weather"):
        sf.Sky.from_epw(tmp_path / "text.epw", 0)
    gaps = np.where(np.arange(8760) == 7, 9999.0, 0.0)
    with pytest.raises(sf.FileError, match=r"gaps\.epw: 1 of its hours have no dni in W/m2"):
        weather.read_weather(write_epw(tmp_path / "gaps.epw", ABOVE, gaps, ABOVE))


def test_hours_of_a_year():
    hours = weather.hours_of_year(2025, 8.5)
    assert len(hours) == 8760
    assert hours[0] == np.datetime64("2024-12-31T23:30")  # half past midnight, an hour east of Greenwich
    assert len(weather.hours_of_year(2024, 0.0)) == 8784
    days = np.array(["2025-01-01T00:30", "2024-12-31T00:30"], "datetime64[ms]")
    assert weather.day_of_year(days).tolist() == [1, 366]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"direct_normal": 5.0}, "^diffuse: wanted with direct_normal"),
        ({"diffuse": 5.0}, "^direct_normal: wanted with diffuse"),
        ({"turbidity": 0.5}, r"^turbidity: wanted values in \[1, 20\]"),
        ({"turbidity": 3.0, "direct_normal": 1.0, "diffuse": 1.0}, "^turbidity: wanted without"),
        ({"altitude": 1e5}, "^altitude: wanted values in"),
        ({"latitude": 91.0}, "^latitude: wanted values in"),
        ({"longitude": 181.0}, "^longitude: wanted values in"),
        ({"albedo": -0.1}, "^albedo: wanted values in"),
    ],
)
def test_places_and_figures_are_checked(options, message):
    with pytest.raises(ValueError, match=message):
        sf.Sky(**({"latitude": 47.4, "longitude": 8.5, "time": "2025-06-21T12:00Z"} | options))


@pytest.mark.slow
@pytest.mark.parametrize("hour", [-1, 8760, 1.0, True])
def test_hours_that_a_file_has_not_are_refused(epw, hour):
    with pytest.raises(ValueError, match=r"^hour: wanted a whole number"):
        sf.Sky.from_epw(epw, hour)
