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

_HOUR = 3_600_000  # ms
# Half-hours east of Greenwich that a file's own sun is held against, and how much better one of them must fit: in
# correlation with what arrives above the air; in the share of time that is light while the sun is up and dark while it
# is not, of which half an hour is a twenty-fourth: both ends of the day move.
_ZONES = np.arange(-24, 29) / 2.0
_BETTER, _BETTER_LIGHT = 0.01, 0.02
# Near the equator hours tell half-hours hardly apart: of two zones as good that of full hours, of which there are more.
_HALF = 0.002
_LIGHT = 1.0  # W/m2: from there on a record is no night


@dataclass(frozen=True, eq=False)
class Weather:
    """Records of weather at a place: times (h,) are UTC, datetime64[ms], in the middle of each; hours: each lasts."""

    latitude: float
    longitude: float
    altitude: float
    times: Any
    direct_normal: Floats
    diffuse: Floats
    hours: float


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
    first, last = (np.datetime64(f"{y}-01-01T00:30", "ms") - zone for y in (year, year + 1))
    return np.arange(first, last, np.timedelta64(1, "h"))


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
    """Weather of an EPW file: typical hours, whose years may differ from month to month; or parts of hours.

    The time zone is the header's where the extraterrestrial radiation of the file agrees with it; where it fits the sun
    of another zone better, that one, with a warning. In a file without that radiation, morning's first and evening's
    last light say the same, which clouds of one half of the day do not move.

    Raises:
        FileError: it cannot be read.
    """
    path = Path(check.path("epw", path))
    pvlib, _ = _pvlib()
    try:
        with open(path, encoding="utf-8", errors="replace") as file, _own_calls_of_pvlib():
            table, about = pvlib.iotools.read_epw(file)
        if not len(table):
            raise ValueError("without records")
        columns = {name: table[name].to_numpy(float) for name in ("dni", "dhi", "etr")}
        begins = table.index.tz_localize(None).to_numpy().astype("datetime64[ms]")
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
    wall, hours = _middles(path, begins)
    zone = _zone(path, wall, hours, columns, place)
    times = wall - np.timedelta64(round(60.0 * zone), "m")
    return Weather(latitude, longitude, altitude, times, columns["dni"], columns["dhi"], hours)


def _middles(path, begins):
    """(middles (h,), hours that each lasts) of records in the hours that begin then; those of one hour share it."""
    first = np.flatnonzero(np.r_[True, begins[1:] != begins[:-1]])
    each = np.diff(np.r_[first, len(begins)])
    if each.min() != each.max() or _HOUR % each[0]:
        counts = f"{each.min()} to {each.max()}" if each.min() != each.max() else str(each[0])
        raise _core.FileError(f"{path}: wanted equal parts of hours, got {counts} records an hour")
    lasts = np.timedelta64(_HOUR // int(each[0]), "ms")
    which = np.arange(len(begins)) - np.repeat(first, each)
    return begins + which * lasts + lasts / 2, 1.0 / int(each[0])


def _zone(path, wall, hours, columns, place):
    """Hours east of Greenwich, by the file's header or by its own sun."""
    latitude, longitude, altitude, said = place
    above, light = columns["etr"], columns["dni"] + columns["dhi"]
    zones = np.r_[said, _ZONES[np.abs(_ZONES - longitude / 15.0) <= 3.0]]

    def heights(offsets):
        """(zones, offsets, h) of the sun, in degrees, so many hours from the middles; each time is looked up once."""
        seconds = np.round(3600.0 * (np.asarray(offsets) - zones[:, None])).astype("timedelta64[s]")
        times, where = np.unique(wall + seconds[..., None], return_inverse=True)
        found, _ = sun_angles(times, latitude, longitude, altitude)
        return found[where].reshape(len(zones), -1, len(wall))

    if np.ptp(above) > 0.0 and above.max() < 2000.0:
        better = _BETTER
        fits = [np.corrcoef(sine, above)[0, 1] for sine in np.sin(np.radians(heights([0.0])[:, 0])).clip(0.0)]
    elif light.max() >= _LIGHT > light.min():
        better = _BETTER_LIGHT
        up = np.mean(heights(hours * np.linspace(-0.5, 0.5, 5)) > 0.0, axis=1)  # the part of each record
        fits = np.mean(np.where(light >= _LIGHT, up, 1.0 - up), axis=1) - _HALF * (zones % 1.0 != 0.0)
    else:
        return said
    best = zones[int(np.argmax(fits))]
    if not max(fits) - fits[0] > better:
        return said
    warn(f"{path}: its header says UTC{said:+g}, but its sun is that of UTC{best:+g}, which is taken")
    return float(best)
