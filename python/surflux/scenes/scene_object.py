"""One [[object]] of a scene file as Surfels."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surflux._base import check
from surflux._base.passes import LOG
from surflux.geometry.cores import replaced
from surflux.geometry.estimates import estimated_radii
from surflux.geometry.orientation import inward_patches
from surflux.geometry.sheets import sheet_faces
from surflux.meshes.mesh_surfels import sampled_surfels, surfels_of_patches
from surflux.meshes.reading import GLTF, read_mesh
from surflux.meshes.transparency import tell_backs
from surflux.meshes.winding import warn_of_winding, wound_alike
from surflux.points.arranging import only_so_many, with_other_sides
from surflux.points.reading import read, read_with_faces
from surflux.points.surfels import Surfels
from surflux.scenes import patterns, shapes
from surflux.scenes.transform import make_transform

_MESHES = {"box": shapes.box, "room": shapes.box, "rectangle": shapes.rectangle}
_POINTS = {"sphere": shapes.sphere, "blob": shapes.blob, "knot": shapes.knot}
SHAPES = (*_MESHES, *_POINTS)
_FEWEST_ON_A_SHAPE = 12
_KEYS = ("scale", "rotate", "translate", "up", "seed", "file", "shape", "kind", "orient", "rooms", "two_sided", "thin")
_KEYS += ("reflectance", "emission", "specular", "exponent")
_KIND_OF = {"patch_area": "mesh", "points": "surfels"}  # keys that go with one kind alone, but for points of a sphere
_OF_CLOUDS = {
    "viewpoint": "whose estimated normals turn towards it",
    "clean": "of which isolated and repeated ones are left out, and steps taken off the depth of a camera",
}
OBJECT_KEYS = (*_KEYS, *_KIND_OF, *_OF_CLOUDS)  # but for those of shapes


@dataclass(frozen=True)
class Source:
    """An [[object]], read and checked, of which it can still be chosen how many surfels it comes in.

    count: as the file says; from `fewest` to `most` can be had, without the backs of two_sided, which make
    `sides` 2. make(n) gives the Surfels.
    """

    count: int
    fewest: int
    most: int
    sides: int
    make: Callable


def open_object(table):
    """The Source of an object table; what is fixed, patches and files, is read here."""
    if "file" not in table and "shape" not in table:  # perhaps misspelt
        table.no_more_keys(*_KEYS, *(key for shape in (None, *SHAPES) for key in _keys_of(shape)))
    file = table.file("file")
    transform = table.call(
        make_transform,
        table.get("scale", 1.0),
        table.get("rotate", (0.0, 0.0, 0.0)),
        table.get("translate", (0.0, 0.0, 0.0)),
        table.get("up") if "up" in table else _up_of_file(table, file),
    )
    seed = table.call(check.seed, "seed", table.get("seed", 0))
    if (file is None) == ("shape" not in table):
        raise table.error("file", "wanted either file or shape")
    if file is None and "up" in table:
        raise table.error("up", "is for a file; a shape is turned by its key rotate")
    shape = None if file is not None else table.choice("shape", SHAPES)
    kind = table.choice("kind", ("surfels", "mesh"), "mesh" if shape in _MESHES else "surfels")
    _refuse_other_keys(table, shape, kind)
    orient = table.call(check.flag, "orient", table.get("orient", False))
    rooms = table.call(check.flag, "rooms", table.get("rooms", False))
    if rooms and not orient:
        raise table.error("rooms", "says how orient = true turns surfels, which is not there")
    two_sided = table.call(check.sides if kind == "mesh" else check.flag, "two_sided", table.get("two_sided", False))
    thin = table.get("thin")

    sheets, two_sided = two_sided == "sheets", two_sided is True
    count, fewest, most, create = _created(table, transform, shape, file, kind, seed, sheets)

    thinned = create
    if thin is not None:
        most, thin = count, table.call(check.count, "thin", thin, 2)
        if thin > most:
            raise table.error("thin", only_so_many(most, thin))
    elif file is not None and fewest == most and kind == "surfels":
        thin, most = count, count  # a cloud from a file can be thinned, though nobody asks for it
    if thin is not None:
        asked, all_of_them, count, fewest = "thin" in table, count, thin, 2

        def thinned(n):
            surfels, side = create(all_of_them)
            if n == all_of_them and not asked:
                return surfels, side
            return table.call(surfels.thinned, n, seed), None  # points no longer know their face

    def make(n):
        surfels, side = thinned(n)
        if orient:
            surfels = table.call(_turned_outwards, surfels, rooms)
        surfels = _painted(table, surfels, shape, side)
        return with_other_sides(surfels) if two_sided else surfels

    return Source(count, min(fewest, count), most, 2 if two_sided else 1, make)


def _up_of_file(table, file):
    """What is up in a file whose table does not say it, or in a shape."""
    if file is None or file.suffix.lower() not in GLTF:
        return 0.0, 0.0, 1.0
    LOG.info("%s (%s): y is up in %s, as glTF has it (up = [0, 0, 1] for z)", table.path, table.name, file.name)
    return 0.0, 1.0, 0.0


def _keys_of(shape):
    """The keys that a shape, or a file where it is None, may have beside _KEYS, by one of its kinds."""
    arguments = () if shape is None else inspect.signature({**_MESHES, **_POINTS}[shape]).parameters
    own = tuple(name for name in arguments if name not in ("seed", "inward"))
    own += ("walls",) if shape in ("box", "room") else ()
    return own if shape in ("blob", "knot") else (*own, *_KIND_OF, *_OF_CLOUDS)


def _refuse_other_keys(table, shape, kind):
    """Refuses keys that this object cannot have, before its file is read: a misspelt one may be why that fails."""
    table.no_more_keys(*_KEYS, *_keys_of(shape))
    for key, its_kind in _KIND_OF.items():
        if key in table and kind != its_kind and not (key == "points" and shape in _POINTS):
            raise table.error(key, f'goes with kind = "{its_kind}", not "{kind}"')
    if shape is not None or kind == "mesh" or "points" in table:
        for key, what in _OF_CLOUDS.items():
            if key in table:
                raise table.error(key, f"is for a file of points, {what}")


def _created(table, transform, shape, file, kind, seed, sheets):
    """(count, fewest, most, n -> (Surfels in place, side of each or None)) of an object before it is thinned."""
    if shape in _POINTS and kind == "surfels":
        function = _POINTS[shape]
        arguments = _shape_arguments(table, function, seed)
        points = arguments.pop("points", inspect.signature(function).parameters["points"].default)
        points = table.call(check.count, "points", points, _FEWEST_ON_A_SHAPE, shapes.MOST_SURFELS)
        return (
            points,
            _FEWEST_ON_A_SHAPE,
            shapes.MOST_SURFELS,
            lambda n: (transform.surfels(table.call(function, points=n, **arguments)), None),
        )
    mesh, side = _mesh(table, shape, file, kind)
    if mesh is None:
        clean = table.call(check.flag, "clean", table.get("clean", False))
        surfels = transform.surfels(_read(table, file, table.get("viewpoint"), clean))
        return len(surfels), len(surfels), len(surfels), lambda _: (surfels, None)
    polygons = mesh._replace(vertices=transform.points(mesh.vertices))
    if kind == "surfels":
        points = table.call(check.count, "points", table.get("points"), 2, shapes.MOST_SURFELS)
        return points, 2, shapes.MOST_SURFELS, lambda n: (_sampled(table, polygons, n, seed), None)
    patches = _patches(table, polygons, side, sheets)
    return len(patches[0]), len(patches[0]), len(patches[0]), lambda _: patches


def _shape_arguments(table, function, seed):
    """The keys of a shape are the arguments of its function."""
    arguments = {}
    for name in inspect.signature(function).parameters:
        if name == "seed":
            arguments[name] = seed
        elif name != "inward":
            value = table.get(name)
            if value is not None:
                arguments[name] = value
    return arguments


def _mesh(table, shape, file, kind):
    """(Mesh, side of each face or None); (None, None) for a file of points."""
    if shape in ("box", "room"):
        arguments = _shape_arguments(table, shapes.box, 0)
        vertices, faces, side = table.call(shapes.box, inward=shape == "room", **arguments)
        return read_mesh((vertices, faces)), side
    if shape == "rectangle":
        rectangle = table.call(shapes.rectangle, **_shape_arguments(table, shapes.rectangle, 0))
        return read_mesh(rectangle), None
    if shape is not None:
        if shape != "sphere":
            raise table.error("kind", f'a {shape} comes as "surfels" alone')
        points = table.call(check.count, "points", table.get("points", 642), 12, shapes.MOST_SURFELS)
        level = shapes.icosphere_level(points)
        if level is None:
            raise table.error("points", f"wanted 10 * 4^k + 2 corners (12, 42, 162, 642, ...) for a mesh, got {points}")
        radius = table.call(check.length, "radius", table.get("radius", 1.0))
        corners, faces = shapes.icosphere(level)
        return read_mesh((radius * corners, faces)), None
    if kind == "surfels" and "points" not in table:
        return None, None
    mesh = table.call(read_mesh, file)
    tell_backs(file, mesh, table.get("two_sided", False))
    if table.get("orient", False) is True:
        return wound_alike(mesh)[0], None
    if table.get("two_sided", False) is not True:
        warn_of_winding(mesh, file, table.get("two_sided", False) == "sheets" and sheet_faces(mesh))
    return mesh, None


def _read(table, file, viewpoint, clean):
    if "kind" in table:  # that faces are left out is meant
        return table.call(read_with_faces, file, viewpoint=viewpoint, clean=clean)[0]
    return table.call(read, file, viewpoint=viewpoint, clean=clean)


def _sampled(table, polygons, n, seed):
    """Points on polygons."""
    return Surfels._from_core(table.call(sampled_surfels, polygons, n, seed, None, None, {}))


def _patches(table, polygons, side, sheets):
    """Patches of polygons, those of sheets with backs if asked, and the side of each where the faces have one."""
    patch_area = table.get("patch_area")
    if patch_area is not None:
        patch_area = table.call(check.number, "patch_area", patch_area, 0.0, low_open=True)
    core, faces = table.call(surfels_of_patches, polygons, patch_area, {}, sheets)
    return Surfels._from_core(core, faces), None if side is None else side[faces.of]


def _turned_outwards(surfels, rooms):
    """The surfels with patches that point inwards turned round; disks reach anew over what was a border."""
    inward = inward_patches(surfels, rooms=rooms) > 0
    if not inward.any():
        return surfels
    s = surfels.flipped(inward)
    if len(s.triangles):
        return s
    # Outliers stay as small as they were made.
    radii = np.minimum(estimated_radii(s.points, s.normals), s.radii.max())
    return Surfels._from_core(replaced(s._core, radii=radii))


def _painted(table, s, shape, side):
    reflectance = table.get("reflectance")
    if isinstance(reflectance, dict):
        rho = _pattern(table.table("reflectance"), s.points)
    elif reflectance is None:
        rho = s.reflectance
    else:
        rho = np.tile(table.call(check.rgb, "reflectance", reflectance, high=1.0, high_open=True), (len(s), 1))
    if shape in ("box", "room"):
        rho = rho.copy()
        walls = table.table("walls")
        for number, name in enumerate(shapes.SIDES if walls else ()):
            color = walls.get(name)
            if color is not None:
                if side is None:
                    raise walls.error(name, 'wanted kind = "mesh", not thinned, for sides of different colours')
                rho[side == number] = walls.call(check.rgb, name, color, high=1.0, high_open=True)
        if walls:
            walls.no_more_keys()
    emission = table.get("emission")
    glow = s.emission if emission is None else np.tile(table.call(check.rgb, "emission", emission), (len(s), 1))
    gloss = {name: value for name in ("specular", "exponent") if (value := table.get(name)) is not None}
    return table.call(s.replace, reflectance=rho, emission=glow, **gloss)


def _pattern(table, points):
    table.no_more_keys("pattern", "colors", "size", "seed")
    kind = table.choice("pattern", patterns.PATTERNS)
    colors = table.get("colors")
    if colors is None:
        raise table.error("colors", "is missing")
    size, seed = table.get("size", 0.1), table.get("seed", 0)
    return table.call(patterns.pattern_colors, kind, points, colors, size, seed)
