"""Skies that change over days and years: daylight coefficients of patches of the sky, bounces included."""

from __future__ import annotations

from functools import cached_property
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.color import rgb_of_grey
from surflux._base.passes import report, stage, watched
from surflux._base.types import Progress
from surflux._base.warn import warn
from surflux.scenes.lights import Environment
from surflux.scenes.sky import Sky
from surflux.scenes.sky_patches import SkyPatches
from surflux.solutions.solution import Solution
from surflux.solving.darkness import warn_of_backs, warn_of_no_arrival
from surflux.solving.transfer import LARGEST, Transfer

SUN_RAYS = 16, 64  # probes and shadow rays of each surfel, as of solve
NARROW = 0.1  # of an environment's light: more than that in small parts of patches is told
UNEVEN = 0.05  # of the light that arrives: what of the ground is elsewhere
WAYS = 8192  # rays that tell which parts of it surfels see


class SkyTransfer(Transfer):
    """What patches of the sky bring to the surfels of a scene: `precompute_transfer(scene, "sky")`.

    Attributes:
        patches: SkyPatches; +z is up, +y is north.
    """

    lighting = "sky"
    _core: _core.SkyTransfer

    @cached_property
    def patches(self) -> SkyPatches:
        """Of the sky, and the ground; +z is up, +y is north."""
        return SkyPatches(len(self._core.patches) - 1)

    @cached_property
    def _ways_out(self):
        """(m, 3) directions in which rays leave the scene, cosine-distributed from surfels drawn by area."""
        core = self._scene_core()
        surfels, random = core.surfels, np.random.default_rng(0)
        areas = np.asarray(surfels.areas)
        if not areas.any():
            return np.zeros((0, 3))
        rows = random.choice(len(areas), WAYS, p=areas / areas.sum())
        around = random.normal(size=(WAYS, 3))
        ways = np.asarray(surfels.normals)[rows] + around / np.linalg.norm(around, axis=1, keepdims=True)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        met, _, _ = _core.closest_hits(core, rows.astype(np.uint32), np.asarray(surfels.positions)[rows], ways)
        return ways[met < 0]

    def relight(
        self,
        sky: Sky | Environment | ArrayLike,
        *,
        reflectance: ArrayLike | None = None,
        bounces: int | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Solution:
        """The scene under a sky, of which each patch is even. It is linear in the sky.

        The sun of a Sky stays sharp: it is a light of its own, as in `solve`, found by rays to each surfel. A sun in an
        Environment, or in radiances, is as wide as its patch (see `patches` of `precompute_transfer`), and so are its
        shadows and what it throws through windows; of an Environment's this warns.

        Args:
            sky: Sky; Environment; or radiances of the patches and of the ground, in their order: (patches,) or
                (patches, 3). At most 1e30.
            reflectance: another one of the surfels: scalar, (3,), (n,) or (n, 3), at least 0 and less than 1. None for
                the scene's.
            bounces: how often light is reflected, at least 0. None for what `precompute_transfer` was given.
            threads: at most this many; None for all.
            progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

        Returns:
            Solution at the scene's own surfels, what emissive ones bring in it. Its `irradiance_at` traces the sky as
            it is. Its `error` is NaN until `estimate_error` is asked. Its history tells where the power
            goes, as that of lamps does.

        Raises:
            ValueError: an argument, by name.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1)
        >>> transfer = sf.precompute_transfer(sf.Scene([floor]), "sky")
        >>> print(transfer.relight(sf.Environment(1.0)).irradiance.round(3)[0])
        [3.142 3.142 3.142]
        """
        radiances, sun = self._parts_of(sky)
        reflectance = self._reflectance(reflectance)
        seconds = {}
        with watched(threads, progress):
            start = perf_counter()
            report(stage("irradiance"), 0, 1)
            if sun is not None:
                sun = np.asarray(self._core.sunlight([sun._to_core()], *SUN_RAYS, 0, stage("sun")))
                seconds["sun"] = perf_counter() - start
                start = perf_counter()
            bounces = self._bounces(bounces)
            found = self._core.irradiance(radiances, sun, reflectance, bounces)
            direct, irradiance = map(np.asarray, found)
            seconds["irradiance"] = perf_counter() - start
        is_light = isinstance(sky, (Environment, Sky))
        lights = [sky if is_light else self.patches.environment(radiances)]
        solution = self._solution(lights, reflectance, bounces, irradiance, direct, timings=seconds)
        if is_light:
            core = self._scene_core()
            warn_of_backs(solution._scene.lights, core.surfels, direct, core.surfels.areas)
        else:
            warn_of_no_arrival(radiances, direct)
        return self._add_account(solution, bounces)

    def _parts_of(self, sky):
        """(patches, 3) radiances of a sky, and its sun, of which they have nothing, or None."""
        if isinstance(sky, Sky):
            radiances, sun = sky.patch_radiances(self.patches), sky.sun
        elif isinstance(sky, Environment):
            radiances, sun = self.patches.radiance(sky), None
        else:
            self._refuse_lights("sky", sky, f"a Sky, an Environment or radiances ({len(self.patches)}, 3)")
            radiances, sun = check.numeric("sky", sky), None
        count = len(self.patches)
        if radiances.shape not in ((count,), (count, 3)):
            shape = f"({count},) or ({count}, 3), of which the first radiance is the ground's"
            raise ValueError(f"sky: wanted shape {shape}, got {radiances.shape}")
        if radiances.ndim == 1:
            radiances = rgb_of_grey(radiances)
        if not isinstance(sky, Environment):  # its own may overflow
            radiances = check.finite_array("sky", radiances, (count, 3))
        check.in_range("sky", radiances, 0.0, LARGEST)
        if isinstance(sky, Environment):
            _warn_of_narrow_light(sky, self.patches, radiances)
            self._warn_of_uneven_ground(sky, radiances)
        return radiances, sun

    def _warn_of_uneven_ground(self, environment, radiances):
        if environment.image is None:
            return
        share = self.patches._misplaced_ground(environment, radiances, self._ways_out)
        if share > UNEVEN:
            warn(
                f"sky: {share:.0%} of the light that arrives of this environment would come from other parts of what "
                "is below the horizon, which is one patch of one radiance: the ground should be surfels of the scene, "
                "or `solve` is right"
            )

    def coefficients(
        self,
        surfels: ArrayLike | None = None,
        *,
        bounces: int | None = None,
        threads: int | None = None,
        progress: Progress = False,
    ) -> NDArray[np.float32]:
        """Daylight coefficients: irradiance at surfels by each patch alone, where its radiance is 1, bounces included.

        One product makes irradiance of them under any sky, and a year of hours of a matrix of 8760 skies, such as
        Radiance's gendaymtx writes: `np.einsum("npc,hpc->hnc", coefficients, skies).clip(0.0)`. Interpolated between
        places, single coefficients can be below 0, and so can what a sky of few patches makes of them, which `relight`
        clips, too. What surfels emit is left out. For a single sky `relight` is quicker.

        Args:
            surfels: (m,) indices of scene.surfels, or a mask (n,); None for all.
            bounces: how often light is reflected, at least 0. None for what `precompute_transfer` was given.
            threads: at most this many; None for all.
            progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

        Returns:
            (m, patches, 3) float32 in steradians, for red, green and blue.

        Raises:
            ValueError, IndexError: an argument, by name.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1)
        >>> transfer = sf.precompute_transfer(sf.Scene([floor]), "sky")
        >>> found = transfer.coefficients([0, 1])
        >>> found.shape, found[0].sum(axis=0).round(3).tolist()  # an even sky of radiance 1: pi
        ((2, 146, 3), [3.1419999599456787, 3.1419999599456787, 3.1419999599456787])
        """
        chosen = check.selection("surfels", slice(None) if surfels is None else surfels, len(self.scene.surfels))
        with watched(threads, progress):
            return self._core.coefficients(chosen, self._bounces(bounces), stage("coefficients"))


def _warn_of_narrow_light(environment, patches, radiances):
    share = patches._narrow_light(environment, radiances)
    if share > NARROW:
        width = np.degrees(np.sqrt(patches.solid_angles[1]))
        warn(
            f"sky: {share:.0%} of this environment's light is narrower than the patches of {width:.0f} degrees over "
            "which it is spread, as a sun is: shadows and what falls through windows are as wide. A Sky has a sharp "
            "sun; more patches are narrower (precompute_transfer(scene, 'sky', patches=2305))"
        )
