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
    assert mesh.faces.tolist() == sorted(mesh.faces)
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
        for face in (0, 2, 4):
            of = owner == face
            mean = np.average(values[of], axis=0, weights=s.areas[of])
            np.testing.assert_allclose(found[face], mean, rtol=1e-12)
        np.testing.assert_array_equal(found[1], found[0])  # one square
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
