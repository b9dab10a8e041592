"""Distant light that turns and changes, on glossy surfaces (Lehtinen and others 2007, sections 5.2 and 6.4)."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.color import rgb_of_grey
from surflux._base.passes import thread_limit
from surflux._base.types import Floats
from surflux.geometry.gloss import gloss_arrays, require_energy
from surflux.scenes.lights import Environment
from surflux.solutions.solution import Solution
from surflux.solving.darkness import warn_of_backs, warn_of_no_arrival
from surflux.solving.harmonics import rotate_harmonics
from surflux.solving.transfer import LARGEST, Transfer

ORDER = 5  # of the environment


class DistantTransfer(Transfer):
    """How distant light comes to the surfels of a scene: `precompute_transfer(scene, "distant")`."""

    lighting = "distant"
    _core: _core.DistantTransfer

    def relight(
        self,
        environment: Environment | ArrayLike,
        *,
        rotation: ArrayLike | None = None,
        reflectance: ArrayLike | None = None,
        specular: ArrayLike | None = None,
        exponent: ArrayLike | None = None,
        bounces: int | None = None,
        threads: int | None = None,
    ) -> Solution:
        """The scene in a distant environment, of which five bands of spherical harmonics are taken.

        It is linear in the environment. Reflections between surfels are diffuse, by `reflectance`: only towards the
        eye surfels are glossy (L07 section 6.4 has the bounces in its matrices likewise). Of the environment 81
        harmonics come to a surfel, so that lobes of an exponent far above 40 are blurred; of what other surfels send
        25, which blurs those above 10. Small strong emissive surfels are in lobes as they are, but for the noise of
        64 rays a surfel, which each view takes anew.

        Args:
            environment: Environment, or its harmonics in the scene's axes (see surflux.spherical_harmonics): (n,) or
                (n, 3), n = 1, 4, 9, 16 or 25. At most 1e30.
            rotation: (3, 3); what came from direction d comes from rotation @ d. None for none.
            reflectance: another one of the surfels: scalar, (3,), (n,) or (n, 3), at least 0 and less than 1. None for
                the scene's.
            specular, exponent: likewise, as Surfels have them. None for the scene's.
            bounces: how often light is reflected, at least 0. None for what `precompute_transfer` was given.
            threads: at most this many; None for all.

        Returns:
            Solution at the scene's own surfels, what emissive ones bring in it. Where surfels are glossy, `render` and
            `radiance_towards` are, too; radiosity is their diffuse part. Its `error` is NaN until `estimate_error`
            is asked, which compares it with the environment as it is, not with its harmonics. Five bands of a bright
            small light are below 0 elsewhere; so may irradiance be, which is cut off at 0. Its history tells where the
            power goes, as that of lamps does.

        Raises:
            ValueError: an argument, by name.

        >>> import surflux as sf
        >>> ball = sf.Surfels.from_mesh(([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[0, 1, 3], [1, 2, 3]]), 0.1)
        >>> transfer = sf.precompute_transfer(sf.Scene([ball]), "distant")
        >>> solution = transfer.relight(sf.Environment(1.0))
        >>> print(solution.irradiance.round(3)[0])
        [3.142 3.142 3.142]
        """
        if not isinstance(environment, Environment):
            self._refuse_lights("environment", environment, "an Environment or 1, 4, 9, 16 or 25 harmonics")
        light, seen = harmonics_of(environment), environment
        if rotation is not None:
            light = rotate_harmonics(light, rotation)
            seen = environment._turned(np.asarray(rotation)) if isinstance(environment, Environment) else light
        reflectance = self._reflectance(reflectance)
        gloss = self._gloss(reflectance, specular, exponent)
        with thread_limit(threads):
            start = perf_counter()
            incident = self._core.incident(light, reflectance, self._bounces(bounces))
            direct, irradiance = (np.maximum(np.asarray(found), 0.0) for found in incident.irradiance())
            seconds = perf_counter() - start
        found = {"reflectance": reflectance, "bounces": bounces, "timings": {"incident": seconds}}
        solution = self._lit(light, seen, irradiance, direct, **found)
        if isinstance(environment, Environment):
            core = self._scene_core()
            warn_of_backs([seen], core.surfels, direct, core.surfels.areas)
        else:
            warn_of_no_arrival(light, direct)
        if gloss:
            solution._mirrored = incident, gloss["specular"], gloss["exponent"]
        return self._add_account(solution, self._bounces(bounces))

    def _unclipped(
        self, light: Floats, reflectance: ArrayLike | None, bounces: int | None
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """(direct, all) irradiance (n, 3) of 25 harmonics, linear in them: below 0 where five bands are."""
        return self._core.incident(light, self._reflectance(reflectance), self._bounces(bounces)).irradiance()

    def _lit(
        self,
        light: Floats,
        seen: Environment | ArrayLike,
        irradiance: Floats,
        direct: Floats,
        *,
        reflectance: Any,
        bounces: int | None,
        **rest: Any,
    ) -> Solution:
        """The Solution of what was found of 25 harmonics; seen: whose they are, or harmonics."""
        given = self._reflectance(reflectance), self._bounces(bounces)
        if isinstance(seen, Environment):  # which estimates and rays that trace direct light have as it is
            return self._solution([seen], *given, irradiance, direct, **rest)
        solution = self._solution([Environment.from_harmonics(light, 32)], *given, irradiance, direct, **rest)
        solution._environments = [Environment.from_harmonics(light)]
        return solution

    def _gloss(self, reflectance, specular, exponent):
        """What `gloss_arrays` gives of these, or else of the scene."""
        own = self.scene.surfels
        gloss = gloss_arrays(
            own.specular if specular is None else specular,
            own.exponent if exponent is None else exponent,
            len(own),
        )
        return require_energy(own.reflectance if reflectance is None else reflectance, gloss)


def harmonics_of(environment: Environment | ArrayLike) -> Floats:
    """(25, 3) of what relight takes, in the scene's axes."""
    if isinstance(environment, Environment):
        pixels = environment.radiance if environment.image is None else environment.image
        check.in_range("environment", np.abs(pixels), high=LARGEST)
        return environment.harmonics(ORDER)
    array = check.numeric("environment", environment)
    if array.ndim == 1:
        array = rgb_of_grey(array)
    array = check.in_range("environment", check.finite_array("environment", array, (None, 3)), -LARGEST, LARGEST)
    if len(array) not in [band**2 for band in range(1, ORDER + 1)]:
        raise ValueError(f"environment: wanted an Environment or 1, 4, 9, 16 or 25 harmonics, got {len(array)}")
    return np.concatenate([array, np.zeros((ORDER**2 - len(array), 3))])
