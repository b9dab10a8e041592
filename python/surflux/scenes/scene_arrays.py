"""A scene as arrays and plain values, for files that hold one whole."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux.meshes.faces import ARRAYS, Faces
from surflux.pictures.camera import Camera
from surflux.points.surfels import Surfels
from surflux.scenes.lights import AreaLight, DirectionalLight, Environment, PhotometricLight, PointLight, SpotLight
from surflux.scenes.photometry import Photometry
from surflux.scenes.scene import Scene

_LIGHTS = {light.__name__: light for light in (PointLight, SpotLight, PhotometricLight, AreaLight, DirectionalLight)}
_ARGUMENTS = {
    PointLight: ("position", "intensity"),
    SpotLight: ("position", "direction", "intensity", "cone", "penumbra"),
    PhotometricLight: ("position", "direction", "azimuth", "intensity"),
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
            arrays |= {f"faces_{k}_{name}": np.atleast_1d(of) for name, of in zip(ARRAYS, surfels._faces, strict=False)}
    lights = []
    for k, light in enumerate(scene.lights):
        values = {"type": type(light).__name__}
        if isinstance(light, Environment):
            values |= light._to_file()
            arrays[f"light_{k}"] = np.asarray(light.image_or_rgb, np.float64)
        else:
            values |= {name: getattr(light, name) for name in _ARGUMENTS[type(light)]}
            if isinstance(light, PhotometricLight):
                values["photometry"] = light.photometry._to_file()
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
        objects.append(Surfels._from_core(selected, _faces(arrays, k, size)))
    camera = None if about["camera"] is None else Camera(**about["camera"])
    scene = Scene(objects, lights, camera=camera, name=about["name"], solve_options=about["solve_options"])
    scene._take_compiled(core)
    return scene


def _faces(arrays, k, size):
    if f"faces_{k}_of" in arrays:
        of, count, pair, pairs, halves = (np.array(arrays[f"faces_{k}_{name}"]) for name in ARRAYS)
        _require_indices(count, (1,), 0)
        count = int(count[0])
    elif f"merged_{k}" in arrays:  # of files without pairs: (f,) the face that each was merged into
        of, merged = np.array(arrays[f"faces_{k}"]), np.array(arrays[f"merged_{k}"])
        count = len(merged)
        _require_indices(merged, (count,), 0, count)
        _require_indices(of, (size,), 0, count)
        second = np.flatnonzero(merged != np.arange(count))
        pairs, halves = np.stack([merged[second], second], axis=1), np.full((len(second), 3, 3), np.nan)
        pair = np.full(count, -1)
        pair[merged[second]] = np.arange(len(second))
        pair = pair[of]
    else:
        return None
    _require_indices(of, (size,), 0, count)
    _require_indices(pair, (size,), -1, len(pairs))
    _require_indices(pairs, (len(pairs), 2), 0, count)
    if halves.shape != (len(pairs), 3, 3) or halves.dtype.kind != "f":
        raise ValueError("faces: of another number of pairs")
    return Faces(of, count, pair, pairs, halves)


def _require_indices(indices, shape, low, end=np.inf):
    if indices.shape != shape:
        raise ValueError("faces: of another number of surfels")
    if indices.dtype.kind not in "iu":
        raise ValueError("faces: wanted whole numbers")
    if indices.size:
        check.in_range("faces", indices, low, end, high_open=True)


def _light(values, image):
    kind = values.pop("type")
    if "photometry" in values:
        values["photometry"] = Photometry(**values["photometry"])
    return Environment._of_file(image, **values) if kind == "Environment" else _LIGHTS[kind](**values)
