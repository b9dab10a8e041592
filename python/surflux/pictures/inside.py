"""The camera of a picture of what lies all around a place, as a room does around a scanner."""

import numpy as np

from surflux.pictures.camera import Camera

_BANDS, _SECTORS = 12, 24  # of equal height and angle: cells of equal solid angle
_AROUND = 0.6  # of the cells, that points in all directions fill at least
_POINTS = 20_000  # looked at, at most
_ABOVE = 4  # bands that a ceiling is in
_LEVEL = 0.4  # sine of the angle over or under the horizon that is looked at
_BESIDE = 2  # sectors on either side that a picture shows
_FOV = 75.0


def lies_around(points, place):
    """Whether points (n, 3) are seen in most directions from a place (3,)."""
    _, bands, sectors = _cells(points, place, (0.0, 0.0, 1.0))
    return _are_filled(bands, sectors, 0)


def is_room_around(points, place, up):
    """Whether points (n, 3) are seen in most directions from a place (3,), above it too: walls and a ceiling."""
    if not lies_around(points, place):
        return False
    _, bands, sectors = _cells(points, place, up)
    return _are_filled(bands, sectors, _BANDS - _ABOVE)


def clearance(points, place, up):
    """How far above a place (3,) the nearest points (n, 3) are, but for a few, or those around a skylight; 0: none."""
    distances, bands, _ = _cells(points, place, up)
    for band in range(_BANDS - 1, _BANDS - 1 - _ABOVE, -1):
        above = distances[bands == band]
        if len(above):
            return np.quantile(above, 0.1) * _sine(band)
    return 0.0


def camera_inside(points, place, up):
    """The Camera at a place (3,) that looks level, to where points (n, 3) are farthest."""
    distances, bands, sectors = _cells(points, place, up)
    level = np.abs(_sine(bands)) < _LEVEL
    far = np.zeros(_SECTORS)
    for sector in range(_SECTORS):
        there = distances[level & (sectors == sector)]
        far[sector] = np.median(there) if len(there) else 0.0
    seen = sum(np.roll(far, shift) for shift in range(-_BESIDE, _BESIDE + 1))
    angle = (np.argmax(seen) + 0.5) / _SECTORS * 2.0 * np.pi - np.pi
    across = _axes(up)
    return Camera(place, place + np.cos(angle) * across[0] + np.sin(angle) * across[1], up=up, fov=_FOV)


def _are_filled(bands, sectors, lowest):
    """Whether most of the cells have points, of the bands from the lowest one that counts."""
    filled = len(np.unique((bands * _SECTORS + sectors)[bands >= lowest]))
    return filled >= _AROUND * (_BANDS - lowest) * _SECTORS


def _sine(band):
    """Of the angle over the horizon, in the middle of a band."""
    return (band + 0.5) / _BANDS * 2.0 - 1.0


def _cells(points, place, up):
    """(distances, band over the horizon, sector around what is up) of some of the points, as the place sees them."""
    to = points[:: -(-len(points) // _POINTS)] - place
    distances = np.linalg.norm(to, axis=1)
    to, distances = to[distances > 0.0], distances[distances > 0.0]
    to /= distances[:, None]
    across = _axes(up)
    height = to @ (np.asarray(up) / np.linalg.norm(up))
    turn = np.arctan2(to @ across[1], to @ across[0])
    bands = np.minimum((height + 1.0) / 2.0 * _BANDS, _BANDS - 1).astype(int)
    sectors = np.minimum((turn + np.pi) / (2.0 * np.pi) * _SECTORS, _SECTORS - 1).astype(int)
    return distances, bands, sectors


def _axes(up):
    """Two unit vectors, across what is up and each other."""
    up = np.asarray(up, np.float64) / np.linalg.norm(up)
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    first = np.cross(up, np.cross(first, up))
    first /= np.linalg.norm(first)
    return first, np.cross(up, first)
