"""A luminaire that shines as its maker's photometry tells."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.types import FilePath, Vector
from surflux.scenes.photometry import Photometry, read_photometry


@dataclass(frozen=True)
class PhotometricLight:
    """A point whose intensity goes by direction, as luminaires have it in IES and EULUMDAT files.

    It does not occlude and has no size: light is right from some five times the luminaire's width on. What is near to
    a wide one is lit by an AreaLight, or a mesh with emission.

    Args:
        position: (3,), of the luminaire's photometric centre.
        photometry: Photometry, or the path of an .ies or .ldt file.
        direction: (3,), where angle gamma = 0 points, of any length but 0; by default straight down. From that to any
            other the luminaire is turned the shortest way; to straight up by 180 degrees about x.
        azimuth: degrees by which the luminaire is turned about its axis, the way that planes C count: counter-clockwise
            seen from above where it hangs.
        intensity: scalar or RGB, at least 0, times what the photometry has: 1 is as the maker says, .5 dimmed to half,
            and an RGB gives it a colour.

    Raises:
        ValueError: an argument, by name.
        FileError: a file that cannot be read.

    >>> import numpy as np, surflux as sf
    >>> gamma = np.arange(0.0, 181.0)
    >>> downlight = sf.Photometry([0.0], gamma, [500.0 * np.maximum(np.cos(np.radians(gamma)), 0.0) ** 2])
    >>> desk = sf.Surfels([[0.0, 0, 0]], [[0.0, 0, 1]], reflectance=0.0, radii=[0.1])
    >>> solution = sf.solve(sf.Scene([desk], [sf.PhotometricLight([0, 0, 2], downlight)]))
    >>> round(float(solution.direct[0, 0]), 1)  # lux, 500 / 2^2
    125.0
    """

    position: Vector
    photometry: Photometry
    direction: Vector = (0.0, 0.0, -1.0)
    azimuth: float = 0.0
    intensity: Vector = (1.0, 1.0, 1.0)

    if TYPE_CHECKING:  # from arrays of any kind, which are kept as tuples

        def __init__(
            self,
            position: ArrayLike,
            photometry: Photometry | FilePath,
            direction: ArrayLike = (0.0, 0.0, -1.0),
            azimuth: float = 0.0,
            intensity: ArrayLike = 1.0,
        ) -> None: ...

    def __post_init__(self) -> None:
        photometry = self.photometry
        if isinstance(photometry, (str, os.PathLike)):
            photometry = read_photometry(photometry)
        if not isinstance(photometry, Photometry):
            raise ValueError(f"photometry: wanted a Photometry or a path, got {type(photometry).__name__}")
        values = {
            "position": check.vector3("position", self.position),
            "direction": check.direction("direction", self.direction),
            "intensity": check.rgb("intensity", self.intensity),
        }
        for name, value in values.items():
            object.__setattr__(self, name, tuple(map(float, value)))
        object.__setattr__(self, "photometry", photometry)
        object.__setattr__(self, "azimuth", check.number("azimuth", self.azimuth, -1e6, 1e6))

    def _shares(self, directions):
        """(n,) of the photometry's intensities, what goes along directions (n, 3) of any length."""
        return np.asarray(self._to_core().shares(directions))

    def _to_core(self):
        planes, candela = self.photometry.all_around()
        zero = _zero_plane(np.asarray(self.direction), self.azimuth)
        angles = self.photometry.angles
        return _core.PhotometricLight(self.position, self.direction, zero, self.intensity, planes, angles, candela)


def _zero_plane(direction, azimuth):
    """(3,) unit, perpendicular to the direction: where half-plane C = 0 lies."""
    down, across = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    axis, cosine = np.cross(down, direction), float(down @ direction)
    if cosine > -1.0 + 1e-12:  # the shortest rotation (Rodrigues)
        turned = np.cross(axis, across)
        across = across + turned + np.cross(axis, turned) / (1.0 + cosine)
        across -= (across @ direction) * direction
        across /= np.linalg.norm(across)
    quarter, turn = np.cross(across, direction), np.radians(azimuth % 360.0)
    return np.cos(turn) * across + np.sin(turn) * quarter
