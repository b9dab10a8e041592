"""Orthographic cameras: sizes of what is known, in pixels; all that shows pictures takes or refuses them."""

import numpy as np
import pytest

import surflux as sf

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]
SIZE = (200, 160)


def from_above(away=5.0, height=3.2):
    """160 pixels for a height of 3.2: 50 are 1."""
    return sf.Camera([0, 0, away], [0, 0, 0], up=(0, 1, 0), height=height)


def solved(*objects):
    return sf.solve(sf.Scene(list(objects), lights=[sf.Environment(1.0)]))


@pytest.fixture(scope="module")
def square():
    return solved(sf.Surfels.from_mesh(SQUARE, patch_area=0.3))


@pytest.fixture(scope="module")
def disk():
    return solved(sf.Surfels([[0.3, 0.2, 0.5]], [[0, 0, 1]], radii=0.8, areas=0.64 * np.pi))


@pytest.mark.parametrize("away", [0.01, 5.0, 2000.0])
def test_a_square_has_its_size_however_far_away(square, away):
    """From (0, 0), the middle of the picture, to (1, 1): 50 columns to the right, 50 rows up."""
    seen = square.render(from_above(away), SIZE, samples=1, layers=True)
    expected = np.zeros((160, 200), bool)
    expected[30:80, 100:150] = True
    np.testing.assert_array_equal(seen["index"] >= 0, expected)
    np.testing.assert_allclose(seen["depth"][expected], away, rtol=1e-6)
    np.testing.assert_allclose(seen["normal"][expected], np.tile([0, 0, 1], (2500, 1)), atol=1e-6)
    np.testing.assert_allclose(seen["radiance"][expected], 0.5, rtol=1e-3)  # rho L under a whole sky


@pytest.mark.filterwarnings("ignore::UserWarning")  # of what lies beneath another sheet
@pytest.mark.parametrize("away", [5.0, 1e4, 1e7])
def test_of_sheets_close_to_each_other_the_nearer_is_seen_however_far_away(away):
    """Over .001 depths of 10 000 are the same in single precision: the lower sheet was drawn instead."""
    lower, upper = (
        sf.Surfels.from_mesh(([[x, y, z] for x, y, _ in SQUARE[0]], SQUARE[1]), 0.05, emission=emission)
        for z, emission in ((0.0, 1.0), (1e-4, 3.0))
    )
    lamp = sf.AreaLight([-1.0, 0.2, 0.6], [0.4, 0, 0], [0, 0.4, 0], 7.0)  # shines up, the nearest of all
    solution = sf.solve(sf.Scene([lower, upper], [lamp]), threads=1)
    seen = solution.render(from_above(away), SIZE, samples=1, layers=["index", "depth", "radiance"])
    inside = np.s_[32:78, 102:148]
    assert (solution.objects[seen["index"][inside]] == 1).all()
    np.testing.assert_allclose(np.pi * seen["radiance"][inside], 3.0, rtol=0.01)
    np.testing.assert_allclose(seen["depth"][inside], away - 1e-4, rtol=1e-6)
    assert np.isinf(seen["depth"][0, 0])
    np.testing.assert_allclose(np.pi * seen["radiance"][55:65, 55:65], 7.0, rtol=1e-5)  # (-1, .2) is (50, 70)


def test_a_square_that_leans_is_as_high_as_its_cosine(square):
    """Seen from 60 degrees over the horizon: rows 50 sin 60 = 43.3, columns 50."""
    leaning = sf.Camera([0.5, 0.5 - 2, 2 * np.sqrt(3)], [0.5, 0.5, 0], height=3.2)
    seen = square.render(leaning, SIZE, samples=1, layers=["index"])["index"] >= 0
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    assert len(columns) == 50
    assert abs(len(rows) - 50 * np.sin(np.radians(60))) <= 1
    assert seen.sum() == len(rows) * len(columns)


