"""The command line: what it writes, says and returns."""

import json
import os
import re
import signal
import subprocess
import sys
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from pixels import pixels
from surflux import _core
from surflux.cli import cloud, commands
from surflux.scenes import shapes

ROOT = Path(__file__).parents[3]


def test_area(ball, run):
    status, out, _ = run("area", "ball.ply", "--json", "-o", "with.ply")
    assert status == 0
    result = json.loads(out)
    assert result["surfels"] == 162
    assert result["area"] == pytest.approx(16 * np.pi, rel=0.1)
    assert sf.read("with.ply").areas.sum() == pytest.approx(result["area"], rel=1e-6)
    for backend in ("cpu", "gl"):
        _, out, _ = run("area", "ball.ply", "--json", "--backend", backend)
        assert json.loads(out)["area"] == pytest.approx(result["area"], rel=1e-5)
    status, out, _ = run("area", "ball.ply")
    assert status == 0
    assert out.startswith(f"162 surfels, area {result['area']:.6g}\n")


def test_area_of_a_scene_counts_its_patches_exactly(here, run):
    assert json.loads(run("area", "room.toml", "--json")[1])["area"] == pytest.approx(6)


def test_render_looks_from_the_camera_of_the_scene_or_from_elsewhere(here, run):
    assert run("solve", "room.toml", "-o", "a.ply", "--image", "a.png", "--size", "80x60")[0] == 0
    status, out, _ = run("render", "a.ply", "--image", "again.png", "--size", "80x60")
    assert (status, out) == (0, "picture: again.png\n")
    assert (pixels("again.png") == pixels("a.png")).all()
    turned = ("--eye", "0.5,0.5,4", "--target", "0.5,0.5,0", "--up", "0,1,0", "--fov", 20)
    status, out, _ = run("render", "a.ply", "--json", "--size", "80x60", *turned)
    assert status == 0
    assert json.loads(out) == {"input": "a.ply", "images": ["a_render.png"]}  # a.png is of solve
    assert (pixels("a_render.png") != pixels("again.png")).any()
    assert (pixels("again.png") == pixels("a.png")).all()


def test_up_alone_frames_the_cloud_anew_with_that_up(here, run):
    mast = sf.Surfels([[0, y, 0] for y in np.linspace(0, 9, 60)], [[0.3, 0.3, 0.9]] * 60, radii=0.5)
    mast.save("mast.ply")
    assert run("solve", "mast.ply", "--size", "80x80", "--up", "0,1,0", "--background", 0)[0] == 0
    lit = np.argwhere(pixels("mast_solved.png").max(axis=2) > 30)
    height, width = np.ptp(lit, axis=0)
    assert height > 60
    assert width < 30
    assert abs(lit.mean(axis=0)[1] - 39.5) < 2


def test_without_a_terminal_each_stage_is_one_line(ball, run):
    err = run("solve", "ball.ply", "--size", "8x6")[2].splitlines()
    assert "surflux: areas" in err
    assert "surflux: exchange" in err
    assert all(line.startswith("surflux: ") for line in err)
    assert len(err) == len({*err})


@pytest.mark.parametrize("flag", ["-q", "--quiet"])
def test_quiet_leaves_progress_out_and_keeps_warnings(ball, run, monkeypatch, flag):
    read = cloud.read_scan_with_faces

    def warned(*arguments, **options):
        warnings.warn("3 normals are zero", stacklevel=1)
        return read(*arguments, **options)

    monkeypatch.setattr(cloud, "read_scan_with_faces", warned)
    status, out, err = run("solve", flag, "ball.ply", "--size", "8x6")
    assert (status, err) == (0, "surflux: warning: 3 normals are zero\n")
    assert "162 points, as read, with their light: ball_solved.ply\n" in out


