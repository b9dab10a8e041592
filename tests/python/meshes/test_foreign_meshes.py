"""Meshes and clouds of other libraries, and their colours. meshio and Open3D are told by what their objects have."""

from types import SimpleNamespace

import numpy as np
import pytest

import surflux as sf
from squares import SQUARE, TWO, two_triangles
from surflux._base.color import WHITE, srgb_to_linear
from surflux.meshes.reading import read_mesh

GREY = WHITE * srgb_to_linear(188 / 255)  # of an 8-bit 188: about half of white


def meshio_like(*cells, points=SQUARE, **point_data):
    blocks = [SimpleNamespace(type=kind, data=np.array(data)) for kind, data in cells]
    return SimpleNamespace(points=points, cells=blocks, point_data=point_data)


def open3d_like(**colors):
    return SimpleNamespace(vertices=SQUARE, triangles=TWO.astype(np.int32), **colors)


def polygons(mesh):
    return [mesh.indices[a:b].tolist() for a, b in zip(mesh.offsets[:-1], mesh.offsets[1:], strict=True)]


def test_blocks_of_meshio():
    mesh = meshio_like(("line", [[0, 1]]), ("triangle", [[0, 1, 2]]), ("quad", [[0, 1, 2, 3]]), ("vertex", [[0]]))
    assert polygons(read_mesh(mesh)) == [[0, 1, 2], [0, 1, 2, 3]]
    assert sf.Surfels.from_mesh(mesh).areas.tolist() == [0.5, 1.0]
    pairs = SimpleNamespace(points=SQUARE, cells=[("quad", np.array([[0, 1, 2, 3]]))])
    assert polygons(read_mesh(pairs)) == [[0, 1, 2, 3]]
    five = meshio_like(("polygon5", [[0, 1, 2, 3, 4]]), points=np.array([[0, 0], [2, 0], [2, 1], [1, 2], [0, 1]]))
    assert read_mesh(five).vertices[3].tolist() == [1, 2, 0]  # in a plane: z is 0
    assert sf.Surfels.sample_mesh(mesh, 20).areas is None


def test_volumes_of_meshio_are_no_surface():
    tetra = ("tetra", [[0, 1, 2, 3]])
    with pytest.raises(ValueError, match=r"^mesh cells: wanted triangles, quads or polygons, got tetra"):
        read_mesh(meshio_like(tetra))
    with pytest.warns(UserWarning, match=r"^mesh cells: tetra are left out"):
        mesh = read_mesh(meshio_like(tetra, ("triangle", [[0, 1, 2]])))
    assert polygons(mesh) == [[0, 1, 2]]


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65535), (float, 1.0)])
def test_colors_of_vertices_of_meshio(dtype, white):
    values = {name: np.array([white, 0, white, 0]).astype(dtype) for name in ("red", "green", "blue")}
    mesh = read_mesh(meshio_like(("quad", [[0, 1, 2, 3]]), **values))
    np.testing.assert_array_equal(mesh.reflectance, np.array([[WHITE] * 3, [0] * 3] * 2))


def test_meshes_of_open3d():
    assert polygons(read_mesh(open3d_like())) == TWO.tolist()
    assert read_mesh(open3d_like(vertex_colors=np.zeros((0, 3)))).reflectance is None
    colors = np.array([[1, 0, 188 / 255]] * 4)
    mesh = read_mesh(open3d_like(vertex_colors=colors))
    np.testing.assert_allclose(mesh.reflectance, [[WHITE, 0, GREY]] * 4)
    tensors = SimpleNamespace(to_legacy=lambda: open3d_like(vertex_colors=colors))
    np.testing.assert_array_equal(read_mesh(tensors).reflectance, mesh.reflectance)
    assert sf.Surfels.from_mesh(open3d_like()).areas.tolist() == [1.0]


def cloud(**more):
    empty = np.zeros((0, 3))
    return SimpleNamespace(**({"points": SQUARE, "normals": empty, "colors": empty} | more))


def test_clouds_of_open3d():
    colors = np.array([[1, 0, 188 / 255]] * 4)
    s = sf.Surfels(cloud(normals=[[0, 0, -2]] * 4, colors=colors), radii=1.0, reflectance=None)
    np.testing.assert_array_equal(s.points, SQUARE)
    np.testing.assert_array_equal(s.normals, [[0, 0, -1]] * 4)
    np.testing.assert_allclose(s.reflectance, [[WHITE, 0, GREY]] * 4)
    # What is given counts; what is not there is as of an array.
    given = sf.Surfels(cloud(colors=colors), [[0, 0, 1]] * 4, radii=1.0, reflectance=0.2)
    assert given.normals[0].tolist() == [0, 0, 1]
    assert (given.reflectance == 0.2).all()
    plain = sf.Surfels(cloud(), radii=1.0, reflectance=None)
    assert (plain.reflectance == 0.5).all()
    np.testing.assert_array_equal(plain.normals, sf.Surfels(SQUARE, radii=1.0).normals)
    tensors = SimpleNamespace(to_legacy=lambda: cloud(colors=colors))
    np.testing.assert_array_equal(sf.Surfels(tensors, radii=1.0, reflectance=None).reflectance, s.reflectance)


