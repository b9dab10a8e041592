"""The hours of sun and sky that solar_irradiation is asked for."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from surflux._base import check
from surflux._base.types import Floats
from surflux.scenes import weather
from surflux.scenes.sky import Sky, hours_at, hours_of_weather, place_of
from surflux.scenes.sky_hours import SkyHours, sun_directions

_ALBEDO = 0.2  # as of Sky
_STEPS = 4  # positions of the sun in each hour of a year


@dataclass(frozen=True, eq=False)
class SolarWeather:
    """skies: SkyHours; suns: (h, steps, 3), the sun in each; times: (h,) UTC, None of Skies; hours: that each lasts."""

    skies: SkyHours
    suns: Floats
    times: Any
    hours: float


def solar_weather(place, times, epw, skies, hours, steps, *, albedo, altitude, **figures):
    """SolarWeather, of one of a place and times, a file, and Skies; figures: direct_normal, diffuse, turbidity."""
    each = 1.0 if hours is None else check.number("hours", hours, 0.0, 8784.0, low_open=True)
    if steps is not None:
        check.count("steps", steps, 1, 60)
    said = [name for name, value in (("times", times), ("epw", epw), ("skies", skies)) if value is not None]
    if len(said) != 1:
        raise ValueError(f"times: wanted one of times, epw and skies, got {' and '.join(said) or 'none'}")
    if said != ["times"]:
        for name, value in {"place": place, "altitude": altitude, **figures}.items():
            if value is not None:
                raise ValueError(f"{name}: goes with times; {said[0]} cannot take it")
    if skies is not None:
        if albedo is not None:
            raise ValueError("albedo: goes with times and epw; skies have their own")
        if steps is not None:
            raise ValueError("steps: goes with times and epw; a sky has its sun in one place")
        return _of_skies(skies, each)
    albedo = _ALBEDO if albedo is None else check.number("albedo", albedo, 0.0, 1.0)
    if epw is not None:
        found = weather.read_weather(epw)
        place, altitude, at = (found.latitude, found.longitude), found.altitude, found.times
        several, each = True, found.hours
        of = hours_of_weather(found, albedo)
    else:
        place = _place(place)
        several = isinstance(times, (int, np.integer)) and not isinstance(times, bool)
        altitude = 0.0 if altitude is None else altitude
        at = weather.hours_of_year(times, place[1]) if several else weather.utc("times", times)
        of = hours_at(place, at, altitude=altitude, albedo=albedo, **figures)
    if several and hours is not None:
        raise ValueError("hours: goes with times one by one, and skies; those of a year last one, and epw says its own")
    steps = (_STEPS if several else 1) if steps is None else steps
    suns = of.suns[:, None]
    if steps > 1:
        shifts = (((np.arange(steps) + 0.5) / steps - 0.5) * each * 3.6e6).astype("timedelta64[ms]")
        angles = weather.sun_angles((at[:, None] + shifts).ravel(), *place, altitude)
        suns = sun_directions(*angles).reshape(len(at), steps, 3)
    return SolarWeather(of, suns, at, each)


def _place(place):
    if not isinstance(place, (tuple, list, np.ndarray)) or len(place) != 2:
        raise ValueError(f"place: wanted (latitude, longitude) in degrees, got {place!r}")
    return place_of(*place)


def _of_skies(skies, hours):
    skies = [skies] if isinstance(skies, Sky) else skies
    if not isinstance(skies, (list, tuple)) or not all(isinstance(sky, Sky) for sky in skies) or not skies:
        raise ValueError("skies: wanted a Sky or a list of at least one, got another thing")
    each = [sky._hours for sky in skies]
    if len({of.albedo for of in each}) > 1:
        raise ValueError("skies: wanted one albedo in all of them, got several")
    names = ("suns", "direct_normal", "diffuse", "days")
    of = SkyHours(*(np.concatenate([getattr(sky, name) for sky in each]) for name in names), each[0].albedo)
    return SolarWeather(of, of.suns[:, None], None, hours)
