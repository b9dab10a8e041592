"""Lamps so close to a surface that their spot on it is met by few paths that start elsewhere."""

import numpy as np

from surflux._base.warn import warn
from surflux.scenes.lights import AreaLight, PhotometricLight, PointLight, SpotLight

_CLOSE = 0.05  # of the distance from where light is asked for
_NONE = 1e-5  # of what is close: rounding
_ENOUGH = 16  # paths that meet the spot, of those from a place


def warn_of_close_lamps(scene, points, samples):
    """Says which light's spot so many paths from points (m, 3) hardly meet, so that these know little of its light."""
    for number, light in enumerate(scene.lights):
        place, wide = _extent(light)
        if place is None:
            continue
        away = float(np.median(np.linalg.norm(points - place, axis=1)))
        spot = max(_distance(scene, light, place, _CLOSE * away), wide)
        met = samples * (spot / away) ** 2 if away > 0.0 else np.inf
        if spot < _CLOSE * away and met < _ENOUGH:
            warn(
                f"light {number} ({type(light).__name__}) is so close to a surface that {met:.1g} of {samples} paths "
                "meet its spot there: what that reflects is uncertain, by more than the standard error says; "
                f"{_ENOUGH * (away / spot) ** 2:.0e} samples would tell it"
            )


def _extent(light):
    """(where a light is, half its width); (None, 0) of none that has a place or any power."""
    if isinstance(light, PointLight | SpotLight | PhotometricLight) and np.any(light.intensity):
        return np.asarray(light.position, float), 0.0
    if isinstance(light, AreaLight) and np.any(light.exitance):
        u, v = np.asarray(light.edge_u, float), np.asarray(light.edge_v, float)
        return np.asarray(light.corner, float) + 0.5 * (u + v), 0.5 * np.sqrt(np.linalg.norm(np.cross(u, v)))
    return None, 0.0


def _distance(scene, light, place, within):
    """From a light to the nearest surfel that it shines on, if that is `within`; else infinity."""
    nearest = np.inf
    for s in scene.objects:
        to = s.points - place
        some = np.flatnonzero(np.linalg.norm(to, axis=1) < s.radii + within)
        height = -np.einsum("ij,ij->i", to[some], s.normals[some])  # over the surfel's plane
        foot = place - height[:, None] * s.normals[some]
        # What lies in a surface lights none of it, and what is black reflects nothing.
        near = (height > _NONE * within) & (height < within) & s.reflectance[some].any(axis=1)
        near &= _shines(light, -s.normals[some]) & (np.linalg.norm(s.points[some] - foot, axis=1) <= s.radii[some])
        patches = np.isin(s.triangle_surfel, some[near])
        over = s.triangle_surfel[patches][_are_inside(s.triangles[patches], place)]
        is_patch = np.isin(some, s.triangle_surfel)
        near &= ~is_patch | np.isin(some, over)
        nearest = min(nearest, height[near].min(initial=np.inf))
    return nearest


def _are_inside(triangles, place):
    """(t,) whether a place is straight over triangles (t, 3, 3)."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    normal = np.cross(sides[:, 0], sides[:, 1])
    return (np.einsum("tki,ti->tk", np.cross(sides, place - triangles), normal) >= 0.0).all(axis=1)


def _shines(light, directions):
    """(m,) whether a light has a part to send along unit directions (m, 3)."""
    if isinstance(light, PointLight):
        return np.ones(len(directions), bool)
    if isinstance(light, SpotLight):
        axis = np.asarray(light.direction, float) / np.linalg.norm(light.direction)
        return directions @ axis > np.cos(np.radians(0.5 * light.cone))
    if isinstance(light, PhotometricLight):
        return light._shares(directions) > 0.0
    front = np.cross(light.edge_u, light.edge_v)
    return directions @ front > 0.5 * np.linalg.norm(front)
