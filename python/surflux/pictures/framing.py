"""The camera of a picture for which none is given: from where the fronts of surfels show."""

import numpy as np

from surflux.pictures.camera import Camera, default_direction, upright

_AZIMUTHS = 12  # around what is up
_ABOVE, _BELOW = (10.0, 25.0, 40.0), (-20.0,)  # elevations of the camera over what it looks at, degrees
_FEW = 200  # surfels: they do not tell sides apart
_POINTS = 8_000  # looked at, at most
_PER_CELL = 8  # of these, in a cell of the picture that is counted
_STRAY, _MARGIN = 0.002, 0.05  # of points on each side, and of what the others span: beyond, they stray
_WIDE = 4.0  # medians of the radii: wider disks are of isolated points
# A view that is less usual has to show so many times what the best of those before does. Statues show up to 1.4 times
# what the usual three quarters do from some other side, and stay; tiles of LiDAR from above more than twice, frames of
# depth cameras along their axis 2.4 to 5 times.
_BETTER_AROUND, _BETTER_ALONG, _BETTER_BELOW = 1.6, 1.8, 1.8
# From below are seen ceilings and what else faces down, so many times as much as up at least: that is 1 of bodies (sums
# of cosines over a statue's points: .8 to 1.4), less where their base is open, and 45 and more of what a depth camera
# saw that looked up. How much of the picture is filled is no reason: a bunny fills 1.8 times as much from below, where
# its ears are behind its back.
_FACES_DOWN = 3.0
# Along what is up are seen layers that face that way alone: .9 and more of frames and tiles, .2 to .6 of bodies.
_FACES_ALONG = 0.8


def framing(surfels, size, up=(0, 0, 1), *, along=True, direction=None):
    """A Camera that has all surfels in a picture of size (width, height), where their fronts show.

    Of clouds, points that stray far from all others, and what disks reach beyond their neighbours, may be cut off. It
    looks from slightly above, where that shows most of what any side does; from below at what faces down. Surfels that
    face along `up` alone, as in the frame of a depth camera (x right, y down, z forward), are seen along it, unless
    `along` is False. direction: (3,), where the camera looks, whatever shows.
    """
    around = _Around(surfels)
    aspect = size[0] / size[1]
    best = direction, up
    if direction is None and len(surfels) >= _FEW:
        best = _best_view(around, _every(surfels.points), _every(surfels.normals), aspect, up, along)
    return around.camera(best, aspect)


def _best_view(around, points, normals, aspect, up, along):
    """(direction, up) of the view of some of the surfels that framing takes."""

    some = around.some()

    def shown(views):
        """(k, 2) of each view the share of the picture that shows fronts, and of the surfels that face the camera."""
        found = [_shown(some.camera(view, aspect), points, normals, aspect) for view in views]
        return np.reshape(found, (-1, 2))

    best = None, up
    most = shown([best])[0, 0]
    for views, better, least in (
        (_around(up, _ABOVE), _BETTER_AROUND, 0.0),
        (_along(up) if along else (), _BETTER_ALONG, _FACES_ALONG),
        (_around(up, _BELOW) if _faces_down(normals, up) else (), _BETTER_BELOW, 0.0),
    ):
        found = shown(views)
        shares = np.where(found[:, 1] > least, found[:, 0], 0.0)
        if max(shares, default=0.0) > better * most:
            most, best = max(shares), views[int(np.argmax(shares))]
    return best


def _faces_down(normals, up):
    """Whether surfels with these normals face down, most of them."""
    upwards = normals @ np.asarray(up, np.float64)
    return np.clip(-upwards, 0.0, None).sum() > _FACES_DOWN * np.clip(upwards, 0.0, None).sum()


def _every(rows):
    """Evenly some of the rows of an array, at most _POINTS."""
    return rows[:: -(-len(rows) // _POINTS)]


class _Around:
    """What is to be in the picture: corners of patches, and disks.

    points: (m, 3). normals (m, 3), radii (m,): of disks; of corners 0.
    """

    def __init__(self, surfels):
        patch = np.zeros(len(surfels), bool)
        patch[surfels.triangle_surfel] = True
        points, normals, radii = surfels.points[~patch], surfels.normals[~patch], surfels.radii[~patch]
        if len(points) >= _FEW and not np.any(patch):
            low, high = np.quantile(points, [_STRAY, 1.0 - _STRAY], axis=0)
            margin = _MARGIN * (high - low)
            kept = np.all((points >= low - margin) & (points <= high + margin), axis=1)
            points, normals, radii = points[kept], normals[kept], radii[kept]
            radii = np.minimum(radii, _WIDE * np.median(radii))
        corners = surfels.triangles.reshape(-1, 3)
        self.points = np.concatenate([points, corners])
        self.normals = np.concatenate([normals, np.zeros_like(corners)])
        self.radii = np.concatenate([radii, np.zeros(len(corners))])

    def some(self):
        """The same of evenly some."""
        found = object.__new__(_Around)
        found.points, found.normals, found.radii = _every(self.points), _every(self.normals), _every(self.radii)
        return found

    def camera(self, view, aspect):
        """The Camera that looks along a (direction, up) and has all in its picture."""
        return Camera._around(self.points, self._reach, *view, aspect=aspect)

    def _reach(self, axis):
        """How far disks reach along a vector, times its length."""
        return self.radii * np.sqrt(np.maximum(axis @ axis - (self.normals @ axis) ** 2, 0.0))


def own_or_framing(camera, surfels, size, up=None):
    """The Camera to begin with: the one that comes with a scene or solution, or None and one that has all in view.

    up: what whoever asks says is up; nothing is looked at along it then.
    """
    if camera is not None:
        return camera
    return framing(surfels, size, (0, 0, 1) if up is None else up, along=up is None)


def _around(up, elevations):
    """[(direction, up)] from cameras at those elevations, all around `up`."""
    axis = np.asarray(up, np.float64) / np.linalg.norm(up)
    ahead = default_direction(up)
    ahead = ahead - (ahead @ axis) * axis
    ahead /= np.linalg.norm(ahead)
    side = np.cross(ahead, axis)
    turns = 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
    return [
        (np.cos(e) * (np.cos(a) * ahead + np.sin(a) * side) - np.sin(e) * axis, up)
        for e in np.radians(elevations)
        for a in turns
    ]


def _along(up):
    """(direction, up) along what is up: forwards with y down, as depth cameras have it, and back as a plan has it."""
    axis = np.asarray(up, np.float64) / np.linalg.norm(up)
    across = upright(axis, axis)  # of z, y
    return (axis, 0.0 - across), (0.0 - axis, across)


def _shown(camera, points, normals, aspect):
    """(the share of the picture in which surfels are seen from their front, and the share of the surfels that are)."""
    height = max(1, int(np.sqrt(len(points) / _PER_CELL / aspect)))
    width = max(1, round(height * aspect))
    fronts = np.sum((camera.eye - points) * normals, axis=1) > 0.0
    if not np.any(fronts):
        return 0.0, 0.0
    column, row, depth = camera.project(points[fronts], (width, height)).T
    inside = (depth > 0.0) & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    cells = row[inside].astype(np.int64) * width + column[inside].astype(np.int64)
    return len(np.unique(cells)) / (width * height), np.mean(fronts)
