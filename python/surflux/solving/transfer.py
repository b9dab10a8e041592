"""Precomputed light transport: what all kinds of it have (Lehtinen and others 2007, sections 6.4 and 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.array_file import write_arrays
from surflux._base.types import FilePath, Floats
from surflux.points.surfels import Surfels
from surflux.scenes.lights import LIGHTS, AreaLight, Environment, Light, environments_among
from surflux.scenes.scene import Scene
from surflux.scenes.scene_arrays import scene_arrays
from surflux.scenes.sky import Sky
from surflux.solutions.rendering import Walls
from surflux.solutions.solution import Solution
from surflux.solving.darkness import warn_of_lost_power, warn_of_power_into_backs

FILE_KIND, FILE_VERSION = "surflux.transfer", 2
LARGEST = 1e30  # of light, in its own unit: the sums of an operator are float32, which ends at 3.4e38


class Transfer:
    """How light is reflected in a scene, whatever the light, as `precompute_transfer` finds it.

    Attributes:
        scene: Scene. Its own lights do not matter.
        lighting: what may change, as it was given to `precompute_transfer`.
        bounces: of light, unless `relight` is given others; None for all. Can be set.
        receivers: (points, normals), (m, 3) each: where light is gathered.
        nbytes: that the operator takes, without the scene.
        rays, links: shot, and kept as pairs of a receiver and a group of surfels.
        left_out: how many receivers and surfels `max_memory` kept from being refined.
        timings: dict, seconds per stage of the precomputation.
    """

    lighting: ClassVar[str]
    scene: Scene
    timings: dict[str, float]
    _core: _core.LocalTransfer | _core.DistantTransfer | _core.SkyTransfer

    def __init__(self, core: Any, scene: Scene, bounces: int | None, timings: dict[str, float]) -> None:
        """Not called by users: see `precompute_transfer` and `load_transfer`."""
        self._made_of = [s._core for s in scene.objects]
        self._core, self.scene, self.bounces, self.timings = core, scene, bounces, timings
        self._walls = Walls()  # of pictures, of whatever light
        self._losses: Floats | None = None  # of what surfels send: what escapes, what backs absorb

    @property
    def bounces(self) -> int | None:
        """Of light, unless `relight` is given others; None for all. Can be set."""
        return self._reflections

    @bounces.setter
    def bounces(self, bounces: int | None) -> None:
        self._reflections = None if bounces is None else check.count("bounces", bounces, 0)

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

    @property
    def left_out(self) -> int:
        """How many receivers and surfels `max_memory` kept from being refined; 0 where all had room."""
        return self._core.left_out

    def __repr__(self) -> str:
        receivers = len(self.receivers[0])
        return f"{type(self).__name__}({receivers} receivers, {self.links} links, {self.nbytes / 1e6:.0f} MB)"

    def save(self, path: FilePath) -> Path:
        """Writes the operator and its scene as one file, which `load_transfer` reads; it appears whole or not at all.

        The file has `nbytes` of the operator and those of the scene: 76 for each triangle, and for each surfel some 90
        (where more than 256 colours are different, some 140). It has checksums, and all that it takes to relight: the
        files that the scene was made of are not needed. What it gives is the same, bit by bit.

        Args:
            path: str or path, ending in .transfer. A file that is there is replaced, whole or not at all.

        Returns:
            The Path written.

        Raises:
            ValueError: a path with another suffix.
            FileError: the file cannot be written.
        """
        path = Path(check.path("path", path))
        if path.suffix.lower() != ".transfer":
            raise ValueError(f"path: wanted a name ending in .transfer, got {str(path)!r}")
        self._scene_core()
        scene, arrays = scene_arrays(self.scene)
        arrays = {f"scene/{name}": values for name, values in arrays.items()}
        arrays |= {f"{self.lighting}/{name}": values for name, values in self._core.arrays().items()}
        about = {"lighting": self.lighting, "bounces": self.bounces, "timings": self.timings, "scene": scene}
        write_arrays(path, FILE_KIND, FILE_VERSION, about, arrays)
        return path

    @classmethod
    def _of_arrays(cls, scene: Scene, arrays: dict[str, Any], bounces: int | None, timings: dict[str, float]) -> Self:
        """Of what _core's arrays() gave; ValueError, naming the array, where they do not fit."""
        kind = getattr(_core, cls.__name__)
        return cls(kind.of_arrays(scene._to_core(), arrays, list(timings.items())), scene, bounces, timings)

    def __reduce__(self) -> tuple[Any, ...]:
        arrays = {name: values.copy() for name, values in self._core.arrays().items()}
        return self._of_arrays, (self.scene, arrays, self.bounces, self.timings)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self  # nothing of it changes

    def _refuse_lights(self, name: str, value: Any, wanted: str) -> None:
        """Refuses lights and lists of them, and says what this takes and what takes those."""
        some = value[0] if isinstance(value, (list, tuple)) and value else value
        if isinstance(some, (*LIGHTS, Sky)):
            if isinstance(some, Environment) or (isinstance(some, Sky) and self.lighting == "sky"):
                raise ValueError(f"{name}: wanted {wanted}, got a list of {type(some).__name__}; wanted one by itself")
            got = type(some).__name__ if some is value else f"a list of {type(some).__name__}"
            goes = "a Sky goes with precompute_transfer(scene, 'sky')"
            if not isinstance(some, Sky):
                goes = "lamps go with precompute_transfer(scene, 'local')"
            raise ValueError(
                f"{name}: wanted {wanted}, got {got}; this is a transfer of lighting {self.lighting!r}, {goes}"
            )

    def _scene_core(self) -> _core.Scene:
        """The compiled scene; ValueError where areas were set since."""
        if any(s._core is not then for s, then in zip(self.scene.objects, self._made_of, strict=True)):
            raise ValueError("scene: areas of its surfels were set after precompute_transfer, which is to be run anew")
        return self.scene._to_core()

    def _reflecting(self, bounces: int | None) -> Self:
        """It, or its twin that reflects light so often; None for all."""
        if bounces == self.bounces:
            return self
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.bounces = bounces
        return twin

    def _bounces(self, bounces: int | None) -> int:
        bounces = self.bounces if bounces is None else check.count("bounces", bounces, 0)
        return -1 if bounces is None else bounces

    def _reflectance(self, reflectance: ArrayLike | None) -> Floats | None:
        if reflectance is None:
            return None
        return check.per_surfel_rgb("reflectance", reflectance, len(self._core.areas), high=1.0, high_open=True)

    def _objects(self, reflectance: Floats | None) -> Sequence[Surfels]:
        """Those of the scene, which reflect `reflectance`, (n, 3) of all surfels, or what they have."""
        objects = self.scene.objects
        if reflectance is None:
            return objects
        each = np.split(reflectance, np.cumsum([len(one) for one in objects])[:-1])
        return [one._reflecting(part) for one, part in zip(objects, each, strict=True)]

    def _add_account(self, solution: Solution, bounces: int) -> Solution:
        """Where the power of a relit solution goes, as its history, and warnings of what backs absorb and, of all
        bounces (below 0), of what is made or lost.

        What leaves the scene and what ends on backs is counted by the rays of receivers around each surfel.
        """
        if self._losses is None:
            self._losses = np.asarray(self._core.losses(), dtype=float)
        areas, surfels = np.asarray(self._core.areas), solution.surfels
        sent = areas * solution.radiosity.sum(axis=1)
        entered = areas @ (surfels.emission + solution.direct).sum(axis=1)
        absorbed = areas @ ((1.0 - surfels.reflectance) * solution.irradiance).sum(axis=1)
        escaped, into_backs = sent @ self._losses
        figures = {
            "surfels": len(surfels),
            "power_in": float(entered),
            "power_absorbed": float(absorbed),
            "power_escaped": float(escaped),
            "power_into_backs": float(into_backs),
            "power_lost": float(entered - absorbed - escaped - into_backs),
        }
        solution.history = [figures]
        warn_of_power_into_backs(figures)
        if bounces < 0:
            warn_of_lost_power(figures, "transfer")
        return solution

    def _solution(
        self,
        lights: list[Light],
        reflectance: Floats | None,
        bounces: int,
        irradiance: Floats,
        direct: Floats,
        **rest: Any,
    ) -> Solution:
        """At the scene's own surfels, which reflect `reflectance`, or what they have; bounces: see _bounces()."""
        core = self._scene_core()
        own = core.surfels if reflectance is None else core.surfels.with_reflectance(reflectance)
        surfels = Surfels._from_core(own)
        scene = Scene(self._objects(reflectance), lights=lights, camera=self.scene.camera)
        solution = Solution(
            surfels,
            parents=np.arange(len(surfels)),
            objects=core.object,
            radiosity=surfels.emission + surfels.reflectance * irradiance,
            irradiance=irradiance,
            direct=direct,
            emitted=self._core.emitted(),
            camera=self.scene.camera,
            lamps=[light for light in scene.lights if isinstance(light, AreaLight)],
            environments=environments_among(scene.lights),
            scene=scene,
            **rest,
        )
        solution._bounces = None if bounces < 0 else bounces
        solution._walls = self._walls
        return solution
