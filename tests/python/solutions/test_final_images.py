"""Pictures of solved scenes: against ray casting, layer by layer, and as files."""

import signal
import threading

import numpy as np
import pytest

import surflux as sf
from surflux import _image
from surflux.bench import scenes
from surflux.bench.ray_casting import psnr, ray_cast
from surflux.pictures.images import resolved_exposure


@pytest.mark.parametrize("name", ["three_spheres", "statues", "cornell"])
@pytest.mark.slow
def test_splats_agree_with_ray_casting(name):
    """At least 35 dB where the solution is cast through Embree: no OpenGL, no splats, another interpolation."""
    scene = sf.load_scene(scenes.data_folder() / f"{name}.toml")
    solution = sf.solve(scene, **scene.solve_options)
    exact, white = ray_cast(solution, scene.camera, (160, 120), 2)
    assert np.mean((exact > 0.02 * white) & (exact < white)) > 0.3
    assert psnr(solution.render(size=(160, 120), samples=2), exact, white) > 35


@pytest.mark.parametrize("options", [{}, {"direct": "traced"}])
@pytest.mark.parametrize("height", [None, 3.0])
def test_a_picture_of_backs_alone_says_so(solution, options, height, recwarn):
    below = sf.Camera([0.0, 0.1, -4.0], [0.0, 0.0, 0.0], height=height)
    floor = sf.solve(sf.Scene([solution.surfels[solution.surfels.points[:, 2] == 0.0]], lights=[sf.Environment(1.0)]))
    assert not floor.render(below, (20, 20), **options).any()
    (said,) = recwarn
    assert str(said.message).startswith(f"the picture is empty: all of the {len(floor.surfels)} surfels in it show the")
    recwarn.clear()
    assert floor.render(below, (20, 20), culling=False, **options).any()
    away = sf.Camera([0.0, 0.1, -4.0], [0.0, 0.0, -8.0])  # sees none of them
    assert not floor.render(away, (20, 20), **options).any()
    assert len(recwarn) == 0


@pytest.fixture(scope="module")
def solution():
    floor = sf.Surfels.from_mesh(
        ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.04, reflectance=[0.8, 0.4, 0.2]
    )
    n = 600
    z = 1 - (2 * np.arange(n) + 1) / n
    phi = np.arange(n) * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z * z)
    normals = np.stack([r * np.cos(phi), r * np.sin(phi), z], 1)
    ball = sf.Surfels([0, 0, 0.4] + 0.4 * normals, normals=normals, reflectance=0.5)
    lamp = sf.AreaLight([-0.2, -0.2, 1.5], [0, 0.4, 0], [0.4, 0, 0], 20.0)
    camera = sf.Camera([0, -2.6, 0.9], [0, 0, 0.5], fov=45)
    return sf.solve(sf.Scene([floor, ball], lights=[lamp], camera=camera))


SIZE = (120, 90)


@pytest.fixture(scope="module")
def layers(solution):
    return solution.render(size=SIZE, layers=True)


def test_albedo_is_the_reflectance_seen(solution, layers):
    seen = layers["index"] >= 0
    inside = seen.copy()
    for axis in (0, 1):
        for step in (-2, -1, 1, 2):
            shifted = np.roll(layers["index"], step, axis)
            on_ball = (shifted >= 0) & (solution.objects[np.maximum(shifted, 0)] == 1)
            inside &= (shifted >= 0) & (on_ball == (seen & (solution.objects[np.maximum(layers["index"], 0)] == 1)))
    assert inside.mean() > 0.15
    np.testing.assert_allclose(
        layers["albedo"][inside], solution.surfels.reflectance[layers["index"][inside]], rtol=1e-5
    )
    nothing = ~seen & (layers["index"] == np.roll(layers["index"], 3, 1))
    assert layers["albedo"][nothing].max() <= 0.8


def test_normals_follow_the_ball_and_not_its_disks(solution, layers):
    index, normal = layers["index"], layers["normal"]
    ball = (index >= 0) & (solution.objects[np.maximum(index, 0)] == 1)
    camera = solution.camera
    right, down, forward = camera._axes()
    tan = np.tan(np.radians(camera.fov) / 2)
    # The middle subpixel of two is the one below and right of the middle: a quarter of a pixel farther.
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.75, np.arange(SIZE[1]) + 0.75)
    ways = (
        forward + (2 * x / SIZE[0] - 1)[..., None] * tan * 4 / 3 * right + (2 * y / SIZE[1] - 1)[..., None] * tan * down
    )
    places = camera.eye + layers["depth"][ball][:, None] * ways[ball]
    exact = (places - [0, 0, 0.4]) / 0.4
    assert np.abs(np.linalg.norm(exact, axis=1) - 1).max() < 0.01
    turned = np.degrees(np.arccos(np.clip(np.sum(exact * normal[ball], axis=1), -1, 1)))
    assert np.median(turned) < 0.5
    assert turned.max() < 5  # half the distance of two surfels is 4 degrees
    floor = (index >= 0) & ~ball
    np.testing.assert_allclose(normal[floor], np.tile([0, 0, 1], (floor.sum(), 1)), atol=1e-6)


