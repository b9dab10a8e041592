"""`surflux relight`: pictures, films and files of lamps that move, the window's picture, and what is refused."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import surflux as sf
from surflux.cli.saying import lines_of_files

PATH = """
frames = 3
[[light]]
type = "point"
position = [[0.3, 0.3, 0.6], [0.7, 0.3, 0.6]]
intensity = [1.0, 0.8, 0.6]
"""
SMALL = ("--size", "60x40")


@pytest.fixture
def room(here):
    """The Transfer of the room, and a path of a lamp through it."""
    (here / "path.toml").write_text(PATH)
    return sf.precompute_transfer(sf.load_scene("room.toml"))


def shown(path):
    return np.asarray(Image.open(path).convert("RGB")) / 255.0


def test_pictures_of_a_lamp_that_moves(room, run):
    options = ("--path", "path.toml", "--image", "a%d.exr", "--samples", 1, *SMALL)
    status, out, err = run("relight", "room.toml", *options)
    assert status == 0, err
    _, error, local, *rest = out.splitlines()
    assert rest == [f"picture: a{k}.exr" for k in (1, 2, 3)]
    assert lines_of_files("picture", [f"a{k}.png" for k in range(60)]) == ["picture: a0.png to a59.png, 60 of them"]
    assert re.fullmatch(r"estimated error of the first frame's irradiance.*: 0\.\d+ %", error)
    assert re.fullmatch(
        r"  relative to the light of the place itself: .* % \(median\), .* % \(90th percentile\)", local
    )
    frames = sf.load_lamps("path.toml")
    pictures = [sf.read_image(f"a{k}.exr") for k in (1, 2, 3)]
    for picture, lights in zip(pictures, frames, strict=True):
        wanted = room.relight(lights).render(size=(60, 40), samples=1)
        np.testing.assert_allclose(picture, wanted, rtol=1e-4, atol=1e-5)
    # The lamp goes to the right, through the middle of a room that is the same on both sides.
    assert pictures[0][:, :30].mean() > 1.1 * pictures[0][:, 30:].mean()
    assert pictures[2][:, 30:].mean() > 1.1 * pictures[2][:, :30].mean()
    np.testing.assert_allclose(pictures[0].mean(), pictures[2].mean(), rtol=0.05)


def test_one_exposure_for_all_frames(room, run):
    assert run("relight", "room.toml", "--path", "path.toml", "--image", "a%d.png", "--stops", 1, *SMALL)[0] == 0
    linear = [room.relight(lights).render(size=(60, 40)) for lights in sf.load_lamps("path.toml")]
    first = sf.tone_map(linear[0], stops=1.0)
    np.testing.assert_allclose(shown("a1.png"), first, atol=0.5 / 255 + 1e-3)
    assert np.abs(shown("a2.png") - sf.tone_map(linear[1], stops=1.0)).max() > 2 / 255  # the exposure of its own


def test_a_film_and_numbered_files(room, run):
    options = ("--path", "path.toml", "--image", "a.gif", "-o", "lit%02d.ply", "--bounces", 1, "--json", *SMALL)
    status, out, err = run("relight", "room.toml", *options)
    assert status == 0, err
    found = json.loads(out)
    assert (found["frames"], found["surfels"], found["images"]) == (3, 216, ["a.gif"])
    assert found["outputs"] == ["lit01.ply", "lit02.ply", "lit03.ply"]
    assert found["bytes"] == room.nbytes
    # One reflection of all: that the others are missing is an error, too.
    assert found["error"] == found["history"][-1]["error"] > 0.05
    assert Image.open("a.gif").n_frames == 3
    for k, lights in enumerate(sf.load_lamps("path.toml"), start=1):
        wanted = room.relight(lights, bounces=1).irradiance
        np.testing.assert_allclose(sf.load_solution(f"lit{k:02d}.ply").irradiance, wanted, rtol=1e-6)
    assert np.abs(wanted - room.relight(lights).irradiance).max() > 1e-3  # of one bounce


def test_the_scenes_own_lamps_are_one_frame(room, run):
    status, _, err = run("relight", "room.toml", "-o", "a.ply", "--image", "a.exr", "--image", "a.png", *SMALL)
    assert status == 0, err
    wanted = room.relight(sf.PointLight([0.5, 0.5, 0.6], 1.0))
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted.irradiance, rtol=1e-6)
    layers = wanted.render(size=(60, 40), layers=True)
    for name in ("radiance", "indirect", "depth"):
        np.testing.assert_allclose(
            sf.read_image("a.exr", None if name == "radiance" else name), layers[name], rtol=1e-4
        )
    assert shown("a.png").shape == (40, 60, 3)


def test_direct_light_at_every_pixel(room, run):
    options = ("--path", "path.toml", "--image", "a%d.exr", "--direct", "traced", *SMALL)
    assert run("relight", "room.toml", *options)[0] == 0
    renderer = sf.LampRenderer(room, None, (60, 40), samples=2)
    for k, lights in enumerate(sf.load_lamps("path.toml"), start=1):
        np.testing.assert_allclose(sf.read_image(f"a{k}.exr"), renderer.frame(lights), rtol=1e-4, atol=1e-5)
    options = ("--image", "b.exr", "--image", "b.png", "--direct", "traced", "--samples", 1)
    status, _, err = run("relight", "room.toml", *options, *SMALL)
    assert status == 0, err
    wanted = sf.LampRenderer(room, None, (60, 40)).frame(sf.PointLight([0.5, 0.5, 0.6], 1.0), layers=True)
    for name in ("radiance", "direct", "depth"):
        found = sf.read_image("b.exr", None if name == "radiance" else name)
        np.testing.assert_allclose(found, wanted[name], rtol=1e-4, atol=1e-5)
    assert shown("b.png").shape == (40, 60, 3)


@pytest.mark.parametrize("direct", ["interpolated", "traced"])
def test_the_background_is_what_is_seen(room, run, direct):
    options = ("--direct", direct, "--background", "0.2,0.4,0.6", "--eye", "0.5,-4,0.5", "--target", "0.5,0.5,0.5")
    status, _, err = run("relight", "room.toml", "--image", "a.png", "--image", "b%d.png", *options, *SMALL)
    assert status == 0, err
    for path in ("a.png", "b1.png"):
        assert (np.rint(255 * shown(path)[0, 0]) == [51, 102, 153]).all()


@pytest.mark.parametrize("image", ["a.png", "a%d.png"])
@pytest.mark.parametrize("direct", ["interpolated", "traced"])
def test_lamps_that_light_nothing_are_warned_of(here, room, run, direct, image):
    (here / "out.toml").write_text((here / "room.toml").read_text().replace("[0.5, 0.5, 0.6]", "[0.5, 0.5, 9.0]"))
    status, _, err = run("relight", "out.toml", "--direct", direct, "--image", image, *SMALL)
    assert status == 0, err
    assert err.count("warning: ") == 1
    assert "warning: the scene's lights shine on backs of surfels, and none of it reaches fronts" in err


@pytest.mark.parametrize("name", ["ball.ply", "ball.obj", "two words.laz"])
def test_files_of_another_kind_are_told_what_they_would_have_to_become(here, run, name):
    (here / name).write_bytes(b"ply\nwhatever \xff\n")
    status, _, err = run("relight", name)
    assert status == 2
    assert err.startswith(f"surflux: error: {name}: wanted a scene (.toml), or what --save wrote of one (.transfer): ")
    assert f'file = "{name}" in a scene file makes one of points' in err
    assert run("relight", "none.ply") == (2, "", "surflux: error: none.ply: no such file\n")


def test_a_camera_of_the_command_line(room, run):
    look = ("--eye", "0.2,-1,0.5", "--target", "0.5,0.5,0.4", "--image", "a.exr")
    assert run("relight", "room.toml", *look, *SMALL)[0] == 0
    camera = sf.Camera([0.2, -1, 0.5], [0.5, 0.5, 0.4])
    wanted = room.relight(sf.PointLight([0.5, 0.5, 0.6], 1.0)).render(camera, size=(60, 40))
    np.testing.assert_allclose(sf.read_image("a.exr"), wanted, rtol=1e-4, atol=1e-5)


def test_a_window_without_a_display_is_a_picture(room, run):
    status, out, err = run("relight", "room.toml", "--screenshot", "a.png", "--size", "200x160")
    assert (status, out.splitlines()[-1]) == (0, "picture: a.png"), err
    bright = shown("a.png")
    assert bright.shape == (160, 200, 3)
    assert run("relight", "room.toml", "--screenshot", "b.png", "--size", "200x160", "--stops", "-2")[0] == 0
    assert shown("b.png")[40:120, 50:150].mean() < 0.8 * bright[40:120, 50:150].mean()
    status, out, err = run("relight", "room.toml", *SMALL)
    assert status == 0
    path = out.splitlines()[-1].removeprefix("picture: ")
    assert f"there is no display, so the picture goes to {path}" in err
    assert shown(path).shape == (40, 60, 3)


def test_what_is_precomputed_is_saved_and_taken(room, run, here, monkeypatch):
    status, out, err = run("relight", "room.toml", "--save", "room.transfer", "--json")
    assert status == 0, err
    assert json.loads(out)["transfer"] == "room.transfer"
    lamp = sf.PointLight([0.5, 0.5, 0.6], 1.0)
    assert np.array_equal(sf.load_transfer("room.transfer").indirect(lamp), room.indirect(lamp))
    (here / "lone.toml").write_text('[[object]]\nshape = "sphere"\npoints = 162\nreflectance = 0.7\n')
    status, out, err = run("relight", "lone.toml", "--save", "lone.transfer")  # without lamps, too
    assert status == 0, err
    assert out.splitlines()[1:] == [f"transfer: lone.transfer ({Path('lone.transfer').stat().st_size / 1e6:.1f} MB)"]
    monkeypatch.setattr(sf, "precompute_transfer", None)
    status, out, err = run("relight", "room.transfer", "-o", "a.ply", "--path", "path.toml", "-o", "a%d.ply")
    assert status == 0, err
    wanted = room.relight(sf.load_lamps("path.toml")[2])
    np.testing.assert_allclose(sf.load_solution("a3.ply").irradiance, wanted.irradiance, rtol=1e-6)


def test_saving_and_relighting_go_together(room, run):
    status, out, err = run("relight", "room.toml", "--save", "a.transfer", "-o", "a.ply", "--gaussians", "a.ply.glb")
    assert status == 0, err
    assert re.fullmatch(r"estimated error of the irradiance.*: 0\.\d+ %", out.splitlines()[2])
    assert out.splitlines()[4:] == ["relit surfels: a.ply", "Gaussians: a.ply.glb"]
    assert 0.0 < sf.load_solution("a.ply").error < 0.02
    wanted = sf.Gaussians.of(room.relight(sf.PointLight([0.5, 0.5, 0.6], 1.0)))
    found = sf.load_gaussians("a.ply.glb")
    assert len(found) == len(wanted) == 216
    np.testing.assert_allclose(found.harmonics, wanted.harmonics, atol=1e-6)  # of float32


def test_an_environment_is_left_out_and_told(room, run, here):
    (here / "sky.toml").write_text((here / "room.toml").read_text() + '[[light]]\ntype = "environment"\nradiance = 1\n')
    status, _, err = run("relight", "sky.toml", "-o", "a.ply")
    assert status == 0
    assert "warning: sky.toml: its environment is left out, for transfer is that of lamps" in err
    wanted = room.relight(sf.PointLight([0.5, 0.5, 0.6], 1.0))
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted.irradiance, rtol=1e-6)


def test_all_bounces(room, run):
    assert run("relight", "room.toml", "-o", "a.ply", "--bounces", "all")[0] == 0
    transfer = sf.precompute_transfer(sf.load_scene("room.toml"), bounces=None)
    wanted = transfer.relight(sf.PointLight([0.5, 0.5, 0.6], 1.0))
    np.testing.assert_allclose(sf.load_solution("a.ply").irradiance, wanted.irradiance, rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--path", "path.toml", "--image", "a.png"), "--image: wanted a film (.mp4, .gif) or a pattern, such as "),
        (("--path", "path.toml", "--image", "a%d%d.png"), "--image: wanted a pattern for numbered pictures"),
        (("--path", "path.toml", "--image", "a.mp4", "--size", "41x30"), "--size: .mp4 takes even numbers alone, got"),
        (("--path", "path.toml", "--image", "%d.exr", "--exposure", "2"), "--exposure: a .exr file holds radiance"),
        (("--path", "path.toml", "--image", "%d.hdr", "--linear"), "--linear: a .hdr file holds radiance itself"),
        (("--path", "path.toml", "-o", "a.ply"), "-o: wanted a pattern, such as frames/%04d.ply, for 3 frames"),
        (("--path", "path.toml"), "--path: path.toml has 3 frames; wanted --image with a film (.mp4, .gif) or a patt"),
        (("--path", "path.toml", "--save", "a.transfer"), "--path: path.toml has 3 frames; wanted --image"),
        (("--path", "path.toml", "-o", "a%d.ply", "--gaussians", "a.glb"), "--gaussians: is of one frame; there are 3"),
        (("--gaussians", "a.obj"), "--gaussians: wanted a name ending in .ply, .glb or .gltf"),
        (("--save", "a.ply"), "--save: wanted a name ending in .transfer, got 'a.ply'"),
        (("--save", "none/a.transfer"), "none/a.transfer: cannot be written: there is no folder none"),
        (("--save", "a.transfer", "--screenshot", "a.png"), "--screenshot: is the window's"),
        (("-o", "a.exr"), "-o: wanted a name ending in .ply"),
        (("--image", "a.jpg"), "--image: wanted a name ending in .exr, .png or .hdr"),
        (("--screenshot", "a.png", "-o", "a.ply"), "--screenshot: is the window's"),
        (("--screenshot", "a.exr"), "--screenshot: wanted a name ending in .png or .jpg"),
        (("--path", "none.toml"), "none.toml: no such file"),
        (("--bounces", "-1"), "--bounces: wanted"),
        (("--epsilon-t", "0"), "--epsilon-t: wanted"),
        (("--rays", "3"), "--rays: wanted"),
        (("--direct", "sharp", "--image", "a.png"), "--direct: wanted"),
        (("--direct", "traced", "-o", "a.ply"), "--direct: is of pictures; wanted with --image"),
    ],
)
def test_what_is_refused_before_any_work(room, run, options, said):
    status, out, err = run("relight", "room.toml", *options)
    assert (status, out) == (2, "")
    assert f"surflux: error: {said}" in err
    assert "placement" not in err


def test_what_is_saved_is_not_saved_again(room, run):
    room.save("room.transfer")
    status, _, err = run("relight", "room.transfer", "--save", "b.transfer")
    assert (status, err) == (2, "surflux: error: --save: is for a scene; room.transfer is precomputed\n")


def test_errors_of_a_path_name_file_and_key(room, run, here):
    (here / "path.toml").write_text(PATH.replace("intensity", "power"))
    status, _, err = run("relight", "room.toml", "--path", "path.toml", "--image", "a.gif")
    assert (status, err) == (
        2,
        "surflux: error: path.toml (light 1, power): is not a key here; there is type, at, position, intensity\n",
    )


def test_a_scene_without_lamps(run, here):
    (here / "dark.toml").write_text('[[object]]\nshape = "room"\npatches = 3\n')
    status, _, err = run("relight", "dark.toml", "-o", "a.ply")
    assert status == 2
    assert "dark.toml: has no lamps; --path LIGHTS.toml gives it some" in err
    (here / "ball.toml").write_text('[[object]]\nshape = "sphere"\npoints = 642\nreflectance = 0.7\n')
    for name in ("dark.toml", "ball.toml"):  # the window gets one that lights what is seen
        status, _, err = run("relight", name, "--screenshot", "a.png", "--size", "200x160")
        assert status == 0
        assert "warning" not in err
        assert shown("a.png")[60:100, 70:130].mean() > 0.3


def test_no_bounces_but_a_number(run, here):
    with pytest.raises(SystemExit):
        run("relight", "room.toml", "--bounces", "some")


def test_an_error_is_said_of_films_and_gaussians_too(room, run):
    """And that reflections are left out."""
    room.save("a.transfer")
    status, out, err = run("relight", "a.transfer", "--gaussians", "a.ply.glb", "--bounces", 0)
    assert status == 0, err
    assert "estimated error of the irradiance, beside all reflections: " in out
    options = ("--path", "path.toml", "--image", "a.gif", "--exposure", 1, "--bounces", "all", "--json", *SMALL)
    status, out, err = run("relight", "a.transfer", *options)
    assert status == 0, err
    assert 0.0 < json.loads(out)["error"] < 0.02


OUT_OF_THE_ROOM = """
frames = 5
[[light]]
type = "point"
position = [[0.5, 0.5, 0.5], [0.5, 0.5, 2.3]]
intensity = 1.0
[[light]]
type = "point"
position = [0.2, 0.2, 0.2]
intensity = 1.0
"""


@pytest.mark.parametrize("direct", ["interpolated", "traced"])
def test_of_a_film_frames_are_named_whose_lamp_leaves_the_room(room, run, direct):
    """They were "light 4", of all that some frames have together, and nothing with --direct traced."""
    Path("path.toml").write_text(OUT_OF_THE_ROOM)
    options = ("--path", "path.toml", "--image", "a%d.png", "--direct", direct)
    status, _, err = run("relight", "room.toml", *options, *SMALL)
    assert status == 0, err
    said = [line for line in err.splitlines() if "are backs of surfels" in line]
    assert len(said) == 1
    assert re.search(r"frames 3 to 5: lights: of what light 0 shines on (\d+% to )?100% are backs", said[0])
