"""The camera of a picture for which none is given: from where the fronts of surfels show."""

import numpy as np

from surflux.pictures.camera import Camera, default_direction

_AZIMUTHS = 12  # around what is up
_ELEVATIONS = (10.0, 25.0, 40.0, -20.0)  # of the camera above what it looks at, degrees
_FEW = 200  # surfels: they do not tell sides apart
_POINTS = 8_000  # looked at, at most
_PER_CELL = 8  # of these, in a cell of the picture that is counted
_STRAY, _MARGIN = 0.002, 0.05  # of points on each side, and of what the others span: beyond, they stray
_WIDE = 4.0  # medians of the radii: wider disks are of isolated points
# A view that is less usual has to show so many times what the best of those before does: a statue is seen from the
# three quarters that everybody expects, a tile of LiDAR askew, and a frame of a depth camera along its axis.
_BETTER_AROUND, _BETTER_ALONG = 1.3, 1.8


def framing(surfels, size, up=(0, 0, 1)):
    """A Camera that has all surfels in a picture of size (width, height), where their fronts show.

    Of clouds, points that stray far from all others, and what disks reach beyond their neighbours, may be cut off. It
    looks from slightly above, where that shows most of what any side does. Surfels that face along `up` alone, as in
    the frame of a depth camera (x right, y down, z forward), are seen along it.
    """
    bounds = _bounds(surfels)
    aspect = size[0] / size[1]

    def seen(direction, up):
        return Camera.fit(bounds, direction, up, aspect=aspect)

    best = seen(None, up)
    if len(surfels) < _FEW:
        return best
    chosen = np.arange(0, len(surfels), -(-len(surfels) // _POINTS))
    points, normals = surfels.points[chosen], surfels.normals[chosen]
    most = _shown(best, points, normals, aspect)
    for group, better in ((_around(up), _BETTER_AROUND), (_along(up), _BETTER_ALONG)):
        views = [seen(*view) for view in group]
        shown = [_shown(view, points, normals, aspect) for view in views]
        if max(shown) > better * most:
            most, best = max(shown), views[int(np.argmax(shown))]
    return best


def _bounds(surfels):
    """Points around what is to be in the picture."""
    points, reach = surfels.points, surfels.radii
    if len(points) >= _FEW and len(surfels.triangles) == 0:
        low, high = np.quantile(points, [_STRAY, 1.0 - _STRAY], axis=0)
        margin = _MARGIN * (high - low)
        kept = np.all((points >= low - margin) & (points <= high + margin), axis=1)
        points, reach = points[kept], np.minimum(reach[kept], _WIDE * np.median(reach))
    return np.concatenate([points - reach[:, None], points + reach[:, None]])


def own_or_framing(camera, surfels, size, up=(0, 0, 1)):
    """The Camera to begin with: the one that comes with a scene or solution, or None and one that has all in view."""
    return framing(surfels, size, up) if camera is None else camera


def _around(up):
    """(direction, up) from the camera, all around `up`."""
    axis = np.asarray(up, np.float64) / np.linalg.norm(up)
    ahead = default_direction(up)
    ahead = ahead - (ahead @ axis) * axis
    ahead /= np.linalg.norm(ahead)
    side = np.cross(ahead, axis)
    for elevation in np.radians(_ELEVATIONS):
        for azimuth in 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS:
            level = np.cos(azimuth) * ahead + np.sin(azimuth) * side
            yield np.cos(elevation) * level - np.sin(elevation) * axis, up


def _along(up):
    """(direction, up) along what is up: forwards with y down, as depth cameras have it, and back as a plan has it."""
    axis = np.asarray(up, np.float64) / np.linalg.norm(up)
    second = np.roll(axis, 1) - (np.roll(axis, 1) @ axis) * axis  # of z, x
    across = np.cross(axis, second)  # of z, y
    if np.linalg.norm(across) < 1e-3:  # up is along (1, 1, 1)
        second = np.array([1.0, -1.0, 0.0])
        across = np.cross(axis, second)
    return (axis, 0.0 - across), (0.0 - axis, across)


def _shown(camera, points, normals, aspect):
    """The share of the picture in which surfels are seen from their front."""
    height = max(1, int(np.sqrt(len(points) / _PER_CELL / aspect)))
    width = max(1, round(height * aspect))
    fronts = np.sum((camera.eye - points) * normals, axis=1) > 0.0
    if not np.any(fronts):
        return 0.0
    column, row, depth = camera.project(points[fronts], (width, height)).T
    inside = (depth > 0.0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    cells = row[inside].astype(np.int64) * width + column[inside].astype(np.int64)
    return len(np.unique(cells)) / (width * height)
