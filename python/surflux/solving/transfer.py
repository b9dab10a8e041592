"""Precomputed light transport: what all kinds of it have (Lehtinen and others 2007, sections 6.4 and 6.5)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.types import Floats
from surflux.points.surfels import Surfels
from surflux.scenes.scene import Scene
from surflux.solutions.solution import Solution


class Transfer:
    """How light is reflected in a scene, whatever the light, as `precompute_transfer` finds it.

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
    _core: _core.LocalTransfer | _core.DistantTransfer | _core.SkyTransfer

    def __init__(self, core: Any, scene: Scene, bounces: int | None, seconds: float) -> None:
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
        return f"{type(self).__name__}({receivers} receivers, {self.links} links, {self.nbytes / 1e6:.0f} MB)"

    def _bounces(self, bounces: int | None) -> int:
        bounces = self.bounces if bounces is None else check.count("bounces", bounces, 0)
        return -1 if bounces is None else bounces

    def _reflectance(self, reflectance: ArrayLike | None) -> Floats | None:
        if reflectance is None:
            return None
        return check.per_surfel_rgb("reflectance", reflectance, len(self._core.areas), high=1.0, high_open=True)

    def _solution(self, reflectance: Floats | None, irradiance: Floats, direct: Floats, **rest: Any) -> Solution:
        """At the scene's own surfels, which reflect `reflectance`, or what they have."""
        core = self.scene._to_core()
        own = core.surfels if reflectance is None else core.surfels.with_reflectance(reflectance)
        surfels = Surfels._from_core(own)
        return Solution(
            surfels,
            parents=np.arange(len(surfels)),
            objects=core.object,
            radiosity=surfels.emission + surfels.reflectance * irradiance,
            irradiance=irradiance,
            direct=direct,
            camera=self.scene.camera,
            **rest,
        )
