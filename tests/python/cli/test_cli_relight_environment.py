"""`surflux relight --environment`: pictures, films, files and a page of what turns, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import surflux as sf
from surflux.solving.turning_light import TurningLight

SMALL = ("--size", "60x40")
SKY = np.full((8, 16, 3), 0.5)
SKY[2:5, 2:6], SKY[2:5, 10:14] = [4.0, 1.0, 0.5], [0.5, 1.0, 3.0]
BALL = """
[[object]]
shape = "sphere"
points = 162
reflectance = 0.3
specular = [0.5, 0.4, 0.3]
exponent = 12
[[object]]
shape = "rectangle"
corner = [-2, -2, -1.1]
edge_u = [4, 0, 0]
edge_v = [0, 4, 0]
patches = 6
[camera]
eye = [0, -6, 2]
target = [0, 0, 0]
"""


@pytest.fixture
def ball(here):
    """The DistantTransfer of ball.toml, where a glossy ball hovers over a plate; sky.exr stands beside it."""
    (here / "ball.toml").write_text(BALL)
    sf.write_image("sky.exr", SKY.astype(np.float32))
    return sf.precompute_transfer(sf.load_scene("ball.toml"), "distant")


def environment(**options):
    return sf.Environment("sky.exr", **options)


def with_sky(here, name, more=""):
    text = BALL + '[[light]]\ntype = "environment"\nimage = "sky.exr"\nup = [0, 1, 0]\nazimuth = 30\n' + more
    (here / name).write_text(text)


@pytest.mark.slow
def test_a_film_and_numbered_files(ball, run):
    options = ("--environment", "sky.exr", "--turntable", 4, "--json", *SMALL)
    status, out, err = run(
        "relight", "ball.toml", *options, "--image", "a%d.exr", "--image", "a.gif", "-o", "lit%d.ply"
    )
    assert status == 0, err
    found = json.loads(out)
    assert (found["frames"], found["surfels"], found["bytes"]) == (4, 162 + 36, ball.nbytes)
    assert found["images"] == ["a1.exr", "a2.exr", "a3.exr", "a4.exr", "a.gif"]
    assert Image.open("a.gif").n_frames == 4
    light = TurningLight(ball, environment())
    for k in range(4):
        wanted = light.relight(90.0 * k)
        np.testing.assert_allclose(sf.load_solution(f"lit{k + 1}.ply").irradiance, wanted.irradiance, rtol=1e-6)
        np.testing.assert_allclose(
            sf.read_image(f"a{k + 1}.exr"), wanted.render(size=(60, 40), background=True), rtol=1e-4, atol=1e-5
        )
    dull = wanted.radiosity / np.pi
    assert (wanted.radiance_towards([0, -1, 0.3]) > 1.5 * dull).any()  # the scene file says that it is glossy


@pytest.mark.slow
def test_turn_is_where_it_begins(ball, run):
    options = ("--environment", "sky.exr", "--turn", 90, *SMALL)
    assert run("relight", "ball.toml", *options, "--image", "a.exr", "--image", "a.png")[0] == 0
    wanted = ball.relight(environment(azimuth=90)).render(size=(60, 40), background=True)
    np.testing.assert_allclose(sf.read_image("a.exr"), wanted, rtol=1e-4, atol=1e-5)
    assert np.abs(wanted - ball.relight(environment()).render(size=(60, 40), background=True)).max() > 0.1
    options = ("--environment", "sky.exr", "--turn", 80, "--turntable", 2, "--image", "b%d.exr", *SMALL)
    assert run("relight", "ball.toml", *options)[0] == 0
    wanted = ball.relight(environment(azimuth=260)).render(size=(60, 40), background=True)
    np.testing.assert_allclose(sf.read_image("b2.exr"), wanted, rtol=1e-4, atol=1e-5)


def test_row_0_lies_towards_up(ball, run):
    assert run("relight", "ball.toml", "--environment", "sky.exr", "--up", "0,1,0", "-o", "a.ply")[0] == 0
    wanted = ball.relight(environment(up=[0, 1, 0])).irradiance
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted, rtol=1e-6)


def test_the_environment_of_the_scene(ball, run, here):
    lamp = '[[light]]\ntype = "point"\nposition = [0, 0, 3]\nintensity = 1\n'
    with_sky(here, "sky.toml", lamp)
    status, _, err = run("relight", "sky.toml", "--environment", "scene", "--turn", 15, "-o", "a.ply")
    assert status == 0, err
    assert "warning: sky.toml: its lamps are left out, for transfer is that of distant light" in err
    wanted = ball.relight(environment(up=[0, 1, 0], azimuth=45)).irradiance
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted, rtol=1e-6)
    # Of lamps, as before: what it leaves out says how it is had.
    status, _, err = run("relight", "sky.toml", "-o", "a.ply")
    assert status == 0
    assert "its environment is left out, for transfer is that of lamps (see --environment)" in err


def test_a_transfer_of_distant_light(ball, run, here):
    ball.save("ball.transfer")
    assert run("relight", "ball.transfer", "--environment", "sky.exr", "-o", "a.ply", "--bounces", 0)[0] == 0
    wanted = ball.relight(environment(), bounces=0).irradiance
    assert np.array_equal(sf.load_solution("a.ply").irradiance, wanted.astype(np.float32))
    with_sky(here, "sky.toml")
    sf.precompute_transfer(sf.load_scene("sky.toml"), "distant").save("sky.transfer")
    status, _, err = run("relight", "sky.transfer", "-o", "a.ply")  # whose environment it has along
    assert status == 0, err
    wanted = ball.relight(environment(up=[0, 1, 0], azimuth=30)).irradiance
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted, rtol=1e-6)


def test_a_page(ball, run):
    options = ("--environment", "sky.exr", "--turn", 90, "--export", "a.html", "--image", "a.png", *SMALL)
    status, out, err = run("relight", "ball.toml", *options)
    assert status == 0, err
    size = Path("a.html").stat().st_size
    assert out.splitlines()[-2:] == ["picture: a.png", f"page: a.html ({size / 1e6:.1f} MB)"]
    wanted = sf.Page(ball, environment=environment(azimuth=90), camera=ball.scene.camera, title="ball")
    assert Path("a.html").read_text() == wanted.html()


def test_a_window_without_a_display_is_a_picture(ball, run):
    options = ("--environment", "sky.exr", "--screenshot", "a.png", "--size", "200x160")
    status, out, err = run("relight", "ball.toml", *options)
    assert (status, out.splitlines()[-1]) == (0, "picture: a.png"), err
    shown = np.asarray(Image.open("a.png").convert("RGB"))
    sf.turn_environment(ball, environment(), camera=ball.scene.camera, size=(200, 160), screenshot="b.png")
    wanted = np.asarray(Image.open("b.png").convert("RGB"))
    assert shown.shape == (160, 200, 3)
    assert np.abs(shown[40:].astype(int) - wanted[40:]).max() <= 1  # below the words, of which the milliseconds differ


REFUSED = [
    (("--direct", "traced", "--image", "a.png"), "--direct: is for lamps, which go without --environment"),
    (("--path", "path.toml"), "--path: is for lamps; an environment is turned by --turntable"),
    (("--turntable", "8"), "--turntable: wants an --image: a film (.mp4, .gif), or a pattern"),
    (("--turntable", "8", "--export", "a.html"), "--turntable: wants an --image"),
    (("--turntable", "0", "--image", "a.gif"), "--turntable: wanted a whole number"),
    (("--turntable", "8", "--image", "a.png"), "--image: wanted a film (.mp4, .gif) or a pattern, such as "),
    (("--turntable", "8", "-o", "a.ply"), "-o: wanted a pattern, such as frames/%04d.ply, for 8 frames"),
    (("--turn", "nan"), "--turn: wanted a finite number"),
    (("--export", "a.png"), "--export: wanted a name ending in .html"),
    (("--export", "none/a.html"), "none/a.html: cannot be written: there is no folder"),
    (
        ("--export", "a.html", "--screenshot", "a.png"),
        "--screenshot: is the window's; wanted without --image, -o, --export",
    ),
    (("--image", "a.jpg"), "--image: wanted a name ending in .exr, .png or .hdr"),
]


@pytest.mark.parametrize(("options", "said"), REFUSED)
def test_what_is_refused_before_any_work(ball, run, options, said):
    status, out, err = run("relight", "ball.toml", "--environment", "sky.exr", *options)
    assert (status, out) == (2, "")
    assert f"surflux: error: {said}" in err
    assert "placement" not in err


@pytest.mark.parametrize("options", [("--turntable", 3, "--image", "a.gif"), ("--turn", 3), ("--export", "a.html")])
def test_lamps_do_not_turn(ball, run, options):
    sf.precompute_transfer(ball.scene).save("lamps.transfer")
    for name in ("room.toml", "lamps.transfer"):
        status, out, err = run("relight", name, *options)
        assert (status, out) == (2, "")
        assert f"surflux: error: {options[0]}: goes with --environment, or with a transfer of distant light" in err


def test_what_there_is_none_of(ball, run, here):
    for environment, said in (
        ("none.exr", "none.exr: no such file"),
        ("ball.toml", "ball.toml"),
        ("scene", "--environment: wanted an image, for ball.toml has no environment of its own"),
    ):
        status, _, err = run("relight", "ball.toml", "--environment", environment, "-o", "a.ply")
        assert status == 2
        assert f"surflux: error: {said}" in err
        assert "placement" not in err
    with_sky(here, "sky.toml", '[[light]]\ntype = "environment"\nradiance = 1\n')
    status, _, err = run("relight", "sky.toml", "--environment", "scene", "-o", "a.ply")
    assert status == 2
    assert "--environment: wanted an image, for sky.toml has 2 environments of its own" in err


def test_of_which_light_a_transfer_is(ball, run):
    ball.save("ball.transfer")
    sf.precompute_transfer(ball.scene).save("lamps.transfer")
    sf.precompute_transfer(ball.scene, "sky").save("sky.transfer")
    for options, said in (
        (("lamps.transfer", "--environment", "sky.exr"), "--environment: lamps.transfer is a transfer of lamps; sf."),
        (("sky.transfer",), "sky.transfer: is a transfer of skies, which `SkyTransfer.relight` takes; wanted one of"),
        (("ball.transfer",), "--environment: wanted an image, for ball.transfer has no environment of its own"),
        (("ball.transfer", "--environment", "sky.exr", "--rays", 64), "--rays: is for a scene; ball.transfer is pre"),
        (("ball.transfer", "--environment", "sky.exr", "--seed", 1), "--seed: is for a scene; ball.transfer is prec"),
    ):
        status, _, err = run("relight", *options)
        assert status == 2
        assert f"surflux: error: {said}" in err


def test_a_page_is_no_plan(ball, run, here):
    (here / "plan.toml").write_text(BALL.replace("target", "height = 4.0\ntarget"))
    status, _, err = run("relight", "plan.toml", "--environment", "sky.exr", "--export", "a.html")
    assert status == 2
    assert "surflux: error: --export: wanted a camera without height" in err
    assert "placement" not in err


def test_what_is_precomputed_is_saved_and_its_lobes_are_gaussians(ball, run):
    options = ("--environment", "sky.exr", "--save", "ball.transfer", "--gaussians", "ball.ply")
    status, out, err = run("relight", "ball.toml", *options)
    assert status == 0, err
    assert "transfer: ball.transfer (" in out
    wanted = ball.relight(environment())
    found = sf.load_transfer("ball.transfer").relight(environment())
    assert np.array_equal(found.irradiance, wanted.irradiance)
    gaussians = sf.load_gaussians("ball.ply")
    assert gaussians.harmonics.shape[1] > 1  # glossy: another colour from each side
    np.testing.assert_allclose(gaussians.harmonics, sf.Gaussians.of(wanted).harmonics, atol=1e-5)
