"""Meshes from files and from other libraries, as vertices and polygons."""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.files import require_file
from surflux.meshes.foreign_meshes import WANTED, Mesh, convert
from surflux.meshes.gltf_meshes import read_gltf
from surflux.meshes.obj_mesh import read_obj_mesh
from surflux.meshes.off import read_off_mesh
from surflux.meshes.ply_mesh import read_ply_mesh
from surflux.meshes.stl import read_stl_mesh
from surflux.meshes.transparency import warn_of_transparency


def name_of(mesh):
    """What messages call a mesh: its path, if it is one."""
    return os.fsdecode(mesh) if _is_path(mesh) else "mesh"


def _is_path(mesh):
    return isinstance(mesh, str | bytes | os.PathLike)


@contextmanager
def file_named(mesh):
    """What is wrong with a mesh that came from a file is a FileError that names it."""
    try:
        yield
    except ValueError as error:
        if not _is_path(mesh) or not str(error).startswith("mesh: "):
            raise
        raise _core.FileError(f"{name_of(mesh)}: {str(error).removeprefix('mesh: ')}") from error


def read_mesh(mesh):
    """Vertices and polygons of a mesh.

    PLY, OBJ, OFF, STL and glTF are read by surflux itself, with their materials and textures: quads and larger polygons
    stay whole, OBJ's relative indices work, positions are exact, and an error names the line. (trimesh cuts polygons
    into triangles; VTK makes three vertices of one where texture coordinates or normals differ, so that neighbours no
    longer share edges.) VTK's formats go through pyvista.

    Args:
        mesh: path; a mesh of trimesh, pyvista, meshio or Open3D; (vertices (v, 3), faces), where faces are an (f, k)
            array of indices or a sequence of sequences of them; or what this function has returned.

    Returns:
        Mesh: at least one face; every face has 3 corners or more, each an existing vertex; all vertices finite.

    Raises:
        FileError: the file cannot be read as a mesh.
        ValueError: what was handed over is no mesh.
    """
    if isinstance(mesh, Mesh):
        return mesh
    if _is_path(mesh):
        return _read_file(os.fsdecode(mesh))
    result = _convert(mesh)
    problem = _problem(result)
    if problem:
        raise ValueError(f"mesh {problem}")
    warn_of_transparency("mesh", "alphaMode", result.clear)
    return result


PYVISTA_SUFFIXES = (".vtp", ".vtk")
GLTF = (".glb", ".gltf")  # which have y up, by their specification
MESHES_ALONE = (*PYVISTA_SUFFIXES, ".stl", ".off", *GLTF)  # never read as points
_READERS = {".ply": read_ply_mesh, ".obj": read_obj_mesh, ".stl": read_stl_mesh, ".off": read_off_mesh}
_READERS |= dict.fromkeys(GLTF, read_gltf)


def _read_file(path):
    suffix = Path(path).suffix.lower()
    require_file(path)
    if suffix in _READERS:
        mesh = _READERS[suffix](path)
        if suffix in GLTF:
            warn_of_transparency(path, "alphaMode", mesh.clear)
    elif suffix in PYVISTA_SUFFIXES:
        mesh = _read_with_pyvista(path)
    else:
        supported = ", ".join((".ply", ".obj", *MESHES_ALONE))
        raise _core.FileError(f"{path}: meshes are not read from {suffix or 'a file without suffix'}; from {supported}")
    problem = _problem(mesh)
    if problem:
        points = ""
        if len(mesh.offsets) <= 1 and suffix in (*PYVISTA_SUFFIXES, *GLTF):
            points = f"; points are not read of {suffix} files: write those that it has as .ply or .npz instead"
        elif suffix == ".ply" and len(mesh.offsets) <= 1 and len(mesh.vertices):
            many = check.counted(len(mesh.vertices), "point")
            points = f'; surflux.read takes its {many} (kind = "surfels" in a scene file)'
        raise _core.FileError(f"{path}: {problem}{points}")
    return mesh


def _read_with_pyvista(path):
    import pyvista

    try:
        return _convert(pyvista.read(path))
    except Exception as error:
        raise _core.FileError(f"{path}: pyvista cannot read it ({type(error).__name__}: {error})") from error


def _convert(mesh):
    found = convert(mesh)
    if found is None and isinstance(mesh, tuple | list) and len(mesh) == 2:
        found = _from_arrays(*mesh)
    if found is None:
        raise ValueError(f"mesh: wanted {WANTED}, got {type(mesh).__name__}")
    return found


def _from_arrays(vertices, faces):
    for name, given in (("vertices", vertices), ("faces", faces)):
        if np.ma.is_masked(given):
            raise ValueError(f"mesh {name}: wanted numbers throughout, got a masked array")
    try:
        vertices = np.array(vertices, dtype=np.float64)
        faces = faces if isinstance(faces, np.ndarray) and faces.ndim == 2 else [np.asarray(face) for face in faces]
    except (TypeError, ValueError) as error:
        raise ValueError(f"mesh: wanted vertices (v, 3) and faces of indices, got {error}") from error
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"mesh vertices: wanted shape (v, 3), got {vertices.shape}")
    if isinstance(faces, np.ndarray):
        if not np.issubdtype(faces.dtype, np.integer):
            raise ValueError(f"mesh faces: wanted whole numbers, got {faces.dtype}")
        return Mesh(vertices, faces.shape[1] * np.arange(len(faces) + 1), faces.ravel().astype(np.int64), None)
    for i, face in enumerate(faces):
        if face.ndim != 1 or (face.size and not np.issubdtype(face.dtype, np.integer)):
            raise ValueError(f"mesh faces: wanted sequences of whole numbers, got {face!r} at index {i}")
    offsets = np.cumsum([0] + [len(face) for face in faces])
    indices = np.concatenate(faces).astype(np.int64) if faces else np.zeros(0, dtype=np.int64)
    return Mesh(vertices, offsets, indices, None)


def _problem(mesh):
    """What is wrong with a mesh, in words; None if nothing."""
    if len(mesh.offsets) <= 1:
        return "faces: wanted at least one, got none"
    corners = np.diff(mesh.offsets)
    if corners.min() < 3:
        face = int(np.argmax(corners < 3))
        return f"faces: wanted 3 corners or more, got {corners[face]} in face {face}"
    finite = np.all(np.isfinite(mesh.vertices), axis=1)
    if not np.all(finite):
        return f"vertices: wanted finite numbers, got {mesh.vertices[np.argmin(finite)]} in vertex {np.argmin(finite)}"
    large = np.any(np.abs(mesh.vertices) > check.LARGEST, axis=1)
    if np.any(large):
        row = int(np.argmax(large))
        return f"vertices: wanted coordinates up to {check.LARGEST:g}, got {mesh.vertices[row]} in vertex {row}"
    bad = (mesh.indices < 0) | (mesh.indices >= len(mesh.vertices))
    if np.any(bad):
        at = int(np.argmax(bad))
        face = int(np.searchsorted(mesh.offsets, at, side="right")) - 1
        return f"faces: wanted indices of the {len(mesh.vertices)} vertices, got {mesh.indices[at]} in face {face}"
    return None
