"""A mesh as the commands take it: cut into patches, and what was found taken home to its faces."""

import warnings
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.passes import LOG
from surflux.geometry.meshes import file_named, read_mesh
from surflux.geometry.winding import faces_against
from surflux.points.layers import layer_of
from surflux.points.surfels import Surfels
from surflux.scans.formats import MESHES
from surflux.solutions.lit_points import LIGHT

# Light varies over a face: those of coarse meshes are cut until there are about as many patches.
PATCHES = 20_000
_GREY = 0.5  # what faces reflect that have no colour
FACES_DOWN = 0.9  # of a terrain's area: it is wound the other way
SUFFIXES = (".ply", ".vtp")


def is_mesh(options):
    """Whether a command takes the faces of a file: of a mesh, and with --mesh of a PLY file."""
    if options.mesh:
        return True
    suffix = Path(options.input).suffix.lower().lstrip(".")
    return suffix in MESHES or (suffix == "obj" and len(_core.read_obj(options.input)[1]) > 1)


def check_output(path):
    """Refuses, before any work, names of files that do not take what was found of a mesh."""
    if Path(path).suffix.lower() not in SUFFIXES:
        raise ValueError(f"-o: wanted a name ending in .ply or .vtp of a mesh, got {str(path)!r}")


def patches_of_mesh(options, reflectance=None):
    """Surfels of the faces of a file, which large ones are cut for.

    reflectance: see Surfels.from_mesh.
    """
    with file_named(options.input):
        mesh, how = read_mesh(options.input), {"threads": options.threads, "progress": True}
        surfels = Surfels.from_mesh(mesh, None, reflectance, **how)
        if len(surfels) < PATCHES:
            area, faces = surfels.areas.sum() / PATCHES, len(surfels)
            surfels = Surfels.from_mesh(mesh, area, reflectance, **how)
            cut = counted(len(surfels), "patch", "patches")
            LOG.info("%s cut into %s", "face is" if faces == 1 else "faces are", cut)
    if reflectance is None and np.all(surfels.reflectance == _GREY):
        LOG.info("faces have no colour: each reflects %g of the light", _GREY)
    return _turned_over(options, mesh, surfels)


def _turned_over(options, mesh, surfels):
    """The surfels of a mesh on the side of it that is out; what is turned over is said."""
    normals, up = getattr(options, "normals", "keep"), getattr(options, "up", None)  # `check` has neither
    if normals == "flip":
        return surfels.flipped()
    against = np.zeros(0) if normals == "keep" else faces_against(mesh)
    if against.any():
        surfels = surfels.flipped(against[surfels.faces])
        verb = "is" if np.count_nonzero(against) == 1 else "are"
        LOG.info(
            "%d of %s %s wound against those beside, and %s turned over (--normals keep)",
            np.count_nonzero(against),
            counted(len(against), "face"),
            verb,
            verb,
        )
    is_level = up is None or (tuple(up[:2]) == (0.0, 0.0) and up[2] > 0.0)
    if is_level and layer_of(surfels.points) == "terrain":
        share = surfels.areas[surfels.normals[:, 2] < 0.0].sum() / max(surfels.areas.sum(), np.finfo(float).tiny)
        if share > FACES_DOWN:
            hint = "which `surflux solve` turns over" if normals == "keep" else "and are turned over (--normals keep)"
            LOG.info("faces of a terrain: %.0f %% face down, %s", 100.0 * share, hint)
            return surfels if normals == "keep" else surfels.flipped()
    return surfels


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
    faces.save(path)
