"""Surfels.from_mesh (D04 section 7.3): geometry against sums and shapes known in advance."""

import numpy as np
import pytest

import surflux as sf
from surflux.meshes.patches import _places

SQUARE = ([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]])
SPLIT = (SQUARE[0], [[0, 1, 2], [0, 2, 3]])


def closed_box():
    v = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
    f = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return v, f


def triangles_of(faces):
    return [t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])]


def vector_area(s):
    return (s.areas[:, None] * s.normals).sum(axis=0)


def test_a_quad_is_one_surfel():
    s = sf.Surfels.from_mesh(SQUARE)
    assert s.points.tolist() == [[1, 1, 0]]
    assert s.normals.tolist() == [[0, 0, 1]]
    assert s.areas.tolist() == [4]
    assert s.radii == pytest.approx([np.sqrt(2)])
    assert s.triangles.shape == (2, 3, 3)
    assert s.triangle_surfel.tolist() == [0, 0]


def test_a_triangle_stands_at_its_centroid_and_reaches_its_farthest_corner():
    s = sf.Surfels.from_mesh(([[0, 0, 0], [3, 0, 0], [0, 6, 0]], [[0, 1, 2]]))
    assert s.points[0] == pytest.approx([1, 2, 0])
    assert s.radii == pytest.approx([np.sqrt(1 + 16)])
    assert s.areas == pytest.approx([9])


def test_the_area_centroid_of_a_trapezium():
    # Bases 4 and 2, height 3: the centroid lies h/3 (a + 2 b)/(a + b) = 3/3 * 8/6 above the longer base.
    s = sf.Surfels.from_mesh(([[-2, 0, 0], [2, 0, 0], [1, 3, 0], [-1, 3, 0]], [[0, 1, 2, 3]]))
    assert s.points[0] == pytest.approx([0, 4 / 3, 0])
    assert s.areas == pytest.approx([9])


def test_coplanar_pairs_of_triangles_count_as_quads():
    vertices, faces = closed_box()
    quads, pairs = sf.Surfels.from_mesh((vertices, faces)), sf.Surfels.from_mesh((vertices, triangles_of(faces)))
    assert len(quads) == len(pairs) == 6
    assert pairs.points == pytest.approx(quads.points)
    assert pairs.areas == pytest.approx([6, 6, 3, 3, 2, 2])
    assert pairs.radii == pytest.approx(quads.radii)
    assert vector_area(pairs) == pytest.approx([0, 0, 0], abs=1e-12)


def test_pairs_are_found_where_each_face_has_corners_of_its_own():
    vertices, faces = closed_box()
    corners = vertices[np.array(triangles_of(faces))].reshape(-1, 3)
    assert len(sf.Surfels.from_mesh((corners, np.arange(36).reshape(12, 3)))) == 6


def test_a_grid_of_split_squares_gives_its_squares():
    # Parallelograms across cells are pairs too; squares come first, so that each cell is found.
    n = 7
    i, j = np.divmod(np.arange((n + 1) ** 2), n + 1)
    vertices = np.stack([i, j, np.zeros(len(i))], axis=1).astype(float)
    i, j = np.divmod(np.arange(n * n), n)
    a = i * (n + 1) + j
    faces = np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])
    s = sf.Surfels.from_mesh((vertices, faces))
    assert s.areas.tolist() == [1.0] * n * n
    assert sorted(map(tuple, s.points[:, :2])) == [(x + 0.5, y + 0.5) for x in range(n) for y in range(n)]


@pytest.mark.parametrize(
    ("vertices", "reason"),
    [
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0.01], [0, 1, 0]], "bent"),
        ([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], "not convex"),
        ([[0, 0, 0], [2, 0, 0], [1, 1, 0], [0, 2, 0]], "a triangle, cut in two"),
    ],
)
def test_other_pairs_stay_triangles(vertices, reason):
    assert len(sf.Surfels.from_mesh((vertices, [[0, 1, 2], [0, 2, 3]]))) == 2, reason


def test_pairs_of_different_colour_stay_apart():
    s = sf.Surfels.from_mesh(SPLIT, reflectance=[0.2, 0.6])
    assert s.reflectance[:, 0].tolist() == [0.2, 0.6]
    assert len(sf.Surfels.from_mesh(SPLIT, reflectance=[0.2, 0.2], emission=[0, 1])) == 2
    assert len(sf.Surfels.from_mesh(SPLIT, reflectance=[0.2, 0.2])) == 1


