"""A unit square of two triangles, as tests of foreign meshes and of textures take it."""

import numpy as np
import pytest

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def two_triangles(**visual):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(SQUARE, TWO, process=False)
    if visual:
        mesh.visual = trimesh.visual.TextureVisuals(**visual)
    return mesh
