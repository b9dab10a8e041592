"""`surflux check`: what points inwards, what may be a room, and what to do about it."""

import json

import numpy as np
import pytest

import surflux as sf
from surflux.cli import commands
from surflux.scenes import shapes

ROOM_FILE = """
[[object]]
shape = "room"
kind = "mesh"
patch_area = 0.02
[[light]]
type = "point"
position = [0.5, 0.5, {height}]
intensity = 1
"""


@pytest.fixture
def check(tmp_path, monkeypatch, capsys):
    """Runs the command in a folder of its own: what it prints."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        assert commands.main(["check", *arguments]) == 0
        return capsys.readouterr().out

    return run


def room(mesh):
    vertices, faces, _ = shapes.box(patches=12, inward=True)
    surfels = sf.Surfels.from_mesh((vertices, faces))
    return surfels if mesh else sf.Surfels(surfels.points, surfels.normals)


def test_the_command_reports_and_turns(tmp_path, capsys):
    ball = shapes.sphere(2000)
    cap = ball.points[:, 2] > 0.8
    before, after = tmp_path / "a.ply", tmp_path / "b.ply"
    ball.flipped(cap).save(before)
    assert commands.main(["check", str(before), "-o", str(after)]) == 0
    out = capsys.readouterr().out
    assert (
        f"2000 surfels, {cap.sum()} of them point inwards, in 1 patch\n  {cap.sum()} around (0.00, 0.00, 0.90)\n" in out
    )
    assert np.allclose(sf.read(after).normals, ball.normals, atol=1e-6)
    assert commands.main(["check", str(after)]) == 0
    assert capsys.readouterr().out == "2000 surfels, none in a patch that points inwards\n"
    assert commands.main(["check", str(before), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["inward"], found["patches"], found["largest"][0]["surfels"]) == (cap.sum(), 1, cap.sum())
    assert commands.main(["check", str(before), "--smallest", "0"]) == 2
    assert "--smallest: wanted a whole number from 1" in capsys.readouterr().err


@pytest.mark.parametrize("mesh", [False, True])
def test_a_room_is_left_as_it_is_unless_it_is_said_to_be_a_body(mesh, check):
    """Rays tell a side that light leaves the scene from; a room and a body turned inside out have the same one."""
    surfels = room(mesh)
    surfels.save("room.ply")
    out = check("room.ply", "-o", "out.ply")
    assert "864 surfels, none in a patch that points inwards\n" in out
    assert "864 surfels around (0.50, 0.50, 0.50) face a common interior: a room seen from inside" in out
    assert "no surfel turned round: out.ply" in out
    assert np.array_equal(sf.read("out.ply").normals, surfels.normals)
    assert "if it is a body, `surflux check room.ply --bodies -o OUT.ply` turns them round" in check("room.ply")
    assert check("room.ply", "--rooms") == "864 surfels, none in a patch that points inwards\n"
    found = json.loads(check("room.ply", "--json"))
    assert (found["inward"], found["unclear"]) == (0, 864)

    assert "864 of them point inwards, in 1 patch" in check("room.ply", "--bodies", "-o", "out.ply")
    assert np.array_equal(sf.read("out.ply").normals, -surfels.normals)


def test_part_of_a_room_that_faces_outwards_is_found(check):
    dome = shapes.sphere(2000).flipped()
    cap = dome.points[:, 2] > 0.8
    dome.flipped(cap).save("dome.ply")
    out = check("dome.ply", "--rooms", "-o", "out.ply")
    assert f"{cap.sum()} of them point inwards, in 1 patch\n  {cap.sum()} around (0.00, 0.00, 0.90)\n" in out
    assert np.allclose(sf.read("out.ply").normals, dome.normals, atol=1e-6)


def test_what_stands_inside_makes_it_a_room(check, tmp_path):
    for height, said in ((0.5, "object 0 is a room: light 0 stands inside"), (5.0, "face a common interior")):
        (tmp_path / "room.toml").write_text(ROOM_FILE.format(height=height))
        assert said in check("room.toml")
    assert "if it is a body, orient = true in its [[object]]" in check("room.toml")
    sf.Surfels(room(mesh=False).points, room(mesh=False).normals).save("cloud.ply")
    assert "the viewpoint stands inside" in check("cloud.ply", "--viewpoint", "0.5,0.5,0.5")


def test_what_is_said_of_a_room_in_a_scene_file_turns_its_patch_and_not_the_room(check, tmp_path):
    walls = shapes.sphere(3000)
    cap = walls.points[:, 2] > 0.8
    walls.flipped(~cap).save(tmp_path / "walls.ply")
    entry = '[[object]]\nfile = "walls.ply"\n'
    (tmp_path / "before.toml").write_text(entry)
    (tmp_path / "after.toml").write_text(f"{entry}orient = true\nrooms = true\n")
    out = check("before.toml", "--rooms")
    assert f"{cap.sum()} of them point inwards, in 1 patch" in out
    assert "  orient = true and rooms = true in its [[object]] turn them round\n" in out
    assert check("after.toml", "--rooms") == "3000 surfels, none in a patch that points inwards\n"


def test_lists_end_with_what_they_leave_out_and_say_what_to_do(check):
    ball = shapes.sphere(20000)
    caps = (ball.points @ shapes.sphere(14).points.T).max(axis=1) > 0.985
    ball.flipped(caps).save("ball.ply")
    out = check("ball.ply").splitlines()
    assert out[0] == f"20000 surfels, {caps.sum()} of them point inwards, in 14 patches"
    sizes = [int(line.split()[0]) for line in out[1:11]]
    assert sizes == sorted(sizes, reverse=True)
    assert out[11] == "  ... and 4 smaller ones"
    assert out[12].startswith("  `surflux check ball.ply -o OUT.ply` turns them round, as s.flipped(")


def test_only_one_reading_at_a_time(check, capsys):
    with pytest.raises(SystemExit):
        commands.main(["check", "room.ply", "--rooms", "--bodies"])
    assert "not allowed with" in capsys.readouterr().err