def test_verbose_tells_settings_the_camera_and_the_seconds_of_stages(ball, run):
    status, _, err = run("solve", "-v", "ball.ply", "--size", "8x6", "--rays", 64, "--seed", 3)
    assert status == 0
    settings = next(line for line in err.splitlines() if "settings: " in line)
    for said in ("input = ball.ply", "solver = radiosity", "rays = 64", "seed = 3", "size = (8, 6)"):
        assert said in settings
    assert "tolerance" not in settings  # not given
    assert "surflux: camera: Camera(eye=" in err
    assert re.search(r"^surflux: areas: \d+\.\d\d s$", err, re.MULTILINE)
    assert "areas: " not in run("solve", "ball.ply", "--size", "8x6")[2]


def test_quiet_and_verbose_are_taken_by_every_command(here, run, capfd):
    for command in commands.RUNS:
        with pytest.raises(SystemExit) as stopped:
            run(command, "--help")
        assert stopped.value.code == 0
        said = capfd.readouterr().out
        assert "-q, --quiet" in said, command
        assert "-v, --verbose" in said, command
        with pytest.raises(SystemExit):
            run(command, "-q", "-v")
        assert "not allowed with argument" in capfd.readouterr().err


def test_areas_are_one_stage_however_many_objects(here, run):
    ball = '[[object]]\nshape = "sphere"\npoints = 42\nradius = 0.1\ntranslate = [0.5, 0.5, 0.5]\n'
    Path("balls.toml").write_text(ball * 3 + Path("room.toml").read_text())
    status, _, err = run("solve", "balls.toml", "--size", "8x6")
    assert status == 0
    assert err.splitlines().count("surflux: areas") == 1


@pytest.mark.slow
def test_view_of_scenes_clouds_and_solutions(ball, run):
    status, out, _ = run("view", "room.toml", "--screenshot", "room.png", "--size", "100x80", "--color", "normal")
    assert (status, out) == (0, "picture: room.png\n")
    assert pixels("room.png")[40, 50].tolist() == pytest.approx([128, 0, 128], abs=2)  # the back wall faces -y
    assert run("view", "ball.ply", "--screenshot", "ball.png", "--color", "radius")[0] == 0
    assert run("solve", "ball.ply", "-o", "lit.ply", "--size", "8x6", "--light", "sky")[0] == 0
    status, out, err = run("view", "lit.ply", "--size", "100x80")
    assert status == 0
    shown = out.removeprefix("picture: ").strip()
    assert f"there is no display, so the picture goes to {shown}" in err
    assert not Path("surflux_view.png").exists()  # the working folder is the user's
    assert pixels(shown)[40, 50].min() > 200  # radiosity, the same everywhere, is white
    status, _, err = run("view", "ball.ply", "--screenshot", "a.png", "--color", "radiosity")
    assert status == 2
    assert "surflux: error: --color: wanted one of" in err


def test_info(run):
    status, out, _ = run("info")
    assert status == 0
    assert out.startswith("surflux")
    found = json.loads(run("info", "--json")[1])
    for key in ("surflux", "python", "numpy", "GL", "instruction set", "threads"):
        assert f"{key} " in out
        assert key in found
    assert found["threads"] >= 1


def test_info_tells_why_there_is_no_gl(monkeypatch):
    def fail():
        raise _core.DeviceError("no EGL device answers")

    monkeypatch.setattr(_core, "gl_info", fail)
    assert sf.info()["GL"] == "none (no EGL device answers)"


def test_the_version_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert sf.__version__ == project["version"]
    assert sf.info()["surflux"] == project["version"]


