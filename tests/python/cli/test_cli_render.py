"""`surflux render`: pictures and films of solved files."""

import json

import numpy as np
import pytest
from PIL import Image

import surflux as sf
from surflux.cli import commands


@pytest.fixture
def solved(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    floor = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    scene = sf.Scene([floor], [sf.PointLight([0.5, 0, 1], 3.0)], camera=sf.Camera([0, -3, 2], [0, 0, 0]))
    solution = sf.solve(scene)
    solution.save("a.ply")
    return solution


@pytest.fixture
def run(capfd):
    def call(*arguments):
        status = commands.main([str(a) for a in arguments])
        return status, *capfd.readouterr()

    return call


def shown(path):
    return np.asarray(Image.open(path)) / 255.0


def test_tone(solved, run):
    image = solved.render(size=(40, 30))
    cases = {
        "auto.png": ([], {}),
        "dark.png": (["--stops", "-2"], {"stops": -2.0}),
        "given.png": (["--exposure", "0.4", "--linear"], {"exposure": 0.4, "filmic": False}),
    }
    for name, (options, same) in cases.items():
        assert run("render", "a.ply", "--size", "40x30", "--image", name, *options)[0] == 0
        np.testing.assert_allclose(shown(name), sf.tone_map(image, **same), atol=0.5 / 255 + 1e-4)


def test_all_layers_go_into_an_exr(solved, run):
    options = ("--samples", 1, "--image", "a.exr", "--image", "a.hdr")
    assert run("render", "a.ply", "--size", "40x30", *options)[0] == 0
    layers = solved.render(size=(40, 30), samples=1, layers=True)
    for name, values in layers.items():
        np.testing.assert_allclose(sf.read_image("a.exr", None if name == "radiance" else name), values, rtol=1e-5)
    np.testing.assert_allclose(sf.read_image("a.hdr"), layers["radiance"], rtol=1 / 64, atol=3e-3)


@pytest.mark.parametrize("tone", [[], ["--linear"], ["--exposure", "0.01"], ["--stops", "3"]], ids=" ".join)
def test_the_background_is_what_is_seen_whatever_the_exposure(solved, run, tone):
    """0 to 1 as a byte of the PNG file over 255: of a byte itself, that very byte."""
    for color in ("0", "0.25", "0.5,0.75,1", "1"):
        options = ("--size", "40x30", "--background", color, "--image", "a.png", *tone)
        assert run("render", "a.ply", *options)[0] == 0
        wanted = np.rint(255 * np.broadcast_to(np.array(color.split(","), float), 3))
        assert (shown("a.png")[:3, :3] * 255 == wanted).all(), color
    seen = solved.render(size=(40, 30), layers=["index"])["index"] >= 0
    assert run("render", "a.ply", *options, "--samples", 1)[0] == 0
    with_white = shown("a.png")[seen]
    assert run("render", "a.ply", *options, "--samples", 1, "--background", "0")[0] == 0
    assert np.median(np.abs(with_white - shown("a.png")[seen])) == 0  # what is seen before it stays as it is


def test_the_background_of_files_of_radiance_is_what_the_exposure_shows_so(solved, run):
    options = ("--size", "40x30", "--background", "0.2,0.4,0.6", "--exposure", "0.03", "--image")
    assert run("render", "a.ply", *options, "a.png", "--image", "a.exr")[0] == 0
    image = sf.read_image("a.exr")
    assert image[0, 0, 2] > 2 * image[0, 0, 0] > 0
    np.testing.assert_allclose(shown("a.png"), sf.tone_map(image, exposure=0.03), atol=0.5 / 255 + 1e-4)


def test_the_background_of_films_and_of_numbered_pictures(solved, run):
    options = ("--turntable", 2, "--size", "40x30", "--background", "0.2,0.4,0.6", "--image")
    assert run("render", "a.ply", *options, "a%d.png", "--image", "a.gif", "--image", "b%d.exr")[0] == 0
    for k in (1, 2):
        assert (shown(f"a{k}.png")[0, 0] * 255 == [51, 102, 153]).all()
        image = sf.read_image(f"b{k}.exr")
        assert image[0, 0, 2] > 2 * image[0, 0, 0] > 0
    film = np.asarray(Image.open("a.gif").convert("RGB"), float)
    assert np.abs(film[0, 0] - [51, 102, 153]).max() <= 8  # one of 256 colours of a palette


@pytest.mark.parametrize("color", ["2", "-0.1", "64,64,64", "0.1,0.2", "black", "nan"])
def test_a_background_that_is_no_display_value_is_refused(solved, run, capfd, color):
    with pytest.raises(SystemExit) as stopped:
        run("render", "a.ply", f"--background={color}")
    assert stopped.value.code == 2
    wanted = "argument --background: wanted sky, one number from 0, black, to 1, white, or three of them, R,G,B, got"
    assert f"{wanted} '{color}'" in capfd.readouterr().err


def test_both_sides(solved, run):
    below = ("--eye", "0,-3,-2", "--image", "a.exr", "--size", "40x30")
    assert run("render", "a.ply", *below)[0] == 0
    assert not np.any(sf.read_image("a.exr", "index") >= 0)
    assert run("render", "a.ply", "--both-sides", *below)[0] == 0
    assert np.mean(sf.read_image("a.exr", "index") >= 0) > 0.1


def test_a_turntable_of_numbered_pictures(solved, run, tmp_path):
    (tmp_path / "frames").mkdir()
    options = ("--turntable", 3, "--image", "frames/%02d.png", "--size", "40x30", "--json", "--stops", 1)
    status, out, _ = run("render", "a.ply", *options)
    assert status == 0
    assert json.loads(out)["images"] == [f"frames/{k:02d}.png" for k in (1, 2, 3)]
    cameras = sf.turntable(solved.camera, 3)
    solved.animate(cameras, "%d.png", (40, 30), stops=1.0)
    for k in (1, 2, 3):
        assert np.array_equal(shown(f"frames/{k:02d}.png"), shown(f"{k}.png"))


def test_a_film(solved, run):
    pytest.importorskip("imageio.v2", reason="needs surflux[video]")
    pytest.importorskip("imageio_ffmpeg", reason="needs surflux[video]")
    status, out, _ = run("render", "a.ply", "--turntable", 4, "--fps", 5, "--image", "a.mp4", "--size", "40x30")
    assert (status, out) == (0, "picture: a.mp4\n")


def test_gaussians_alone(solved, run, tmp_path):
    """Exposed as told, and y up in glTF; no picture, for which there may be no OpenGL."""
    said = run("render", "a.ply", "--gaussians", "a.glb", "--exposure", "0.4", "--stops", 1)
    assert said == (0, "Gaussians: a.glb\n", "")
    found, told = sf.load_gaussians("a.glb"), sf.Gaussians.of(solved, exposure=0.8)
    np.testing.assert_allclose(found.positions, told.positions, atol=1e-6)
    np.testing.assert_allclose(found.harmonics, told.harmonics, atol=1e-6)
    assert not (tmp_path / "a.png").exists()
    run("render", "a.ply", "--gaussians", "b.gltf", "--up", "0,1,0")
    np.testing.assert_allclose(sf.load_gaussians("b.gltf", up=(0, 1, 0)).positions, told.positions, atol=1e-6)


def test_gaussians_beside_a_picture(solved, run):
    status, out, _ = run("render", "a.ply", "--gaussians", "g.ply", "--image", "a.png", "--size", "40x30", "--json")
    assert (status, json.loads(out)) == (0, {"input": "a.ply", "images": ["a.png"], "gaussians": "g.ply"})
    assert len(sf.load_gaussians("g.ply")) == len(solved.surfels)
    assert shown("a.png").shape == (30, 40, 3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--samples", "0"], "--samples: wanted a whole number from 1 to 8, got 0"),
        (["--exposure", "bright"], "--exposure: wanted a number above 0 or auto, got 'bright'"),
        (["--exposure", "0"], "--exposure: wanted a number above 0 or auto, got '0'"),
        (["--stops", "nan"], "--stops: wanted a finite number"),
        (["--fps", "0"], "--fps: wanted values in [0.01, 1000], got 0"),
        (["--turntable", "0"], "--turntable: wanted a whole number from 1"),
        (["--turntable", "4"], "--turntable: wants an --image"),
        (["--turntable", "4", "--image", "a.png"], "--image: wanted a pattern for numbered pictures"),
        (["--turntable", "4", "--image", "a.avi"], "--image: wanted a name ending in .mp4"),
        (["--turntable", "4", "--image", "none/%d.png"], "there is no folder"),
        (
            ["--turntable", "4", "--image", "a.mp4", "--size", "40x31"],
            "--size: .mp4 takes even numbers alone",
        ),
        (["--turntable", "4", "--image", "%d.exr", "--stops", "1"], "--stops: a .exr file holds radiance itself"),
        (["--gaussians", "a.splat"], "--gaussians: wanted a name ending in .ply, .glb or .gltf, got 'a.splat'"),
        (["--gaussians", "none/a.glb"], "there is no folder"),
        (["--image", "a.mp4"], "--image: wanted a name ending in .exr, .png or .hdr"),
    ],
)
def test_refusals_come_before_the_file_is_read(tmp_path, monkeypatch, run, options, message):
    monkeypatch.chdir(tmp_path)
    status, _, err = run("render", "none.ply", *options)
    assert status == 2
    assert message in err.splitlines()[-1]


def test_a_scene_file_is_not_a_solution(solved, run, tmp_path):
    (tmp_path / "room.toml").write_text('[[object]]\nshape = "sphere"\n')
    status, out, err = run("render", "room.toml", "--image", "a.png")
    assert (status, out) == (2, "")
    assert err == "surflux: error: room.toml: holds a scene but no solution; `surflux solve room.toml` makes one\n"


def test_a_mesh_is_not_a_solution(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    status, out, err = run("render", "room.obj", "--image", "a.png")
    assert (status, out) == (2, "")
    assert err == "surflux: error: room.obj: is no solution, but obj; `surflux solve room.obj` makes one\n"


def test_a_solution_is_not_solved_again(solved, run, tmp_path):
    status, out, err = run("solve", "a.ply")
    assert (status, out) == (2, "")
    assert err.startswith("surflux: error: a.ply: is solved already")
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "a_solved.ply").exists()
