"""Precomputed light transport: lights move, the scene stays (Lehtinen and others 2007, section 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.types import Floats, Progress
from surflux.points.surfels import Surfels
from surflux.scenes.lights import LIGHTS, AreaLight, DirectionalLight, Light, PointLight, SpotLight
from surflux.scenes.scene import Scene
from surflux.solutions.solution import Solution
from surflux.solving.run import check_scene

LOCAL = PointLight, SpotLight, AreaLight, DirectionalLight
SAMPLES = 4  # of the unoccluded light of each group of senders


class Transfer:
    """How the light of lamps is reflected in a scene, as `precompute_transfer` finds it.

    Attributes:
        scene: Scene. Its own lights do not matter.
        bounces: of light, unless `relight` is given others; None for all.
        receivers: (points, normals), (m, 3) each: where light is gathered.
        nbytes: that the operator takes, without the scene.
        rays, links: shot, and kept as pairs of a receiver and a group of surfels.
        timings: dict, seconds per stage of the precomputation.
    """

    scene: Scene
    bounces: int | None
    timings: dict[str, float]

    def __init__(self, core: _core.LocalTransfer, scene: Scene, bounces: int | None, seconds: float) -> None:
        """Not called by users: see `precompute_transfer`."""
        self._core, self.scene, self.bounces = core, scene, bounces
        self.timings = {"areas": seconds, **core.timings}

    @property
    def receivers(self) -> tuple[Floats, Floats]:
        """(points, normals), (m, 3) each: where light is gathered."""
        return self._core.receivers

    @property
    def nbytes(self) -> int:
        """Bytes that the operator takes, without the scene."""
        return self._core.bytes

    @property
    def rays(self) -> int:
        """How many were shot from receivers."""
        return self._core.rays

    @property
    def links(self) -> int:
        """Pairs of a receiver and a group of surfels that its rays met."""
        return self._core.links

    def __repr__(self) -> str:
        receivers = len(self.receivers[0])
        return f"Transfer({receivers} receivers, {self.links} links, {self.nbytes / 1e6:.0f} MB)"

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

        Lights are additive: with the same seed, what two bring is the sum of what each brings.

        Args:
            lights: one or a list of PointLight, SpotLight, AreaLight and DirectionalLight.
            reflectance: another one of the surfels: scalar, (3,), (n,) or (n, 3), at least 0 and less than 1. None for
                the scene's.
            bounces: how often light is reflected, at least 0. None for what `precompute_transfer` was given.
            shadow_rays: towards each light, of all groups of senders together.
            probes, penumbra_rays: of direct light, as `probes` and `shadow_rays` of `solve`.
            seed, threads, progress: see `solve`.

        Returns:
            Solution at the scene's own surfels. What emissive surfels bring is in it. Its `error` is NaN: it is not
            estimated.

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
        options = _penumbra_options(probes, penumbra_rays)
        scene = Scene(self.scene.objects, lights=_as_list(lights), camera=self.scene.camera)
        with thread_limit(threads):
            core = self.scene._to_core()
            start = perf_counter()
            indirect = self._core.indirect(*given)
            found = perf_counter()
            with stage_callback(progress) as callback:
                report = None if callback is None else lambda done, total: callback("direct", done, total)
                direct = np.asarray(self._core.direct(given[0], *options, given[-1], report))
            seconds = {"indirect": found - start, "direct": perf_counter() - found}
        surfels = core.surfels if given[1] is None else core.surfels.with_reflectance(given[1])
        surfels = Surfels._from_core(surfels)
        irradiance = direct + indirect
        return Solution(
            surfels,
            parents=np.arange(len(surfels)),
            objects=core.object,
            radiosity=surfels.emission + surfels.reflectance * irradiance,
            irradiance=irradiance,
            direct=direct,
            timings=seconds,
            lamps=[light for light in scene.lights if isinstance(light, AreaLight)],
            camera=scene.camera,
            scene=scene,
        )

    def _given(self, lights, reflectance, bounces, shadow_rays, seed):
        lights = _as_list(lights)
        for index, light in enumerate(lights):
            if not isinstance(light, LOCAL):
                what = type(light).__name__
                raise ValueError(f"lights: wanted point, spot, area or directional lights, got {what} at index {index}")
        bounces = self.bounces if bounces is None else check.count("bounces", bounces, 0)
        if reflectance is not None:
            n = len(self._core.areas)
            reflectance = check.per_surfel_rgb("reflectance", reflectance, n, high=1.0, high_open=True)
        return (
            [light._to_core() for light in lights],
            reflectance,
            -1 if bounces is None else bounces,
            check.count("shadow_rays", shadow_rays),
            check.seed("seed", seed),
        )


def _penumbra_options(probes, penumbra_rays):
    check.count("penumbra_rays", penumbra_rays)
    if check.count("probes", probes) > penumbra_rays:
        raise ValueError(f"penumbra_rays: wanted at least the {probes} probes, got {penumbra_rays}")
    return probes, penumbra_rays


def _as_list(lights):
    if isinstance(lights, LIGHTS):
        return [lights]
    if not isinstance(lights, (list, tuple)):
        raise ValueError(f"lights: wanted a light or a list of lights, got {type(lights).__name__}")
    return list(lights)


def precompute_transfer(
    scene: Scene,
    lighting: Literal["local"] = "local",
    *,
    bounces: int | None = 3,
    epsilon_t: float = 0.3,
    levels: int = 6,
    radius: float | None = None,
    rays: int = 512,
    senders: int = 65536,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> Transfer:
    """Direct-to-indirect transfer: light transport of a scene, found once, for lamps that then move (L07 section 6.5).

    Rays from the points of a multilevel basis link them to groups of surfels, whatever the light. `Transfer.relight`
    finds the direct light of the groups, and the operator turns what they reflect of it into indirect light everywhere,
    with one product for each bounce. Points are refined where they differ in the light of 64 lamps at random places in
    the air. Surfels whose own rays contradict the basis have rays of their own.

    What departs from L07: senders are groups of surfels and no basis functions, so that nothing is interpolated of
    senders; bounces are products at run time, so that reflectance may change, too; points keep irradiance and its
    gradient by the normal.

    Args:
        scene: Scene; its lights do not matter. `Transfer` keeps it.
        lighting: "local", lamps in the scene and around it.
        bounces: how often light is reflected; None for until another bounce brings less than a thousandth.
        epsilon_t: what the light of a lamp at a point may be off by before it is refined, of the RMS over the scene, in
            the mean square over the lamps; 1.4 times as much on each finer level; positive.
        levels, radius: of the basis, as in `solve_meshless`.
        rays: of a point on the coarsest level, 16 to 65535; half as many on every other finer level, down to 128.
        senders: groups of surfels, at most; the more, the nearer lamps may come to surfaces. At least 1.
        seed, threads, progress: see `solve`.

    Returns:
        Transfer.

    Raises:
        ValueError: an argument out of range, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
    >>> near, far = (transfer.indirect(sf.PointLight([x, 0.5, 0.5], 1.0)).mean() for x in (0.2, 0.8))
    >>> bool(near > far)
    True
    """
    check_scene(scene)
    check.choice("lighting", lighting, ("local",))
    bounces = None if bounces is None else check.count("bounces", bounces, 0)
    options = (
        check.count("levels", levels, 1, 10),
        0.0 if radius is None else check.number("radius", radius, 0.0, low_open=True),
        check.number("epsilon_t", epsilon_t, 0.0, low_open=True),
        check.count("rays", rays, 16, 65535),
        check.count("senders", senders, 1),
        SAMPLES,
        check.seed("seed", seed),
    )
    with thread_limit(threads):
        start = perf_counter()
        core = scene._to_core(progress=progress)
        seconds = perf_counter() - start
        with stage_callback(progress) as callback:
            return Transfer(_core.LocalTransfer(core, *options, callback), scene, bounces, seconds)
