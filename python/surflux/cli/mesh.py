"""A mesh as the commands take it: cut into patches, and what was found taken home to its faces."""

import os
import shlex
import warnings
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.files import require_file
from surflux._base.passes import LOG
from surflux.geometry.estimates import percent
from surflux.meshes.reading import GLTF, file_named, read_mesh
from surflux.meshes.transparency import tell_backs
from surflux.meshes.winding import wound_alike
from surflux.points.layers import is_terrain_of
from surflux.points.surfels import Surfels
from surflux.scans.formats import MESHES
from surflux.scans.vtp import write_polydata
from surflux.solutions.lit_points import LIGHT

# Light varies over a face: those of coarse meshes are cut until there are about as many patches.
PATCHES = 20_000
_GREY = 0.5  # what faces reflect that have no colour
_DARK = 0.01  # of the area
FACES_DOWN = 0.9  # of a terrain's area: it is wound the other way
# Vertices of a PLY file that may be points; in distances of theirs, were they even, how wide a face is that they do not
# cover; and the share of the area of such faces from which on these are taken: of a sofa .24, of Sponza .9.
_MANY, _FAR, _WIDE = 1000, 4.0, 0.12
_NUMBERS_OF_POINTS = "points", "thin", "viewpoint"
_FLAGS_OF_POINTS = "keep_outliers", "keep_steps", "raw_colors", "albedo", "strict"
SUFFIXES = (".ply", ".glb", ".gltf", ".vtp")


def is_mesh(options):
    """Whether a command takes the faces of a file: of a mesh, and of a PLY file with --mesh, or where its points do not
    cover the faces, and nothing asks for points; that is said. What was found stands in options.mesh.
    """
    suffix = Path(options.input).suffix.lower().lstrip(".")
    if options.mesh is None and suffix == "ply" and not _asks_for_points(options):
        share = wide_faces(options.input)
        options.mesh = bool(share > _WIDE)
        if options.mesh:
            words = "faces are taken, not points alone, which lie too far apart on %s of the surface (--no-mesh)"
            LOG.info(words, percent(share))
    return bool(options.mesh) or suffix in MESHES or (suffix == "obj" and _has_faces(options.input))


def _asks_for_points(options):
    """Whether an option is for points alone, or what is written is."""
    output = getattr(options, "output", None)
    if output is not None and Path(output).suffix.lower() not in SUFFIXES:
        return True
    is_given = any(getattr(options, name, None) is not None for name in _NUMBERS_OF_POINTS)
    return is_given or any(getattr(options, name, None) is True for name in _FLAGS_OF_POINTS)


def wide_faces(path):
    """The share of the area of a PLY file's faces that are far wider than its points are apart; 0 where it has few.

    The vertices of such faces sample no surface: of scans that have faces it is .06 at most, once they are reduced.
    """
    try:
        elements = _core.read_ply(path, [])["elements"]
        if elements.get("patch", 0) or not elements.get("face", 0) or elements.get("vertex", 0) < _MANY:
            return 0.0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = read_mesh(path)
    except _core.FileError:  # said by whoever takes the file
        return 0.0
    first = mesh.offsets[:-1]
    following = np.roll(mesh.indices, -1)
    following[mesh.offsets[1:] - 1] = mesh.indices[first]
    vertices = mesh.vertices - mesh.vertices.mean(axis=0)
    begins, ends = vertices[mesh.indices], vertices[following]
    widths = np.maximum.reduceat(np.linalg.norm(ends - begins, axis=1), first)
    areas = 0.5 * np.linalg.norm(np.add.reduceat(np.cross(begins, ends), first, axis=0), axis=1)
    area = areas.sum()
    return areas[widths > _FAR * np.sqrt(area / len(vertices))].sum() / area if area > 0.0 else 0.0


def _has_faces(path):
    """Whether a line of an OBJ file is a face's; the file is not taken apart."""
    require_file(path)
    with open(path, "rb") as file:
        return any(line.startswith((b"f", b" ", b"\t")) and line.split(None, 1)[:1] == [b"f"] for line in file)


