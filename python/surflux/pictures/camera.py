"""A camera for pictures of surfels, pinhole or orthographic."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from surflux._base.check import finite_array, flag, length, number, positions, unit_vectors, vector3
from surflux._base.types import Floats, Size
from surflux._base.warn import warn

_RADIANS = 0.1, 2.0  # of usual lenses, 6 to 115 degrees; as degrees, of telescopes


class Camera:
    """A pinhole camera, or with `height` an orthographic one, whose rays are all parallel to its view.

    Row 0 of its images is on top, columns go to the right; depth is measured along the view axis, not along the ray.

    Args:
        eye, target: (3,) each: where the camera is, and a point in the middle of its picture.
        up: (3,), a direction that is vertical in the picture; not parallel to the view.
        fov: vertical field of view, full angle in degrees, between 0 and 180; an orthographic camera has
            none. From .1 to 2, where radians may be meant, a warning says so.
        height: what an orthographic camera shows from bottom to top, above 0, in the unit of eye and target; None for
            a pinhole camera. What is behind the eye is not seen.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite, target at the eye, up along the
            view.

    >>> import surflux as sf
    >>> camera = sf.Camera([0, -4, 1], [0, 0, 1], fov=40)
    >>> camera
    Camera(eye=[0.0, -4.0, 1.0], target=[0.0, 0.0, 1.0], up=[0.0, 0.0, 1.0], fov=40)
    >>> camera.project([[0, 0, 1]], (800, 600))  # the target, 4 away, is in the middle of the picture
    array([[400., 300.,   4.]])
    >>> plan = sf.Camera([0, 0, 9], [0, 0, 0], up=[0, 1, 0], height=6)  # from above; 100 pixels are 1
    >>> plan.project([[1, 0, 0]], (800, 600))
    array([[500., 300.,   9.]])
    """

    __slots__ = ("_eye", "_fov", "_height", "_target", "_up")

    def __init__(
        self,
        eye: ArrayLike,
        target: ArrayLike,
        up: ArrayLike = (0, 0, 1),
        fov: float = 45.0,
        *,
        height: float | None = None,
    ) -> None:
        self._eye = positions("eye", eye).copy()
        self._target = positions("target", target).copy()
        self._up = positions("up", up).copy()
        self._fov = number("fov", fov)
        if not 0.0 < self._fov < 180.0:
            raise ValueError(f"fov: wanted degrees between 0 and 180, got {self._fov:g}")
        self._height = None if height is None else length("height", height)
        if height is None and _RADIANS[0] <= self._fov < _RADIANS[1]:
            meant = f"{np.degrees(self._fov):.3g} degrees"
            warn(f"fov: {self._fov:g} degrees are those of a telescope; if these are radians, {meant} are meant")
        view = self._target - self._eye
        distance = np.linalg.norm(view)
        if distance == 0.0:
            raise ValueError("target: wanted a point other than the eye")
        size = np.linalg.norm(self._up)
        if size == 0.0:
            raise ValueError("up: wanted a direction, got zero")
        if np.linalg.norm(np.cross(view / distance, self._up / size)) <= 1e-6:
            raise ValueError("up: wanted a direction not parallel to the view, as (0, 1, 0) from straight above")

    @property
    def eye(self) -> Floats:
        """(3,)."""
        return self._eye.copy()

    @property
    def target(self) -> Floats:
        """(3,)."""
        return self._target.copy()

    @property
    def up(self) -> Floats:
        """(3,)."""
        return self._up.copy()

    @property
    def fov(self) -> float:
        """Vertical, full angle in degrees."""
        return self._fov

    @property
    def height(self) -> float | None:
        """Of what an orthographic camera shows; None of a pinhole camera."""
        return self._height

    @classmethod
    def fit(
        cls,
        points: ArrayLike,
        direction: ArrayLike | None = None,
        up: ArrayLike = (0, 0, 1),
        fov: float = 45.0,
        aspect: float = 4.0 / 3.0,
        *,
        orthographic: bool = False,
    ) -> Self:
        """A camera that looks along `direction` and has all of `points` in its picture, with a small margin.

        Args:
            points: (n, 3), n >= 1; for bounds, give their corners.
            direction: (3,), from the camera towards the points; None for three quarters from slightly above: for
                up = +z that is (-0.6, 1, -0.45), for any other `up` the same, turned by the shortest rotation that
                takes +z to `up` (for -z by 180 degrees about x).
            up, fov: as of the camera.
            aspect: width of the picture over its height.
            orthographic: True for such a camera, from where a pinhole one would stand.

        Raises:
            ValueError: an argument, by name.
        """
        points = finite_array("points", points, (None, 3))
        if len(points) == 0:
            raise ValueError("points: wanted at least one")
        return cls._around(points, lambda axis: 0.0, direction, up, fov, aspect, orthographic)

    @classmethod
    def _around(cls, points, reach, direction, up=(0, 0, 1), fov=45.0, aspect=4.0 / 3.0, orthographic=False):
        """Camera.fit for what lies around points: reach(axis) says how far (n,) from each along a vector, times its
        length.
        """
        direction = default_direction(up) if direction is None else vector3("direction", direction)
        size = np.linalg.norm(direction)
        if size == 0.0:
            raise ValueError("direction: wanted a direction, got zero")
        aspect = number("aspect", aspect, 1e-3, 1e3)
        reaches = np.stack([np.broadcast_to(reach(axis), len(points)) for axis in np.eye(3)], axis=1)
        center = 0.5 * ((points - reaches).min(axis=0) + (points + reaches).max(axis=0))
        forward = direction / size
        right, down, forward = cls(center - forward, center, up, fov)._axes()  # checks up and fov
        p = points - center

        def most(axis):
            return (p @ axis + reach(axis)).max()

        tan_y = np.tan(np.radians(fov) / 2.0) / 1.05  # the margin
        # The eye at center + x right + y down - distance * forward sees p where |p . right - x| <= tan (p . forward +
        # distance), and so on: as near as both sides of the picture let it be.
        sides = (right, tan_y * aspect), (down, tan_y)
        (x, wide), (y, high) = (
            _middle_and_distance(most(axis - tan * forward), most(-axis - tan * forward), tan) for axis, tan in sides
        )
        extent = (np.linalg.norm(p, axis=1) + np.linalg.norm(reaches, axis=1)).max()
        height = None
        if flag("orthographic", orthographic):
            x, y = ((most(axis) - most(-axis)) / 2 for axis in (right, down))
            spans = [most(axis) + most(-axis) for axis in (right, down)]
            height = 1.05 * max(spans[0] / aspect, spans[1], extent * 2e-3, 2e-6)
        target = center + x * right + y * down
        distance = max(wide, high, 0.05 * extent + most(-forward), extent * 1e-3, 1e-6)
        return cls(target - distance * forward, target, up, fov, height=height)

    @classmethod
    def from_pyvista(cls, view: Any) -> Self:
        """The Camera that a picture of pyvista is seen through, perspective or parallel.

        Args:
            view: pyvista.Plotter, or its camera.

        Raises:
            ValueError: neither; a camera whose angle is horizontal, or that Camera refuses.

        >>> import pyvista
        >>> import surflux as sf
        >>> view = pyvista.Camera()
        >>> view.position, view.focal_point, view.up = (0, -4, 1), (0, 0, 1), (0, 0, 1)
        >>> sf.Camera.from_pyvista(view)
        Camera(eye=[0.0, -4.0, 1.0], target=[0.0, 0.0, 1.0], up=[0.0, 0.0, 1.0], fov=30)
        """
        found = getattr(view, "camera", view)
        needed = ("position", "focal_point", "up", "view_angle", "parallel_projection", "parallel_scale")
        if not all(hasattr(found, name) for name in needed):
            raise ValueError(f"view: wanted a pyvista.Plotter or its camera, got {type(view).__name__}")
        height = 2.0 * found.parallel_scale if found.parallel_projection else None
        if height is None and found.GetUseHorizontalViewAngle():
            raise ValueError("view: wanted a camera with a vertical angle, got a horizontal one")
        return cls(found.position, found.focal_point, found.up, found.view_angle, height=height)

    def project(self, points: ArrayLike, size: Size) -> Floats:
        """Where points appear in a picture of `size` (width, height): (n, 3) of column, row, depth.

        Pixel (0, 0) covers columns and rows 0 to 1. Depth is negative behind the camera, where columns and rows mean
        nothing.

        Raises:
            ValueError: points of another shape, or not finite.
        """
        points = finite_array("points", points, (None, 3))
        width, height = size
        right, down, forward = self._axes()
        p = points - self._eye
        depth = p @ forward
        if self._height is not None:
            scale = height / self._height
            return np.stack([0.5 * width + scale * (p @ right), 0.5 * height + scale * (p @ down), depth], axis=1)
        scale = 0.5 * height / np.tan(np.radians(self._fov) / 2.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            column, row = (0.5 * n + scale * (p @ axis) / depth for n, axis in ((width, right), (height, down)))
        return np.stack([column, row, depth], axis=1)

    def _axes(self):
        forward = self._target - self._eye
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, self._up)
        right /= np.linalg.norm(right)
        return right, np.cross(forward, right), forward

    def _to_core(self):
        return self._eye, self._target, self._up, self._fov, self._height or 0.0

    def to_dict(self) -> dict[str, Any]:
        """The camera as plain lists and numbers: the [camera] table of a scene file; Camera(**d) takes it back."""
        found = {"eye": self._eye.tolist(), "target": self._target.tolist(), "up": self._up.tolist(), "fov": self._fov}
        return found if self._height is None else found | {"height": self._height}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Camera) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash((*self._eye, *self._target, *self._up, self._fov, self._height))

    def __repr__(self) -> str:
        eye, target, up, fov = (self.to_dict()[name] for name in ("eye", "target", "up", "fov"))
        seen = f"fov={fov:g}" if self._height is None else f"height={self._height:g}"
        return f"Camera(eye={eye}, target={target}, up={up}, {seen})"


def _middle_and_distance(on_right, on_left, tan):
    """Where between points an eye is that has them within a tangent on either side, and how far before the origin.

    on_right, on_left: the most of +-across - tan * ahead.
    """
    return 0.5 * (on_right - on_left), 0.5 * (on_right + on_left) / tan


def default_direction(up):
    """The direction to look in by default, for that up."""
    x, y, z = unit_vectors("up", vector3("up", up)[None, :])[0]
    seen = np.array([-0.6, 1.0, -0.45])
    if z < -1.0 + 1e-9:
        return seen * [1.0, -1.0, -1.0]
    axis = np.array([-y, x, 0.0])  # +z cross up, of length sine; Rodrigues' formula, free of the sine's division
    return z * seen + np.cross(axis, seen) + axis * (axis @ seen) / (1.0 + z)


def facing(target, towards, reach, up, fov, size):
    """A Camera that looks at target from the direction towards, with a ball of radius reach around it in view."""
    half = np.arctan(np.tan(np.radians(fov / 2)) * min(1.0, size[0] / size[1]))
    return Camera(target + reach / np.sin(half) * towards, target, upright(up, towards), fov)


def come_close(camera, surfels, lamps):
    """(Camera, how far it came): an orthographic one moved ahead, to as far before all that it sees as that is deep.

    Its picture stays the same but for depths. Single precision tells ten millionths of them apart: from far away sheets
    that are nearer to each other have one depth. Pinhole cameras stay, and those that have anything behind them.

    Args:
        camera: Camera.
        surfels: Surfels.
        lamps: list of AreaLight, which are seen, too.
    """
    if camera.height is None or len(surfels) == 0:
        return camera, 0.0
    _, _, forward = camera._axes()
    corners = [
        np.add(lamp.corner, np.multiply(k, lamp.edge_u) + np.multiply(j, lamp.edge_v))
        for lamp in lamps
        for k in (0, 1)
        for j in (0, 1)
    ]
    near, far = (surfels.points @ forward + side * surfels.radii for side in (-1, 1))
    flat = np.concatenate([np.reshape(surfels.triangles, (-1, 3)), np.reshape(corners, (-1, 3))]) @ forward
    first, last = min(near.min(), flat.min(initial=np.inf)), max(far.max(), flat.max(initial=-np.inf))
    by = first - camera.eye @ forward - (last - first)
    if not by > 0.0:
        return camera, 0.0
    moved = [end + by * forward for end in (camera.eye, camera.target)]
    return Camera(*moved, camera.up, camera.fov, height=camera.height), by


def upright(up, view):
    """A direction (3,) to have up in a picture: `up`, or where the unit vector view is nearly along it, another."""
    up = np.asarray(up, np.float64) / np.linalg.norm(up)
    for found in (up, np.roll(up, -1)):  # which for up along an axis is the next one
        if abs(view @ found) < 0.9:
            return found
    return np.eye(3)[np.argmin(np.abs(view))]