def test_colors_of_faces_of_trimesh():
    mesh = two_triangles()
    mesh.visual.face_colors = [[255, 0, 0, 255], [0, 188, 0, 255]]
    s = sf.Surfels.from_mesh(mesh, reflectance=None)  # no pair of triangles of two colours is one patch
    np.testing.assert_allclose(s.reflectance, [[WHITE, 0, 0], [0, GREY, 0]])
    spread = sf.Surfels.sample_mesh(mesh, 50, reflectance=None)
    upper = spread.points[:, 1] > spread.points[:, 0]
    np.testing.assert_allclose(spread.reflectance, np.where(upper[:, None], [0, GREY, 0], [WHITE, 0, 0]))


@pytest.mark.parametrize(("dtype", "white", "half"), [(np.uint8, 255, 188), (np.uint16, 65535, 188 * 257)])
def test_colors_of_pyvista_in_8_and_16_bits(dtype, white, half):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData(SQUARE, faces=[3, 0, 1, 2, 3, 0, 2, 3])
    mesh.point_data["RGB"] = np.array([[white, half, 0]] * 4, dtype)
    np.testing.assert_allclose(read_mesh(mesh).face_reflectance(), [[WHITE, GREY, 0]] * 2)
    mesh.cell_data["RGB"] = np.array([[0, half, 0], [0, 0, white]], dtype)
    np.testing.assert_allclose(read_mesh(mesh).face_reflectance(), [[0, GREY, 0], [0, 0, WHITE]])


def test_dark_colors_of_16_bits_are_not_taken_for_8():
    dark = np.full(4, 188, np.uint16)
    mesh = read_mesh(meshio_like(("quad", [[0, 1, 2, 3]]), red=dark, green=dark, blue=dark))
    np.testing.assert_allclose(mesh.reflectance, WHITE * srgb_to_linear(188 / 65535))


def test_colors_that_no_type_has_are_refused():
    with pytest.raises(ValueError, match=r"^colours: wanted finite numbers"):
        read_mesh(open3d_like(vertex_colors=np.full((4, 3), np.nan)))


def test_clouds_of_pyvista_and_trimesh():
    pv, trimesh = pytest.importorskip("pyvista"), pytest.importorskip("trimesh")
    points = np.random.default_rng(0).random((40, 3))
    normals = np.tile([0.0, 0.0, -1.0], (40, 1))
    colors = np.tile(np.array([188, 0, 255], np.uint8), (40, 1))
    cloud = pv.PolyData(points)
    assert np.array_equal(sf.Surfels(cloud, normals=normals).points, points)
    cloud.point_data["Normals"], cloud.point_data["RGB"] = normals, colors
    s = sf.Surfels(cloud)
    assert np.array_equal(s.normals, normals)
    # sRGB 188 is linear .503, and white is .98.
    assert s.reflectance[0] == pytest.approx([0.98 * 0.503, 0.0, 0.98], abs=1e-3)
    assert sf.Surfels(cloud, reflectance=0.5).reflectance[0].tolist() == [0.5, 0.5, 0.5]
    assert np.array_equal(sf.Surfels(cloud, normals=-normals).normals, -normals)
    # What was made of surfels is surfels again.
    assert np.array_equal(sf.Surfels(s.to_pyvista(kind="points")).normals, s.normals)
    found = sf.Surfels(trimesh.PointCloud(points, colors), normals=normals)
    assert np.array_equal(found.points, points)
    assert found.reflectance[0] == pytest.approx([0.98 * 0.503, 0.0, 0.98], abs=1e-3)
    assert sf.Surfels(trimesh.PointCloud(points), normals=normals).reflectance[0, 0] == 0.5


def test_colours_of_pyvista_may_be_fractions():
    """As add_mesh(rgb=True) shows them."""
    pyvista = pytest.importorskip("pyvista")
    plane = pyvista.Plane(i_resolution=2, j_resolution=2)
    colors = np.tile([0.8, 0.4, 0.2], (plane.n_cells, 1))
    plane.cell_data["RGB"] = np.rint(255 * colors).astype(np.uint8)
    wanted = sf.Surfels.from_mesh(plane).reflectance
    plane.cell_data["RGB"] = colors
    np.testing.assert_allclose(sf.Surfels.from_mesh(plane).reflectance, wanted, rtol=1e-6)
    assert wanted[0, 0] > 0.55
