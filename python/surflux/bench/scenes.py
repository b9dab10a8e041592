"""The scenes of `surflux bench --quick` and `--full`, coarser or finer, and the same surfaces as polygons.

Each scene comes with a `density`: 1 is the scene file as it stands, 0.5 has half as many surfels each way.
"""

import os
import sys
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

import surflux as sf
from surflux import _core
from surflux.scenes import shapes
from surflux.scenes.lights import AreaLight
from surflux.scenes.scene_file import Table, make_scene, read_toml


@dataclass(eq=False)
class BenchScene:
    """One scene at one density.

    exact: (n, 3), the irradiance of all surfels in closed form, or None.
    polygons: () -> Scene, the same surfaces as polygons throughout, with lamps that stand in the way of light: what a
        renderer of meshes takes; None where they cannot be had.
    """

    scene: sf.Scene
    exact: np.ndarray | None
    polygons: object


def data_folder():
    """The folder with the scene files: the package's own, or that of the checkout that it runs from; or None."""
    try:
        return sf.examples.folder()
    except sf.FileError:
        return None


def has_scans():
    """Whether SURFLUX_DATA names a folder of scans."""
    return bool(os.environ.get("SURFLUX_DATA"))


def scans_for(what):
    """Whether there are scans; where there are none, that what needs them is left out is said."""
    if not has_scans():
        print(f"bench: {what} left out: {NO_SCANS}", file=sys.stderr)
    return has_scans()


def why_no_file(stem):
    """Why a scene file of data/ cannot be had here, or None."""
    if data_folder() is None:
        return f"{stem}.toml is missing in this installation"
    return None if has_scans() or stem not in OF_SCANS else NO_SCANS


def why_not(name):
    """Why a scene cannot be built here, or None."""
    return why_no_file(FILES[name]) if name in FILES else None


def build(name, density=1.0):
    """The BenchScene of that name."""
    return concentric(density) if name == "concentric spheres" else from_file(FILES[name], density)


def from_file(stem, density):
    """A scene of data/, with `patches`, `points` and `thin` of its objects changed to suit the density.

    Whole scans are thinned where it is below 1.
    """
    path = data_folder() / f"{stem}.toml"
    data = read_toml(path)
    if density < 1.0:
        for entry, table in zip(data["object"], Table(path, "", data).tables("object"), strict=True):
            if "file" in entry and entry.get("kind") != "mesh" and not {"thin", "points"} & {*entry}:
                entry["thin"] = _core.read_ply(str(table.file("file")), [])["elements"]["vertex"]
    for entry in data["object"]:
        if "patches" in entry:
            patches = np.array(entry["patches"])
            entry["patches"] = np.maximum(1, np.rint(density * patches)).astype(int).tolist()
        if "points" in entry:
            level = shapes.icosphere_level(entry["points"])
            finer = round(np.log2(density))
            entry["points"] = round(entry["points"] * density**2) if level is None else _icosphere(level + finer)
        if "thin" in entry:
            entry["thin"] = round(entry["thin"] * density**2)

    def polygons():
        whole = deepcopy(data)
        for entry in whole["object"]:
            if entry.get("shape") == "sphere" or "file" in entry:
                entry["kind"] = "mesh"
                entry.pop("thin", None)
        return with_solid_lamps(make_scene(path, whole))

    scene = make_scene(path, data)
    lamps_alone = all(isinstance(light, AreaLight) for light in scene.lights)
    has_meshes = all(entry.get("shape") not in POINTS_ALONE for entry in data["object"])
    return BenchScene(scene, None, polygons if lamps_alone and has_meshes else None)


def concentric(density):
    """A black sphere of exitance 1 and radius 1/2 inside one of radius 1 and reflectance 1/2: H is .2 and .4.

    B2 = F21 M + rho2 F22 B2 with F21 = 1/4 and F22 = 3/4 is .2 on the outer one; the inner one sees nothing else.
    """
    finer = round(np.log2(density))
    (inner, inner_faces), (outer, outer_faces) = shapes.icosphere(3 + finer), shapes.icosphere(4 + finer)
    scene = sf.Scene(
        [sf.Surfels(0.5 * inner, inner, reflectance=0.0, emission=1.0), sf.Surfels(outer, -outer, reflectance=0.5)],
        name="concentric spheres",
    )

    def polygons():
        hot = sf.Surfels.from_mesh((0.5 * inner, inner_faces), reflectance=0.0, emission=1.0)
        return sf.Scene([hot, sf.Surfels.from_mesh((outer, outer_faces[:, ::-1]), reflectance=0.5)])

    exact = np.repeat([0.2, 0.4], [len(inner), len(outer)])[:, None] * np.ones(3)
    return BenchScene(scene, exact, polygons)


def _icosphere(level):
    return 10 * 4 ** max(0, level) + 2


def with_solid_lamps(scene):
    """The scene with its area lights as black rectangles that emit, and are in the way."""
    objects = list(scene.objects)
    for light in scene.lights:
        if not isinstance(light, AreaLight):
            raise ValueError(f"scene: wanted area lights alone, got a {type(light).__name__}")
        corner, u, v = (np.array(x) for x in (light.corner, light.edge_u, light.edge_v))
        corners = [corner, corner + u, corner + u + v, corner + v]
        objects.append(sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), None, 0.0, light.exitance))
    return sf.Scene(objects, name=scene.name)


def without_light_between(scene):
    """The scene with black surfels that emit nothing: what is left is the light of its lights."""
    return sf.Scene([s.replace(reflectance=0.0, emission=0.0) for s in scene.objects], scene.lights)


def targets_on(polygons, scene, seed=0):
    """As many places on the polygons as the scene has surfels, as Surfels with areas, to measure irradiance at.

    Where an object of the scene is patches itself, these; else points spread evenly at random on its polygons, each
    with the normal and the reflectance of its face. The lamps, which the scene has not, get none.
    """
    targets = []
    for k, (theirs, ours) in enumerate(zip(polygons.objects, scene.objects, strict=False)):
        if len(ours.triangles):
            targets.append(theirs)
            continue
        points, triangle = _core.sample_triangles(theirs.triangles, len(ours), seed + k)
        face = theirs.triangle_surfel[triangle]
        targets.append(
            sf.Surfels(
                points,
                theirs.normals[face],
                radii=theirs.radii[face],
                areas=theirs.areas.sum() / len(ours),
                reflectance=theirs.reflectance[face],
                emission=theirs.emission[face],
            )
        )
    return sf.Scene(targets).surfels


# Name -> file in data/.
FILES = {
    "three spheres": "three_spheres",
    "statues": "statues",
    "Cornell box": "cornell",
    "two bunnies": "two_bunnies",
    "door ajar": "door",
}
# Of --quick and --full. Concentric spheres are made here.
NAMES = ("concentric spheres", *FILES)
POINTS_ALONE = ("blob", "knot")  # shapes that have no polygons
OF_SCANS = ("two_bunnies", "statue", "gallery", "sponza")  # scene files that name some
NO_SCANS = "SURFLUX_DATA names no folder of scans"
