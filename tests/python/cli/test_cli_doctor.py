"""`surflux doctor`: what it finds in files of every kind."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.cli.doctor_points import CLASSES, class_name
from surflux.scenes import shapes

# A grid of 20 x 20 points, .1 apart: three of them stored twice, and one 5 beside it.
GRID = np.stack(np.meshgrid(np.arange(20) * 0.1, np.arange(20) * 0.1, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
POINTS = np.concatenate([GRID, GRID[:3], [[7.0, 1.0, 0.0]]])


@pytest.fixture
def doctor(here, run):
    """The dict that `surflux doctor --json` prints of a file, and its exit status."""

    def call(path, *options):
        status, out, _ = run("doctor", path, "--json", *options)
        return json.loads(out), status

    return call


def write_ply(path, columns, faces=None, points=POINTS):
    places = [(name, "double", points[:, k]) for k, name in enumerate("xyz")]
    elements = [("vertex", len(points), places + columns)]
    _core.write_ply(path, elements + ([] if faces is None else [("face", len(faces[0]) - 1, [])]), faces, [])


def test_points_their_spacing_duplicates_and_isolated_ones(doctor, run):
    write_ply("grid.ply", [])
    found, status = doctor("grid.ply")
    assert status == 0
    assert (found["kind"], found["format"], found["points"], found["finite"]) == ("points", "ply", 404, 404)
    assert found["spacing"] == pytest.approx(0.1)
    assert found["duplicates"] == 3
    assert found["isolated"] == 1
    assert found["extent"] == pytest.approx(np.hypot(7.0, 1.9))
    assert found["normals"] == {"given": False, "estimated": 404, "side": None}
    assert found["colors"] is None
    assert found["solve"]["reflectance"] == [0.5, 0.5, 0.5]
    assert found["solve"]["surfels"] == 400  # those that are neither
    assert found["solve"]["light"] == "studio"
    assert found["next"] == "surflux solve grid.ply"
    _, out, _ = run("doctor", "grid.ply")
    for line in (
        "points: 404 points (PLY), all finite",
        "duplicates: 3 points where another one is, which counts once",
        "isolated: 1 point, four times as far from others as usual",
        "normals: none given: estimated from 16 neighbours",
        "next: surflux solve grid.ply",
    ):
        assert line in out


def test_what_solve_then_makes_of_it_is_what_doctor_said(doctor, run):
    shapes.sphere(642).save("ball.ply")
    found, _ = doctor("ball.ply")
    status, out, _ = run("solve", "ball.ply", "--no-insert", "--json", "--size", "800x600", "--no-image")
    assert status == 0
    assert json.loads(out)["surfels"] == found["solve"]["surfels"] == 642
    camera = sf.load_solution("ball_solved.ply").camera
    assert camera.to_dict() == found["solve"]["camera"]


def test_a_file_is_read_once(here, run):
    write_ply("grid.ply", [])
    status, _, err = run("doctor", "grid.ply")
    assert status == 0
    assert err.splitlines().count("surflux: reading") == 1


def test_a_file_of_more_points_than_solve_takes(doctor, run, monkeypatch):
    from surflux.cli import commands

    monkeypatch.setattr(commands, "CLOUD_LIMIT", 200)
    write_ply("grid.ply", [])
    found, _ = doctor("grid.ply")
    assert found["points"] == 404
    assert 100 < found["sampled"] <= 200
    assert found["solve"]["surfels"] == found["sampled"] - 1  # without the isolated one
    assert found["duplicates"] is None
    assert found["finite"] is None
    assert found["next"] == "surflux solve grid.ply --points 200"
    assert "of which an even sample of" in run("doctor", "grid.ply")[1]


def test_points_without_a_place_and_far_from_the_origin(doctor, run):
    points = np.add(POINTS, [6.5e5, 8.5e5, 0.0])
    points[7] = np.nan
    write_ply("far.ply", [], points=points)
    found, _ = doctor("far.ply")
    assert (found["points"], found["finite"]) == (404, 403)
    assert found["steps"] is None  # 8-byte floats
    out = run("doctor", "far.ply")[1]
    assert "1 of them without a finite place" in out
    assert "far from the origin" in out
    assert "note: far.ply: 1 point of 404 left out" in out
    coarse = points.astype(np.float32).astype(float)
    write_ply("coarse.ply", [], points=coarse)
    found, _ = doctor("coarse.ply")
    assert found["steps"] == 0.0625  # 2^-4 = 2^(19 - 23): between 2^19 and 2^20
    assert "4-byte floats, which here come in steps of 0.0625" in run("doctor", "coarse.ply")[1]


@pytest.mark.slow
def test_normals_given_zero_and_of_a_viewpoint(doctor, run):
    def columns(normals):
        return [(name, "float", normals[:, k]) for k, name in enumerate(("nx", "ny", "nz"))]

    normals = np.tile([0.0, 0.0, 1.0], (404, 1))
    write_ply("up.ply", columns(normals))
    assert doctor("up.ply")[0]["normals"]["estimated"] == 0
    assert "normals: given, as the file has them" in run("doctor", "up.ply")[1]
    normals[:5] = 0.0
    write_ply("some.ply", columns(normals))
    found = doctor("some.ply")[0]
    assert found["normals"]["estimated"] == 5
    assert "5 are zero or not finite: estimated" in run("doctor", "some.ply")[1]
    assert any("of 400 normals are zero" in note for note in found["notes"])
    write_ply("none.ply", [])
    found, _ = doctor("none.ply", "--viewpoint", "0,0,-9")
    assert found["normals"]["side"] == "towards --viewpoint"
    assert found["next"] == "surflux solve none.ply --viewpoint=0,0,-9"


def test_given_normals_are_said_to_be_checked_as_solve_does(doctor, run):
    ball = shapes.sphere(1000)
    sf.Scan(ball.points, -ball.normals).save("inwards.ply")
    out = run("doctor", "inwards.ply")[1]
    assert "normals: given, as the file has them; solve turns over what faces inwards (--normals keep leaves it)" in out
    assert "note: inwards.ply: 100 % of the points faced inwards and are turned over" in out
    sf.Surfels.from_mesh(shapes.box(patches=6)[:2]).save("box.ply")
    assert doctor("box.ply")[0]["normals"]["side"] == "as the file has them"  # patches stay


@pytest.mark.slow
def test_colours_of_8_bits_of_16_of_none_and_of_fractions(doctor, run):
    def written(name, kind, values):
        write_ply(name, [(channel, kind, np.full(404, values)) for channel in ("red", "green", "blue")])
        return doctor(name)[0]["colors"], run("doctor", name)[1]

    assert written("a.ply", "uchar", 200)[0] == {"bits": 8, "largest": 200.0, "white": 255.0}
    found, out = written("b.ply", "ushort", 200)
    assert found == {"bits": 16, "largest": 200.0, "white": 255.0}
    assert "8-bit numbers in 16-bit fields, up to 200; white is 255" in out
    assert written("c.ply", "ushort", 60000)[0] == {"bits": 16, "largest": 60000.0, "white": 65535.0}
    assert written("d.ply", "float", 0.5)[0] == {"bits": None, "largest": 0.5, "white": 1.0}
    found, out = written("e.ply", "uchar", 0)
    assert found["largest"] == 0
    assert "none: the file has room for them, and all are 0" in out
    assert "reflectance: " in out


def test_classes_returns_and_intensity(doctor, run):
    classes, number, of = np.tile([2, 6], 202), np.tile([1, 1, 2, 3], 101), np.tile([1, 3, 3, 3], 101)
    np.savez(
        "a.npz",
        points=POINTS,
        classification=classes,
        return_number=number,
        number_of_returns=of,
        intensity=np.arange(404.0),
    )
    found, _ = doctor("a.npz")
    assert found["classes"] == [
        {"class": 2, "name": "ground", "points": 202},
        {"class": 6, "name": "building", "points": 202},
    ]
    assert found["returns"] == {"most": 3, "of_several": 303, "last": 202}
    assert found["intensity"] == {"least": 0.0, "largest": 403.0, "mean": 201.5}
    out = run("doctor", "a.npz")[1]
    assert "classes: 202 ground (2), 202 building (6)" in out
    assert "grey by the intensity, .5 on average" in out


def test_points_without_a_class(doctor, run):
    classes = np.full(404, 2.0)
    classes[5] = np.nan
    np.savez("a.npz", points=POINTS, classification=classes)
    found, status = doctor("a.npz")
    assert status == 0
    assert [(one["class"], one["points"]) for one in found["classes"]] == [(0, 1), (2, 403)]
    text = "a.npz: 1 point of 404 without a class (at index 5: nan) count as class 0, never classified"
    assert text in found["notes"]
    assert found["notes"].count("counted once, for another one stands at their place: 3 points") == 1


def test_classes_have_the_names_of_the_standard():
    names = {
        2: "ground",
        5: "high vegetation",
        9: "water",
        17: "bridge deck",
        18: "high noise",
        22: "temporal exclusion",
    }
    assert {code: class_name(code) for code in names} == names
    assert len(CLASSES) == 23
    assert class_name(23) == class_name(63) == "reserved"
    assert class_name(64) == class_name(255) == "defined by its user"


def test_a_mesh_that_solve_would_take_for_points(doctor, run):
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    write_ply("quad.ply", [], (np.array([0, 4]), np.arange(4)), points=quad)
    found, _ = doctor("quad.ply")
    assert (found["kind"], found["faces"]) == ("points", 1)
    out = run("doctor", "quad.ply")[1]
    assert 'kind = "mesh" in a scene file' in out
    assert "`surflux solve --mesh` lights its faces, `surflux view --mesh` shows them" in out


def test_the_scene_that_is_shown_for_a_mesh_can_be_solved(doctor, run):
    Path("quad.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    found, status = doctor("quad.obj")
    assert (status, found["kind"], found["vertices"], found["faces"]) == (0, "mesh", 4, 1)
    assert found["next"] == "surflux solve quad.obj, or surflux view quad.obj"
    assert "in a scene file" not in run("doctor", "quad.obj")[1]
    assert run("solve", "quad.obj", "--no-image", "--rays", 16)[0] == 0
    lines = [line.strip() for line in run("doctor", "quad.obj")[1].splitlines() if line.startswith("  ")]
    Path("scene.toml").write_text("\n".join(lines))
    assert run("solve", "scene.toml", "--no-image")[0] == 0


def test_scenes_solutions_transfers_and_pictures(doctor, run):
    found, _ = doctor("room.toml")
    assert (found["kind"], found["surfels"], found["patches"]) == ("scene", 216, 216)
    assert found["lights"] == {"PointLight": 1}
    assert found["next"] == "surflux solve room.toml"
    assert run("solve", "room.toml", "--no-image")[0] == 0
    found, _ = doctor("room_solved.ply")
    assert found["kind"] == "solution"
    assert found["error"] == pytest.approx(sf.load_solution("room_solved.ply").error)
    assert "so `surflux solve` refuses it" in run("doctor", "room_solved.ply")[1]
    sf.precompute_transfer(sf.load_scene("room.toml")).save("room.transfer")
    found, _ = doctor("room.transfer")
    assert (found["kind"], found["lighting"], found["surfels"]) == ("transfer", "local", 216)
    sf.write_image("sky.exr", np.full((4, 8, 3), 2.0))
    found, _ = doctor("sky.exr")
    assert (found["kind"], found["size"], found["largest"]) == ("picture", [8, 4], 2.0)
    assert "taken for a latitude-longitude image" in run("doctor", "sky.exr")[1]


def test_a_scene_without_light_is_told(here, run):
    Path("dark.toml").write_text('[[object]]\nshape = "box"\n')
    out = run("doctor", "dark.toml")[1]
    assert "lights: none: it stays black until its file has a [[light]] or an emission" in out
    assert "next: add a [[light]] to dark.toml" in out


def test_what_solve_refuses_is_told_with_its_exit_status(doctor, run):
    Path("one.xyz").write_text("1 2 3\n")
    found, status = doctor("one.xyz")
    assert status == 2
    assert found["points"] == 1
    status, out, _ = run("doctor", "one.xyz")
    assert status == 2
    refused = re.search(r"`surflux solve` refuses it: (.*)", out)[1]
    assert run("solve", "one.xyz")[2].endswith(f"surflux: error: {refused}\n")


def test_progress_goes_to_stderr_and_is_no_note(ball, run):
    _, out, err = run("doctor", "ball.ply")
    assert "surflux: reading" in err
    assert "note: reading" not in out


@pytest.mark.slow
@pytest.mark.scans
@pytest.mark.parametrize("folder", ["scans", "statues", "hard", "broken", "probes"])
def test_every_file_has_an_answer_or_a_clear_error(scans, here, run, folder):
    """Whatever it says names the next command, or the file and what is wrong with it."""
    paths = sorted(path for path in (scans / folder).iterdir() if path.stat().st_size < 5e6)
    assert paths
    for path in paths:
        status, out, err = run("doctor", "-q", path)
        said = err.splitlines()
        assert status in (0, 2), (path, err)
        assert "Traceback" not in err
        if out:
            assert out.splitlines()[-1].startswith("next: "), path
            assert status == 0 or f"refuses it: {path}" in out, path
        else:
            assert status == 2
            assert said[-1].startswith(f"surflux: error: {path}"), (path, said)
            assert len(said[-1]) > len(f"surflux: error: {path}: ") + 15, said


@pytest.mark.slow
@pytest.mark.scans
def test_what_is_known_of_real_scans(scans, here, run):
    """By their publishers, in MANIFEST.md."""
    found = {}
    for name in ("scans/room_scan1.pcd", "scans/autzen_trim.laz", "scans/office1.pcd", "broken/utm17_space.pcd"):
        found[name] = json.loads(run("doctor", "-q", "--json", scans / name)[1])
    assert found["scans/room_scan1.pcd"]["duplicates"] == 56427
    assert found["scans/room_scan1.pcd"]["points"] == 112586
    tile = found["scans/autzen_trim.laz"]
    assert (tile["points"], tile["format"]) == (110000, "las")
    assert (tile["colors"]["bits"], tile["colors"]["white"]) == (16, 255.0)
    frame = found["scans/office1.pcd"]
    assert frame["points"] - frame["finite"] == 52744


@pytest.mark.slow
def test_a_closed_terminal_or_a_pipe_gets_the_answer(ball):
    done = subprocess.run(
        [sys.executable, "-m", "surflux", "doctor", "-q", "ball.ply"], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "next: surflux solve ball.ply"
    assert done.stderr == ""


def test_what_shines_by_itself_gets_no_light(here, run):
    """What Surfels.save wrote, and a mesh by its materials."""
    d = np.random.default_rng(0).normal(size=(300, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    sf.Surfels(d, d, emission=1.0).save(here / "lamp.ply")
    (here / "lamp.mtl").write_text("newmtl lamp\nKe 1 1 1\n")
    (here / "lamp.obj").write_text("mtllib lamp.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl lamp\nf 1 2 3\n")
    for name in ("lamp.ply", "lamp.obj"):
        status, out, err = run("doctor", name)
        assert status == 0, err
        assert "for it shines by itself" in out
        assert "[[light]]" not in out


def test_what_is_up_of_a_mesh_is_what_solve_takes(doctor, run):
    """Two blocks on the floor of a room that is open at one side, y up; and z up."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    inwards = "1 2 4 3", "2 6 8 4", "3 4 8 7", "1 3 7 5", "5 7 8 6"
    outwards = "5 6 8 7", "1 2 6 5", "2 4 8 6", "4 3 7 8", "3 1 5 7"
    parts = [(corners * 4, inwards), *((np.add(corners, at), outwards) for at in ([0.6, 2, 0], [2.3, 1, 0]))]
    for name, along in (("z.obj", [0, 1, 2]), ("y.obj", [1, 2, 0])):
        lines = []
        for k, (at, faces) in enumerate(parts):
            lines += ["v {} {} {}".format(*at[i, along]) for i in range(8)]
            lines += ["f " + " ".join(str(int(c) + 8 * k) for c in face.split()) for face in faces]
        Path(name).write_text("\n".join(lines))
        up = [0.0, 1.0, 0.0] if name == "y.obj" else [0.0, 0.0, 1.0]
        found = doctor(name)[0]
        assert found["up"] == up
        assert found["next"].endswith(f"view {name}")
        _, out, _ = run("doctor", name)
        assert f"up: {name[0]}, as `surflux solve` takes it (--up)" in out
        assert ("  up = [0, 1, 0]" in out) == (name == "y.obj")
        assert f"note: {name[0]} is taken for up" in out


def test_threads_are_those_that_were_asked_for(doctor, run):
    write_ply("grid.ply", [])
    assert doctor("grid.ply", "--threads", 1)[0]["solve"]["threads"] == 1
    assert " on 1 thread," in run("doctor", "grid.ply", "--threads", 1)[1]


def test_files_that_are_no_scans_are_not_to_be_converted(here, run):
    for name, hint in (
        ("a.epw", "`surflux solar --epw`"),
        ("a.md", "It is no scan"),
        ("a.ies", "surflux.read_photometry"),
        ("a.xyb", "PDAL"),
    ):
        (here / name).write_text("LOCATION,Zurich\n")
        status, _, err = run("doctor", name)
        assert status == 2
        assert hint in err
        assert ("PDAL" in err) == (hint == "PDAL")
