"""Point files as surfels: what the file says, what is estimated, what the arguments say."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

import surflux as sf
from ply_samples import write
from surflux.scenes import shapes


def sphere(n, center=(0.0, 0.0, 0.0)):
    """Unit normals and points of a Fibonacci sphere of radius 1."""
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(n)
    normals = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
    return normals, normals + center


def cloud_file(path, points, normals=None, more="", values=()):
    columns = [points] if normals is None else [points, normals]
    header = f"vertex {len(points)}: double x y z" + (", double nx ny nz" if normals is not None else "") + more
    rows = np.hstack([*columns, *values]) if len(values) else np.hstack(columns)
    return write(path, [header], [" ".join(map(repr, row.tolist())) for row in rows])


def test_surfels_with_patches_come_back(tmp_path):
    box = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]], [[0, 1, 2], [0, 2, 3]]
    s = sf.Surfels.from_mesh(box, 0.1, reflectance=[0.1, 0.5, 0.9], emission=2.0)
    s.save(tmp_path / "a.ply")
    back = sf.read(tmp_path / "a.ply")
    for name in ("points", "radii", "areas", "triangles", "triangle_surfel"):
        np.testing.assert_array_equal(getattr(back, name), getattr(s, name))
    for name in ("normals", "reflectance", "emission"):
        np.testing.assert_allclose(getattr(back, name), getattr(s, name), atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(back.normals, axis=1), 1.0, rtol=1e-15)


def test_surfels_without_areas_come_back_without(tmp_path):
    normals, points = sphere(50)
    s = sf.Surfels(np.add(points, [5e6, 0.0, 0.0]), normals)
    s.save(tmp_path / "a.ply")
    back = sf.read(tmp_path / "a.ply")
    np.testing.assert_array_equal(back.points, s.points)
    assert back.areas is None


def test_arguments_win_over_the_file(tmp_path):
    normals, points = sphere(20)
    sf.Surfels(points, normals, reflectance=0.2, emission=[1.0, 2.0, 3.0]).save(tmp_path / "a.ply")
    kept = sf.read(tmp_path / "a.ply")
    np.testing.assert_allclose(kept.reflectance, 0.2, rtol=1e-7)
    np.testing.assert_array_equal(kept.emission, [[1.0, 2.0, 3.0]] * 20)
    changed = sf.read(tmp_path / "a.ply", reflectance=[0.7, 0.6, 0.5], emission=4.0)
    np.testing.assert_array_equal(changed.reflectance, [[0.7, 0.6, 0.5]] * 20)
    np.testing.assert_array_equal(changed.emission, [[4.0] * 3] * 20)


def test_a_file_of_positions_gets_the_defaults(tmp_path):
    _, points = sphere(200)
    s = sf.read(cloud_file(tmp_path / "a.ply", points))
    np.testing.assert_array_equal(s.points, points)
    np.testing.assert_array_equal(s.reflectance, 0.5)
    np.testing.assert_array_equal(s.emission, 0.0)
    assert np.all(np.sum(s.normals * points, axis=1) > 0.9)
    inward = sf.read(tmp_path / "a.ply", viewpoint=[0.0, 0.0, 0.0])
    assert np.all(np.sum(inward.normals * points, axis=1) < -0.9)


def test_bad_normals_are_estimated_and_turn_like_their_neighbours(tmp_path):
    # Two spheres, one of them seen from inside: an estimate alone could not know.
    normals, points = sphere(300)
    normals = np.vstack([normals, -normals])
    points = np.vstack([points, np.add(points, [10.0, 0.0, 0.0])])
    truth = normals.copy()
    normals[::7] = 0.0
    normals[1::50] = np.nan
    bad = len(np.union1d(np.arange(600)[::7], np.arange(600)[1::50]))
    path = cloud_file(tmp_path / "a.ply", points, normals)
    with pytest.warns(UserWarning, match=rf"a\.ply: {bad} of 600 normals are zero or not finite and were estimated"):
        s = sf.read(path)
    given = np.isfinite(normals[:, 0]) & np.any(normals, axis=1)
    np.testing.assert_allclose(s.normals[given], truth[given], rtol=1e-12)
    assert np.all(np.sum(s.normals * truth, axis=1) > 0.9)


def ball_with_bad_normals(path, given, bad):
    """The file of 3000 points on a ball; given makes normals of them, of which one in a hundred is bad."""
    points = np.random.default_rng(0).normal(size=(3000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    normals = given(points).copy()
    normals[::100] = bad
    return cloud_file(path, points, normals)


@pytest.mark.parametrize("bad", [0.0, np.nan])
def test_a_bad_normal_keeps_no_other_from_being_turned_over(tmp_path, bad):
    path = ball_with_bad_normals(tmp_path / "a.ply", lambda d: np.where(d[:, 2:] > 0.5, -d, d), bad)
    with pytest.warns(UserWarning, match="30 of 3000 normals"):
        s = sf.read(path, orient=True)
    border = np.abs(s.points[:, 2] - 0.5) < 0.13  # of the cap that faced inwards: points lie .065 apart
    assert np.all(np.sum(s.normals * s.points, axis=1)[~border] > 0.9)


def test_bad_normals_face_the_viewpoint_and_the_others_the_side_that_is_seen(tmp_path):
    path = ball_with_bad_normals(tmp_path / "a.ply", np.negative, np.nan)
    outside, inside = np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 0.5])
    with pytest.warns(UserWarning, match="30 of 3000 normals"):
        body = sf.read(path, orient=True, viewpoint=outside)
    assert np.all(np.sum(body.normals * (outside - body.points), axis=1)[::100] > 0.0)
    others = np.arange(3000) % 100 > 0
    assert np.all(np.sum(body.normals * body.points, axis=1)[others] > 0.9)
    path = ball_with_bad_normals(tmp_path / "b.ply", np.positive, np.nan)
    with pytest.warns(UserWarning, match="30 of 3000 normals"):
        room = sf.read(path, orient=True, viewpoint=inside)
    assert np.all(np.sum(room.normals * room.points, axis=1) < -0.9)


def test_normals_that_are_all_zero_count_as_missing(tmp_path):
    _, points = sphere(200)
    path = cloud_file(tmp_path / "a.ply", points, np.zeros((200, 3)))
    with pytest.warns(UserWarning, match="200 of 200 normals"):
        s = sf.read(path)
    assert np.all(np.sum(s.normals * points, axis=1) > 0.9)


def test_what_cannot_be_estimated_is_the_files_fault(tmp_path):
    path = write(tmp_path / "a.ply", ["vertex 1: float x y z"], ["0 0 0"])
    with pytest.raises(sf.FileError, match=r"a\.ply: normals: wanted \(n, 3\), since a plane cannot be fitted"):
        sf.read(path)
    path = write(tmp_path / "b.ply", ["vertex 1: float x y z nx ny nz"], ["0 0 0 0 0 1"])
    with pytest.raises(sf.FileError, match=r"b\.ply: radii: must be given for a single point"):
        sf.read(path)


def test_wrong_arguments_are_the_callers_fault(tmp_path):
    _, points = sphere(20)
    path = cloud_file(tmp_path / "a.ply", points)
    for argument, value in (("reflectance", 1.0), ("emission", -1.0), ("viewpoint", [0, 0])):
        with pytest.raises(ValueError, match=f"^{argument}: wanted"):
            sf.read(path, **{argument: value})


def test_faces_are_not_left_out_without_a_word(tmp_path):
    vertices, faces, _ = shapes.box(patches=2)
    trimesh.Trimesh(vertices, faces[:, :3], process=False).export(tmp_path / "a.ply")
    with pytest.warns(UserWarning, match=rf"a\.ply: has {len(faces)} faces, left out.*Surfels\.from_mesh") as said:
        assert len(sf.read(tmp_path / "a.ply")) == len(vertices)
    assert [Path(w.filename).name for w in said] == [Path(__file__).name]
    scene = '[[object]]\nfile = "a.ply"\n{}[[light]]\ntype = "environment"\nradiance = 1\n'
    (tmp_path / "a.toml").write_text(scene.format(""))
    with pytest.warns(UserWarning, match="faces, left out"):
        sf.load_scene(tmp_path / "a.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (tmp_path / "a.toml").write_text(scene.format('kind = "surfels"\n'))  # it is meant
        sf.load_scene(tmp_path / "a.toml")
        sf.Surfels.from_mesh(tmp_path / "a.ply").save(tmp_path / "b.ply")  # patches come back
        assert len(sf.read(tmp_path / "b.ply").triangles) == len(faces)


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("a.stl", r"surflux\.Surfels\.from_mesh reads it as a mesh \(kind = \"mesh\" in a scene file\)"),
        ("a.GLB", r"surflux\.Surfels\.from_mesh reads it as a mesh"),
        ("a.toml", r"surflux\.load_scene reads it as a scene"),
        ("a.npy", r"numpy\.savez\('a\.npz', points=array\[:, :3\]\) writes one with names"),
        ("a.rcp", r"PDAL \(pdal translate .*a\.rcp a\.laz\) and CloudCompare turn most others into these"),
    ],
)
def test_other_formats_say_what_reads_or_converts_them(tmp_path, name, hint):
    (tmp_path / name).write_bytes(b"junk")
    wanted = rf"{name}: format .* cannot be read as points; supported now: ply, pcd, las, laz, e57, npz, xyz.*\. {hint}"
    with pytest.raises(sf.FileError, match=wanted):
        sf.read(tmp_path / name)


@pytest.mark.parametrize("name", ["a.npy", "a.npz", "a"])
def test_an_array_of_numpy_says_what_it_lacks(tmp_path, name):
    with open(tmp_path / name, "wb") as file:
        np.save(file, np.zeros((9, 3)))
    wanted = (
        rf"{name}: one array of numpy, without a name, cannot be read as points; supported now: ply, .*npz, .*\.savez"
    )
    with pytest.raises(sf.FileError, match=wanted):
        sf.read_scan(tmp_path / name)


@pytest.mark.parametrize("call", [sf.read, sf.Surfels.from_mesh, sf.load_solution, sf.read_image])
@pytest.mark.parametrize("suffix", ["", ".ply", ".obj", ".png"])
def test_folders_are_told_from_files(tmp_path, call, suffix):
    folder = tmp_path / f"scans{suffix}"
    folder.mkdir()
    wrong_suffix = call is sf.read_image and suffix != ".png"
    with pytest.raises(sf.FileError, match="unknown image format" if wrong_suffix else "is a folder, not a file"):
        call(folder)


def test_points_alone_are_no_mesh_and_say_what_reads_them(tmp_path):
    shapes.sphere(50).save(tmp_path / "a.ply")
    with pytest.raises(
        sf.FileError, match=r"a\.ply: faces: wanted at least one, got none; surflux\.read takes its 50 points"
    ):
        sf.Surfels.from_mesh(tmp_path / "a.ply")


@pytest.mark.parametrize("values", [200, [200, 100, 50], np.full((2, 3), 255, np.uint8)])
def test_reflectance_in_bytes_is_told(values):
    points = [[0, 0, 0], [1, 0, 0]]
    with pytest.raises(ValueError, match=r"reflectance: wanted values in \[0, 1\), got .*8-bit values .* 0\.98 / 255"):
        sf.Surfels(points, [[0, 0, 1]] * 2, radii=1.0, reflectance=values)
    sf.Surfels(points, [[0, 0, 1]] * 2, radii=1.0, reflectance=np.asarray(values) * 0.98 / 255)
    with pytest.raises(ValueError, match=r"^reflectance: wanted values in \[0, 1\), got 1\.2( at index 0)?$"):
        sf.Surfels(points, [[0, 0, 1]] * 2, radii=1.0, reflectance=1.2)
    with pytest.raises(ValueError, match=r"got 1 at index 0$"):  # a mirror is none
        sf.Surfels(points, [[0, 0, 1]] * 2, radii=1.0, reflectance=1.0)
