"""Where on earth the points of a file lie: the coordinate reference system of LAS files, by pyproj (surflux[solar])."""

import os
from dataclasses import dataclass

import numpy as np

from surflux._base.files import file_error
from surflux.scans.formats import format_of
from surflux.scans.laz import backends
from surflux.scans.outside import outside

# Keys of GeoTIFF, and the units that they name by EPSG's numbers, in metres.
_MODEL, _LINEAR, _VERTICAL_SYSTEM, _VERTICAL_UNIT = 1024, 3076, 4096, 4099
_PROJECTED = 1
_UNITS = {9001: 1.0, 9002: 0.3048, 9003: 1200.0 / 3937.0}
_KEYS, _WKT = 34735, 2112  # numbers of the records that hold a system
_STEP = 1e-4  # degrees, over which directions on the grid are found
_SAME = 1e-5  # of a unit: feet of both kinds are the same here, metres and feet are not


@dataclass(frozen=True)
class Georeference:
    """Of a place in a file.

    Attributes:
        name: of the coordinate reference system.
        latitude, longitude: degrees, north and east.
        north: degrees from the grid's +y to true north, clockwise seen from above.
        horizontal: metres of the unit of x and y.
        vertical: metres of that of z; None where the file does not say.
    """

    name: str
    latitude: float
    longitude: float
    north: float
    horizontal: float
    vertical: float | None


def georeference(path, place):
    """The Georeference at a place (x, y) of a file; None of one that names no coordinate reference system.

    Raises:
        FileError: the system cannot be read or understood, has degrees for coordinates, or contradicts itself.
        ImportError: pyproj is not there (`pip install 'surflux[solar]'`).
    """
    if format_of(path) != "las":
        return None
    with outside(path, "laspy"):
        import laspy

        with laspy.open(path, laz_backend=backends()) as reader:
            records = [*reader.header.vlrs, *(reader.evlrs or ())]
            header = reader.header
    records = [r for r in records if r.user_id == "LASF_Projection" and r.record_id in (_KEYS, _WKT)]
    if not records:
        return None
    try:
        import pyproj
    except ImportError as error:
        path = os.fsdecode(path)
        raise ImportError(f"{path}: its place on earth needs pyproj: pip install 'surflux[solar]' ({error})") from error
    keys = {key.id: key.value_offset for r in records for key in getattr(r, "geo_keys", ())}
    try:
        system = header.parse_crs()
    except pyproj.exceptions.CRSError as error:
        said = " ".join(str(error).split())[:200]
        raise file_error(path, f"its coordinate reference system is not understood ({said})") from error
    horizontal = None if system is None else _horizontal(system)
    if horizontal is None or (horizontal.is_geographic and keys.get(_MODEL) == _PROJECTED):
        raise file_error(path, "its coordinate reference system is not understood: it has no EPSG code and no WKT")
    if horizontal.is_geographic:
        raise file_error(path, f"its coordinates are degrees ({horizontal.name}); wanted lengths: project it first")
    if not horizontal.is_projected:
        raise file_error(path, f"its coordinate reference system is of no projection ({horizontal.name})")
    unit = _unit_of(path, horizontal, keys)
    latitude, longitude, north = _on_earth(path, horizontal, place)
    return Georeference(horizontal.name, latitude, longitude, north, unit, _height_unit(path, system, keys))


def _horizontal(system):
    """The part of a system that has x and y."""
    system = system.sub_crs_list[0] if system.is_compound else system
    return system.source_crs if system.is_bound else system


def _unit_of(path, horizontal, keys):
    unit = horizontal.axis_info[0].unit_conversion_factor
    said = _UNITS.get(keys.get(_LINEAR), unit)
    if abs(said - unit) > _SAME * unit:
        raise file_error(path, f"x and y are {unit:g} m by its coordinate reference system, {said:g} m by its unit")
    return unit


def _height_unit(path, system, keys):
    """Metres of the unit of z; None where nothing says it."""
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    for axis in system.axis_info:
        if axis.direction == "down":
            raise file_error(path, "z goes downwards by its coordinate reference system; wanted heights")
        if axis.direction == "up":
            return axis.unit_conversion_factor
    if keys.get(_VERTICAL_UNIT) in _UNITS:
        return _UNITS[keys[_VERTICAL_UNIT]]
    try:
        return CRS.from_epsg(keys[_VERTICAL_SYSTEM]).axis_info[0].unit_conversion_factor
    except (KeyError, CRSError, IndexError):  # files have datums here, too
        return None


def _on_earth(path, horizontal, place):
    """(latitude, longitude, degrees from +y to true north) of a place."""
    from pyproj import Transformer

    to_earth = Transformer.from_crs(horizontal, "EPSG:4326", always_xy=True)  # Greenwich and degrees, whatever its own
    longitude, latitude = to_earth.transform(*place)
    if not (np.isfinite([longitude, latitude]).all() and abs(latitude) < 90.0 - _STEP):
        x, y = place
        raise file_error(path, f"x, y = {x:g}, {y:g} is no place on earth in {horizontal.name}")
    x, y = to_earth.transform(
        [longitude, longitude, longitude + _STEP], [latitude, latitude + _STEP, latitude], direction="INVERSE"
    )
    north, east = (np.array([x[k] - x[0], y[k] - y[0]]) for k in (1, 2))
    if not east[0] * north[1] - east[1] * north[0] > 0.0:
        raise file_error(path, f"x and y of {horizontal.name} do not go east and north")
    return latitude, longitude, float(np.degrees(np.arctan2(*north)))
