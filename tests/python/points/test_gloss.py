"""Specular reflectance and exponents of Surfels: through everything that makes Surfels of Surfels, and files."""

import copy
import pickle

import numpy as np
import pytest

import surflux as sf

SQUARE = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
K = np.array([[0.1, 0.2, 0.3], [0.4, 0.3, 0.2], [0.0, 0.0, 0.0], [0.25, 0.25, 0.25]])
S = np.array([1.0, 5.5, 20.0, 1000.0])


def shiny(**options):
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    return sf.Surfels(points, [[0, 0, 1]] * 4, radii=0.7, specular=K, exponent=S, **options)


def plain(n=3):
    return sf.Surfels(np.arange(3.0 * n).reshape(n, 3), [[0, 0, 1]] * n, radii=0.7)


def assert_gloss(s, specular, exponent):
    np.testing.assert_array_equal(s.specular, specular)
    np.testing.assert_array_equal(s.exponent, exponent)


def test_none_unless_given():
    assert_gloss(plain(), np.zeros((3, 3)), np.full(3, 20.0))
    assert not plain()._core.has_gloss


def test_every_shape():
    assert_gloss(plain().replace(specular=0.25, exponent=3), np.full((3, 3), 0.25), [3, 3, 3])
    assert_gloss(plain(4).replace(specular=S / 4000, exponent=S), np.repeat(S[:, None] / 4000, 3, axis=1), S)
    assert_gloss(plain(4).replace(specular=[0.1, 0.2, 0.3]), np.tile([0.1, 0.2, 0.3], (4, 1)), np.full(4, 20.0))


def test_read_only_copies():
    s = shiny()
    for array in (s.specular, s.exponent):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


@pytest.mark.parametrize(
    "solver",
    [
        sf.solve,
        sf.solve_meshless,
        lambda scene: sf.precompute_transfer(scene, "sky"),
        lambda scene: sf.precompute_transfer(scene, "local"),
    ],
    ids=["solve", "meshless", "sky", "local"],
)
def test_solvers_say_that_they_leave_it_out(solver):
    mirror = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=1.0, reflectance=0.2, specular=0.7)
    with pytest.warns(UserWarning, match="specular is left out: all that is computed here"):
        solver(sf.Scene([mirror], lights=[sf.Environment(1.0)]))


def test_goes_with_selections_and_copies():
    s = shiny()
    assert_gloss(s[[3, 0]], K[[3, 0]], S[[3, 0]])
    assert_gloss(s[s.exponent > 10], K[2:], S[2:])
    assert not s[2:3]._core.has_gloss  # none of that is specular
    for other in (copy.copy(s), copy.deepcopy(s), pickle.loads(pickle.dumps(s)), s.flipped()):
        assert_gloss(other, K, S)
    assert_gloss(s.transformed(np.diag([2.0, 2, 2, 1])), K, S)
    assert_gloss(shiny(two_sided=True), np.r_[K, K], np.r_[S, S])
    s.areas = 1.0
    assert_gloss(s, K, S)


def test_goes_with_what_is_put_together():
    none, twenty = np.zeros((3, 3)), np.full(3, 20.0)
    assert_gloss(sf.concatenate([plain(), shiny()]), np.r_[none, K], np.r_[twenty, S])
    assert_gloss(sf.concatenate([shiny(), plain(), shiny()]), np.r_[K, none, K], np.r_[S, twenty, S])
    wide = plain().replace(exponent=2.0)  # no specular part, and an exponent that is kept all the same
    assert_gloss(sf.concatenate([plain(), wide]), np.zeros((6, 3)), np.r_[twenty, [2, 2, 2]])
    scene = sf.Scene([plain(), shiny()])
    assert_gloss(scene.surfels, np.r_[none, K], np.r_[twenty, S])


def test_thinned_keeps_it():
    rng = np.random.default_rng(0)
    p = np.c_[rng.random((200, 2)), np.zeros(200)]
    s = sf.Surfels(p, [[0, 0, 1]] * 200, radii=0.1, specular=0.3 * p[:, :1] * [1, 1, 1], exponent=1 + 100 * p[:, 1])
    few = s.thinned(50)
    assert_gloss(few, 0.3 * few.points[:, :1] * [1, 1, 1], 1 + 100 * few.points[:, 1])


def test_replace_changes_one_and_keeps_the_others():
    s = shiny()
    assert_gloss(s.replace(exponent=7), K, np.full(4, 7.0))
    assert_gloss(s.replace(specular=0.3), np.full((4, 3), 0.3), S)
    assert_gloss(s.replace(specular=0.0), np.zeros((4, 3)), S)
    assert_gloss(s.replace(reflectance=0.1), K, S)
    assert not s.replace(specular=0.0, exponent=20.0)._core.has_gloss


def test_no_surfel_reflects_more_than_it_gets():
    said = r"^specular: wanted reflectance \+ specular below 1 in every channel, got "
    with pytest.raises(ValueError, match=said + r"1 at index \(0, 0\)$"):
        sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, reflectance=0.5, specular=0.5)
    with pytest.raises(ValueError, match=said + r"1\.05 at index \(1, 0\)$"):
        shiny().replace(reflectance=[[0.65] * 3] * 4)
    with pytest.raises(ValueError, match=said):
        plain().replace(specular=[0.1, 0.1, 0.6])
    with pytest.raises(ValueError, match=said):
        sf.Surfels.from_mesh(SQUARE, specular=0.6)
    with pytest.raises(ValueError, match=said):
        sf.Surfels.sample_mesh(SQUARE, 10, specular=0.6)


