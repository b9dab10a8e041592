"""Lamps that move, the scene stays: direct-to-indirect transfer (Lehtinen and others 2007, section 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.types import Floats, Progress
from surflux.scenes.lights import (
    AreaLight,
    DirectionalLight,
    Environment,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
    power_name,
)
from surflux.scenes.sky import Sky
from surflux.solutions.solution import Solution
from surflux.solving.darkness import warn_of_backs
from surflux.solving.light_on_backs import warn_of_lamps_in_bodies
from surflux.solving.transfer import LARGEST, Transfer

LOCAL = PointLight, SpotLight, PhotometricLight, AreaLight, DirectionalLight
_TAKEN = {
    Environment: '; precompute_transfer(scene, "distant") or "sky" takes it',
    Sky: '; precompute_transfer(scene, "sky") takes it',
}


class LocalTransfer(Transfer):
    """How the light of lamps is reflected in a scene: `precompute_transfer(scene, "local")`."""

    lighting = "local"
    _core: _core.LocalTransfer

    def indirect(
        self,
        lights: Light | Sequence[Light],
        *,
        reflectance: ArrayLike | None = None,
        bounces: int | None = None,
        shadow_rays: int = 16384,
        seed: int = 0,
        threads: int | None = None,
    ) -> Floats:
        """Indirect irradiance of all surfels of the scene, and nothing else: what a lamp that is dragged needs.

        Args:
            lights, reflectance, bounces, shadow_rays, seed, threads: see `relight`.

        Returns:
            (n, 3), by the rows of `scene.surfels`, in the unit of the lights (W/m2): what surfaces reflect and emit.
            Of lamps in bodies and light on backs of surfels `relight` warns, this does not.

        Raises:
            ValueError: an argument, by name.

        >>> import surflux as sf
        >>> floor = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]
        >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(floor, 0.1)]))
        >>> transfer.indirect(sf.PointLight([0.5, 0.5, 1], 1.0)).max()  # a plane does not light itself
        np.float64(0.0)
        """
        given = self._given(lights, reflectance, bounces, shadow_rays, seed)
        with thread_limit(threads):
            return np.asarray(self._core.indirect(*given))

    def relight(
        self,
        lights: Light | Sequence[Light],
        *,
        reflectance: ArrayLike | None = None,
        bounces: int | None = None,
        shadow_rays: int = 16384,
        probes: int = 16,
        penumbra_rays: int = 64,
        seed: int = 0,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Solution:
        """The scene under other lights: indirect light by the operator, direct light by rays to each surfel.

        Lights are additive: what two bring is the sum of what each brings, but for the shadow rays' noise, for each
        light has rays of its own.

        Args:
            lights: one or a list of PointLight, SpotLight, PhotometricLight, AreaLight and DirectionalLight, of at most
                1e30 in their units each.
            reflectance: another one of the surfels: scalar, (3,), (n,) or (n, 3), at least 0 and less than 1. None for
                the scene's.
            bounces: how often light is reflected, at least 0. None for what `precompute_transfer` was given.
            shadow_rays: towards each light, of all groups of senders together; of one that is wider than it is far away
                up to four times as many, and more where groups would share a ray and walls part them.
            probes, penumbra_rays: of direct light, as `probes` and `shadow_rays` of `solve`.
            seed, threads, progress: see `solve`.

        Returns:
            Solution at the scene's own surfels. What emissive surfels bring is in it. Its `error` is NaN until
            `estimate_error` is asked, by some half a million rays. Its history tells where the power goes:
            `power_lost` is what is made (below 0) or lost, and what reflections that `bounces` leaves out would bring.

        Raises:
            ValueError: an argument, by name; an Environment, which is no local light.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
        >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
        >>> solution = transfer.relight([sf.PointLight([0.5, 0.5, 0.5], 1.0)])
        >>> print(f"{(solution.irradiance - solution.direct).sum() / solution.direct.sum():.1f}")
        0.1
        """
        given = self._given(lights, reflectance, bounces, shadow_rays, seed)
        rays = _penumbra_options(probes, penumbra_rays)
        solution = self._relit(lights, given, *rays, threads, progress)
        self._warn(as_list(lights), solution.direct)
        return self._add_account(solution, given[2])

    def _relit(self, lights, given, probes, penumbra_rays, threads=None, progress=False):
        """What `relight` returns, without its warnings; given: see _given."""
        with thread_limit(threads):
            start = perf_counter()
            indirect = self._core.indirect(*given)
            found = perf_counter()
            with stage_callback(progress) as callback:
                report = None if callback is None else lambda done, total: callback("direct", done, total)
                direct = np.asarray(self._core.direct(given[0], probes, penumbra_rays, given[-1], report))
            seconds = {"indirect": found - start, "direct": perf_counter() - found}
        return self._solution(as_list(lights), *given[1:3], direct + indirect, direct, timings=seconds)

    def _warn(self, lights, direct):
        """Of lights that reach no fronts, or hardly any; direct: (n, 3) irradiance that they bring."""
        core = self._scene_core()
        told = []
        if not warn_of_backs(lights, core.surfels, direct, core.surfels.areas, told):
            warn_of_lamps_in_bodies(lights, core, told)

    def _given(self, lights, reflectance, bounces, shadow_rays, seed):
        lights = as_list(lights)
        for index, light in enumerate(lights):
            if not isinstance(light, LOCAL):
                what = type(light).__name__
                got = f"{what} at index {index}{_TAKEN.get(type(light), '')}"
                raise ValueError(f"lights: wanted point, spot, photometric, area or directional lights, got {got}")
            power = power_name(light)
            if max(getattr(light, power)) > LARGEST:
                got = f"{max(getattr(light, power)):g} at index {index}"
                raise ValueError(f"lights: wanted {power} of at most {LARGEST:g}, got {got}")
        return (
            [light._to_core() for light in lights],
            self._reflectance(reflectance),
            self._bounces(bounces),
            check.count("shadow_rays", shadow_rays),
            check.seed("seed", seed),
        )


def _penumbra_options(probes, penumbra_rays):
    check.count("penumbra_rays", penumbra_rays)
    if check.count("probes", probes) > penumbra_rays:
        raise ValueError(f"penumbra_rays: wanted at least the {probes} probes, got {penumbra_rays}")
    return probes, penumbra_rays


def as_list(lights):
    return list(lights) if isinstance(lights, (list, tuple)) else [lights]