def take_up(options):
    """Of glTF, y is up by its specification, where nobody says otherwise."""
    if options.up is None and Path(options.input).suffix.lower() in GLTF:
        options.up = (0.0, 1.0, 0.0)
        LOG.info("y is up, as glTF has it (--up 0,0,1 for z)")


def patches_of_mesh(options, reflectance=None, mesh=None):
    """Surfels of the faces of a file, which large ones are cut for, on the side of it that is out.

    reflectance: see Surfels.from_mesh. mesh: what the file holds, where it is read already.
    """
    normals = getattr(options, "normals", "keep")  # `check` has none
    with file_named(options.input):
        mesh = read_mesh(options.input) if mesh is None else mesh
        tell_backs(options.input, mesh, two_sided=False)
        how = {"threads": options.threads, "progress": True}
        mesh, against = (mesh, 0) if normals in ("keep", "flip") else wound_alike(mesh)
        surfels = Surfels.from_mesh(mesh, None, reflectance, **how)
        if len(surfels) < PATCHES:
            faces = len(surfels)
            surfels = Surfels.from_mesh(mesh, surfels.areas.sum() / PATCHES, reflectance, **how)
            cut = counted(len(surfels), "patch", "patches")
            LOG.info("%s cut into %s", "face is" if faces == 1 else "faces are", cut)
    if reflectance is None and np.all(surfels.reflectance == _GREY):
        LOG.info("faces have no colour: each reflects %g of the light", _GREY)
    if against:
        verb, faces = "is" if against == 1 else "are", counted(len(mesh.offsets) - 1, "face")
        words = "%d of %s %s wound against those beside, and %s turned over (--normals keep)"
        LOG.info(words, against, faces, verb, verb)
    return surfels.flipped() if normals == "flip" else _upwards(options, surfels, normals == "keep")


def cut_to_tell(options, surfels):
    """Patches of the faces of a file, which `surfels` are, as patches_of_mesh has them: so many tell what is up."""
    if options.up is not None:
        return surfels
    with file_named(options.input), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # all was said when it was read to be shown
        mesh, _ = wound_alike(read_mesh(options.input))
        return Surfels.from_mesh(mesh, surfels.areas.sum() / PATCHES if len(surfels) < PATCHES else None)


def _upwards(options, surfels, stays):
    """The surfels of a mesh, turned over where they are a terrain's that faces down, unless it stays; which is said."""
    if not is_terrain_of(surfels.points, getattr(options, "up", None)):  # `check` has no --up
        return surfels
    share = surfels.areas[surfels.normals[:, 2] < 0.0].sum() / max(surfels.areas.sum(), np.finfo(float).tiny)
    if share <= FACES_DOWN:
        return surfels
    hint = "which `surflux solve` turns over" if stays else "and are turned over (--normals keep)"
    LOG.info("faces of a terrain: %.0f %% face down, %s", 100.0 * share, hint)
    return surfels if stays else surfels.flipped()


def tell_dark(options, patches, light):
    """Says how much of a mesh, `patches`, has no light at all, and does not shine, if it is not next to nothing.

    light: (n, 3) at these patches, and at others that follow them.
    """
    areas = patches.areas
    is_dark = ~(light[: len(patches)].any(axis=1) | patches.emission.any(axis=1))
    share = np.sum(areas * is_dark) / max(areas.sum(), np.finfo(float).tiny)
    if share > _DARK:
        file = shlex.quote(os.fsdecode(options.input)) + (" --mesh" if options.mesh else "")
        text = "%s of the surface has no light: hidden from it, as undersides are, or facing inwards "
        text += "(`surflux check %s` tells)"
        LOG.info(text, percent(share), file)


def save_faces(path, source, solution):
    """Writes the faces of a mesh file as .vtp, in their order, with their light (NaN without area)."""
    import pyvista

    with warnings.catch_warnings():  # all was said when it was read to be solved
        warnings.simplefilter("ignore")
        mesh = read_mesh(source)
    corners = np.insert(mesh.indices, mesh.offsets[:-1], np.diff(mesh.offsets))
    faces = pyvista.PolyData(mesh.vertices, faces=corners)
    for name in LIGHT:
        faces.cell_data[name] = solution.per_face(name).astype(np.float32)
    write_polydata(path, faces)