def test_of_meshes_by_face():
    mesh = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 2, 3], [0, 4, 1]])
    s = sf.Surfels.from_mesh(mesh, patch_area=0.1, specular=[0.1, 0.1, 0.3], exponent=[4, 4, 9.0])
    side = np.abs(s.normals[:, 1]) > 0.5
    assert_gloss(s, np.tile([0.1, 0.1, 0.3], (len(s), 1)), np.where(side, 9.0, 4.0))
    # Coplanar triangles of different exponents are two patches; of one, a quadrilateral.
    counts = [len(sf.Surfels.from_mesh((mesh[0], mesh[1][:2]), specular=0.1, exponent=e)) for e in (3.0, [3.0, 4.0])]
    assert counts == [1, 2]
    both = sf.Surfels.from_mesh(SQUARE, specular=0.2, exponent=8, two_sided=True)
    assert_gloss(both, np.full((2, 3), 0.2), [8, 8])
    assert_gloss(sf.Surfels.sample_mesh(SQUARE, 20, specular=0.2, exponent=8), np.full((20, 3), 0.2), np.full(20, 8.0))


def test_patches_cut_at_walls_keep_it():
    floor = sf.Surfels.from_mesh(
        ([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]], [[0, 1, 2, 3]]), specular=0.2, exponent=8
    )
    wall = sf.Surfels.from_mesh(([[1, 0, 0], [1, 3, 0], [1, 3, 2], [1, 0, 2]], [[0, 1, 2, 3]]))
    floor, wall = sf.divide_patches([floor, wall])
    assert_gloss(floor, np.full((2, 3), 0.2), [8, 8])
    assert not wall._core.has_gloss


def test_survives_files(tmp_path):
    back = sf.read(shiny().save(tmp_path / "shiny.ply"))
    np.testing.assert_array_equal(back.specular, K.astype(np.float32))
    np.testing.assert_array_equal(back.exponent, S)
    assert b"specular" not in plain().save(tmp_path / "plain.ply").read_bytes()


def test_what_reflects_nearly_all_survives_rounding(tmp_path):
    near = np.array([0.3, 0.7, 0.1])
    s = plain().replace(reflectance=near, specular=np.nextafter(1.0, 0.0) - near - 1e-16)
    back = sf.read(s.save(tmp_path / "near.ply"))
    np.testing.assert_allclose(back.reflectance + back.specular, 1.0, atol=2e-7)


@pytest.mark.parametrize(
    ("column", "said"),
    [("specular_g", "vertex 0: specular is -1; wanted"), ("exponent", "vertex 0: exponent is -1; wanted")],
)
def test_files_with_what_cannot_be(tmp_path, column, said):
    names = ["x", "y", "z", "nx", "ny", "nz", "radius", "specular_r", "specular_g", "specular_b", "exponent"]
    values = dict.fromkeys(names, "0") | {"nz": "1", "radius": "1", "exponent": "2", column: "-1"}
    path = tmp_path / "bad.ply"
    header = ["ply", "format ascii 1.0", "element vertex 1", *(f"property float {n}" for n in names), "end_header"]
    path.write_text("\n".join([*header, " ".join(values[n] for n in names), ""]))
    with pytest.raises(sf.FileError, match=said):
        sf.read(path)


def test_files_that_reflect_more_than_all(tmp_path):
    names = ["x", "y", "z", "nx", "ny", "nz", "radius", "specular_r", "specular_g", "specular_b"]
    path = tmp_path / "bright.ply"
    header = ["ply", "format ascii 1.0", "element vertex 1", *(f"property float {n}" for n in names), "end_header"]
    path.write_text("\n".join([*header, "0 0 0 0 0 1 1 .6 .6 .6", ""]))
    with pytest.raises(sf.FileError, match=r"specular: wanted reflectance \+ specular below 1"):
        sf.read(path)
    np.testing.assert_allclose(sf.read(path, reflectance=0.1).specular, 0.6, rtol=1e-6)


def test_an_exponent_without_specular_is_some_other_column(tmp_path):
    path = tmp_path / "other.ply"
    names = ["x", "y", "z", "nx", "ny", "nz", "radius", "exponent"]
    header = ["ply", "format ascii 1.0", "element vertex 1", *(f"property float {n}" for n in names), "end_header"]
    path.write_text("\n".join([*header, "0 0 0 0 0 1 1 -5", ""]))
    assert not sf.read(path)._core.has_gloss


def test_solutions_keep_it(tmp_path):
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.1, specular=0.2, exponent=8)
    solution = sf.solve(sf.Scene([floor], [sf.PointLight([0.5, 0.5, 0.3], 1.0)]))
    n = len(solution.surfels)
    assert_gloss(solution.surfels, np.full((n, 3), 0.2), np.full(n, 8.0))
    back = sf.load_solution(solution.save(tmp_path / "solved.ply")).surfels
    np.testing.assert_allclose(back.specular, 0.2, rtol=1e-7)
    np.testing.assert_array_equal(back.exponent, 8.0)


def test_scene_files_say_it(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text('[[object]]\nshape = "rectangle"\nspecular = [0.1, 0.2, 0.3]\nexponent = 50\n')
    s = sf.load_scene(path).surfels
    assert_gloss(s, np.tile([0.1, 0.2, 0.3], (len(s), 1)), np.full(len(s), 50.0))
    path.write_text('[[object]]\nshape = "rectangle"\nspecular = 0.6\n')
    with pytest.raises(
        sf.FileError, match=r"specular.*wanted reflectance \+ specular below 1 in every channel, got 1\.1"
    ):
        sf.load_scene(path)
    path.write_text('[[object]]\nshape = "rectangle"\nexponent = -1\n')
    with pytest.raises(sf.FileError, match=r"exponent.*wanted values at least 0, got -1"):
        sf.load_scene(path)
