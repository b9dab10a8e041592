"""Images of an Environment stand as cameras take panoramas and other programs show them: left to right from inside."""

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.scenes.scene_arrays import scene_arrays, scene_of_arrays
from surflux.solutions.about import about_solution, environments_of, pixels_of

RED, BLUE = [4.0, 0.0, 0.0], [0.0, 0.0, 4.0]
# The left half red, the right half blue; dark beyond the quarters beside the middle, so that no mirror passes for it.
HALVES = np.repeat([np.repeat([RED, BLUE], 8, axis=0)], 8, axis=0)
QUARTERS = HALVES * np.repeat([0.0, 1.0, 1.0, 0.0], 4)[:, None]
IMAGE = np.random.default_rng(5).uniform(0.1, 2.0, (7, 12, 3)).astype(np.float32)
DIRECTIONS = np.random.default_rng(6).normal(size=(60, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
# What is up, how far the image is turned about it, where its middle looks then, and what is left of that.
STANDING = [
    ([0, 0, 1], 0, [1, 0, 0], [0, 1, 0]),
    ([0, 0, 1], 90, [0, 1, 0], [-1, 0, 0]),
    ([0, 1, 0], 0, [1, 0, 0], [0, 0, -1]),
    ([0, 1, 0], -90, [0, 0, 1], [1, 0, 0]),
]


def disk(normal, at=(0, 0, 0)):
    return sf.Surfels([at], normals=[normal], radii=0.1, reflectance=0.5)


def seen(light, directions):
    """(n, 3) radiance behind pictures of one pixel each."""
    up = [np.eye(3)[np.argmin(np.abs(d))] for d in directions]
    cameras = [sf.Camera([0, 0, 0], d, u, fov=1e-3)._to_core() for d, u in zip(directions, up, strict=True)]
    return np.array([_core.environment_image([light._to_core()], c, np.zeros((1, 1)), 1)[0, 0] for c in cameras])


@pytest.mark.parametrize(("up", "azimuth", "middle", "left"), STANDING)
def test_what_is_left_in_an_image_is_left_of_who_looks_at_its_middle(up, azimuth, middle, left):
    solution = sf.solve(sf.Scene([disk(middle)], lights=[sf.Environment(QUARTERS, up, azimuth)]))
    camera = sf.Camera(middle, 2 * np.array(middle), up, fov=90)
    picture = solution.render(camera, (8, 6), background=True)
    assert picture[:, :4].tolist() == np.broadcast_to(RED, (6, 4, 3)).tolist()
    assert picture[:, 4:].tolist() == np.broadcast_to(BLUE, (6, 4, 3)).tolist()
    # That is `left` of it: Camera.project, which knows no image, says where a thing is in a picture.
    assert camera.project([2 * np.array(middle) + 0.5 * np.array(left)], (8, 6))[0][0] < 4


@pytest.mark.parametrize(("up", "azimuth", "middle", "left"), STANDING)
def test_a_patch_has_the_light_of_the_half_that_it_faces(up, azimuth, middle, left):
    """pi L of a half sky that fills a hemisphere, half of it where the dark begins at its middle; both before those."""
    light = sf.Environment(QUARTERS, up, azimuth)
    normals = np.array([left, np.negative(left), middle, np.negative(middle)], dtype=float)
    wanted = np.pi * np.array([[2, 0, 0], [0, 0, 2], [2, 0, 2], [0, 0, 0]])
    for how in ({}, {"transport": "rays"}):
        scene = sf.Scene([sf.Surfels(5 * normals, normals, radii=0.1, reflectance=0.5)], lights=[light])
        np.testing.assert_allclose(sf.solve(scene, **how).direct, wanted, atol=0.02 * 4 * np.pi)
    speck = sf.Scene([disk([0, 0, 1], [0, 0, -1e3])], [light])
    found, _ = sf.reference_irradiance(speck, np.zeros((4, 3)), normals, samples=1024)
    np.testing.assert_allclose(found, wanted, atol=0.02 * 4 * np.pi)


def test_harmonics_have_the_halves_where_they_are():
    """The first band is the integral of radiance times direction, of halves of a sphere pi L, by its norm."""
    linear = sf.Environment(HALVES).harmonics(order=2)[1:] * np.sqrt(4 * np.pi / 3)  # y, z and x
    np.testing.assert_allclose(linear, np.outer([1, 0, 0], np.pi * np.subtract(RED, BLUE)), atol=1e-12)


def of_blender(x, y, z):
    """Equirectangular textures of Cycles, z up: (u, v), v from below."""
    return 0.5 - np.arctan2(y, x) / (2 * np.pi), 1 - np.arccos(z) / np.pi


def of_three(x, y, z):
    """Backgrounds of three.js with EquirectangularReflectionMapping, y up."""
    return np.arctan2(z, x) / (2 * np.pi) + 0.5, np.arcsin(y) / np.pi + 0.5


@pytest.mark.parametrize(("mapping", "up"), [(of_blender, [0, 0, 1]), (of_three, [0, 1, 0])])
def test_images_stand_as_in_other_programs(mapping, up):
    u, v = mapping(*DIRECTIONS.T)
    wanted = IMAGE[(7 * (1 - v)).astype(int), (12 * u).astype(int)]
    np.testing.assert_array_equal(seen(sf.Environment(IMAGE, up), DIRECTIONS), wanted)


def test_images_stand_as_in_mitsuba():
    """Its y is up and the middle of an image looks along z. It blends pixels: each of ours is 64 of them."""
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    bitmap = mitsuba.Bitmap(IMAGE.repeat(64, axis=0).repeat(64, axis=1))
    theirs = mitsuba.load_dict({"type": "scene", "sky": {"type": "envmap", "bitmap": bitmap}}).environment()
    row, column = (index.ravel() + 0.5 for index in np.indices(IMAGE.shape[:2]))
    theta, angle = np.pi * row / 7, 2 * np.pi * column / 12
    directions = np.c_[np.sin(theta) * np.sin(angle), np.cos(theta), -np.sin(theta) * np.cos(angle)]
    wanted = []
    for d in directions:
        at = mitsuba.SurfaceInteraction3f()
        at.wi = mitsuba.Vector3f(*-d)
        wanted.append(np.array(theirs.eval(at)).ravel())
    np.testing.assert_allclose(seen(sf.Environment(IMAGE, [0, 1, 0], -90), directions), wanted, rtol=1e-4)


@pytest.mark.parametrize(("up", "azimuth"), [([0, 0, 1], 0.0), ([0, 0, 1], 75.0), ([0.6, 0, 0.8], -200.0)])
def test_files_from_when_columns_went_the_other_way_mean_what_they_meant(up, azimuth):
    """Then phi was 2 pi (column + .5) / w, and nothing in a file told of columns."""
    light = sf.Environment(IMAGE, up, azimuth)
    scene = sf.Scene([disk([0, 0, -1])], lights=[light])
    solution = sf.solve(scene)
    about, (scene_about, arrays) = about_solution(solution), scene_arrays(scene)
    for entry in (about["environments"][0], scene_about["lights"][0]):
        assert entry.pop("columns") == "clockwise"
    (of_solution,) = environments_of(about, pixels_of(solution))
    (of_scene,) = scene_of_arrays(scene_about, arrays).lights
    assert of_solution == of_scene
    # By the axes of the image, of which a light of one pixel's width shows one after the other.
    x, y = (seen_axis(up, azimuth + turn) for turn in (0.0, 90.0))
    phi = 2 * np.pi * (np.arange(12) + 0.5) / 12
    for row in (1, 3, 5):
        theta = np.pi * (row + 0.5) / 7
        around = np.cos(phi)[:, None] * x + np.sin(phi)[:, None] * y
        directions = np.sin(theta) * around + np.cos(theta) * np.array(up)
        np.testing.assert_array_equal(seen(of_scene, directions), IMAGE[row])


def seen_axis(up, azimuth):
    """Where +x comes to: by the shortest rotation of +z onto `up`, which here leans towards x, and about it."""
    x = np.array([up[2], 0.0, -up[0]])
    turned = np.radians(azimuth)
    return np.cos(turned) * x + np.sin(turned) * np.cross(up, x)


def test_files_that_tell_another_order_of_columns_are_refused():
    about, arrays = scene_arrays(sf.Scene([disk([0, 0, 1])], lights=[sf.Environment(IMAGE)]))
    about["lights"][0]["columns"] = "upwards"
    with pytest.raises(ValueError, match=r"^columns: wanted 'clockwise', got 'upwards'$"):
        scene_of_arrays(about, arrays)