def test_level_is_that_of_the_surfel_seen(solution, layers):
    seen = layers["index"] >= 0
    np.testing.assert_array_equal(layers["level"][seen], solution.levels[layers["index"][seen]])
    assert np.isnan(layers["level"][~seen]).all()
    # Every insertion halves a radius: what was inserted is told by its depth.
    count = np.bincount(solution.parents)[solution.parents]
    assert np.array_equal(solution.levels < 0, count > 1)
    assert (count > 1).any()


def test_levels_of_groups_come_with_rays(solution):
    x, y = (v.ravel() for v in np.meshgrid(*2 * [np.linspace(0, 1, 60)]))
    flat = sf.Surfels(np.stack([x, y, 0 * x], 1), normals=np.tile([0, 0, 1.0], (3600, 1)))
    by_rays = sf.solve(sf.Scene([flat], [sf.Environment(1.0)]), transport="rays", insert=False)
    assert by_rays.levels.max() >= 1
    assert by_rays.levels.min() >= 0
    assert not np.any(sf.solve(solution._scene, transport="pairs", insert=False).levels)


def test_levels_survive_a_file(solution, tmp_path):
    solution.save(tmp_path / "a.ply")
    assert np.array_equal(sf.load_solution(tmp_path / "a.ply").levels, solution.levels)
    data = (tmp_path / "a.ply").read_bytes()
    (tmp_path / "old.ply").write_bytes(data.replace(b" level\n", b" other\n"))
    old = sf.load_solution(tmp_path / "old.ply").levels
    assert np.mean(old == np.minimum(solution.levels, 0)) > 0.9  # told by areas, then


def test_some_layers_alone(solution, layers):
    some = solution.render(size=SIZE, layers=["depth", "albedo"])
    assert list(some) == ["depth", "albedo"]
    for name, values in some.items():
        np.testing.assert_array_equal(values, layers[name])
    assert solution.render(size=SIZE, layers=[]) == {}


def test_a_file_of_all_layers(layers, tmp_path):
    path = tmp_path / "all.exr"
    sf.write_image(path, layers)
    names, _ = _image.read_image(str(path))
    three = ["", "direct.", "indirect.", "albedo."]
    assert sorted(names) == sorted(
        [*(p + c for p in three for c in "RGB"), "N.X", "N.Y", "N.Z", "Z", "alpha", "index", "level"]
    )
    np.testing.assert_array_equal(sf.read_image(path), layers["radiance"])
    for name, values in layers.items():
        if name != "radiance":
            np.testing.assert_array_equal(sf.read_image(path, name), values)
    # Other formats show the radiance.
    sf.write_image(tmp_path / "a.png", layers, exposure=0.3)
    sf.write_image(tmp_path / "b.png", layers["radiance"], exposure=0.3)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with pytest.raises(ValueError, match=r"^image: wanted a layer 'radiance' among 'depth'"):
        sf.write_image(path, {"depth": layers["depth"]})


def test_an_index_beyond_floats_is_refused(tmp_path):
    index = np.full((2, 2), 2**24 + 1)
    with pytest.raises(ValueError, match=r"^index: wanted whole numbers up to 2\^24"):
        sf.write_image(tmp_path / "a.exr", np.zeros((2, 2, 3)), index=index)


def test_tone_of_png_files(layers, tmp_path):
    image = layers["radiance"]
    auto = resolved_exposure(None, image)
    for given, same in [
        ({"exposure": "auto"}, {"exposure": auto}),
        ({"stops": 1.0}, {"exposure": 2 * auto}),
        ({"exposure": 0.2, "stops": -2.0}, {"exposure": 0.05}),
        ({"exposure": 0.2, "filmic": False}, {"exposure": 0.2, "filmic": False}),
    ]:
        sf.write_image(tmp_path / "a.png", image, **given)
        shown = sf.tone_map(sf.read_image(tmp_path / "a.png"), exposure=1.0, filmic=False)
        np.testing.assert_allclose(shown, sf.tone_map(image, **same), atol=0.5 / 255 + 1e-3)
        np.testing.assert_array_equal(sf.tone_map(image, **given), sf.tone_map(image, **same))
    for name, value in [("stops", 1.0), ("filmic", False), ("exposure", 2.0)]:
        with pytest.raises(ValueError, match=rf"^{name}: a \.exr file holds radiance itself"):
            sf.write_image(tmp_path / "a.exr", image, **{name: value})
    for name, value in [("stops", np.nan), ("stops", "two"), ("filmic", 1), ("exposure", "bright")]:
        with pytest.raises(ValueError, match=rf"^{name}: wanted"):
            sf.write_image(tmp_path / "a.png", image, **{name: value})


