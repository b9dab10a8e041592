"""A scene: objects made of surfels, and lights."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.passes import progress_callback
from surflux._base.summary import box_text, html_table
from surflux.meshes.divided import cut_at_walls
from surflux.pictures.camera import Camera
from surflux.points.arranging import concatenate
from surflux.points.surfels import Surfels
from surflux.scenes.lights import LIGHTS, Light
from surflux.scenes.options import checked_solve_options
from surflux.scenes.sky import Sky


class Scene:
    """Surfels and lights that are solved together.

    Args:
        objects: list of Surfels, at least one, none of them empty; each entry is one object, whose surfels interpolate
            among themselves alone (a reconstruction group, L07 section 6.1). Points of several objects on one surface,
            as overlapping scans have them or slices of one cloud, share its area; so do areas that were given, unless
            they are such shares already.
        lights: list of PointLight, SpotLight, PhotometricLight, AreaLight, DirectionalLight, Environment and Sky; may
            be empty where surfels have emission.
        camera: Camera from which the scene wants to be seen, or None.
        name: text for titles and messages.
        solve_options: dict of options for solve() by its own names, all but threads and progress. They count in
            sf.solve(scene) wherever the call does not give others, those that sf.solve_meshless has in that, too, and
            so on the command line.

    Attributes:
        objects, lights: as handed in, as tuples; a Sky as the lights that it is made of.
        surfels: all surfels in one.
        camera, name: as handed in. Both can be set: a solution takes the scene's camera along for its pictures.
        solve_options: a dict of its own, empty where none were given; can be set.

    Raises:
        ValueError: names the argument and the entry; an option that solve() does not have or would not take.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.25)
    >>> sf.Scene([floor], lights=[sf.PointLight([0.5, 0.5, 1], 10)])
    Scene(1 object, 4 surfels, 1 light)
    """

    def __init__(
        self,
        objects: list[Surfels] | tuple[Surfels, ...],
        lights: Sequence[Light | Sky] = (),
        *,
        camera: Camera | None = None,
        name: str = "",
        solve_options: Mapping[str, Any] | None = None,
    ) -> None:
        self._objects = _entries("objects", objects, (Surfels,), "Surfels")
        if not self._objects:
            raise ValueError("objects: wanted at least one Surfels, got an empty list")
        for index, surfels in enumerate(self._objects):
            if not len(surfels):
                raise ValueError(f"objects: wanted at least one surfel in each, got none at index {index}")
        given = _entries("lights", lights, (*LIGHTS, Sky), "lights")
        self._lights = tuple(part for light in given for part in (light.lights if isinstance(light, Sky) else [light]))
        self.camera, self.name, self.solve_options = camera, name, solve_options
        self._core = self._made_of = self._divided = None

    def __getstate__(self) -> dict[str, Any]:
        """What the scene was made of; what was computed from that is computed again."""
        made_of = ("_objects", "_lights", "_camera", "_name", "_solve_options")
        computed = dict.fromkeys(("_core", "_made_of", "_divided"))
        return {name: self.__dict__[name] for name in made_of} | computed

    @property
    def objects(self) -> tuple[Surfels, ...]:
        """The Surfels handed in, as a tuple."""
        return self._objects

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights, as a tuple; of a Sky its Environment and its sun."""
        return self._lights

    @property
    def camera(self) -> Camera | None:
        """The Camera from which the scene wants to be seen, or None; can be set."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera | None) -> None:
        if not isinstance(camera, (Camera, type(None))):
            raise ValueError(f"camera: wanted a Camera or None, got {type(camera).__name__}")
        self._camera = camera

    @property
    def name(self) -> str:
        """Text for titles and messages; can be set."""
        return self._name

    @name.setter
    def name(self, name: str) -> None:
        if not isinstance(name, str):
            raise ValueError(f"name: wanted text, got {type(name).__name__}")
        self._name = name

    @property
    def solve_options(self) -> dict[str, Any]:
        """Options for solve() by name, a dict of the scene's own; can be set, None for no options."""
        return self._solve_options

    @solve_options.setter
    def solve_options(self, options: Mapping[str, Any] | None) -> None:
        self._solve_options = checked_solve_options(options)

    @property
    def surfels(self) -> Surfels:
        """All surfels in one, object after object. Its areas are those given; None where any object has none."""
        return concatenate(self._objects)

    def __repr__(self) -> str:
        objects, surfels, lights = self._counts()
        title = f"{self.name!r}, " if self.name else ""
        return f"Scene({title}{counted(objects, 'object')}, {counted(surfels, 'surfel')}, {counted(lights, 'light')})"

    def _repr_html_(self) -> str:
        objects, surfels, lights = self._counts()
        bounds = np.array([s.bounds for s in self._objects])
        area = None if any(s.areas is None for s in self._objects) else sum(float(s.areas.sum()) for s in self._objects)
        kinds = Counter(type(light).__name__ for light in self._lights)
        shining = sum(int(np.count_nonzero(s.emission.any(axis=1))) for s in self._objects)
        rows = [
            ("objects", str(objects)),
            ("surfels", f"{surfels}, {shining} of them emissive" if shining else str(surfels)),
            ("bounds", box_text([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)])),
            ("area", "open" if area is None else f"{area:.6g}"),
            ("lights", ", ".join(f"{n} {kind}" for kind, n in kinds.items()) if lights else "0"),
        ]
        return html_table(f"Scene {self.name}".rstrip(), rows)

    def _counts(self):
        return len(self._objects), sum(len(s) for s in self._objects), len(self._lights)

    def _compiled(self, *, progress=False):
        """(_core.Scene, what of it coincides): what all passes share; the objects stay as they are.

        Compiled once, and anew where areas have been set since.
        """
        made_of = [s._core for s in self._objects]
        if self._core is None or any(now is not then for now, then in zip(made_of, self._made_of, strict=True)):
            lights = [light._to_core() for light in self._lights]
            with progress_callback(progress, "areas") as callback:
                self._core, self._made_of = _core.compile_scene(made_of, lights, callback), made_of
        return self._core

    def _to_core(self, *, progress=False):
        """The compiled scene, with effective areas for every object."""
        return self._compiled(progress=progress)[0]

    def _coincidence(self):
        """Where surfels coincide and face the same way: their areas count once, and none covers another."""
        if self._compiled()[1] is None:  # of a scene from a file, which does not hold it
            self._core = None
        return self._compiled()[1]

    def _take_compiled(self, core):
        """Takes over what is compiled of these very objects and lights, as a file has it."""
        self._core, self._made_of = (core, None), [s._core for s in self._objects]

    def _count_divided(self):
        """Of each object, how many patches go on beneath walls of others (see divide_patches)."""
        if self._divided is None:
            found = cut_at_walls([s._core for s in self._objects])
            self._divided = [0 if cut is None else int(np.sum(np.bincount(cut[1]) > 1)) for cut in found]
        return self._divided


def _entries(name, values, types, what):
    if not isinstance(values, (list, tuple)):
        raise ValueError(f"{name}: wanted a list of {what}, got {type(values).__name__}")
    for index, value in enumerate(values):
        if not isinstance(value, types):
            wanted = " or ".join(t.__name__ for t in types)
            raise ValueError(f"{name}: wanted {wanted}, got {type(value).__name__} at index {index}")
    return tuple(values)
