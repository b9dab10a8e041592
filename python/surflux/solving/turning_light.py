"""An environment that turns about an axis, and what surfels receive of it as waves of the angle."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux._base import check
from surflux._base.types import Floats
from surflux.geometry.rotation import rotation_about
from surflux.scenes.lights import Environment
from surflux.solutions.solution import Solution
from surflux.solving.distant_transfer import ORDER, DistantTransfer, harmonics_of
from surflux.solving.harmonics import rotate_harmonics

WAVES = 2 * ORDER - 1  # 1, and a cosine and a sine of 1, 2, 3 and 4 periods


class Waves(NamedTuple):
    """Coefficients (9, n, 3) of n surfels: `waves_at(angle) @ coefficients` is below 0 where five bands are."""

    irradiance: NDArray[np.float32]
    direct: NDArray[np.float32]


class TurningLight:
    """A DistantTransfer under an environment that turns about an axis.

    A turn about an axis mixes the harmonics of band l by waves of at most l periods: what is linear in five bands, the
    light of a surfel with all its bounces, is a Fourier series of order 4 in the angle. Nine relightings at even angles
    say all of it.

    Args:
        transfer: DistantTransfer.
        environment: see DistantTransfer.relight.
        axis: (3,); None for what is up in an Environment, of harmonics for z.
        options: reflectance, specular, exponent and bounces, as of DistantTransfer.relight.

    Attributes:
        transfer: DistantTransfer.
        axis: (3,) of length 1.
        glossy: whether surfels look another way from each side.

    Raises:
        ValueError: an argument, by name.
    """

    def __init__(
        self,
        transfer: DistantTransfer,
        environment: Environment | ArrayLike,
        axis: ArrayLike | None = None,
        **options: Any,
    ) -> None:
        if not isinstance(transfer, DistantTransfer):
            raise ValueError(f"transfer: wanted a DistantTransfer, got {type(transfer).__name__}")
        self.transfer, self._environment, self._options = transfer, environment, options
        self._harmonics = harmonics_of(environment)
        if axis is None:
            axis = environment.up if isinstance(environment, Environment) else (0.0, 0.0, 1.0)
        self.axis: Floats = check.direction("axis", axis)
        reflectance = transfer._reflectance(options.get("reflectance"))
        gloss = transfer._gloss(reflectance, options.get("specular"), options.get("exponent"))
        self.glossy = bool(gloss and gloss["specular"].any())

    def harmonics(self, degrees: float = 0.0) -> Floats:
        """(25, 3) of the environment, turned by so many degrees, counter-clockwise seen from the tip of the axis."""
        degrees = degrees % 360.0
        return rotate_harmonics(self._harmonics, self._turn(degrees)) if degrees else self._harmonics

    def _turn(self, degrees):
        return rotation_about(self.axis, np.radians(degrees))

    def _seen(self, degrees):
        """What stands behind the scene then: an Environment, or harmonics."""
        degrees, environment = degrees % 360.0, self._environment
        if not isinstance(environment, Environment):
            return self.harmonics(degrees)
        return environment._turned(self._turn(degrees)) if degrees else environment

    def relight(self, degrees: float = 0.0) -> Solution:
        """What the transfer has for the turned environment. 360 degrees more give the same, bit by bit."""
        solution = self.transfer.relight(self.harmonics(degrees), **self._options)
        if isinstance(self._environment, Environment):  # its harmonics have less of it
            solution._environments = [self._seen(degrees)]
        return solution

    def diffuse(self, degrees: float) -> Solution:
        """The same by the waves, in a hundredth of the time, without gloss."""
        at = waves_at(np.radians(degrees % 360.0))
        irradiance, direct = (np.maximum(np.tensordot(at, of, 1), 0.0) for of in self.waves)
        given = {name: self._options.get(name) for name in ("reflectance", "bounces")}
        return self.transfer._lit(self.harmonics(degrees), self._seen(degrees), irradiance, direct, **given)

    @cached_property
    def waves(self) -> Waves:
        """Found when first asked for, by nine relightings."""
        angles = 2.0 * np.pi * np.arange(WAVES) / WAVES
        # Of orthogonal columns the transpose is the inverse, but for their squares: 9 of the constant, 9/2 of others.
        inverse = np.array([waves_at(angle) for angle in angles]).T / WAVES
        inverse[1:] *= 2.0
        given = {name: self._options.get(name) for name in ("reflectance", "bounces")}
        found = np.zeros((2, WAVES, len(self.transfer.scene.surfels), 3), np.float32)
        for k, angle in enumerate(angles):
            direct, irradiance = self.transfer._unclipped(self.harmonics(np.degrees(angle)), **given)
            for into, values in zip(found, (irradiance, direct), strict=True):
                for wave, weight in zip(into, inverse[:, k].astype(np.float32), strict=True):
                    wave += weight * values
        return Waves(*found)


def waves_at(angle: float) -> Floats:
    """(9,): 1, cos a, sin a, cos 2a, sin 2a, ... of an angle in radians."""
    at = np.ones(WAVES)
    periods = np.arange(1, ORDER) * angle
    at[1::2], at[2::2] = np.cos(periods), np.sin(periods)
    return at