def test_surfaces_from_behind(solution):
    below = sf.Camera([0.5, 0.5, -3], [0, 0, 0], up=(0, 1, 0))
    front = solution.render(below, (40, 30), layers=["radiance", "index"])
    both = solution.render(below, (40, 30), culling=False, layers=["radiance", "normal", "index"])
    floor = (both["index"] >= 0) & (solution.objects[np.maximum(both["index"], 0)] == 0)
    assert floor.mean() > 0.2
    assert not ((front["index"] >= 0) & (solution.objects[np.maximum(front["index"], 0)] == 0)).any()
    np.testing.assert_allclose(both["normal"][floor], np.tile([0, 0, -1], (floor.sum(), 1)), atol=1e-6)
    assert np.median(both["radiance"][floor]) > 0.003


def test_progress_and_cancelling(solution):
    seen = []
    solution.render(size=(400, 300), samples=4, progress=lambda done, total: seen.append((done, total)) or True)
    assert seen[0] == (0, 300)
    assert seen[-1] == (300, 300)
    assert len(seen) >= 3
    with pytest.raises(sf.Cancelled):
        solution.render(size=(40, 30), progress=lambda done, total: False)


def test_ctrl_c_stops_a_picture(solution):
    """Progress is asked on the thread that called, where signals arrive."""
    main = threading.get_ident()
    asked = []
    solution.render(
        size=(400, 300), samples=4, progress=lambda done, total: asked.append(threading.get_ident()) or True
    )
    assert set(asked) == {main}
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        solution.render(size=(4000, 3000), samples=4)
    timer.join()


def test_a_meshless_picture_is_drawn_in_bands(solution, monkeypatch):
    from surflux.solutions import subpixels

    meshless = sf.solve_meshless(solution._scene, levels=3, rays=64)
    whole = meshless.render(size=(48, 36), layers=True)
    monkeypatch.setattr(subpixels, "SUBPIXELS_AT_ONCE", 48 * 4 * 10)
    seen = []
    bands = meshless.render(size=(48, 36), layers=True, progress=lambda done, total: seen.append((done, total)) or True)
    assert seen == [(0, 36), (10, 36), (20, 36), (30, 36), (36, 36)]
    for name in ("radiance", "direct", "indirect", "albedo"):
        different = np.abs(bands[name] - whole[name]) > 1e-3 * whole[name].max()
        assert different.mean() < 0.005, name
    assert np.mean(bands["index"] != whole["index"]) < 0.005
    with pytest.raises(sf.Cancelled):
        meshless.render(size=(48, 36), progress=lambda done, total: done < 10)
    # Levels are those of the basis at the very place.
    there = whole["index"] >= 0
    found, finest = np.unique(whole["level"][there]), meshless._field.basis.functions()["levels"].max()
    assert len(found) > 1
    assert found.max() <= finest
    assert np.isnan(whole["level"][~there]).all()
    # Surfels with light of their own are one finer than all of it.
    by_surfel = meshless.levels[whole["index"][there]]
    assert np.mean(by_surfel <= finest) > 0.1
    assert np.mean((whole["level"][there] == by_surfel)[by_surfel <= finest]) > 0.5


def test_an_eye_on_a_surfel_sees_the_others_blended():
    grid = np.array([[x, y, 0.0] for x in range(12) for y in range(12)])
    reflectance = np.random.default_rng(0).uniform(0.1, 0.9, 145)
    surfels = sf.Surfels(
        np.concatenate([grid, [[5, -3, 2]]]), [[0, 0, 1]] * 145, radii=0.8, areas=1.0, reflectance=reflectance
    )
    on, without = (
        sf.solve(sf.Scene([part], lights=[sf.DirectionalLight([0, 0, -1], 1.0)])).render(
            sf.Camera([5, -3, 2], [5, 5, 0]), (60, 40)
        )
        for part in (surfels, surfels[:144])
    )
    np.testing.assert_allclose(on, without, atol=1e-5)
