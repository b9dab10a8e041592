"""Strips of triangles of pyvista are triangles behind the polygons, each with what its strip has."""

import numpy as np
import pyvista

import surflux as sf
from surflux.meshes.reading import read_mesh
from surflux.meshes.strips import without_strips
from surflux.solving.pyvista_accessor import PolyDataAccessor

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0], [3, 0, 0], [3, 1, 0]], float)
COLORS = np.array([[255, 255, 255], [255, 0, 0], [0, 0, 255], [0, 255, 0]], np.uint8)
WHITE = 0.98


def mixed():
    """A line, a square, a strip of three triangles and one of a single triangle, facing up."""
    mesh = pyvista.PolyData(POINTS, lines=[2, 0, 1], faces=[4, 0, 1, 2, 3], strips=[5, 2, 1, 5, 4, 6, 3, 5, 6, 7])
    mesh.cell_data["RGB"] = COLORS
    mesh.cell_data["number"] = np.arange(4)
    mesh.point_data["height"] = np.arange(8.0)
    return mesh


def test_colours_of_cells_go_to_the_triangles_of_strips():
    """Beside polygons triangles had whatever was in memory."""
    mesh = read_mesh(mixed())
    assert np.split(mesh.indices, mesh.offsets[1:-1])[0].tolist() == [0, 1, 2, 3]
    assert mesh.indices[4:].reshape(-1, 3).tolist() == [[2, 1, 5], [5, 1, 4], [5, 4, 6], [5, 6, 7]]
    wanted = np.array([[1, 0, 0], [0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 1, 0]]) * WHITE
    np.testing.assert_array_equal(mesh.of_faces, wanted)


def test_cells_and_points_keep_their_data():
    before = mixed()
    mesh = without_strips(before)
    assert (mesh.n_lines, mesh.n_strips, mesh.n_cells) == (1, 0, 6)
    np.testing.assert_array_equal(mesh.cell_data["number"], [0, 1, 2, 2, 2, 3])
    np.testing.assert_array_equal(mesh.point_data["height"], np.arange(8.0))
    assert before.n_strips == 2
    plain = pyvista.Cube()
    assert without_strips(plain) is plain
    alone = without_strips(pyvista.PolyData(POINTS, strips=[4, 0, 1, 3, 2]))
    np.testing.assert_array_equal(alone.faces, [3, 0, 1, 3, 3, 3, 1, 2])


def test_light_of_polygons_beside_strips():
    lit = PolyDataAccessor(mixed()).solve([sf.Environment(1.0)])
    np.testing.assert_array_equal(lit.cell_data["number"], [0, 1, 2, 2, 2, 3])
    assert np.isnan(lit.cell_data["irradiance"][0]).all()
    np.testing.assert_allclose(lit.cell_data["irradiance"][1:], np.pi, rtol=1e-6)