def test_a_disk_has_its_size_and_its_place(disk):
    """Around (115, 70), as large as disks are drawn, 1.15 times their radius of .8: 46 pixels.

    Which pixels count of those on the rim, 2 pi 46, is chance: their sum is off by less than a tenth of them.
    """
    seen = disk.render(from_above(), SIZE, samples=1, layers=["index", "depth", "radiance"])
    covered = np.argwhere(seen["index"] == 0)
    assert abs(len(covered) - np.pi * 46**2) < 0.1 * 2 * np.pi * 46
    np.testing.assert_allclose(covered.mean(axis=0) + 0.5, [70, 115], atol=0.1)
    np.testing.assert_allclose(from_above().project([[0.3, 0.2, 0.5]], SIZE), [[115, 70, 4.5]])
    np.testing.assert_allclose(seen["depth"][tuple(covered.T)], 4.5, rtol=1e-6)
    np.testing.assert_allclose(seen["radiance"][tuple(covered.T)], 0.5, rtol=1e-3)


def ball(n=2000):
    k = np.arange(n) + 0.5
    z, phi = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    unit = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], axis=1)
    return sf.Surfels(unit, unit, reflectance=0.5 + 0.4 * unit)


@pytest.mark.filterwarnings("ignore:fov:UserWarning")  # of a camera that is as far away as is said
def test_bent_disks_look_as_a_pinhole_camera_sees_them_from_very_far():
    """At a distance of 1000 radii rays over the ball differ by a thousandth of a radius: by .05 pixels."""
    found = solved(ball())
    direction, height = np.array([0.6, -0.64, 0.48]), 3.2
    far = sf.Camera(1000 * direction, [0, 0, 0], fov=2 * np.degrees(np.arctan(height / 2 / 1000)))
    near = sf.Camera(5 * direction, [0, 0, 0], height=height)
    one, other = (found.render(camera, SIZE, layers=["radiance", "index"]) for camera in (near, far))
    both = (one["index"] >= 0) & (other["index"] >= 0)
    assert np.sum((one["index"] >= 0) != (other["index"] >= 0)) < 2 * np.pi * 50 * 0.2  # of the rim, what .05 can move
    assert np.abs(one["radiance"] - other["radiance"])[both].mean() < 0.002
    assert (one["index"] >= 0).sum() == pytest.approx(np.pi * 50**2, rel=0.01)


def test_backs_are_culled_along_the_rays(square):
    below = sf.Camera([0, 0, -5], [0, 0, 0], up=(0, 1, 0), height=3.2)
    assert (square.render(below, SIZE, layers=["index"])["index"] == -1).all()
    seen = square.render(below, SIZE, samples=1, layers=["index"], culling=False)["index"]
    assert (seen >= 0).sum() == 2500
    # What is behind the eye is not seen.
    behind = sf.Camera([0, 0, -1], [0, 0, -2], up=(0, 1, 0), height=3.2)
    assert (square.render(behind, SIZE, layers=["index"], culling=False)["index"] == -1).all()


def test_plots_and_views_show_the_square_in_its_size(square, tmp_path):
    from PIL import Image

    for show in (lambda **o: square.plot("reflectance", **o), lambda **o: sf.view(square, color="reflectance", **o)):
        path = show(screenshot=tmp_path / "a.png", camera=from_above(height=0.5), size=SIZE)
        image = np.asarray(Image.open(path).convert("RGB")).astype(int)
        # All of the upper right quarter, of which half a unit is 160 pixels: the background is white.
        assert image[5:75, 105:195].max() < 250
    path = square.plot("reflectance", screenshot=tmp_path / "a.png", camera=from_above(), size=SIZE)
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    shown = np.argwhere(image.max(axis=2) < 250)
    assert np.abs(shown.min(axis=0) - [30, 100]).max() <= 1
    assert np.abs(shown.max(axis=0) - [79, 149]).max() <= 1


