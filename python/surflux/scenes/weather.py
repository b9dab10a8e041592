"""Where the sun stands and what the weather brings: the only room of pvlib, the extra `solar`."""

import datetime
import warnings
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.types import Floats
from surflux._base.warn import warn

_STEP = np.timedelta64(30, "m")
# Half-hours east of Greenwich that a file's own sun is held against, and how much better one of them must fit.
_ZONES = np.arange(-24, 29) / 2.0
_BETTER = 0.01


@dataclass(frozen=True, eq=False)
class Weather:
    """Hours of weather at a place: times (h,) are UTC, datetime64[ms], in the middle of each."""

    latitude: float
    longitude: float
    altitude: float
    times: Any
    direct_normal: Floats
    diffuse: Floats


def _pvlib():
    try:
        import pandas
        import pvlib
    except ImportError as error:
        raise ImportError(f"sun and weather need pvlib: pip install 'surflux[solar]' ({error})") from error
    return pvlib, pandas


@contextmanager
def _own_calls_of_pvlib():
    """What pvlib calls is for its makers to change: no caller of ours is told that pandas will drop it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield


def utc(name, times):
    """(h,) datetime64[ms] in UTC of one time or several, each of which says its time zone.

    ISO text with an offset, aware datetimes and pandas' Timestamps, and datetime64, which is UTC.
    """
    if isinstance(times, (str, datetime.datetime, np.datetime64)):
        times = [times]
    try:
        found = [_utc(name, time) for time in times]
    except TypeError:
        raise ValueError(f"{name}: wanted a time or several, got {type(times).__name__}") from None
    if not found:
        raise ValueError(f"{name}: wanted at least one time, got none")
    return np.array(found, "datetime64[ms]")


def _utc(name, time):
    if isinstance(time, np.datetime64):
        if np.isnat(time):
            raise ValueError(f"{name}: wanted a time, got NaT")
        return time.astype("datetime64[ms]")
    if isinstance(time, str):
        try:
            time = datetime.datetime.fromisoformat(time)
        except ValueError:
            what = "wanted text such as 2025-06-21T12:00+02:00"
            raise ValueError(f"{name}: {what}, got {time!r}") from None
    if not isinstance(time, datetime.datetime) or time != time:
        raise ValueError(f"{name}: wanted a datetime, text or datetime64, got {time!r}")
    if time.utcoffset() is None:
        raise ValueError(f"{name}: wanted a time with its time zone, such as 2025-06-21T12:00+02:00, got {time}")
    return np.datetime64(time.astimezone(datetime.UTC).replace(tzinfo=None), "ms")


def hours_of_year(year, longitude):
    """(8760,) or (8784,): middles of all hours of a year, in the zone of full hours nearest to mean solar time."""
    check.count("year", year, 1950, 2100)
    zone = np.timedelta64(round(longitude / 15.0), "h")
    first, last = (np.datetime64(f"{y}-01-01T00:00", "ms") - zone for y in (year, year + 1))
    return np.arange(first + _STEP, last, np.timedelta64(1, "h"))


def day_of_year(times):
    """(h,) from 1."""
    return (times.astype("datetime64[D]") - times.astype("datetime64[Y]").astype("datetime64[D]")).astype(int) + 1


@_own_calls_of_pvlib()
def sun_angles(times, latitude, longitude, altitude):
    """(altitude, azimuth) of the sun in degrees, with refraction; azimuth clockwise from north (Reda and Andreas)."""
    pvlib, pandas = _pvlib()
    found = pvlib.solarposition.get_solarposition(
        pandas.DatetimeIndex(times).tz_localize("UTC"), latitude, longitude, altitude=altitude
    )
    return found["apparent_elevation"].to_numpy(float), found["azimuth"].to_numpy(float)


@_own_calls_of_pvlib()
def clear_sky(times, latitude, longitude, altitude, turbidity):
    """(direct normal, diffuse) in W/m2 of a clear sky, by Ineichen and Perez 2002.

    turbidity: of Linke; None for the monthly means of a map of the world.
    """
    pvlib, pandas = _pvlib()
    index = pandas.DatetimeIndex(times).tz_localize("UTC")
    if turbidity is None:
        turbidity = pvlib.clearsky.lookup_linke_turbidity(index, latitude, longitude)
    sun = pvlib.solarposition.get_solarposition(index, latitude, longitude, altitude=altitude)
    pressure = pvlib.atmosphere.alt2pres(altitude)
    mass = pvlib.atmosphere.get_absolute_airmass(
        pvlib.atmosphere.get_relative_airmass(sun["apparent_zenith"]), pressure
    )
    above = pvlib.irradiance.get_extra_radiation(index)
    found = pvlib.clearsky.ineichen(sun["apparent_zenith"], mass, turbidity, altitude=altitude, dni_extra=above)
    return tuple(np.nan_to_num(found[name].to_numpy(float)).clip(0.0) for name in ("dni", "dhi"))


def read_weather(path):
    """Weather of an EPW file: typical hours, whose years may differ from month to month.

    The time zone is the header's where the extraterrestrial radiation of the file agrees with it; where it fits the sun
    of another zone better, that one, with a warning.

    Raises:
        FileError: it cannot be read.
    """
    path = Path(check.path("epw", path))
    pvlib, _ = _pvlib()
    try:
        with open(path, encoding="utf-8", errors="replace") as file, _own_calls_of_pvlib():
            table, about = pvlib.iotools.read_epw(file)
        columns = {name: table[name].to_numpy(float) for name in ("dni", "dhi", "ghi", "etr")}
        wall = table.index.tz_localize(None).to_numpy().astype("datetime64[ms]") + _STEP
        place = [float(about[name]) for name in ("latitude", "longitude", "altitude", "TZ")]
    except OSError as error:
        raise _core.FileError(f"{path}: {error.strerror or error}") from None
    except (ValueError, KeyError, IndexError, TypeError) as error:
        raise _core.FileError(f"{path}: is no EPW file of weather ({error})") from None
    for name in ("dni", "dhi"):
        values = columns[name]
        if not np.isfinite(values).all() or values.min() < 0.0 or values.max() > 2000.0:
            missing = int(np.count_nonzero(~((values >= 0.0) & (values <= 2000.0))))
            raise _core.FileError(f"{path}: {missing} of its hours have no {name} in W/m2")
    latitude, longitude, altitude, zone = place
    if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0 and abs(zone) <= 15.0 and np.isfinite(altitude)):
        raise _core.FileError(f"{path}: its header has no place on earth: latitude, longitude, altitude, zone {place}")
    zone = _zone(path, wall, columns, place)
    times = wall - np.timedelta64(round(60.0 * zone), "m")
    return Weather(latitude, longitude, altitude, times, columns["dni"], columns["dhi"])


def _zone(path, wall, columns, place):
    """Hours east of Greenwich, by the file's header or by its own sun."""
    latitude, longitude, altitude, said = place
    own = columns["etr"] if np.ptp(columns["etr"]) > 0.0 and columns["etr"].max() < 2000.0 else columns["ghi"]
    if not np.ptp(own) > 0.0:
        return said

    def fit(zone):
        height, _ = sun_angles(wall - np.timedelta64(round(60.0 * zone), "m"), latitude, longitude, altitude)
        return np.corrcoef(np.sin(np.radians(height)).clip(0.0), own)[0, 1]

    here = fit(said)
    near = _ZONES[np.abs(_ZONES - longitude / 15.0) <= 3.0]
    fits = [fit(zone) for zone in near]
    best = near[int(np.argmax(fits))]
    if not max(fits) - here > _BETTER:
        return said
    warn(f"{path}: its header says UTC{said:+g}, but its sun is that of UTC{best:+g}, which is taken")
    return float(best)
