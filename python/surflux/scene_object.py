"""One [[object]] of a scene file as Surfels."""

import inspect

import numpy as np

from surflux import _check, _core, patterns, shapes
from surflux.surfels import Surfels, only_so_many, sampled_surfels, surfels_of_patches
from surflux.transform import make_transform

_MESHES = {"box": shapes.box, "room": shapes.box, "rectangle": shapes.rectangle}
_POINTS = {"sphere": shapes.sphere, "blob": shapes.blob, "knot": shapes.knot}
SHAPES = (*_MESHES, *_POINTS)


def make_object(table):
    """Surfels of an object table: made or read, placed, thinned, painted."""
    transform = table.call(
        make_transform,
        table.get("scale", 1.0),
        table.get("rotate", (0.0, 0.0, 0.0)),
        table.get("translate", (0.0, 0.0, 0.0)),
    )
    seed = table.call(_check.seed, "seed", table.get("seed", 0))
    file = table.file("file")
    if (file is None) == ("shape" not in table):
        raise table.error("file", "wanted either file or shape")
    shape = None if file is not None else table.choice("shape", SHAPES)
    kind = table.choice("kind", ("surfels", "mesh"), "mesh" if shape in _MESHES else "surfels")

    side = None
    if shape in _POINTS and kind == "surfels":
        surfels = transform.surfels(table.call(_POINTS[shape], **_shape_arguments(table, _POINTS[shape], seed)))
    else:
        mesh, side = _mesh(table, shape, file, kind)
        if mesh is None:
            surfels = transform.surfels(_read(table, file))
        else:
            surfels, side = _from_mesh(table, (transform.points(mesh[0]), *mesh[1:]), side, kind, seed)
    thin = table.get("thin")
    if thin is not None:
        n = table.call(_check.count, "thin", thin, 2)
        if n > len(surfels):
            raise table.error("thin", only_so_many(len(surfels), n))
        surfels = table.call(surfels.thinned, n, seed)
        side = None  # points no longer know their face
    surfels = _painted(table, surfels, shape, side)
    two_sided = table.call(_check.flag, "two_sided", table.get("two_sided", False))
    table.no_more_keys()
    return Surfels._from_core(surfels._core.two_sided()) if two_sided else surfels


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
    """((vertices, offsets, indices), side of each face or None); (None, None) for a file of points."""
    from surflux.files import read_mesh

    if shape in ("box", "room"):
        arguments = _shape_arguments(table, shapes.box, 0)
        vertices, faces, side = table.call(shapes.box, inward=shape == "room", **arguments)
        return read_mesh((vertices, faces))[:3], side
    if shape == "rectangle":
        rectangle = table.call(shapes.rectangle, **_shape_arguments(table, shapes.rectangle, 0))
        return read_mesh(rectangle)[:3], None
    if shape is not None:
        if shape != "sphere":
            raise table.error("kind", f'a {shape} comes as "surfels" alone')
        points = table.call(_check.count, "points", table.get("points", 642), 12, shapes.MOST_SURFELS)
        level = shapes.icosphere_level(points)
        if level is None:
            raise table.error("points", f"wanted 10 * 4^k + 2 corners (12, 42, 162, 642, ...) for a mesh, got {points}")
        radius = table.call(_check.length, "radius", table.get("radius", 1.0))
        corners, faces = shapes.icosphere(level)
        return read_mesh((radius * corners, faces))[:3], None
    if kind == "surfels" and "points" not in table:
        return None, None
    return table.call(read_mesh, file)[:3], None


def _read(table, file):
    from surflux.files import read

    return table.call(read, file)


def _from_mesh(table, polygons, side, kind, seed):
    """Surfels of polygons, and the side that each lies on where the faces have one."""
    if kind == "surfels":
        n = table.call(_check.count, "points", table.get("points"), 2, shapes.MOST_SURFELS)
        half, dark = np.full((n, 3), 0.5), np.zeros((n, 3))
        return table.call(sampled_surfels, polygons, n, seed, half, dark), None
    patch_area = table.get("patch_area")
    if patch_area is not None:
        patch_area = table.call(_check.number, "patch_area", patch_area, 0.0, low_open=True)
    faces = len(polygons[1]) - 1
    half, dark = np.full((faces, 3), 0.5), np.zeros((faces, 3))
    surfels, face = table.call(surfels_of_patches, polygons, patch_area, half, dark)
    return surfels, None if side is None else side[face]


def _painted(table, s, shape, side):
    reflectance = table.get("reflectance")
    if isinstance(reflectance, dict):
        rho = _pattern(table.table("reflectance"), s.points)
    elif reflectance is None:
        rho = s.reflectance
    else:
        rho = np.tile(table.call(_check.rgb, "reflectance", reflectance, high=1.0, high_open=True), (len(s), 1))
    if shape in ("box", "room"):
        rho = rho.copy()
        walls = table.table("walls")
        for number, name in enumerate(shapes.SIDES if walls else ()):
            color = walls.get(name)
            if color is not None:
                if side is None:
                    raise walls.error(name, 'wanted kind = "mesh", not thinned, for sides of different colours')
                rho[side == number] = walls.call(_check.rgb, name, color, high=1.0, high_open=True)
        if walls:
            walls.no_more_keys()
    emission = table.get("emission")
    glow = s.emission if emission is None else np.tile(table.call(_check.rgb, "emission", emission), (len(s), 1))
    return Surfels._from_core(
        _core.Surfels(s.points, s.normals, s.radii, s.areas, rho, glow, s.triangles, s.triangle_surfel)
    )


def _pattern(table, points):
    kind = table.choice("pattern", patterns.PATTERNS)
    colors = table.get("colors")
    if colors is None:
        raise table.error("colors", "is missing")
    size, seed = table.get("size", 0.1), table.get("seed", 0)
    table.no_more_keys()
    return table.call(patterns.pattern_colors, kind, points, colors, size, seed)