def test_files_keep_it(square, tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        '[[object]]\nshape = "rectangle"\n\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n'
    )
    sf.save_camera(path, from_above())
    assert "height = 3.2" in path.read_text()
    assert sf.load_scene(path).camera == from_above()
    pinhole = sf.Camera([0, -4, 1], [0, 0, 0])
    sf.save_camera(path, pinhole)  # nothing of it is left
    assert "height" not in path.read_text()
    assert sf.load_scene(path).camera == pinhole
    square.camera = from_above()
    assert sf.load_solution(square.save(tmp_path / "a.ply")).camera == from_above()
    square.camera = None


def test_turntables_and_paths_keep_it():
    assert [camera.height for camera in sf.turntable(from_above(), 3, axis=[0, 0, 1])] == [3.2] * 3
    tilted = sf.Camera([0, -5, 2], [0, 0, 0], height=1.2)
    path = sf.camera_path([sf.Camera([0, -5, 1], [0, 0, 0], height=2.2), tilted], 3)
    assert [camera.height for camera in path] == pytest.approx([2.2, 1.7, 1.2])
    with pytest.raises(ValueError, match=r"^cameras: wanted pinhole cameras or orthographic ones, got both"):
        sf.camera_path([sf.Camera([0, -5, 1], [0, 0, 0]), tilted], 3)


def test_fit_has_all_points_in_the_picture():
    points = np.random.default_rng(0).normal(size=(50, 3)) * [1, 5, 2]
    for aspect in (0.5, 4 / 3, 3.0):
        camera = sf.Camera.fit(points, aspect=aspect, orthographic=True)
        size = (round(600 * aspect), 600)
        seen = camera.project(points, size)[:, :2] / size
        assert seen.min() > 0
        assert seen.max() < 1
        assert max(np.abs(2 * seen - 1).max(axis=0)) == pytest.approx(1 / 1.05, rel=0.2)  # the margin, about its middle
        assert (camera.project(points, size)[:, 2] > 0).all()


def test_what_it_says_and_refuses():
    camera = from_above()
    assert repr(camera) == "Camera(eye=[0.0, 0.0, 5.0], target=[0.0, 0.0, 0.0], up=[0.0, 1.0, 0.0], height=3.2)"
    assert sf.Camera(**camera.to_dict()) == camera
    assert camera != sf.Camera(camera.eye, camera.target, camera.up)
    for height in (0, -1, np.inf, "wide"):
        with pytest.raises(ValueError, match=r"^height: wanted"):
            sf.Camera([0, 0, 5], [0, 0, 0], up=(0, 1, 0), height=height)


def test_what_cannot_show_it_says_so(square):
    with pytest.raises(ValueError, match=r"^camera: wanted one without height, for a page"):
        sf.Page(square, camera=from_above())
    floor = sf.Surfels.from_mesh(SQUARE, patch_area=0.3)
    meshless = sf.solve_meshless(sf.Scene([floor], lights=[sf.Environment(1.0)]), levels=2, rays=64)
    with pytest.raises(ValueError, match=r"^camera: wanted one without height, for a meshless basis"):
        meshless.render(from_above(), SIZE)


@pytest.mark.parametrize("parallel", [False, True])
def test_cameras_of_pyvista(parallel):
    import pyvista

    plotter = pyvista.Plotter(off_screen=True)
    plotter.camera.position, plotter.camera.focal_point, plotter.camera.up = (1, -4, 2), (0, 0, 1), (0, 0, 1)
    plotter.camera.view_angle = 40
    if parallel:
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = 1.5
    expected = sf.Camera([1, -4, 2], [0, 0, 1], fov=40, height=3.0 if parallel else None)
    assert sf.Camera.from_pyvista(plotter) == expected
    assert sf.Camera.from_pyvista(plotter.camera) == expected
    plotter.close()
    with pytest.raises(ValueError, match=r"^view: wanted a pyvista.Plotter or its camera, got list"):
        sf.Camera.from_pyvista([])


def test_horizontal_angles_of_pyvista_are_refused():
    import pyvista

    view = pyvista.Camera()
    view.SetUseHorizontalViewAngle(True)
    with pytest.raises(ValueError, match=r"^view: wanted a camera with a vertical angle"):
        sf.Camera.from_pyvista(view)
