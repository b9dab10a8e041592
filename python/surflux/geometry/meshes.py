"""Meshes from files and from other libraries, as vertices and polygons."""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.color import COLOR_CHOICES, reflectance_of_colors, white_of_colors
from surflux._base.files import require_file
from surflux._base.warn import warn
from surflux.geometry.foreign_meshes import WANTED, Mesh, convert
from surflux.geometry.gltf_meshes import read_gltf
from surflux.geometry.obj_materials import looks_of_faces
from surflux.geometry.stl import require_whole_stl
from surflux.geometry.textures import TexturedFaces
from surflux.geometry.transparency import warn_of_transparency


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

    PLY and OBJ are read by surflux itself, with materials and textures of OBJ: quads and larger polygons stay whole,
    OBJ's relative indices work, positions are exact, and an error names the line. (trimesh cuts polygons into
    triangles; VTK makes three vertices of one where texture coordinates or normals differ, so that neighbours no longer
    share edges.)
    glTF is, too, with all that its scene shows. VTK's formats go through pyvista; STL and OFF through trimesh, the
    extra surflux[meshes].

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
TRIMESH_SUFFIXES = (".stl", ".off")  # those it needs no further package for


def _read_file(path):
    suffix = Path(path).suffix.lower()
    require_file(path)
    if suffix == ".ply":
        mesh = _read_ply(path)
    elif suffix == ".obj":
        vertices, offsets, indices, colors, materials, (places, of_corners) = _core.read_obj(path)
        rho = _reflectance(path, colors, "float")
        textured = TexturedFaces(vertices, offsets, indices, places.reshape(-1, 2), of_corners) if len(places) else None
        of_faces, exitance, uses = looks_of_faces(path, *materials, textured, has_colors=rho is not None)
        mesh = Mesh(vertices, offsets, indices.astype(np.int64), rho, None if rho is not None else of_faces, exitance)
        if uses:
            mesh = mesh._replace(places=textured.of_each_corner(), textures=uses)
    elif suffix in GLTF:
        mesh = read_gltf(path)
        warn_of_transparency(path, "alphaMode", mesh.clear)
    elif suffix in PYVISTA_SUFFIXES:
        mesh = _read_outside(path, "pyvista", _read_with_pyvista)
    elif suffix in TRIMESH_SUFFIXES:
        if suffix == ".stl":
            require_whole_stl(path)
        mesh = _read_outside(path, "trimesh", _read_with_trimesh)
    else:
        supported = ", ".join((".ply", ".obj", *PYVISTA_SUFFIXES, *TRIMESH_SUFFIXES, *GLTF))
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


def _read_ply(path):
    ply = _core.read_ply(path)
    vertex = ply["columns"].get("vertex", {})
    if not all(axis in vertex for axis in "xyz"):
        raise _core.FileError(f"{path}: no vertices with x, y and z")
    if len(ply["face_offsets"]) == 1 and "tristrips" in ply["elements"]:
        raise _core.FileError(
            f"{path}: its triangles stand in strips (tristrips), which are not supported; wanted faces"
        )
    points = np.stack([vertex[axis] for axis in "xyz"], axis=-1)
    rho, of_faces = (_ply_reflectance(path, ply, element) for element in ("vertex", "face"))
    mesh = Mesh(points, ply["face_offsets"], ply["face_indices"].astype(np.int64), rho, of_faces)
    exitance = _ply_linear(path, ply, "face", "emission")
    if exitance is None and (of_vertices := _ply_linear(path, ply, "vertex", "emission")) is not None:
        exitance = mesh.mean_of_corners(of_vertices)
    return mesh._replace(exitance=exitance)


def _ply_reflectance(path, ply, element):
    linear = _ply_linear(path, ply, element, "reflectance")
    if linear is not None:
        return linear
    columns = ply["columns"].get(element, {})
    for names in COLOR_CHOICES:
        if all(name in columns for name in names):
            colors = np.stack([columns[name] for name in names], axis=-1)
            return _reflectance(path, colors, ply["types"][element].get(names[0]), element)
    return None


def _ply_linear(path, ply, element, name):
    """RGB (n, 3) of name_r, name_g and name_b, as surflux writes them; None where there are none."""
    columns = ply["columns"].get(element, {})
    missing = [f"{name}_{channel}" for channel in "rgb" if f"{name}_{channel}" not in columns]
    if len(missing) == 3:
        return None
    if missing:
        raise _core.FileError(f"{path}: its {element} elements have colours of {name}, but no {missing[0]}")
    values = np.stack([columns[f"{name}_{channel}"] for channel in "rgb"], axis=-1).astype(np.float64)
    below = 1.0 if name == "reflectance" else np.inf
    bad = ~((values >= 0.0) & (values < below)).all(axis=1)
    if np.any(bad):
        row = int(np.argmax(bad))
        value = values[row][~((values[row] >= 0.0) & (values[row] < below))][0]
        wanted = "from 0 to below 1" if below == 1.0 else "from 0, finite"
        raise _core.FileError(f"{path}: {element} {row}: {name} is {value:g}; wanted {wanted}")
    return values


def _reflectance(path, colors, type_name, element="vertex"):
    if colors is None or len(colors) == 0:
        return None
    if not np.all(np.isfinite(colors)):
        row = int(np.argmax(~np.all(np.isfinite(colors), axis=1)))
        warn(f"{path}: {element} {row} has a colour that is not finite; the colours are ignored")
        return None
    if np.any(colors < 0):
        row = int(np.argmax(np.any(colors < 0, axis=1)))
        raise _core.FileError(f"{path}: {element} {row}: colour is {colors[row].min():g}; wanted not below 0")
    white = white_of_colors(colors, type_name, path)
    if white is None:
        row = int(np.argmax(colors.max(axis=1)))
        raise _core.FileError(f"{path}: {element} {row}: colour is {colors.max():g}; wanted at most 1, 255 or 65535")
    return reflectance_of_colors(colors, white)


def _read_outside(path, library, reader):
    """What an outside reader makes of a file; whatever it raises becomes a FileError."""
    try:
        return reader(path)
    except _core.FileError:
        raise
    except ImportError as error:
        raise _core.FileError(
            f"{path}: needs {error.name or library}, which is not installed: pip install 'surflux[meshes]'"
        ) from error
    except Exception as error:
        raise _core.FileError(f"{path}: {library} cannot read it ({type(error).__name__}: {error})") from error


def _read_with_pyvista(path):
    import pyvista

    return _convert(pyvista.read(path))


def _read_with_trimesh(path):
    import trimesh

    return _convert(trimesh.load(path))


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
