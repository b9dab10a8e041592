"""Meshes of PLY files, with reflectance, colours and emission of vertices or faces, and textures."""

import numpy as np

from surflux import _core
from surflux._base.color import COLOR_CHOICES
from surflux.meshes.file_colors import reflectance_in_file
from surflux.meshes.foreign_meshes import Mesh
from surflux.meshes.ply_textures import with_textures


def read_ply_mesh(path):
    """The Mesh of a PLY file."""
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
        exitance = mesh.mean_over_faces(of_vertices)
    mesh = mesh._replace(exitance=exitance)
    has_reflectance = any("reflectance_r" in columns for columns in ply["columns"].values())
    return mesh if has_reflectance else with_textures(path, mesh, ply)


def _ply_reflectance(path, ply, element):
    linear = _ply_linear(path, ply, element, "reflectance")
    if linear is not None:
        return linear
    columns = ply["columns"].get(element, {})
    for names in COLOR_CHOICES:
        if all(name in columns for name in names):
            colors = np.stack([columns[name] for name in names], axis=-1)
            return reflectance_in_file(path, colors, ply["types"][element].get(names[0]), element)
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