def colored_split(tmp_path, *colors):
    lines = [f"v {x} {y} {z} {color} 0 0" for (x, y, z), color in zip(SPLIT[0], colors, strict=True)]
    path = tmp_path / "colored.obj"
    path.write_text("\n".join([*lines, "f 1 2 3", "f 1 3 4", ""]))
    return path


def test_a_mesh_has_the_colours_of_its_corners(tmp_path):
    """sRGB .7353570 is .5, half of white, which is .98."""
    path = colored_split(tmp_path, 1, 0.7353570, 0, 0)
    s = sf.Surfels.from_mesh(path)
    assert s.reflectance == pytest.approx(np.array([[0.49, 0, 0], [0.98 / 3, 0, 0]]), abs=1e-6)
    # Parts of faces and points on them have what is between the corners there.
    cut, points = sf.Surfels.from_mesh(path, 0.3, None), sf.Surfels.sample_mesh(path, 200)
    for found, tolerance in ((cut, 1e-6), (points, 0.07)):
        x, y, _ = found.points.T
        assert found.reflectance[:, 0] == pytest.approx(0.98 - 0.49 * np.where(x > y, (x + y) / 2, y), abs=tolerance)
        assert np.all(found.reflectance[:, 1:] == 0)
    # Alike on both triangles they are one quadrilateral; a mesh without has .5.
    assert np.all(sf.Surfels.from_mesh(path, reflectance=0.5).reflectance == 0.5)
    assert len(sf.Surfels.from_mesh(colored_split(tmp_path, 0.5, 0.5, 0.5, 0.5))) == 1
    assert np.all(sf.Surfels.from_mesh(SPLIT).reflectance == 0.5)
    assert np.all(sf.Surfels.sample_mesh(SPLIT, 20).reflectance == 0.5)


def test_a_scene_file_takes_the_colours_of_a_mesh(tmp_path):
    colored_split(tmp_path, 1, 1, 1, 0)
    scene = tmp_path / "scene.toml"
    for kind, tolerance in (('kind = "mesh"', 1e-6), ("points = 100", 0.1)):
        scene.write_text(f'[[object]]\nfile = "colored.obj"\nscale = 2\n{kind}\n')
        s = sf.load_scene(scene).surfels
        x, y, _ = s.points.T  # from 0 to 4
        assert s.reflectance[:, 0] == pytest.approx(0.98 * np.minimum(1.0, 1.0 - (y - x) / 4), abs=tolerance)
        scene.write_text(scene.read_text() + "reflectance = 0.25")
        assert np.all(sf.load_scene(scene).surfels.reflectance == 0.25)


@pytest.mark.parametrize("faces", [SQUARE[1], SPLIT[1]])
def test_patch_area_makes_a_grid(faces):
    s = sf.Surfels.from_mesh((SQUARE[0], faces), patch_area=0.01)
    assert len(s) == 400
    assert s.areas == pytest.approx(np.full(400, 0.01))
    assert s.radii == pytest.approx(np.full(400, 0.05 * np.sqrt(2)))
    xs = np.unique(s.points[:, 0].round(9))
    assert xs == pytest.approx(0.05 + 0.1 * np.arange(20))


