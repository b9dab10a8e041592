"""What commands show behind a scene: its sky, unless told otherwise, at the exposure of what stands before it."""

import numpy as np
import pytest

import surflux as sf
from pixels import pixels

SUN = 1e6
SMALL = ("--size", "80x60")
FLOOR = """
[[object]]
shape = "rectangle"
corner = [-1, -1, 0]
edge_u = [2, 0, 0]
edge_v = [0, 2, 0]
patches = 3
[[light]]
type = "environment"
image = "sky.exr"
[camera]
eye = [0, -4, 1.2]
target = [0, 0, 0.7]
"""


@pytest.fixture
def sky(here):
    """floor.toml, and its sky: blue above, brown below, and a sun in a pixel over +y, which the camera looks along."""
    image = np.repeat([[[200.0, 400.0, 800.0]], [[400.0, 300.0, 200.0]]], 16, axis=0) * np.ones((1, 64, 1))
    image[14, 16] = SUN
    sf.write_image("sky.exr", image)
    (here / "floor.toml").write_text(FLOOR)
    return sf.Environment("sky.exr")


def test_the_sky_of_a_scene_is_behind_it(sky, run):
    images = ("--image", "a.png", "--image", "a.exr", *SMALL)
    assert run("solve", "floor.toml", "-o", "a.ply", *images)[0] == 0
    assert run("render", "a.ply", "--image", "black.png", "--background", 0, *SMALL)[0] == 0
    assert run("render", "a.ply", "--image", "again.png", *SMALL)[0] == 0
    assert run("render", "a.ply", "--image", "named.png", "--background", "sky", *SMALL)[0] == 0
    found, black = pixels("a.png").astype(int), pixels("black.png").astype(int)
    assert np.abs(pixels("again.png") - found).max() <= 1  # radiosity in a file has 7 digits
    np.testing.assert_array_equal(pixels("named.png"), pixels("again.png"))
    alpha = sf.read_image("a.exr", "alpha")
    # Neither the sky nor its sun, of which the floor has a small share, exposes the picture.
    assert np.abs(found - black)[alpha == 1].max() <= 1
    assert not black[alpha == 0].any()
    assert (np.diff(found[:4].reshape(-1, 3), axis=1) > 10).all()  # blue, and brown below
    assert (np.diff(found[-4:].reshape(-1, 3), axis=1) < -10).all()
    # In files of radiance the sun is as bright as it is, and so in the layer of direct light.
    radiance = sf.read_image("a.exr")
    assert radiance.max() == SUN == sf.read_image("a.exr", "direct").max()
    np.testing.assert_allclose(radiance[0, 0], sky.image[0, 0])
    assert sf.load_solution("a.ply").render(sf.Camera([0, 0, 9], [0, 1, 12]), (2, 2), background=True).all()


def test_films_have_the_sky_and_one_exposure(sky, run):
    assert run("solve", "floor.toml", "-o", "a.ply", "--no-image")[0] == 0
    for name, more in (("a%d.png", ()), ("b%d.png", ("--background", 0))):
        assert run("render", "a.ply", "--turntable", 2, "--image", name, *SMALL, *more)[0] == 0
    sky, black = pixels("a1.png").astype(int), pixels("b1.png").astype(int)
    assert (sky[0, 0] > 20).all()
    floor = black.max(axis=2) > 100
    assert floor.mean() > 0.05
    assert np.median(np.abs(sky - black)[floor]) == 0


def test_an_environment_that_turns_is_seen_turning(sky, run):
    options = ("--environment", "scene", "--turntable", 4, "--image", "a%d.exr", "--seed", 1, *SMALL)
    status, _, err = run("relight", "floor.toml", *options)
    assert status == 0, err
    seen = [(sf.read_image(f"a{k}.exr") == SUN).any() for k in (1, 2, 3, 4)]
    assert seen == [True, False, False, False]  # a quarter turn takes the sun out of sight


def test_the_sky_of_a_cloud_is_behind_it_and_in_its_file(ball, run):
    sf.Scan(ball.points, ball.normals).save("ball.npz")
    assert run("solve", "ball.npz", "-o", "sky.ply", "--light", "sky", "--image", "a.exr", *SMALL)[0] == 0
    assert sf.read_image("a.exr")[0, 0].tolist() == [1, 1, 1]
    assert sf.load_solution("sky.ply")._environments == [sf.Environment(1.0)]
    assert run("solve", "ball.npz", "-o", "sun.ply", "--light", "sun", "--image", "a.exr", *SMALL)[0] == 0
    (sky,) = sf.load_solution("sun.ply")._environments
    assert sky.image.shape == (128, 256, 3)
    np.testing.assert_allclose(sf.read_image("a.exr")[-1, 0], sky.image[-1, 0], rtol=1e-6)  # its ground
    assert len(sf.read_scan("sun.ply")) == len(ball.points)  # for all else the file is one of points
    # A studio has a sky only to fill in the shadows of its lamp.
    assert run("solve", "ball.npz", "-o", "studio.ply", "--image", "a.png", *SMALL)[0] == 0
    assert sf.load_solution("studio.ply")._environments == []
    assert (pixels("a.png")[0, 0] == 64).all()
