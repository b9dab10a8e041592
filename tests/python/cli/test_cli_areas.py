"""`surflux view --areas`: what it writes, says and returns."""

import numpy as np
import pytest

import surflux as sf
from area_pictures import PICKED, read
from surflux.cli import commands
from surflux.scenes import shapes

ROOM = '[[object]]\nshape = "room"\npatches = 6\n[camera]\neye = [0.5, -1.4, 0.5]\ntarget = [0.5, 0.5, 0.5]\n'


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Runs `surflux view` in a folder with a cloud of 162 points and a room of 6 patches."""
    monkeypatch.chdir(tmp_path)
    shapes.sphere(162, 2.0).save("ball.ply")
    (tmp_path / "room.toml").write_text(ROOM)

    def call(*arguments):
        return commands.main(["view", *arguments]), *capfd.readouterr()

    return call


def test_areas_of_a_cloud(run):
    status, out, err = run("ball.ply", "--areas", "--screenshot", "areas.png", "--size", "400x300")
    assert (status, out) == (0, "picture: areas.png\n")
    assert err.splitlines().count("surflux: areas") == 1
    image = read("areas.png")
    assert image.shape == (300, 400, 3)
    assert not (image == PICKED).all(axis=2).any()


@pytest.mark.slow
def test_a_picked_surfel(run):
    assert run("ball.ply", "--areas", "--pick", "7", "--screenshot", "curved.png")[0] == 0
    assert read("curved.png")[263, 247].tolist() == PICKED
    assert run("ball.ply", "--areas", "--pick", "7", "--screenshot", "paper.png", "--method", "paper")[0] == 0
    assert (read("paper.png") != read("curved.png")).any()
    options = ("--eye", "0,-9,0", "--color", "normal", "--screenshot", "far.png")
    assert run("ball.ply", "--areas", "--pick", "7", *options)[0] == 0
    assert read("far.png")[263, 247] == pytest.approx([128, 0, 128], abs=20)


def test_a_scene_has_a_camera_of_its_own_but_not_for_one_surfel(run):
    assert run("room.toml", "--areas", "--color", "normal", "--screenshot", "room.png")[0] == 0
    assert read("room.png")[263, 247] == pytest.approx([128, 0, 128], abs=2)  # the back wall faces -y
    assert run("room.toml", "--areas", "--pick", "3", "--screenshot", "patch.png")[0] == 0
    assert read("patch.png")[263, 247].tolist() == PICKED


def test_coverage_without_the_panel(run):
    assert run("ball.ply", "--color", "coverage", "--screenshot", "plain.png")[0] == 0
    assert len(np.unique(read("plain.png").reshape(-1, 3), axis=0)) > 10


WRONG = [
    # What is wrong with the options is told before the file is looked at.
    (["none.ply", "--method", "paper"], "--method: goes with --areas"),
    (["none.ply", "--areas", "--pick", "-1"], "--pick: wanted a whole number from 0"),
    (["none.ply", "--areas"], "none.ply: no such file"),
    (["ball.ply", "--areas", "--pick", "162"], "--pick: wanted a whole number from 0 to 161, got 162"),
    (["ball.ply", "--areas", "--color", "level"], "--color: wanted one of 'coverage', 'area', 'radius', 'normal', got"),
    (["ball.ply", "--areas", "--method", "best"], "--method: wanted one of 'paper', 'curved', got 'best'"),
    (["ball.ply", "--areas", "--screenshot", "a.gif"], "--screenshot: wanted a name ending in .png or .jpg"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_what_cannot_be_shown(arguments, message, run):
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert f"surflux: error: {message}" in err


@pytest.mark.slow
def test_up_without_a_camera(run):
    """It turns the picture, and leaves all of it, or the picked surfel, in view."""
    pictures = {}
    for up in ("0,0,1", "0,1,0"):
        assert run("ball.ply", "--areas", "--up", up, "--color", "normal", "--screenshot", "up.png")[0] == 0
        pictures[up] = read("up.png").astype(float)
    assert np.abs(pictures["0,0,1"] - pictures["0,1,0"]).mean() > 1.0
    # Light is where the normal points to, in that colour's channel: green for y, blue for z.
    for up, channel in (("0,0,1", 2), ("0,1,0", 1)):
        half = pictures[up][:, : pictures[up].shape[1] // 2, channel]
        assert half[: len(half) // 3].mean() > half[-len(half) // 3 :].mean()
    assert run("ball.ply", "--areas", "--pick", "7", "--up", "0,1,0", "--screenshot", "picked.png")[0] == 0
    assert (read("picked.png") == PICKED).all(axis=2).any()


def test_knobs_and_a_viewpoint(run, capfd):
    for arguments in (["--resolution", "64"], ["--kappa", "6"], ["--epsilon", "0.99"]):
        assert commands.main(["area", "ball.ply", *arguments]) == 0
    assert commands.main(["area", "ball.ply", "--resolution", "3"]) == 2
    assert "resolution: wanted" in capfd.readouterr().err
    rows = "".join(f"{x} {y} 0\n" for x, y in np.random.default_rng(0).uniform(size=(99, 2)))
    properties = "property float x\nproperty float y\nproperty float z\n"
    with open("sheet.ply", "w") as file:  # without normals
        file.write(f"ply\nformat ascii 1.0\nelement vertex 99\n{properties}end_header\n{rows}")
    assert commands.main(["area", "sheet.ply", "-o", "seen.ply", "--viewpoint", "0,0,-9"]) == 0
    assert (sf.read("seen.ply").normals[:, 2] < -0.99).all()
    assert commands.main(["area", "room.toml", "--viewpoint", "0,0,9"]) == 2
    assert "--viewpoint: is for a cloud" in capfd.readouterr().err


def test_areas_stand_beside_all_that_a_cloud_has(run, capfd):
    points = shapes.sphere(500, 1.0).points
    attributes = {"classification": np.arange(500) % 7, "intensity": np.arange(500) + 1.0, "area": np.ones(500)}
    sf.Scan(points, attributes=attributes).save("scan.ply")
    assert commands.main(["area", "scan.ply", "-o", "all.ply", "-q"]) == 0
    found = sf.read_scan("all.ply")
    np.testing.assert_array_equal(found.points, points)
    assert set(found.attributes) == {"classification", "intensity", "radius", "area"}
    np.testing.assert_array_equal(found.attributes["classification"], attributes["classification"])
    assert found.attributes["area"].sum() == pytest.approx(4 * np.pi, rel=0.01)
    again, before = sf.read("all.ply"), sf.read("scan.ply")
    np.testing.assert_array_equal(again.areas, found.attributes["area"])
    np.testing.assert_array_equal(again.radii, before.radii)
    np.testing.assert_allclose(again.normals, before.normals, atol=1e-7)
    np.testing.assert_array_equal(again.reflectance, before.reflectance)
    assert commands.main(["area", "scan.ply", "-o", "some.ply", "--points", "100", "-q"]) == 0
    some = sf.read_scan("some.ply").attributes
    assert 50 < len(some["row"]) <= 100
    np.testing.assert_array_equal(some["classification"], some["row"] % 7)
    capfd.readouterr()


def test_areas_of_what_was_lit_are_of_its_surfels(run, capfd):
    points = np.vstack([shapes.sphere(500, 1.0).points, [[30.0, 30.0, 30.0]]])
    sf.Scan(points).save("scan.ply")
    assert commands.main(["solve", "scan.ply", "--light", "sky", "--no-image", "-q"]) == 0
    assert commands.main(["area", "scan_solved.ply", "-o", "all.ply", "-q"]) == 0
    assert "500 surfels" in capfd.readouterr().out
    found = sf.read_scan("all.ply").attributes
    assert np.isnan(found["area"]).tolist() == found["left_out"].astype(bool).tolist() == [False] * 500 + [True]


def test_areas_of_patches_go_with_their_triangles(run):
    sf.Surfels.from_mesh(([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2, 3]])).save("patch.ply")
    assert commands.main(["area", "patch.ply", "-o", "all.ply", "-q"]) == 0
    assert len(sf.read("all.ply").triangles) == 2
