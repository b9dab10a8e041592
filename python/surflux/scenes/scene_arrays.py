"""A scene as arrays and plain values, for files that hold one whole."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux.geometry.mesh_surfels import Faces
from surflux.pictures.camera import Camera
from surflux.points.surfels import Surfels
from surflux.scenes.lights import AreaLight, DirectionalLight, Environment, PointLight, SpotLight
from surflux.scenes.scene import Scene

_LIGHTS = {light.__name__: light for light in (PointLight, SpotLight, AreaLight, DirectionalLight)}
_ARGUMENTS = {
    PointLight: ("position", "intensity"),
    SpotLight: ("position", "direction", "intensity", "cone", "penumbra"),
    AreaLight: ("corner", "edge_u", "edge_v", "exitance"),
    DirectionalLight: ("direction", "irradiance"),
}


def scene_arrays(scene):
    """(about, arrays) of a Scene: what JSON takes, and a dict of arrays.

    As it is compiled, with areas, ends of disks and what coincides, so that nothing of that has to be found again.
    """
    arrays = dict(_core.scene_arrays(scene._to_core()))
    areas = [np.full(len(s), np.nan) if s.areas is None else s.areas for s in scene.objects]
    arrays["given_areas"] = np.concatenate(areas)
    for k, surfels in enumerate(scene.objects):
        if surfels._faces is not None:
            arrays[f"faces_{k}"], arrays[f"merged_{k}"] = (np.asarray(of, np.int64) for of in surfels._faces)
    lights = []
    for k, light in enumerate(scene.lights):
        values = {"type": type(light).__name__}
        if isinstance(light, Environment):
            values |= light._to_file()
            arrays[f"light_{k}"] = np.asarray(light.image_or_rgb, np.float64)
        else:
            values |= {name: getattr(light, name) for name in _ARGUMENTS[type(light)]}
        lights.append(values)
    about = {
        "name": scene.name,
        "camera": None if scene.camera is None else scene.camera.to_dict(),
        "solve_options": {name: np.asarray(value).tolist() for name, value in scene.solve_options.items()},
        "lights": lights,
    }
    return about, arrays


def scene_of_arrays(about, arrays):
    """The Scene of `scene_arrays`, compiled as it was.

    Raises:
        ValueError, TypeError, KeyError, AttributeError: this is not what that gave.
    """
    lights = [_light(dict(values), arrays.get(f"light_{k}")) for k, values in enumerate(about["lights"])]
    core = _core.scene_of_arrays(arrays, [light._to_core() for light in lights])
    surfels, begin, objects = core.surfels, 0, []
    given = arrays["given_areas"]
    if given.shape != (len(surfels),) or given.dtype != np.float64:
        raise ValueError(f"given_areas: wanted those of {check.counted(len(surfels), 'surfel')}")
    for k, size in enumerate(np.bincount(core.object)):
        own = slice(begin, begin := begin + int(size))
        areas = np.zeros(0) if np.isnan(given[own]).all() else check.per_surfel("given_areas", given[own], int(size))
        selected = surfels.select(np.arange(own.start, own.stop, dtype=np.uint32)).with_areas(areas)
        objects.append(Surfels._from_core(selected, _faces(arrays.get(f"faces_{k}"), arrays.get(f"merged_{k}"), size)))
    camera = None if about["camera"] is None else Camera(**about["camera"])
    scene = Scene(objects, lights, camera=camera, name=about["name"], solve_options=about["solve_options"])
    scene._take_compiled(core)
    return scene


def _faces(of, merged, size):
    if of is None or merged is None:
        return None
    if of.shape != (size,) or merged.ndim != 1:
        raise ValueError("faces: of another number of surfels")
    for indices in (of, merged):
        if indices.dtype.kind not in "iu":
            raise ValueError("faces: wanted whole numbers")
        if len(indices):
            check.in_range("faces", indices, 0, len(merged) - 1)
    return Faces(np.array(of), np.array(merged))


def _light(values, image):
    kind = values.pop("type")
    return Environment._of_file(image, **values) if kind == "Environment" else _LIGHTS[kind](**values)
