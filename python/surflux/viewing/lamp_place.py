"""Where a lamp goes that nobody has placed: into the air that a camera sees, where it lights most of what is seen."""

import numpy as np

from surflux import _core
from surflux.scenes.lights import PointLight

_SIGHTS = 24, 18  # lines of sight through the picture that ask what is seen
# Places tried: on lines of sight through these parts of the picture's width and height, so that the lamp is in the
# picture, at these parts of the way to what is seen there.
_ACROSS, _DOWN = (0.2, 0.35, 0.5, 0.65, 0.8), (0.2, 0.3, 0.4, 0.5)
_AHEAD = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
_FLAT = np.sin(np.radians(30.0))  # of the angle between lamp and eye, as points see it, below which light looks flat
_MIDDLE = 0.8  # of the best place: the middle of the scene is taken if it is as good as that


def lamp_in_view(scene, camera, size):
    """A point light in the air that a Camera sees, with an irradiance of about 1 W/m2 where it faces what is seen.

    Args:
        scene: Scene.
        camera: Camera. size: (width, height) of its picture.
    """
    low, high = scene.surfels.bounds
    place, reach = (low + high) / 2, (high - low) / 2
    seen = _seen(scene, camera, size)
    if seen is not None:
        places = np.concatenate([place[None], _places(scene, camera, size, place)])
        merit = _merit(scene, camera, *seen, places)
        if merit[0] < _MIDDLE * merit.max():
            place = places[np.argmax(merit)]
        reach = seen[1] - place
    return PointLight(place, float(np.mean(np.sum(reach**2, axis=-1))))


def _merit(scene, camera, surfels, points, places):
    """(m,) 0 to 1: how well a lamp at each of m places lights points of surfels.

    Even light is good: (mean of the root of irradiance)^2 / (mean of irradiance) is the lit share where light is even
    there, and little for a lamp that nearly touches something. Light from where the eye is looks flat.
    """
    irradiance, towards = _irradiance(scene, surfels, points, places)
    mean = irradiance.mean(axis=1)
    even = np.sqrt(irradiance).mean(axis=1) ** 2 / np.where(mean > 0.0, mean, 1.0)
    eye = camera.eye - points if camera.height is None else np.broadcast_to(camera.eye - camera.target, points.shape)
    eye = eye / np.linalg.norm(eye, axis=1, keepdims=True)
    sine = np.sqrt(np.maximum(1.0 - np.sum(towards * eye, axis=2) ** 2, 0.0))
    return even * (1.0 + np.minimum(sine / _FLAT, 1.0).mean(axis=1)) / 2.0


def _seen(scene, camera, size):
    """(surfels (n,), points (n, 3)) of fronts that are seen, evenly over the picture; None where there are none."""
    columns, rows = ((np.arange(n) + 0.5) / n for n in _SIGHTS)
    eyes, ways = _sights(camera, size, columns, rows)
    surfels, distance = _core.seen_fronts(scene._to_core(), eyes, ways)
    met = surfels >= 0
    if not met.any():
        return None
    return surfels[met].astype(np.uint32), (eyes + distance[:, None] * ways)[met]


def _places(scene, camera, size, middle):
    """(m, 3) on lines of sight that are tried."""
    eyes, ways = _sights(camera, size, _ACROSS, _DOWN)
    surfels, distance = _core.seen_fronts(scene._to_core(), eyes, ways)
    # Where nothing is seen, as far as the middle of the scene is away.
    distance = np.where(surfels >= 0, distance, np.sum((middle - eyes) * ways, axis=1))
    return (eyes + np.multiply.outer(_AHEAD, distance)[..., None] * ways).reshape(-1, 3)


def _sights(camera, size, columns, rows):
    """(starts, directions), (n, 3) each, of lines of sight through these parts of a picture's width and height."""
    right, down, forward = camera._axes()
    x, y = (part.reshape(-1, 1) - 0.5 for part in np.meshgrid(columns, rows))
    high = 2.0 * np.tan(np.radians(camera.fov) / 2.0) if camera.height is None else camera.height
    across = x * high * size[0] / size[1] * right + y * high * down
    if camera.height is not None:
        return camera.eye + across, np.broadcast_to(forward, across.shape)
    ways = forward + across
    return np.broadcast_to(camera.eye, ways.shape), ways / np.linalg.norm(ways, axis=1, keepdims=True)


def _irradiance(scene, surfels, points, places):
    """(m, n) at n points of surfels, of a lamp of 1 W/sr at each of m places, and (m, n, 3) towards it."""
    towards = places[:, None] - points
    distance = np.linalg.norm(towards, axis=2)
    towards /= np.where(distance > 0.0, distance, 1.0)[..., None]
    cosine = np.sum(towards * scene.surfels.normals[surfels], axis=2)
    k, i = np.nonzero((cosine > 0.0) & (distance > 0.0))
    met, _, far = _core.closest_hits(scene._to_core(), surfels[i], points[i], towards[k, i])
    found = np.zeros(distance.shape)
    found[k, i] = np.where((met < 0) | (far >= distance[k, i]), cosine[k, i] / distance[k, i] ** 2, 0.0)
    return found, towards