def test_cells_of_a_long_rectangle_are_near_square():
    s = sf.Surfels.from_mesh(([[0, 0, 0], [6, 0, 0], [6, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.25)
    assert len(s) == 24  # 12 x 2
    assert s.radii == pytest.approx(np.full(24, 0.25 * np.sqrt(2)))


def test_a_triangle_becomes_k_squared_congruent_ones():
    corners = np.array([[0, 0, 0], [3, 0, 1], [1, 2, 0]], float)
    area = 0.5 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    s = sf.Surfels.from_mesh((corners, [[0, 1, 2]]), patch_area=area / 20)
    assert len(s) == 25
    assert s.areas == pytest.approx(np.full(25, area / 25))
    assert s.normals == pytest.approx(np.tile(s.normals[0], (25, 1)))
    # A linear function's mean over the triangle is its value at the centroid: the pieces cover it once.
    assert np.average(s.points, axis=0, weights=s.areas) == pytest.approx(corners.mean(axis=0))
    moment = sum(np.outer(p, p) * a for p, a in zip(s.points, s.areas, strict=True)) / area
    inner = (corners[:, None, :, None] * corners[None, :, None, :]).sum(axis=(0, 1))
    exact = (inner + sum(np.outer(c, c) for c in corners)) / 12
    assert np.abs(moment - exact).max() < 0.05 * np.abs(exact).max()


@pytest.mark.parametrize("patch_area", [None, 3.0, 0.5, 0.031, 0.002])
def test_patches_cover_a_solid_whatever_their_size(patch_area):
    trimesh = pytest.importorskip("trimesh")
    for mesh in (trimesh.creation.box((1, 2, 3)), trimesh.creation.cylinder(1.0, 2.0, sections=24)):
        s = sf.Surfels.from_mesh(mesh, patch_area)
        assert s.areas.sum() == pytest.approx(mesh.area, rel=1e-9)
        assert vector_area(s) == pytest.approx([0, 0, 0], abs=1e-9)
        # Gauss: a third of the flux of the position through the surface is the volume.
        assert (s.areas * (s.points * s.normals).sum(axis=1)).sum() / 3 == pytest.approx(mesh.volume, rel=1e-9)
        if patch_area is not None:
            assert s.areas.max() <= patch_area * (1 + 1e-9)
        corners = np.linalg.norm(s.triangles - s.points[s.triangle_surfel][:, None], axis=2).max(axis=1)
        assert np.maximum.reduceat(corners, np.searchsorted(s.triangle_surfel, np.arange(len(s)))) == pytest.approx(
            s.radii
        )


def test_cells_of_a_tapered_quad_stay_below_the_limit():
    s = sf.Surfels.from_mesh(([[0, 0, 0], [4, 0, 0], [2.5, 1, 0], [1.5, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.02)
    assert s.areas.max() <= 0.02
    assert s.areas.sum() == pytest.approx(2.5)


def test_polygons_of_many_corners():
    angle = 2 * np.pi * np.arange(7) / 7
    heptagon = np.stack([np.cos(angle), np.sin(angle), np.zeros(7)], axis=1)
    s = sf.Surfels.from_mesh((heptagon, [list(range(7))]))
    assert len(s) == 1
    assert s.areas == pytest.approx([3.5 * np.sin(2 * np.pi / 7)])
    assert s.radii == pytest.approx([1.0])
    assert len(s.triangles) == 5
    cut = sf.Surfels.from_mesh((heptagon, [list(range(7))]), patch_area=0.05)
    assert cut.areas.max() <= 0.05
    assert cut.areas.sum() == pytest.approx(s.areas[0])


def test_polygons_that_are_not_convex_are_covered_once():
    corner = ([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], [[0, 1, 2, 3, 4, 5]])
    for patch_area in (None, 0.01):
        s = sf.Surfels.from_mesh(corner, patch_area)
        assert s.areas.sum() == pytest.approx(3)
        assert (s.normals == [0, 0, 1]).all()
        assert not ((s.points[:, 0] > 1) & (s.points[:, 1] > 1)).any()


def test_a_bent_quad_becomes_its_triangles():
    s = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]], [[0, 1, 2, 3]]))
    assert len(s) == 2


def test_mixed_faces_come_out_in_their_order():
    vertices = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [2, 0, 5],
        [3, 0, 5],
        [2, 1, 5],
        [0, 0, 9],
        [1, 0, 9],
        [1, 1, 9],
        [0, 1, 9],
    ]
    s = sf.Surfels.from_mesh((vertices, [[4, 5, 6], [0, 1, 2, 3], [7, 8, 9, 10]]), reflectance=[0.1, 0.2, 0.3])
    # Three numbers for three faces are one RGB, as for surfels.
    assert s.points[:, 2].tolist() == [5, 0, 9]
    assert (s.reflectance == [0.1, 0.2, 0.3]).all()


def test_degenerate_faces_are_dropped_with_a_warning():
    vertices = [*SQUARE[0], [1, 0, 0]]
    with pytest.warns(UserWarning, match="2 degenerate faces dropped"):
        s = sf.Surfels.from_mesh((vertices, [[0, 1, 2], [0, 1, 4], [0, 2, 3], [3, 3, 1]]))
    assert s.areas.sum() == pytest.approx(4)
    only = pytest.raises(ValueError, match=r"^mesh: wanted faces with an area, got none")
    with pytest.warns(UserWarning, match=r"^mesh: 1 degenerate face dropped"), only:
        sf.Surfels.from_mesh((vertices, [[0, 1, 4]]))


def test_selections_keep_their_triangles():
    s = sf.Surfels.from_mesh(closed_box(), patch_area=0.3)
    side = s[s.normals[:, 2] > 0.5]
    assert (side.triangles[:, :, 2] == 3).all()
    assert side.triangle_surfel.max() == len(side) - 1
    area = 0.5 * np.linalg.norm(np.cross(*np.moveaxis(side.triangles[:, 1:] - side.triangles[:, :1], 1, 0)), axis=1)
    assert np.bincount(side.triangle_surfel, area) == pytest.approx(side.areas)


def test_two_sided_patches_turn_their_triangles_too():
    s = sf.Surfels.from_mesh(SQUARE, patch_area=1.0, two_sided=True)
    e = s.triangles[:, 1:] - s.triangles[:, :1]
    n = np.cross(e[:, 0], e[:, 1])
    assert (np.sign(n[:, 2]) == s.normals[s.triangle_surfel, 2]).all()
    assert sorted(s.normals[:, 2]) == [-1] * 4 + [1] * 4


def test_pyvista_and_trimesh_and_arrays_agree():
    pyvista, trimesh = pytest.importorskip("pyvista"), pytest.importorskip("trimesh")
    cube = pyvista.Cube()
    for mesh in (cube, cube.triangulate(), trimesh.creation.box()):
        s = sf.Surfels.from_mesh(mesh)
        assert len(s) == 6
        assert s.areas == pytest.approx(np.ones(6))
        assert (s.points * s.normals).sum(axis=1) == pytest.approx(np.full(6, 0.5))


def test_patches_far_from_the_origin():
    vertices = np.add(SQUARE[0], [5e6, 4e5, 100])
    s = sf.Surfels.from_mesh((vertices, SPLIT[1]), patch_area=0.01)
    assert len(s) == 400
    assert s.areas.sum() == pytest.approx(4, rel=1e-6)


@pytest.mark.parametrize(
    ("faces", "patch_area"), [(SQUARE[1], 1e-7), (SPLIT[1], 1e-7), ([[0, 1, 2]], 2 / 6325**2 * (1 + 1e-7))]
)
def test_a_tiny_patch_area_is_refused_before_any_memory_is_taken(faces, patch_area):
    # The square, 2 x 2, in cells of 1e-7: sqrt(4e7) = 6324.6, so 6325 x 6325 = 40005625; the triangle likewise.
    with pytest.raises(ValueError, match=r"^patch_area: wanted at most 20000000 patches, got 40005625 with "):
        sf.Surfels.from_mesh((SQUARE[0], faces), patch_area=patch_area)


@pytest.mark.parametrize("patch_area", [1e-300, 5e-324])
def test_the_smallest_patch_areas_overflow_nothing(patch_area):
    pentagon = [[1, 0, 0], [0.3, 0.95, 0], [-0.8, 0.6, 0], [-0.8, -0.6, 0], [0.3, -0.95, 0]]
    for mesh in (SQUARE, (SQUARE[0], [[0, 1, 2]]), (pentagon, [[0, 1, 2, 3, 4]])):
        with pytest.raises(ValueError, match=r"^patch_area: wanted at most 20000000 patches, got (inf|[\d.]+e\+\d+) "):
            sf.Surfels.from_mesh(mesh, patch_area=patch_area)


def test_a_floor_ends_at_the_walls_that_stand_on_it():
    """Its pieces keep its colour and its area."""
    v, f = closed_box()
    corners = np.concatenate([[[-2.3, -2.3, 0], [3, -2.3, 0], [3, 3, 0], [-2.3, 3, 0]], v])
    faces = [[0, 1, 2, 3], *(4 + np.array(f)).tolist()]
    rho = np.linspace(0.2, 0.8, len(faces))
    s = sf.Surfels.from_mesh((corners, faces), reflectance=rho)
    floor = np.isclose(s.reflectance[:, 0], rho[0])
    assert np.all(s.points[floor, 2] == 0)
    assert np.all(s.normals[floor, 2] == 1)
    assert s.areas[floor].sum() == pytest.approx(5.3**2, rel=1e-12)
    assert np.count_nonzero(floor) == 5  # one beneath the box, and one off each of its sides
    below = floor & np.isclose(s.areas, 2.0)
    assert s.points[below] == pytest.approx(np.array([[0.5, 1.0, 0.0]]))
    assert np.array_equal(np.flatnonzero(floor), np.arange(5))  # in the order of the faces
    assert s.areas[5:].tolist() == pytest.approx([6, 6, 3, 3, 2, 2])  # no wall stands on those of the box


def test_corners_at_one_place_have_one_number():
    # Three coordinates of a few values each, so that most places recur; zero has two signs and is one place.
    points = np.random.default_rng(0).choice([-1.0, -0.0, 0.0, 1e-300, 5e6], (500, 3))
    _, expected = np.unique(points + 0.0, axis=0, return_inverse=True)
    np.testing.assert_array_equal(_places(points, None), expected.ravel())
