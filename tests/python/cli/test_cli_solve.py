"""`surflux solve`: what it writes, says and returns."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from pixels import pixels
from surflux import _core
from surflux.cli import cloud, points

ROOT = Path(__file__).parents[3]


def test_solve_writes_surfels_and_a_picture_beside_them(here, run):
    status, out, err = run("solve", "room.toml", "--size", "120x90")
    assert status == 0
    surfels = len(sf.load_solution("room_solved.ply").surfels)
    assert 216 <= surfels <= 432
    assert f"{surfels} surfels, area 6," in out
    assert out.endswith("solved surfels: room_solved.ply\npicture: room_solved.png\n")
    assert "surflux: error" not in err
    image = pixels("room_solved.png")
    assert image.shape == (90, 120, 3)
    assert image[45, 60].min() > 50  # the back wall is lit


def test_the_usual_output_of_another_file_is_not_replaced_without_a_word(here, run):
    said = "surflux: room_solved.ply is there already, and is replaced (-o names another)\n"
    (here / "room.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    options = "--no-image", "--rays", 16
    for name, more, is_said in (
        ("room.toml", (), False),
        ("room.obj", (), True),
        ("room.obj", ("-q",), False),
        ("room.obj", ("-o", "room_solved.ply"), False),  # which says it
    ):
        status, _, err = run("solve", name, *options, *more)
        assert (status, said in err) == (0, is_said), err


def test_solve_for_programs(here, run):
    status, out, _ = run(
        "solve", "room.toml", "--json", "-o", "a.ply", "--image", "a.exr", "--image", "b.png", "--size", "40x30"
    )
    assert status == 0
    result = json.loads(out)  # and nothing else
    assert result["output"] == "a.ply"
    assert result["images"] == ["a.exr", "b.png"]
    assert result["area"] == pytest.approx(6)
    # All light ends in the walls: area times mean (1 - rho) / rho B is the lamp's power, 4 pi, in each channel.
    assert np.array(result["mean_radiosity"]) * 6 == pytest.approx(np.full(3, 4 * np.pi), rel=0.03)
    assert all(seconds >= 0 for seconds in result["timings"].values())
    assert sf.read_image("a.exr").shape == (30, 40, 3)
    direct, indirect = sf.read_image("a.exr", "direct"), sf.read_image("a.exr", "indirect")
    assert direct + indirect == pytest.approx(sf.read_image("a.exr"), rel=1e-4, abs=1e-6)
    assert pixels("b.png").shape == (30, 40, 3)


def test_options_reach_the_solver(here, run, monkeypatch):
    given = {}

    def solve(scene, **options):
        given.update(options)
        raise ValueError("enough: seen")

    monkeypatch.setattr(sf, "solve", solve)
    assert run("solve", "room.toml", "--seed", 7, "--threads", 1, "--zeta", 0.1, "--rays", 64)[0] == 2
    assert given == {"zeta": 0.1, "rays": 64, "seed": 7, "threads": 1, "progress": True}


def test_what_a_scene_file_asks_for_counts_where_no_option_is_given(here, run):
    """`insert = false` was taken over by the usual one, and --solver meshless asked for nothing that the file says."""
    text = Path("room.toml").read_text()
    Path("own.toml").write_text(text + "\n[solve]\ninsert = false\nseed = 3\n")
    assert run("solve", "own.toml", "--no-image")[0] == 0
    assert len(sf.load_solution("own_solved.ply").surfels) == len(sf.load_scene("own.toml").surfels)
    assert run("solve", "own.toml", "--no-image", "--insert", "-o", "more.ply")[0] == 0
    assert len(sf.load_solution("more.ply").surfels) > len(sf.load_scene("own.toml").surfels)
    found = {}
    for name, path, options in (("own", "own.toml", []), ("usual", "room.toml", []), ("given", "own.toml", [0])):
        seed = ["--seed", *options] if options else []
        assert run("solve", path, "--no-image", "--solver", "meshless", *seed, "-o", f"{name}.ply")[0] == 0
        found[name] = sf.load_solution(f"{name}.ply").irradiance
    assert (found["own"] != found["usual"]).any()
    assert (found["given"] == found["usual"]).all()


def test_a_cloud_is_solved_for_its_own_points(ball, run, monkeypatch):
    given = []

    def solve(scene, **options):
        given.append(options.get("insert", True))
        raise ValueError("enough: seen")

    monkeypatch.setattr(sf, "solve", solve)
    for options in ((), ("--insert",), ("--ground",), ("--ground", "--no-insert")):
        assert run("solve", "ball.ply", *options)[0] == 2
    assert given == [False, True, True, False]


@pytest.mark.parametrize("command", ["solve", "area", "check"])
def test_threads_are_a_limit_of_reading_too(ball, run, monkeypatch, command):
    alive, seen = [], {}

    class Limit:
        def __init__(self, count):
            self.count = count
            alive.append(count)

        def __del__(self):
            alive.remove(self.count)

    def recorded(name, where=sf):
        call = getattr(where, name)

        def recording(*arguments, **options):
            seen[name] = (list(alive), options.get("threads"))
            return call(*arguments, **options)

        monkeypatch.setattr(where, name, recording)

    monkeypatch.setattr(_core, "ThreadLimit", Limit)
    reads = "read" if command == "check" else "read_scan_with_faces"
    recorded(reads, {"solve": cloud, "area": points, "check": sf}[command])
    recorded("load_scene")
    more = ["--no-image"] if command == "solve" else []
    assert run(command, "ball.ply", "--threads", 1, *more)[0] == 0
    assert seen[reads][0] == [1]
    assert run(command, "room.toml", "--threads", 1, *more)[0] == 0
    assert seen["load_scene"] == ([1], 1)  # what it does in threads of its own has to be told


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["radiosity", "meshless"])
def test_rays_are_those_of_either_solver(here, run, solver):
    """Each ray of a meshless receiver is a link, and pairs shoot from every surfel: fewer are fewer."""
    shot = []
    for rays in (64, 256):
        status, out, _ = run("solve", "room.toml", "--solver", solver, "--rays", rays, "--no-image", "--json")
        assert status == 0
        shot.append(json.loads(out)["history"][-1]["rays"])
    assert 0 < shot[0] < shot[1]


@pytest.mark.parametrize("solver", ["radiosity", "meshless"])
def test_an_error_can_be_asked_for(here, run, solver):
    status, out, err = run("solve", "room.toml", "--solver", solver, "--error", "3%", "--no-image", "--json")
    assert status == 0, err
    found = json.loads(out)
    assert found["error"] <= 0.03
    assert found["attempts"][-1]["error"] == found["error"] == found["history"][-1]["error"]
    assert found["history"][-1]["wanted_error"] == 0.03
    assert re.search(r"attempt 1: estimated error [\d.]+ % after", err)


def test_a_time_can_be_asked_for(here, run):
    status, out, err = run("solve", "room.toml", "--seconds", 1e-3, "--no-image", "--json")
    assert status == 0, err
    assert len(json.loads(out)["attempts"]) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--error", "2%", "--zeta", "0.1"), "--zeta: is chosen where --error is given; wanted one of the two"),
        (("--seconds", "5", "--rays", "64"), "--rays: is chosen where --seconds is given; wanted one of the two"),
        (("--seconds", "0"), "--seconds: wanted"),
    ],
)
def test_what_does_not_go_with_an_error_is_refused(here, run, options, message):
    status, _, err = run("solve", "room.toml", *options)
    assert status == 2
    assert message in err


@pytest.mark.parametrize("text", ["2", "0%", "-1%", "nan", "much"])
def test_an_error_is_a_share(here, run, capfd, text):
    with pytest.raises(SystemExit, match="2"):
        run("solve", "room.toml", f"--error={text}")
    assert f"--error: wanted a share below 1, such as 2% or 0.02, got {text!r}" in capfd.readouterr().err


def test_too_few_rays_are_refused_before_any_work(here, run):
    status, _, err = run("solve", "missing.toml", "--rays", 15)
    assert status == 2
    assert "--rays: wanted" in err


def test_a_cloud_is_lit_from_behind_the_camera_and_this_is_said(ball, run):
    status, _, err = run("solve", "ball.ply", "--size", "60x45")
    assert status == 0
    said = "surflux: a cloud has no light: it gets a lamp behind the camera, and a sky (--light sun or sky)"
    assert err.count(said) == 1
    image = pixels("ball_solved.png").astype(int).max(axis=2)
    assert image[12, 20] > image[32, 40] + 40  # brighter above on the left, where the lamp is, than below on the right
    assert image[32, 40] > image[0, 0] + 10  # and all of it brighter than what is behind


def test_light_is_for_clouds(here, run):
    status, _, err = run("solve", "room.toml", "--light", "sky")
    assert status == 2
    assert "--light: is for a cloud; a scene file has lights of its own" in err


def test_a_cloud_under_a_plain_sky(ball, run):
    status, out, err = run("solve", "ball.ply", "--light", "sky", "--json", "--size", "60x45")
    assert status == 0
    assert "surflux: the cloud is lit by a sky of radiance 1 from all sides\n" in err
    # A convex cloud sees the whole sky: H = pi L, and B = rho H with rho = 0.5.
    assert json.loads(out)["mean_radiosity"] == pytest.approx([np.pi / 2] * 3, rel=0.01)
    image = pixels("ball_solved.png")
    assert image[22, 30].min() > 100
    assert image[0, 0].min() > image[22, 30].max()  # the sky behind is twice as bright


@pytest.mark.slow
def test_large_clouds_are_thinned_and_this_is_said(ball, run, monkeypatch):
    status, out, err = run("solve", "ball.ply", "--thin", 60, "--json", "--size", "8x6")
    assert status == 0
    assert "surflux: 162 points are thinned to 60 (--thin sets the number)\n" in err
    assert json.loads(out)["surfels"] >= 60
    monkeypatch.setattr(cloud, "CLOUD_LIMIT", 100)
    _, out, err = run("solve", "ball.ply", "--json", "--size", "8x6")
    assert "162 points are thinned to 100" in err
    assert json.loads(out)["surfels"] >= 100


def test_a_scene_without_light_says_so(here, run):
    Path("dark.toml").write_text('[[object]]\nshape = "room"\npatches = 3\n')
    status, _, err = run("solve", "dark.toml", "--size", "8x6")
    assert status == 0
    assert err.count("all of it stays black") == 1


def test_solve_tells_its_estimated_error(here, run):
    out = run("solve", "room.toml", "--size", "8x6")[1]
    error = sf.load_solution("room_solved.ply").error
    assert f"estimated error of the irradiance: {100 * error:.2g} %\n" in out
    assert 0 < error < 0.1


def test_the_meshless_solver(here, run):
    status, out, _ = run("solve", "room.toml", "--solver", "meshless", "--seed", "3", "--json", "--no-image")
    assert status == 0
    found = json.loads(out)
    room = sf.load_scene("room.toml")
    wanted = sf.solve_meshless(room, seed=3)
    assert found["error"] == wanted.error
    np.testing.assert_allclose(sf.load_solution(found["output"]).radiosity, wanted.radiosity, rtol=1e-6)
    status, _, err = run("solve", "room.toml", "--solver", "meshless", "--zeta", "0.1")
    assert (status, "--zeta: goes with --solver radiosity" in err) == (2, True)


@pytest.mark.slow
def test_options_of_the_file_count_in_the_package_too(here, run):
    Path("own.toml").write_text(Path("room.toml").read_text() + "\n[solve]\nseed = 5\ntransport = 'rays'\n")
    found = json.loads(run("solve", "own.toml", "--json", "--no-image")[1])
    own = sf.load_scene("own.toml")
    kept = sf.load_solution(found["output"]).irradiance
    np.testing.assert_allclose(sf.solve(own).irradiance, kept, rtol=1e-6)
    np.testing.assert_array_equal(sf.solve(own).irradiance, sf.solve(own, seed=5, transport="rays").irradiance)
    assert np.abs(sf.solve(own, seed=6).irradiance - kept).max() > 1e-6 * kept.max()  # what is given counts over it


@pytest.mark.slow
def test_without_gl_a_solution_is_saved_and_told_of(here, run, monkeypatch):
    def render(*_, **__):
        raise _core.DeviceError("no EGL device answers")

    monkeypatch.setattr(sf.Solution, "render", render)
    status, out, err = run("solve", "room.toml", "--json")
    assert status == 0
    assert "surflux: warning: no picture, for no EGL device answers (--no-image asks for none)\n" in err
    found = json.loads(out)
    assert found["images"] == []
    assert sf.load_solution(found["output"]).radiosity.shape == (found["surfels"], 3)
    status, out, _ = run("solve", "room.toml", "--json", "--image", "a.png")  # which was asked for
    assert status == 1
    assert json.loads(out)["images"] == []
    status, out, err = run("solve", "room.toml", "--no-image")
    assert (status, "picture" in out, "no EGL" in err) == (0, False, False)
    assert run("solve", "room.toml", "--no-image", "--image", "a.png")[0] == 2
