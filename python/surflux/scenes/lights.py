"""Lights, as plain immutable values, equal where their contents are.

Colours are linear RGB; one number means the same in all three channels.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.color import rgb_of_grey
from surflux._base.types import FilePath, Floats, Vector
from surflux.pictures.images import read_image
from surflux.scenes.photometric_light import PhotometricLight

_USUAL_PENUMBRA = 5.0  # degrees


def _set(light, **values):
    for name, value in values.items():
        if isinstance(value, np.ndarray) and value.ndim == 1:
            value = tuple(float(v) for v in value)
        object.__setattr__(light, name, value)


@dataclass(frozen=True)
class PointLight:
    """A point that shines alike in all directions.

    Args:
        position: (3,).
        intensity: radiant intensity in W/sr, scalar or RGB, at least 0; the power of the light is 4 pi times this.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite or out of range.
    """

    position: Vector
    intensity: Vector

    if TYPE_CHECKING:  # from arrays of any kind, which are kept as tuples

        def __init__(self, position: ArrayLike, intensity: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        _set(
            self,
            position=check.vector3("position", self.position),
            intensity=check.rgb("intensity", self.intensity),
        )

    def _to_core(self):
        return _core.PointLight(self.position, self.intensity)


@dataclass(frozen=True)
class SpotLight:
    """A point that shines into a cone.

    Args:
        position: (3,).
        direction: (3,), from the light into the scene, of any length but 0.
        intensity: W/sr on the axis, scalar or RGB, at least 0.
        cone: full angle in degrees outside of which there is no light, in (0, 360].
        penumbra: full angle in degrees, in [0, cone]: the intensity is full within cone - penumbra and falls as a
            smoothstep of the angle to 0 at cone. A cone narrower than the default wants one of its own.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite or out of range, a direction of
            zero length.
    """

    position: Vector
    direction: Vector
    intensity: Vector
    cone: float = 45.0
    penumbra: float = _USUAL_PENUMBRA

    if TYPE_CHECKING:  # from arrays of any kind, which are kept as tuples

        def __init__(
            self,
            position: ArrayLike,
            direction: ArrayLike,
            intensity: ArrayLike,
            cone: float = 45.0,
            penumbra: float = 5.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        _set(
            self,
            position=check.vector3("position", self.position),
            direction=check.direction("direction", self.direction),
            intensity=check.rgb("intensity", self.intensity),
            cone=check.number("cone", self.cone, 0.0, 360.0, low_open=True),
        )
        _set(self, penumbra=check.number("penumbra", self.penumbra, 0.0))
        if self.penumbra > self.cone:
            usual = ", as is usual" if self.penumbra == _USUAL_PENUMBRA else ""
            raise ValueError(f"penumbra: wanted at most the cone, {self.cone:g} degrees, got {self.penumbra:g}{usual}")

    def _to_core(self):
        return _core.SpotLight(self.position, self.direction, self.intensity, self.cone, self.penumbra)


@dataclass(frozen=True)
class AreaLight:
    """A rectangle that emits evenly along edge_u x edge_v. It does not occlude and does not reflect.

    A lamp that does is a mesh with emission.

    Args:
        corner: (3,).
        edge_u, edge_v: (3,) each, perpendicular, from the corner.
        exitance: W/m2, scalar or RGB, at least 0; the radiance is exitance / pi.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite or out of range, edges that are not
            perpendicular.
    """

    corner: Vector
    edge_u: Vector
    edge_v: Vector
    exitance: Vector

    if TYPE_CHECKING:  # from arrays of any kind, which are kept as tuples

        def __init__(self, corner: ArrayLike, edge_u: ArrayLike, edge_v: ArrayLike, exitance: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        u, v = check.vector3("edge_u", self.edge_u), check.vector3("edge_v", self.edge_v)
        cosine = check.direction("edge_u", u) @ check.direction("edge_v", v)
        if abs(cosine) > 1e-6:
            angle = np.degrees(np.arccos(cosine))
            raise ValueError(f"edge_v: wanted a vector perpendicular to edge_u, got one at {angle:.4g} degrees")
        _set(
            self,
            corner=check.vector3("corner", self.corner),
            edge_u=u,
            edge_v=v,
            exitance=check.rgb("exitance", self.exitance),
        )

    def _to_core(self):
        return _core.AreaLight(self.corner, self.edge_u, self.edge_v, self.exitance)


@dataclass(frozen=True)
class DirectionalLight:
    """Parallel light, such as the sun's.

    Args:
        direction: (3,), the direction of travel, of any length but 0.
        irradiance: W/m2 on a plane that faces the light, scalar or RGB, at least 0.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite or out of range, a direction of
            zero length.
    """

    direction: Vector
    irradiance: Vector

    if TYPE_CHECKING:  # from arrays of any kind, which are kept as tuples

        def __init__(self, direction: ArrayLike, irradiance: ArrayLike) -> None: ...

    def __post_init__(self) -> None:
        _set(
            self,
            direction=check.direction("direction", self.direction),
            irradiance=check.rgb("irradiance", self.irradiance),
        )

    def _to_core(self):
        return _core.DirectionalLight(self.direction, self.irradiance)


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Environment:
    """Radiance from the full sphere of directions: one colour, or a latitude-longitude image.

    Images are as cameras and other programs have them: seen from inside, columns go from left to right. Pixel
    (row, column) of an image (h, w, 3) shows the direction with the angle theta = pi (row + 0.5) / h from `up` and the
    azimuth phi = pi - 2 pi (column + 0.5) / w, counter-clockwise seen from the tip of `up`. For up = +z that is
    (sin theta cos phi, sin theta sin phi, cos theta): the middle of the image looks along +x, the column at w/4 along
    +y, the seam along -x, as in Blender. For any other `up` these directions are turned by the shortest rotation that
    takes +z to `up` (for +y all look where three.js has them); for up = -z, where there is no shortest one, by 180
    degrees about x. Then the image is turned about `up` by `azimuth`: what showed at phi shows at phi + azimuth.

    Args:
        image_or_rgb: radiance in W/(m2 sr), at least 0: one number, RGB (3,), an image (h, w, 3), or the path of an
            image file (EXR, HDR; PNG is taken as sRGB).
        radiance, image: the same by the names that scene files have, one of them instead: a number or RGB, or an image
            or its path.
        up: (3,), where row 0 of the image lies; of any length but 0.
        azimuth: degrees by which the image is turned about `up`, counter-clockwise seen from its tip; 90 brings the
            middle of the image from +x to +y. 360 more are the same light, bit by bit.

    Raises:
        ValueError: an argument, by name: a wrong shape, a value that is not finite or below 0, an up of zero length.
        FileError: an image that cannot be read.
    """

    image_or_rgb: Vector | Floats
    up: Vector = (0.0, 0.0, 1.0)
    azimuth: float = 0.0
    radiance: Vector = field(init=False)
    image: Floats | None = field(init=False)

    def __init__(
        self,
        image_or_rgb: ArrayLike | FilePath | None = None,
        up: ArrayLike = (0.0, 0.0, 1.0),
        azimuth: float = 0.0,
        *,
        radiance: ArrayLike | None = None,
        image: ArrayLike | FilePath | None = None,
    ) -> None:
        ways = {"image_or_rgb": image_or_rgb, "radiance": radiance, "image": image}
        given = {name: value for name, value in ways.items() if value is not None}
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(f"image_or_rgb: wanted radiance, an image or a path, by one of its names; got {got}")
        ((name, value),) = given.items()
        if isinstance(value, (str, os.PathLike)):
            if name == "radiance":
                raise ValueError(f"radiance: wanted a number or RGB, got {os.fspath(value)!r}; image takes a path")
            value, name = read_image(value), f"{name} ({os.fspath(value)})"
        pixels = None
        array = check.numeric(name, value)
        if array.ndim == 3 and name != "radiance":
            pixels = check.in_range(name, check.finite_array(name, array, (None, None, 3)), 0.0).copy()
            pixels.setflags(write=False)
            shining = np.zeros(3)
        elif array.shape in ((), (3,)) and name != "image":
            shining = check.rgb(name, array)
        else:
            wanted = {"radiance": "a number or RGB (3,)", "image": "an image (h, w, 3) or a path"}
            wanted = wanted.get(name, "a number, RGB (3,), an image (h, w, 3) or a path")
            raise ValueError(f"{name}: wanted {wanted}, got {array.shape}")
        # The light keeps its own copy of the pixels and no hold on what was handed in.
        _set(
            self,
            image_or_rgb=shining if pixels is None else pixels,
            radiance=shining,
            image=pixels,
            up=check.direction("up", up),
            azimuth=check.number("azimuth", azimuth, -1e6, 1e6),
        )

    @classmethod
    def from_harmonics(cls, coefficients: ArrayLike, height: int = 128) -> Environment:
        """A light that is given by its spherical harmonics, as surflux.spherical_harmonics has them, as an image of it.

        Each pixel has the mean of the function over its solid angle. What that smooths away of band l is the share
        l (l + 1) (pi / height)^2 / 12 of it, at most: 1e-3 of band 4 for 128 rows.

        Few harmonics of a small bright lamp are below 0 elsewhere, and pixels are so, too: they take light away. The
        path tracer (reference_irradiance, reference_radiance) counts it as it is; solvers refuse it. Clipping such a
        light, Environment(np.maximum(light.image, 0)), makes another, brighter one.

        Args:
            coefficients: (n,) or (n, 3), n = 1, 4, 9, 16, 25, ... up to 1024; in the scene's axes.
            height: rows of the image, twice as many columns.

        Returns:
            Environment with up = +z.

        Raises:
            ValueError: an argument, by name.

        >>> import surflux as sf
        >>> light = sf.Environment.from_harmonics([1.0, 0.0, 0.5, 0.0])  # brighter above
        >>> light
        Environment(image of 256 x 128 pixels, up=(0.0, 0.0, 1.0))
        >>> light.harmonics(order=2)[[0, 2], 0].round(3).tolist()
        [1.0, 0.5]
        """
        array = check.numeric("coefficients", coefficients)
        if array.ndim == 1:
            array = rgb_of_grey(array)
        array = check.finite_array("coefficients", array, (None, 3))
        height = check.count("height", height, 1, 2**14)
        return cls._of_pixels(np.asarray(_core.image_of_harmonics(array, 2 * height, height)))

    @classmethod
    def _of_pixels(cls, image, up=(0.0, 0.0, 1.0), azimuth=0.0):
        """Of an image whose pixels may be below 0, or RGB."""
        light = cls(np.maximum(image, 0.0), up, azimuth)
        if image.min() < 0.0:
            image = np.array(image)
            image.setflags(write=False)
            _set(light, image_or_rgb=image, image=image)
        return light

    def _to_file(self):
        """What _of_file takes beside the pixels, for JSON."""
        columns = {} if self.image is None else {"columns": "clockwise"}
        return {"up": self.up, "azimuth": self.azimuth} | columns

    @classmethod
    def _of_file(cls, image_or_rgb, up, azimuth, columns=None):
        """Of what _to_file gave. Files that say nothing of columns are from when these went the other way, from +x on.

        Raises:
            ValueError, TypeError: this is not what that gave.
        """
        if columns not in (None, "clockwise"):
            raise ValueError(f"columns: wanted 'clockwise', got {columns!r}")
        image = np.asarray(image_or_rgb)
        if image.ndim == 3 and columns is None:
            image, azimuth = image[:, ::-1], azimuth + (180.0 if azimuth < 0.0 else -180.0)
        return cls._of_pixels(image, up, azimuth)

    def _turned(self, rotation):
        """The light in which what came from direction d comes from rotation @ d."""
        middle, _, up = _axes(self.up, self.azimuth) @ rotation.T
        at_zero, at_quarter, _ = _axes(up, 0.0)
        azimuth = np.degrees(np.arctan2(middle @ at_quarter, middle @ at_zero))
        return Environment._of_pixels(np.asarray(self.image_or_rgb), up, azimuth)

    def harmonics(self, order: int = 5) -> Floats:
        """Spherical harmonics of the radiance, as surflux.spherical_harmonics has them, in the scene's axes.

        The integral of the light, constant in each pixel, times each harmonic: `up` and azimuth are in it.

        Args:
            order: number of bands, 1 to 32.

        Returns:
            (order**2, 3).

        Raises:
            ValueError: an order out of range.

        >>> import surflux as sf
        >>> sf.Environment([1.0, 2.0, 0.0]).harmonics(order=2).round(4)[:, 0].tolist()  # sqrt(4 pi) L in band 0
        [3.5449, 0.0, 0.0, 0.0]
        """
        order = check.count("order", order, 1, _core.largest_harmonic_order)
        return np.asarray(_core.project_environment(self._to_core(), order))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Environment):
            return NotImplemented
        if (self.radiance, self.up, self.azimuth) != (other.radiance, other.up, other.azimuth):
            return False
        if self.image is None or other.image is None:
            return self.image is other.image
        return np.array_equal(self.image, other.image)

    def __hash__(self) -> int:
        # Of an image the shape alone: 0 and -0 are equal pixels of different bytes.
        return hash((self.radiance, self.up, self.azimuth, None if self.image is None else self.image.shape))

    def __repr__(self) -> str:
        if self.image is None:
            return f"Environment(radiance={self.radiance}, up={self.up})"
        azimuth = f", azimuth={self.azimuth:g}" if self.azimuth else ""
        return f"Environment(image of {self.image.shape[1]} x {self.image.shape[0]} pixels, up={self.up}{azimuth})"

    def _to_core(self):
        return _core.Environment(radiance=self.radiance, pixels=self.image, up=self.up, azimuth=self.azimuth)


def _axes(up, azimuth):
    """(3, 3): where the middle of an image and its column w/4 look on the horizon, and where its row 0 lies."""
    return np.asarray(_core.Environment(np.zeros(3), None, up, azimuth).axes)


def environments_among(lights):
    """The Environments among lights, in their order."""
    return [light for light in lights if isinstance(light, Environment)]


def power_name(light):
    """The name of what a light other than an Environment has of power, which it is proportional to."""
    return next(name for name in ("intensity", "exitance", "irradiance") if hasattr(light, name))


Light: TypeAlias = PointLight | SpotLight | PhotometricLight | AreaLight | DirectionalLight | Environment
LIGHTS = (PointLight, SpotLight, PhotometricLight, AreaLight, DirectionalLight, Environment)
