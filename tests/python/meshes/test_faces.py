"""Which faces patches lie in, and how much of each, where two coplanar triangles share them."""

import numpy as np
import pytest

import surflux as sf

# A kite, its long diagonal the edge that both triangles have, and a tilted quadrilateral without any symmetry.
QUADS = {
    "kite": [[0, 0, 0], [1, -1, 0], [4, 0, 0], [1, 1, 0]],
    "oblique": [[0, 0, 0], [3, 1, 3], [4, 5, 4], [1, 2, 1]],
}
HALVES = [[0, 1, 2], [0, 2, 3]]
TURN = np.array([[0, -2, 0, 1e3], [2, 0, 0, -5], [0, 0, 2, 3], [0, 0, 0, 1.0]])


def triangle_areas(corners):
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def areas_in_faces(s):
    surfel, face, share = s._faces.shares(s)
    assert (share >= 0.0).all()
    np.testing.assert_allclose(np.bincount(surfel, share), 1.0, rtol=1e-12)
    return np.bincount(face, share * s.areas[surfel], s._faces.count)


def lies_in(point, corners):
    """Whether a point in the plane of a triangle is in it: on the same side of all of its edges."""
    sides = np.cross(np.roll(corners, -1, axis=0) - corners, point - corners)
    return (sides @ np.cross(corners[1] - corners[0], corners[2] - corners[0]) >= 0.0).all()


@pytest.mark.parametrize("patch_area", [None, 0.7, 0.02])
@pytest.mark.parametrize("quad", QUADS)
def test_patches_that_two_triangles_share_add_up_to_the_area_of_each(quad, patch_area):
    vertices = np.array(QUADS[quad], float)
    s = sf.Surfels.from_mesh((vertices, HALVES), patch_area, two_sided=True)
    assert len(s) == 2 or patch_area
    areas = triangle_areas(vertices[HALVES])
    np.testing.assert_allclose(areas_in_faces(s), 2 * areas, rtol=1e-5)
    np.testing.assert_allclose(areas_in_faces(s.transformed(TURN).flipped()), 8 * areas, rtol=1e-5)
    lower = s.points[:, 2].argsort()[: len(s) // 2]
    part = s[lower]
    assert areas_in_faces(part).sum() == pytest.approx(part.areas.sum(), rel=1e-12)


def test_the_face_of_a_patch_is_that_of_its_centre():
    vertices = np.array(QUADS["oblique"], float)
    s = sf.Surfels.from_mesh((vertices, HALVES), 0.02)
    moved = s.transformed(TURN)
    np.testing.assert_array_equal(moved.faces, s.faces)
    assert set(s.faces) == {0, 1}
    assert all(lies_in(p, vertices[HALVES[face]]) for p, face in zip(s.points, s.faces, strict=True))
    wall = sf.Surfels.from_mesh((TURN[:3, 3] + [[-3, 1, -1], [-3, 3, -1], [-3, 3, 9], [-3, 1, 9]], [[0, 1, 2, 3]]))
    cut = sf.divide_patches([moved, wall])[0]
    assert len(cut) > len(s)
    corners = vertices @ TURN[:3, :3].T + TURN[:3, 3]
    assert all(lies_in(p, corners[HALVES[face]]) for p, face in zip(cut.points, cut.faces, strict=True))
    np.testing.assert_allclose(areas_in_faces(cut), areas_in_faces(moved), rtol=1e-9)


def test_faces_of_several_triangles_share_patches_with_those_beside():
    """An L is cut into triangles, of which one makes a quadrilateral with a triangle beside it."""
    outline = [[0, 0, 0], [3, 0, 0], [3, 1, 0], [1, 1, 0], [1, 3, 0], [0, 3, 0], [3, 3, 0]]
    faces = [[0, 1, 2, 3, 4, 5], [3, 2, 4], [2, 6, 4]]
    for patch_area in (None, 0.05):
        s = sf.Surfels.from_mesh((outline, faces), patch_area)
        assert len(s._faces.pairs) > 0
        np.testing.assert_allclose(areas_in_faces(s), [5, 2, 2], rtol=1e-9)


def test_a_quadrilateral_is_one_face():
    whole = sf.Surfels.from_mesh((QUADS["oblique"], [[0, 1, 2, 3]]), 0.02)
    assert areas_in_faces(whole) == pytest.approx([whole.areas.sum()], rel=1e-12)
    assert not whole.faces.any()


def test_a_patch_without_triangles_lies_in_the_face_of_its_centre():
    s = sf.Surfels.from_mesh((QUADS["kite"], HALVES), 0.1)
    disks = sf.Surfels(s.points, s.normals, radii=s.radii)
    surfel, face, share = s._faces.shares(disks)
    np.testing.assert_array_equal(face, s.faces[surfel])
    assert (share == 1.0).all()
