"""Light for what has none: a soft lamp over the camera's left shoulder, or over it in a room, and a sky; or the sun."""

import numpy as np

from surflux.pictures.inside import clearance
from surflux.points.surfels import Surfels
from surflux.scenes.lights import AreaLight, DirectionalLight, Environment
from surflux.scenes.sky import Sky
from surflux.scenes.transform import turn_to_z

_SKY = 0.35  # radiance
BACKDROP = 0.25  # display value, from 0 to 1, of what is seen behind: grey surfaces stand out from it
_KEY = 2.8  # irradiance of what faces the key light, in the middle
_FROM = (-0.8, 0.9, -0.5)  # to the right, up and forward in the picture
_FAR, _SIDE = 4.0, 2.0  # radii of a ball around the points: the lamp's distance, and its side
_ROOM, _LAMP = 1.0, 0.2  # mean irradiance of a room without shadows; its lamp's side, over the way up to the ceiling
_SUN_HIGH, _SUN_LEFT = 40.0, 60.0  # degrees: over the horizon, and left of the way back to the camera
_SUN, _CLEAR = 800.0, 100.0  # W/m2 of the sun on what faces it, and of a clear sky on a level plane
# Of a ground: its side, over the size of what stands on it; cells along that; the share of points beneath it.
_WIDE, _CELLS, _BELOW = 3.0, 48, 0.002


def studio(surfels, camera):
    """The lights: an Environment and an AreaLight behind the camera's left shoulder, whatever is up there."""
    right, down, forward = camera._axes()
    low, high = (surfels.points + sign * surfels.radii[:, None] for sign in (-1, 1))
    low, high = low.min(axis=0), high.max(axis=0)
    middle, reach = 0.5 * (low + high), 0.5 * np.linalg.norm(high - low)
    towards = np.array(_FROM) / np.linalg.norm(_FROM)
    towards = towards[0] * right - towards[1] * down + towards[2] * forward
    u = np.cross(down, towards)
    u *= _SIDE * reach / np.linalg.norm(u)
    v = np.cross(towards, u)  # u x v faces back, along -towards
    v *= -_SIDE * reach / np.linalg.norm(v)
    exitance = _KEY * np.pi * _FAR**2 / _SIDE**2
    corner = middle + _FAR * reach * towards - 0.5 * (u + v)
    return [Environment(_SKY), AreaLight(corner, u, v, exitance)]


def room_light(surfels, camera, up):
    """The lights of a room that the camera stands in: half way up to its ceiling a square that shines up and down, and
    an Environment in its windows."""
    up = np.asarray(up, np.float64) / np.linalg.norm(up)
    far = clearance(surfels.points, camera.eye, up)
    u = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    u *= _LAMP * far / np.linalg.norm(u)
    v = np.cross(u, up)  # u x v faces down
    place = camera.eye + 0.5 * far * up
    to = surfels.points - place
    squares = np.maximum(np.einsum("ij,ij->i", to, to), u @ u)
    cosines = np.abs(np.einsum("ij,ij->i", to, surfels.normals)) * np.abs(to @ up)  # whichever way normals face
    areas = surfels.areas if np.any(surfels.areas) else np.ones(len(surfels))
    per_exitance = np.average(cosines / squares**2, weights=areas) * (u @ u) / np.pi
    exitance = _ROOM / per_exitance if per_exitance > 0.0 else _ROOM
    corner = place - 0.5 * (u + v)
    return [Environment(_SKY), AreaLight(corner, u, v, exitance), AreaLight(corner, v, u, exitance)]


def daylight(camera, up=(0.0, 0.0, 1.0)):
    """The lights of a clear day, the sun 40 degrees high over the camera's left shoulder: where z is up, a Sky."""
    turn = turn_to_z(np.asarray(up, np.float64) / np.linalg.norm(up))
    _, down, forward = (turn @ axis for axis in camera._axes())
    x, y, _ = forward if abs(forward[2]) < 0.9 else -down  # of who looks down, what is up in the picture
    left = np.radians(_SUN_LEFT)
    back = -np.cos(left) * x - np.sin(left) * y, -np.cos(left) * y + np.sin(left) * x
    day = clear_day(np.degrees(np.arctan2(back[0], back[1])))
    if np.array_equal(turn, np.eye(3)):
        return [day]
    return [day.environment()._turned(turn.T), DirectionalLight(turn.T @ day.sun.direction, day.sun.irradiance)]


def clear_day(azimuth=150.0):
    """A Sky of a clear day, the sun so many degrees clockwise from +y: of the north in the late morning."""
    return Sky.from_sun(_SUN_HIGH, azimuth, direct_normal=_SUN, diffuse=_CLEAR)


def ground(surfels, up, reflectance=0.4):
    """Surfels of a level square beneath all others, but for a few that stray below it."""
    up = np.asarray(up, np.float64) / np.linalg.norm(up)
    heights = surfels.points @ up
    level = np.quantile(heights, _BELOW)
    low, high = np.quantile(surfels.points, [_BELOW, 1.0 - _BELOW], axis=0)
    middle = 0.5 * (low + high)
    middle += (level - middle @ up) * up
    u = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    u *= 0.5 * _WIDE * np.linalg.norm(high - low) / np.linalg.norm(u)
    v = np.cross(up, u)
    corners = [middle - u - v, middle + u - v, middle + u + v, middle - u + v]
    side = 2.0 * np.linalg.norm(u) / _CELLS
    return Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=side * side, reflectance=reflectance)
