"""Colours within polygons are those of the fan around the first corner, for faces as a whole and for parts of them."""

from itertools import pairwise

import numpy as np
import pytest

import surflux as sf
from surflux.meshes.face_colors import colors_of_patches
from surflux.meshes.fans import cut_along_fans
from surflux.meshes.foreign_meshes import Mesh
from surflux.meshes.reading import read_mesh

TRAPEZOID = [(0, 0), (2, 0), (1.5, 1), (0.5, 1)]
HEXAGON = [(0, 0), (2, 0), (3, 1), (2.5, 2), (1, 2.5), (-1, 1)]
DARTS = [(0, 0), (2, -1), (0.5, 0), (2, 1)], [(2, -1), (0.5, 0), (2, 1), (0, 0)]
AT = [(0, 0), (1, 0), (1, 1), (0, 1), (0.3, 0.9), (0.1, 0.4)]  # no affine image of the polygons
SHADES = [0.9, 0.8, 0.0, 0.1, 0.7, 0.2]
AREAS = [None, 0.5, 0.1, 0.01]


def textured(folder, corners, faces="whole"):
    """The path of a polygon, or of the triangles of its fan, on which a corner of a texture shines."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:4, :4] = 255
    image.fromarray(pixels).save(folder / "corner.png")
    (folder / "a.mtl").write_text("newmtl a\nKd 0 0 0\nKe 10 10 10\nmap_Ke corner.png\n")
    places = "".join(f"v {x:g} {y:g} 0\nvt {u:g} {v:g}\n" for (x, y), (u, v) in zip(corners, AT, strict=False))
    k = len(corners)
    rings = [range(1, k + 1)] if faces == "whole" else [(1, i, i + 1) for i in range(2, k)]
    lines = "".join("f " + " ".join(f"{i}/{i}" for i in ring) + "\n" for ring in rings)
    (folder / f"{faces}.obj").write_text(f"mtllib a.mtl\n{places}usemtl a\n{lines}")
    return folder / f"{faces}.obj"


def shaded(folder, corners, name="reflectance"):
    """The path of a polygon whose vertices have SHADES."""
    head = "".join(f"property float {p}\n" for p in ("x", "y", "z", *(f"{name}_{channel}" for channel in "rgb")))
    k = len(corners)
    rows = "".join(f"{x} {y} 0 {f'{s} ' * 3}\n" for (x, y), s in zip(corners, SHADES, strict=False))
    faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    text = f"ply\nformat ascii 1.0\nelement vertex {k}\n{head}{faces}{rows}{k} {' '.join(map(str, range(k)))}\n"
    (folder / "a.ply").write_text(text)
    return folder / "a.ply"


def mean_of_fan(corners, values):
    a, b, c = np.array([(corners[0], *pair) for pair in pairwise(corners[1:])]).swapaxes(0, 1)
    areas = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    means = [np.mean([values[0], values[i], values[i + 1]]) for i in range(1, len(corners) - 1)]
    return np.average(means, weights=areas)


def total(s, name):
    return (getattr(s, name)[:, 0] * s.areas).sum()


@pytest.mark.parametrize("corners", [TRAPEZOID, HEXAGON, *DARTS])
def test_the_power_of_a_texture_is_the_same_however_it_is_cut(tmp_path, corners):
    """A patch across a diagonal of the fan had one affine image of the texture: power was off by up to a tenth."""
    wanted = total(sf.Surfels.from_mesh(textured(tmp_path, corners, "fan")), "emission")
    whole = textured(tmp_path, corners)
    found = [total(sf.Surfels.from_mesh(whole, area), "emission") for area in AREAS]
    if corners in DARTS[1:]:  # no fan: the part beyond the concave corner counts less than 0
        np.testing.assert_allclose(found, found[0], rtol=1e-6)
    else:
        np.testing.assert_allclose(found, wanted, rtol=1e-6)
    low, high = np.min(corners, axis=0) - 1, np.max(corners, axis=0) + 1
    wall = [[0.4, low[1], -1], [0.9, high[1], -1], [0.9, high[1], 1], [0.4, low[1], 1]], [[0, 1, 2, 3]]
    cut = sf.divide_patches([sf.Surfels.from_mesh(whole), sf.Surfels.from_mesh(wall)])[0]
    assert total(cut, "emission") == pytest.approx(found[0], rel=1e-6)


@pytest.mark.parametrize("corners", [TRAPEZOID, HEXAGON, [(0, 0), (1, 0), (1, 1), (0.75, 1), (0.5, 1), (0, 1)]])
def test_faces_have_the_mean_of_their_vertices_by_area(tmp_path, corners):
    """It was the mean of the corners, up to twice as much as what pieces of the face have."""
    wanted = mean_of_fan(corners, SHADES)
    for area in AREAS:
        s = sf.Surfels.from_mesh(shaded(tmp_path, corners), area)
        assert total(s, "reflectance") / s.areas.sum() == pytest.approx(wanted, rel=1e-6)
        s = sf.Surfels.from_mesh(shaded(tmp_path, corners, "emission"), area)
        assert total(s, "emission") / s.areas.sum() == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize(("count", "tolerance"), [(60, 1e-9), (800, 0.02)])
def test_polygons_of_many_corners_have_their_colors(count, tolerance):
    """All triangles were cut along all lines of the fan: time went by the third power of the corners, for minutes."""
    angle = np.arange(count) * 2 * np.pi / count
    vertices = np.stack([np.cos(angle), 0.5 * np.sin(angle), 0 * angle], axis=1)
    shades = np.repeat(0.5 + 0.4 * np.cos(angle)[:, None], 3, axis=1)
    mesh = Mesh(vertices, np.array([0, count]), np.arange(count), shades)
    triangles = np.stack([np.roll(vertices, -1, axis=0), np.zeros((count, 3)), vertices], axis=1)
    at = np.zeros(count, int)
    (found,), _ = colors_of_patches(mesh, at[:1], at, triangles)
    np.testing.assert_allclose(found, mesh.face_reflectance()[0], rtol=tolerance)


def test_the_mean_beyond_a_concave_corner_is_one_of_its_colours(tmp_path):
    """Where triangles of the fan count less than 0."""
    found = read_mesh(shaded(tmp_path, DARTS[1])).face_reflectance()
    assert min(SHADES[:4]) <= found.min() <= found.max() <= max(SHADES[:4])


@pytest.mark.parametrize("shift", [0.0, 5e6])
def test_parts_cover_triangles_each_in_one_of_the_fan(shift):
    angle = np.arange(9) * 2 * np.pi / 9
    polygon = np.stack([np.cos(angle), np.sin(angle), np.zeros(9)], axis=1)
    inside = np.random.default_rng(3).dirichlet(np.full(9, 0.3), (40, 3)) @ polygon
    across = polygon[[[0, 3, 6], [1, 4, 7], [2, 5, 8]]]  # corners of the first lie on lines of the fan
    triangles = np.concatenate([inside, across])
    vertices = polygon + shift
    of, parts = cut_along_fans(vertices, np.array([0, 9]), np.arange(9), np.zeros(43, int), triangles + shift)

    def areas(t):
        return 0.5 * np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)

    np.testing.assert_allclose(np.bincount(of, areas(parts)), areas(triangles), rtol=1e-6, atol=1e-8)
    # Seen from the first corner, whose lines to the others are 20 degrees apart.
    x, y, _ = (parts - vertices[0]).transpose(2, 0, 1)
    at = np.where(np.hypot(x, y) > 1e-4, np.degrees(np.arctan2(y, -x)) + 70.0, np.nan) / 20.0
    low, high = np.nanmin(at, axis=1), np.nanmax(at, axis=1)
    assert (np.ceil(high - 1e-3) - np.floor(low + 1e-3) <= 1).all()


def test_slivers_have_parts_too():
    """As thin as one digit, far from the origin."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) + 5e6
    start = np.random.default_rng(5).random((500, 2)) * [0.4, 0.4] + [0.1, 0.5]
    corners = start[:, None] + np.array([[0, 0], [0.4, -0.5], [0.2, -0.25 + 1e-9]])
    triangles = np.insert(corners, 2, 0.0, axis=2) + 5e6
    of, parts = cut_along_fans(square, np.array([0, 4]), np.arange(4), np.zeros(500, int), triangles)
    np.testing.assert_array_equal(np.unique(of), np.arange(500))
    assert np.isfinite(parts).all()
