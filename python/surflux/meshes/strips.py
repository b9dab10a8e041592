"""Strips of triangles in meshes of pyvista."""

import numpy as np


def without_strips(mesh):
    """The pyvista.PolyData with triangles, behind its polygons, in place of strips, each with the data of its strip."""
    if not mesh.n_strips:
        return mesh
    from vtkmodules.util.numpy_support import vtk_to_numpy

    cells = mesh.GetStrips()
    offsets, corners = (vtk_to_numpy(a) for a in (cells.GetOffsetsArray(), cells.GetConnectivityArray()))
    counts = np.diff(offsets) - 2
    strip = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(strip)) - np.repeat(np.cumsum(counts) - counts, counts)
    turned = (number % 2)[:, None]  # every other one goes the other way round
    triangles = corners[(offsets[strip] + number)[:, None] + np.where(turned, [1, 0, 2], [0, 1, 2])]
    before = mesh.n_cells - mesh.n_strips
    cell = np.concatenate([np.arange(before), before + strip])
    result = mesh.copy()
    result.clear_cell_data()
    result.faces = np.concatenate([mesh.faces, np.insert(triangles, 0, 3, axis=1).ravel()])
    result.strips = np.zeros(0, np.int64)
    for name, values in mesh.cell_data.items():
        result.cell_data[name] = values[cell]
    return result
