"""Light for what has none: a soft lamp over the camera's left shoulder, and a sky all around that fills shadows."""

import numpy as np

from surflux.scenes.lights import AreaLight, Environment

_SKY = 0.35  # radiance
BACKDROP = 0.25  # display value, from 0 to 1, of what is seen behind: grey surfaces stand out from it
_KEY = 2.8  # irradiance of what faces the key light, in the middle
_FROM = (-0.8, 0.9, -0.5)  # to the right, up and forward in the picture
_FAR, _SIDE = 4.0, 2.0  # radii of a ball around the points: the lamp's distance, and its side


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
