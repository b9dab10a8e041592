"""Light back on the faces of the mesh that it was solved for."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

# Two triangles that make a square and one beside it, a face without area, a quad 1 above.
VERTICES = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
FACES = [[0, 1, 2], [0, 2, 3], [1, 4, 2], [0, 1, 1], [5, 6, 7, 8]]


@pytest.fixture(scope="module")
def solution():
    with pytest.warns(UserWarning, match="1 degenerate face dropped"):
        mesh = sf.Surfels.from_mesh((VERTICES, FACES), patch_area=0.01)
    assert mesh.faces[100:].tolist() == sorted(mesh.faces[100:])
    assert np.unique(mesh.faces).tolist() == [0, 1, 2, 4]
    ball = shapes.sphere(42).transformed(np.diag([0.1, 0.1, 0.1, 1.0]))
    return sf.solve(sf.Scene([ball, mesh], [sf.PointLight([0.3, 0.6, 2.0], 5.0)]), transport="rays")


def test_every_face_has_the_mean_of_its_patches(solution):
    s = solution.surfels
    mesh = solution._scene.objects[1]
    owner = np.where(solution.objects == 1, np.append(np.zeros(42, int), mesh.faces)[solution.parents], -1)
    for name in ("irradiance", "direct", "radiosity"):
        found = solution.per_face(name, 1)
        assert found.shape == (5, 3)
        values = getattr(solution, name)
        for face in (2, 4):
            of = owner == face
            mean = np.average(values[of], axis=0, weights=s.areas[of])
            np.testing.assert_allclose(found[face], mean, rtol=1e-12)
        of = (owner == 0) | (owner == 1)  # halves of a square
        mean = np.average(values[of], axis=0, weights=s.areas[of])
        np.testing.assert_allclose(found[:2].mean(axis=0), mean, rtol=1e-12)
        assert np.isnan(found[3]).all()
    assert solution.per_face("direct", 1)[4, 0] > solution.per_face("direct", 1)[2, 0]  # above, and in its shadow


def test_faces_go_with_their_patches():
    both = sf.Surfels.from_mesh((VERTICES, FACES[:3]), patch_area=0.1, two_sided=True)
    assert len(both.faces) == len(both)
    half = both[both.points[:, 0] > 0.5]
    np.testing.assert_array_equal(half.faces, both.faces[both.points[:, 0] > 0.5])
    np.testing.assert_array_equal(half.replace(emission=1.0).faces, half.faces)
    np.testing.assert_array_equal(half.transformed(np.eye(4)).faces, half.faces)
    assert shapes.sphere(42).faces is None
    assert sf.concatenate([both, both]).faces is None
    floor = sf.Scene([half], [sf.Environment(1.0)])
    found = sf.solve(floor).per_face()
    np.testing.assert_allclose(found[[0, 1, 2]], np.pi, rtol=1e-3)


def lit_from_a_corner(s):
    return sf.solve(sf.Scene([s], [sf.PointLight([1.8, 0.2, 0.3], 1.0)]), insert=False)


SQUARE = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], float), [[0, 1, 2], [0, 2, 3]]


def test_two_triangles_of_a_square_have_a_mean_each():
    """Coplanar triangles share patches; each had the mean over both, for one in the light and one in the dark."""
    s = sf.Surfels.from_mesh(SQUARE, patch_area=0.002)
    x, y = s.points[:, 0], s.points[:, 1]
    np.testing.assert_array_equal(s.faces, np.where(y <= x + 1e-9, 0, 1))
    solution = lit_from_a_corner(s)
    # Of the square cells on the diagonal each triangle has half.
    share = np.where(np.abs(x - y) < 1e-9, 0.5, x > y)
    by_hand = [np.average(solution.irradiance, axis=0, weights=w) for w in (share, 1.0 - share)]
    np.testing.assert_allclose(solution.per_face(), by_hand, rtol=1e-9)
    assert by_hand[0][0] > 10 * by_hand[1][0]


def test_triangles_of_one_patch_have_its_value():
    solution = lit_from_a_corner(sf.Surfels.from_mesh(SQUARE))
    np.testing.assert_allclose(solution.per_face(), np.tile(solution.irradiance, (2, 1)), rtol=1e-12)
    s = sf.Surfels.from_mesh(SQUARE, 0.002)
    found = lit_from_a_corner(s[s.points[:, 0] - s.points[:, 1] > 0.1]).per_face()
    assert (found[0] > 0.0).all()
    assert np.isnan(found[1]).all()  # none of its patches is there


def test_what_has_no_faces_is_refused(solution, tmp_path):
    with pytest.raises(ValueError, match=r"object: wanted one of Surfels\.from_mesh, but object 0 is not"):
        solution.per_face()
    with pytest.raises(ValueError, match="object: wanted"):
        solution.per_face(object=2)
    with pytest.raises(ValueError, match="name: wanted"):
        solution.per_face("heat", 1)
    solution.save(tmp_path / "a.ply")
    with pytest.raises(ValueError, match="which a file does not hold"):
        sf.load_solution(tmp_path / "a.ply").per_face()
