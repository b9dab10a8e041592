"""Meshes as the user hands them in."""

import numpy as np

from surflux import _check


def read_mesh(mesh):
    """Polygons of a mesh: vertices (v, 3), offsets (f + 1,) into indices; face f is indices[offsets[f]:offsets[f + 1]].

    mesh is a trimesh.Trimesh, a pyvista.PolyData or (vertices, faces), where faces are an integer array (f, k) or a
    list of corner lists. Raises ValueError naming "mesh".
    """
    kind = type(mesh).__module__.partition(".")[0], type(mesh).__name__
    if isinstance(mesh, tuple) and len(mesh) == 2:
        vertices, (offsets, indices) = mesh[0], _faces(mesh[1])
    elif kind[0] == "trimesh" and hasattr(mesh, "faces"):
        vertices, (offsets, indices) = mesh.vertices, _faces(np.asarray(mesh.faces))
    elif kind[0] == "pyvista" and kind[1] == "PolyData":
        polygons = mesh.GetPolys()
        if mesh.n_cells != polygons.GetNumberOfCells():
            raise ValueError(f"mesh: wanted polygons alone, got {mesh.n_cells} cells of which some are not")
        from pyvista import convert_array

        offsets, indices = convert_array(polygons.GetOffsetsArray()), convert_array(polygons.GetConnectivityArray())
        vertices = mesh.points
    else:
        raise ValueError(
            "mesh: wanted a path, trimesh.Trimesh, pyvista.PolyData or (vertices, faces), "
            f"got {type(mesh).__module__}.{type(mesh).__qualname__}"
        )
    vertices = _check.finite_array("mesh vertices", vertices, (None, 3))
    offsets, indices = np.asarray(offsets, np.int64), np.asarray(indices, np.int64)
    if len(offsets) < 2:
        raise ValueError("mesh faces: wanted at least one, got none")
    if len(indices) and (indices.min() < 0 or indices.max() >= len(vertices)):
        bad = indices[(indices < 0) | (indices >= len(vertices))][0]
        raise ValueError(f"mesh faces: wanted indices of the {len(vertices)} vertices, got {bad}")
    return vertices, offsets, indices


def _faces(faces):
    if isinstance(faces, np.ndarray) or len({len(face) for face in faces if hasattr(face, "__len__")}) == 1:
        array = _check.numeric("mesh faces", faces)
        if array.ndim != 2 or array.dtype.kind not in "iu":
            raise ValueError(f"mesh faces: wanted whole numbers of shape (f, k), got {array.dtype} {array.shape}")
        return np.arange(len(array) + 1) * array.shape[1], array.ravel()
    rows = [_check.numeric("mesh faces", face) for face in faces]
    if any(row.ndim != 1 or row.dtype.kind not in "iu" for row in rows):
        raise ValueError("mesh faces: wanted lists of whole numbers")
    if not rows:
        return np.zeros(1, np.int64), np.zeros(0, np.int64)
    return np.concatenate([[0], np.cumsum([len(row) for row in rows])]), np.concatenate(rows)