WRONG = [
    (["solve", "none.toml"], "none.toml: no such file"),
    (["solve", "none.ply"], "none.ply"),
    (["solve", "cloud.jpeg"], "cloud.jpeg"),
    (["solve", "broken.ply"], "broken.ply"),
    (["solve", "broken.toml"], "broken.toml (object 1, shape): wanted one of"),
    (["solve", "room.toml", "--thin", "50"], "--thin: is for a cloud"),
    (["solve", "room.toml", "--points", "50"], "--points: is for a cloud"),
    (["solve", "ball.ply", "--points", "1"], "--points: wanted a whole number from 2"),
    (["solve", "ball.ply", "--thin", "1"], "--thin: wanted a whole number from 2"),
    (["solve", "room.toml", "--tolerance", "-1"], "--tolerance: wanted values in (0, 1), got -1"),
    (["solve", "room.toml", "--seed", "-1"], "--seed: wanted a whole number from 0"),
    (["solve", "room.toml", "--threads", "0"], "--threads: wanted a whole number from 1"),
    (["solve", "room.toml", "--image", "a.jpeg"], "--image: wanted a name ending in .exr, .png or .hdr, got 'a.jpeg'"),
    (["solve", "room.toml", "--image", "no/a.png"], "no/a.png: cannot be written: there is no folder no"),
    (["solve", "room.toml", "-o", "no/a.ply", "--image", "a.png", "--size", "8x6"], "no/a.ply"),
    # Before anything is solved: see test_where_nothing_can_be_written_nothing_is_solved.
    (["solve", "room.toml", "-o", "folder.ply"], "folder.ply: is a folder, not a file"),
    (["solve", "room.toml", "--image", "folder.png"], "folder.png: is a folder, not a file"),
    (["view", "room.toml", "--export", "folder.html"], "folder.html: is a folder, not a file"),
    (["view", "room.toml", "--screenshot", "folder.png"], "folder.png: is a folder, not a file"),
    (["solve", "room.toml", "--fov", "0"], "--fov: wanted"),
    (["solve", "room.toml", "--eye", "0.5,0.5,0.5"], "target: wanted"),
    # What is wrong with the options is told before the file is looked at.
    (["solve", "none.toml", "--size", "0x6"], "--size: wanted a whole number from 1 to 16384, got 0"),
    (["view", "none.toml", "--size", "8x20000"], "--size: wanted a whole number from 1 to 16384, got 20000"),
    (["render", "none.ply", "--size", "8x-1"], "--size: wanted"),
    (["solve", "none.ply", "--thin", "0"], "--thin: wanted"),
    (["solve", "none.ply", "--zeta", "0"], "--zeta: wanted values above 0, got 0"),
    (["solve", "none.ply", "--seed", "-2"], "--seed: wanted"),
    (["solve", "none.ply", "--tolerance", "1"], "--tolerance: wanted"),
    (["area", "none.ply", "--threads", "0"], "--threads: wanted"),
    (["render", "none.ply", "--threads", "-1"], "--threads: wanted"),
    (["solve", "none.toml", "-o", "a.obj"], "-o: wanted a name ending in .ply, .glb, .gltf, got 'a.obj'"),
    (["solve", "none.toml", "-o", "a.png"], "got 'a.png'; a picture is --image"),
    (["area", "none.ply", "-o", "a"], "-o: wanted a name ending in .ply, got 'a'"),
    (["area", "none.ply", "-o", "no/a.ply"], "no/a.ply: cannot be written: there is no folder no"),
    (["area", "none.ply"], "none.ply: no such file"),
    (["area", "ball.ply", "--method", "best"], "--method: wanted one of"),
    (["area", "ball.ply", "--backend", "gpu"], "--backend: wanted one of 'auto', 'cpu', 'gl', got 'gpu'"),
    (["render", "ball.ply"], "ball.ply"),
    (["render", "none.ply"], "none.ply"),
    (["view", "none.ply"], "none.ply"),
    (["view", "ball.ply", "--screenshot", "a.gif"], "--screenshot: wanted a name ending in .png or .jpg, got 'a.gif'"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_errors_are_one_line_and_status_2(ball, run, arguments, message):
    Path("broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1\n")
    Path("broken.toml").write_text('[[object]]\nshape = "cone"\n')
    for suffix in ("ply", "png", "html"):
        Path(f"folder.{suffix}").mkdir()
    status, out, err = run(*arguments)
    assert status == 2
    assert out == ""
    last = err.rstrip("\n").splitlines()[-1]
    assert last.startswith("surflux: error: ")
    assert message in last
    assert "Traceback" not in err
    assert not Path("room_solved.ply").exists()


@pytest.mark.parametrize(
    ("arguments", "written"),
    [
        (["solve", "room.toml"], "room_solved.ply"),
        (["solve", "room.toml", "-o", "a.ply"], "a.ply"),
        (["view", "room.toml", "--export", "a.html"], "a.html"),
        (["view", "room.toml", "--screenshot", "a.png"], "a.png"),
    ],
    ids=" ".join,
)
def test_where_nothing_can_be_written_nothing_is_solved(ball, run, monkeypatch, arguments, written):
    def solve(*_, **__):
        raise AssertionError("solved in vain")

    monkeypatch.setattr(sf, "solve", solve)
    monkeypatch.setattr("os.access", lambda path, mode: False)  # as of a folder of somebody else
    status, _, err = run(*arguments)
    assert status == 2
    assert err.endswith(f"error: {written}: cannot be written: no permission to write in .\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "room.toml", "--image", "new/a.png"],
        ["solve", "room.toml", "-o", "new/a.ply"],
        ["area", "ball.ply", "-o", "new/a.ply"],
        ["check", "ball.ply", "-o", "new/a.ply"],
        ["render", "none.ply", "--image", "new/a.png"],
        ["render", "none.ply", "--gaussians", "new/a.glb"],
        ["render", "none.ply", "--turntable", "4", "--image", "new/%04d.png"],
        ["render", "none.ply", "--turntable", "4", "--image", "new/a.gif"],
        ["relight", "room.toml", "--image", "new/%04d.png"],
        ["relight", "room.toml", "--image", "new/a.gif"],
        ["relight", "room.toml", "--image", "new/a.exr"],
        ["relight", "room.toml", "-o", "new/a.ply"],
        ["relight", "room.toml", "--screenshot", "new/a.png"],
        ["relight", "room.toml", "--environment", "sky.exr", "--export", "new/a.html"],
        ["view", "room.toml", "--screenshot", "new/a.png"],
        ["view", "room.toml", "--export", "new/a.html"],
    ],
    ids=" ".join,
)
def test_a_folder_that_does_not_exist_is_told_before_any_work(ball, run, monkeypatch, arguments):
    def work(*_, **__):
        raise AssertionError("worked in vain")

    sf.write_image("sky.exr", np.ones((2, 4, 3)))
    for name in ("solve", "effective_areas", "inward_patches", "load_solution", "precompute_transfer"):
        monkeypatch.setattr(sf, name, work)
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert re.fullmatch(r"surflux: error: new/\S+: cannot be written: there is no folder new", err.splitlines()[-1])
    assert not Path("new").exists()


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_a_film_without_its_extra_is_told_before_any_work(here, run, monkeypatch, suffix):
    monkeypatch.setitem(sys.modules, "imageio", None)
    monkeypatch.setitem(sys.modules, "imageio.v2", None)

    def work(*_, **__):
        raise AssertionError("worked in vain")

    monkeypatch.setattr(sf, "load_solution", work)
    monkeypatch.setattr(sf, "precompute_transfer", work)
    for arguments in (["render", "a.ply", "--turntable", 4], ["relight", "room.toml"]):
        status, out, err = run(*arguments, "--image", f"a{suffix}")
        assert (status, out) == (2, "")
        wanted = (
            rf"surflux: error: {suffix} files need `pip install 'surflux\[video\]'` \(.*\); numbered pictures do not"
        )
        assert re.fullmatch(wanted, err.splitlines()[-1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "the following arguments are required: COMMAND, of solve, area, check, doctor, "),
        (["solve", "room.toml", "--ligth=sun"], "unrecognized arguments: --ligth=sun; did you mean --light?"),
        (["solve", "room.obj", "--reflectance", "1.2"], "; reflectance is a key of an [[object]] in a scene file ("),
        (["check", "room.obj", "--patch-area", "0"], "; patch_area is a key of an [[object]] in a scene file ("),
        (["render", "a.ply", "--direct", "traced"], "; --direct is an option of surflux solve and surflux relight ("),
        (["-q", "solve", "room.toml"], "unrecognized arguments: -q; -q goes behind the command: surflux solve -q ("),
        (["paint"], "invalid choice: 'paint'"),
        (["solv", "scan.ply"], "invalid choice: 'solv' (choose from"),
        (["solv", "scan.ply"], "); did you mean solve?"),
        (["solve", "scan.ply", "--light", "sunn"], "); did you mean sun?"),
        (["solve", "scan.ply", "--viewpoint", "nan,0,0"], "argument --viewpoint: wanted three finite numbers x,y,z"),
        (["check", "scan.ply", "--viewpoint", "0,-inf,0"], "argument --viewpoint: wanted three finite numbers"),
        (
            ["solve", "scan.ply", "--eye", "0,1e31,0"],
            "argument --eye: wanted three finite numbers x,y,z up to 1e+30, got",
        ),
        (["solve"], "the following arguments are required: SCENE|CLOUD"),
        (["solve", "a.toml", "--size", "800"], "wanted WIDTHxHEIGHT, such as 800x600, got '800'"),
        (["solve", "a.toml", "--up", "0,0,0"], "argument --up: wanted a direction, of non-zero length, got '0,0,0'"),
        (["solve", "a.toml", "--eye", "1,2"], "wanted three numbers x,y,z, got '1,2'"),
        (["solve", "a.toml", "--thin", "many"], "invalid int value: 'many'"),
        (["solve", "a.ply", "--points", "1.5"], "wanted a whole number, such as 500k or 2M, got '1.5'"),
    ],
)
def test_wrong_usage(capsys, arguments, message):
    with pytest.raises(SystemExit) as end:
        commands.main(arguments)
    assert end.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (_core.Cancelled("cancelled by the progress callback"), 130, "interrupted"),
        (_core.DeviceError("no GL"), 1, "no GL"),
        (MemoryError(), 1, "MemoryError"),
        (ValueError("rho: on\n  two lines"), 2, "rho: on two lines"),
    ],
)
def test_what_stops_a_run_is_told_in_one_line(here, run, monkeypatch, error, status, message):
    def solve(scene, **options):
        raise error

    monkeypatch.setattr(sf, "solve", solve)
    assert run("solve", "room.toml") == (status, "", f"surflux: error: {message}\n")


def start(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "surflux", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def test_ctrl_c_ends_a_solve_without_a_traceback(here):
    Path("big.toml").write_text(Path("room.toml").read_text().replace("patches = 6", "patches = 40"))
    process = start("solve", "big.toml")
    process.stderr.read(1)  # its first progress
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "surflux: error: interrupted" in err
    assert "Traceback" not in err
    assert out == ""
    assert not Path("big_solved.ply").exists()


def test_a_reader_that_has_gone_is_no_error(here):
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed:
        done = subprocess.run(
            [sys.executable, "-m", "surflux", "info"], stdout=closed, stderr=subprocess.PIPE, text=True
        )
    assert done.stderr == ""
    assert done.returncode == 1


def test_warnings_are_one_line(here, run, monkeypatch):
    def read(path, **_):
        warnings.warn("3 normals are zero", stacklevel=1)
        return shapes.sphere(42)

    monkeypatch.setattr(sf, "read", read)
    status, _, err = run("check", "ball.ply")
    assert status == 0
    assert "surflux: warning: 3 normals are zero\n" in err
    assert "test_cli.py" not in err
