"""Where the input of `surflux solar` lies, how its coordinates become metres with +y to the north, and its weather."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.passes import LOG
from surflux._base.warn import warn
from surflux.scans.formats import MESHES
from surflux.scans.georeference import georeference
from surflux.scenes import weather

_UNLOCATED = {".toml", *(f".{suffix}" for suffix in MESHES)}  # files that have no coordinate reference system
_FAR = 50.0  # km, from where a place is not the one of the weather any more
_EARTH = 6371.0  # km
_SMALL = 1.0  # m, from end to end: no roof
_NONE = "--place: wanted LAT,LON in degrees"


@dataclass(frozen=True)
class Frame:
    """Metres, x to the east, y to true north, z up, around the origin of the file, where a scanner may have stood."""

    north: float = 0.0  # degrees clockwise from the file's +y
    horizontal: float = 1.0  # metres of the file's unit
    vertical: float = 1.0

    def points(self, points):
        """(n, 3) of points in the file's coordinates."""
        return np.asarray(points) * [self.horizontal, self.horizontal, self.vertical] @ self._turn().T

    def normals(self, normals):
        """(n, 3), unit, of normals in the file's coordinates."""
        found = normals / [self.horizontal, self.horizontal, self.vertical] @ self._turn().T
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    def matrix(self):
        """(4, 4), as Surfels.transformed takes it; of a frame with one unit."""
        out = np.eye(4)
        out[:3, :3] = self.horizontal * self._turn()
        return out

    def _turn(self):
        angle = np.radians(self.north)
        return np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class Site:
    """A Frame, and what solar_irradiation takes of the place and its weather, with words for it."""

    frame: Frame
    place: tuple[float, float]
    hours: dict  # arguments of solar_irradiation
    words: str  # what the picture is of: "2025 under clear skies"


def check_weather(options):
    """Refuses what says no weather, or more than one, before anything is read."""
    given = [name for name in ("epw", "year", "time") if getattr(options, name) is not None]
    if len(given) != 1:
        said = " and ".join(f"--{name}" for name in given) or "none"
        raise ValueError(f"--epw: wanted one of --epw FILE, --year YEAR and --time ISO, got {said}")
    if options.epw is not None:
        for name in ("place", "altitude"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: goes with --year or --time; a file of weather has a place of its own")
        return weather.read_weather(options.epw)
    if options.place is not None:
        check.number("--place: latitude", options.place[0], -90.0, 90.0)
        check.number("--place: longitude", options.place[1], -180.0, 180.0)
    if options.year is not None:
        check.count("--year", options.year, 1950, 2100)
    else:
        weather.utc("--time", options.time)
    weather.sun_angles(weather.utc("--time", "2025-01-01T00:00Z"), 0.0, 0.0, 0.0)  # where pvlib is missing, at once
    return None


def site_of(options, points, found):
    """The Site of points (n, 3) in the input's coordinates.

    found: what check_weather gave. What is taken for granted is logged.
    """
    about = _georeference(options, 0.5 * (points.min(axis=0) + points.max(axis=0))[:2])
    horizontal = vertical = 1.0 if options.unit is None else options.unit
    if about is not None and options.unit is None:
        horizontal = about.horizontal
        vertical = horizontal if about.vertical is None else about.vertical
    north = options.north if options.north is not None else 0.0 if about is None else about.north
    frame = Frame(north, horizontal, vertical)
    _warn_of_small_sites(options, frame.horizontal * np.ptp(points[:, :2], axis=0).max())
    place = options.place
    if place is None and found is not None:
        place = found.latitude, found.longitude
    if place is None and about is not None:
        place = about.latitude, about.longitude
    if place is None:
        raise ValueError(f"{_NONE}, for {options.input} has no coordinate reference system that says it")
    _say_where(options, frame, about, place)
    if about is not None:
        _check_distance((about.latitude, about.longitude), place, found is not None)
    hours = {"albedo": options.albedo}
    if found is not None:
        return Site(frame, place, hours | {"epw": options.epw}, f"a year's weather of {Path(options.epw).name}")
    hours |= {"place": place, "times": options.time if options.year is None else options.year}
    if options.altitude is not None:
        hours["altitude"] = options.altitude
    elif about is not None:
        hours["altitude"] = float(np.clip(vertical * np.median(points[:, 2]), -500.0, 9000.0))
    else:
        LOG.info("the skies are those at the level of the sea: at 500 m a roof has 2 % more in a year (--altitude M)")
    LOG.info("skies are clear in all hours; with clouds it is less: --epw FILE has a typical year's")
    if options.year is None:
        return Site(frame, place, hours, f"{check.counted(len(options.time), 'clear hour')}")
    return Site(frame, place, hours, f"{options.year} under clear skies")


def _warn_of_small_sites(options, width):
    if width < _SMALL:
        warn(
            f"{options.input}: all of it lies within {width:.2g} m; longitudes and latitudes have to be projected to "
            "metres (pyproj), other units are told by --unit, metres of one"
        )


def _georeference(options, place):
    """The Georeference of a file of points, or None; --place goes without one that cannot be read."""
    if Path(options.input).suffix.lower() in _UNLOCATED:
        return None
    try:
        return georeference(options.input, place)
    except (sf.FileError, ImportError) as error:
        if options.place is None:
            raise type(error)(f"{error}; or say --place LAT,LON, --north DEGREES and --unit METRES") from None
        warn(f"{error}; --north and --unit say what they differ by from +y and metres")
        return None


def _say_where(options, frame, about, place):
    unknown = [text for text in ("north", "unit") if about is None and getattr(options, text) is None]
    towards = f"{frame.north:.2f} degrees clockwise from +y" if frame.north else "+y"
    units = f"{frame.horizontal:g} m" + (f", of z {frame.vertical:g} m" if frame.vertical != frame.horizontal else "")
    if about is not None and about.vertical is None and options.unit is None:
        units += " (of z as well, of which the file does not say it)"
    note = f", as nothing says otherwise (--{', --'.join(unknown)})" if unknown else ""
    by = f", by {about.name}" if about is not None else ""
    LOG.info("%s: z is up, north is %s, the unit is %s%s%s", place_text(place), towards, units, by, note)
    if options.up is not None and tuple(options.up[:2]) != (0.0, 0.0):
        LOG.info(
            "--up is of the picture alone: a file with another axis up goes into a scene file, whose objects take up"
        )


def place_text(place):
    """44.051 N, 123.071 W."""
    (north, east) = place
    return f"{abs(north):.3f} {'S' if north < 0.0 else 'N'}, {abs(east):.3f} {'W' if east < 0.0 else 'E'}"


def _check_distance(here, place, of_weather):
    a, b = np.radians(here), np.radians(place)
    half = np.sin(0.5 * (b - a)) ** 2
    apart = 2.0 * _EARTH * np.arcsin(np.sqrt(half[0] + np.cos(a[0]) * np.cos(b[0]) * half[1]))
    if apart > _FAR:
        what = "the weather is" if of_weather else "--place is"
        warn(f"{what} of {place_text(place)}, {apart:.0f} km from the points, and so is the sun")
