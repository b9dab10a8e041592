"""`surflux check`: what points inwards, what may be a room, and what to do about it."""

import json

import numpy as np
import pytest

import surflux as sf
from surflux import _core
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


def test_what_is_turned_keeps_all_that_a_cloud_has(check):
    ball = shapes.sphere(500)
    cap = ball.points[:, 2] > 0.8
    columns = {"classification": np.arange(500) % 7, "intensity": np.arange(500) + 1.0}
    sf.Scan(ball.points, attributes=columns).save(
        "scan.ply", normals=np.where(cap[:, None], -ball.normals, ball.normals)
    )
    check("scan.ply", "-o", "turned.ply")
    found = sf.read_scan("turned.ply")
    np.testing.assert_array_equal(found.points, ball.points)
    np.testing.assert_allclose(found.normals, ball.normals, atol=1e-6)
    for name, column in columns.items():
        np.testing.assert_array_equal(found.attributes[name], column)
    check("scan.ply", "-o", "some.ply", "--points", "200")
    some = sf.read_scan("some.ply").attributes
    np.testing.assert_array_equal(some["classification"], some["row"] % 7)


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


@pytest.fixture
def ball_with_a_cap(tmp_path):
    """A ball as .obj, of which faces above z = .4 have their corners the other way round: their numbers."""
    pyvista = pytest.importorskip("pyvista")
    ball = pyvista.Sphere(theta_resolution=24, phi_resolution=24)
    faces = ball.faces.reshape(-1, 4)[:, 1:].copy()
    cap = ball.points[faces].mean(axis=1)[:, 2] > 0.4
    faces[cap] = faces[cap, ::-1]
    lines = [f"v {x} {y} {z}" for x, y, z in ball.points] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (tmp_path / "ball.obj").write_text("\n".join(lines) + "\n")
    return np.flatnonzero(cap)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_mesh_is_read_once(ball_with_a_cap, check, tmp_path, monkeypatch, end):
    read, paths = _core.read_obj, []
    monkeypatch.setattr(_core, "read_obj", lambda path: paths.append(path) or read(path))
    lines = (tmp_path / "ball.obj").read_text().replace("f ", "\t f ")
    (tmp_path / "ball.obj").write_bytes(lines.replace("\n", end).encode())
    assert "of 1056 faces of the mesh" in check("ball.obj")
    assert paths == ["ball.obj"]


def test_a_mesh_is_checked_as_solve_takes_it(ball_with_a_cap, check, capsys):
    out = check("ball.obj")
    many, first = len(ball_with_a_cap), ", ".join(map(str, ball_with_a_cap[:10]))
    assert f"of 1056 faces of the mesh {many} point inwards, numbered from 0: {first}, ...\n" in out
    assert "in 1 patch\n" in out
    found = json.loads(check("ball.obj", "--json", "-o", "turned.ply"))
    assert found["inward_faces"] == ball_with_a_cap.tolist()
    assert found["surfels"] >= 20_000
    assert check("turned.ply").endswith("none in a patch that points inwards\n")
    capsys.readouterr()
    assert commands.main(["check", "ball.obj", "--points", "50"]) == 2
    assert "--points: is for a cloud" in capsys.readouterr().err


def test_a_mesh_turned_inside_out_is_turned_by_an_option_of_solve(check, tmp_path):
    vertices, faces, _ = shapes.box(patches=1, inward=True)
    corners = [f"v {x} {y} {z}\n" for x, y, z in np.asarray(vertices)]
    polygons = [f"f {' '.join(str(k + 1) for k in face)}\n" for face in faces]
    (tmp_path / "box.obj").write_text("".join(corners + polygons))
    assert "these are all faces of the mesh: `surflux solve --normals flip`" in check("box.obj", "--bodies")


@pytest.mark.parametrize("suffix", ["obj", "stl"])
def test_a_lid_that_is_wound_the_other_way_is_told(suffix, check, tmp_path):
    """Its normal is square to those around, and says nothing of a side; its edges do."""
    vertices, faces, _ = shapes.box(patches=1, inward=False)
    vertices, faces = np.asarray(vertices), [list(face) for face in faces]

    def written(faces):
        if suffix == "obj":
            corners = [f"v {x} {y} {z}\n" for x, y, z in vertices]
            text = "".join(corners + [f"f {' '.join(str(k + 1) for k in face)}\n" for face in faces])
            (tmp_path / "box.obj").write_text(text)
        else:
            pytest.importorskip("trimesh").Trimesh(
                vertices, [[f[0], f[k], f[k + 1]] for f in faces for k in (1, 2)], process=False
            ).export("box.stl")
        return check(f"box.{suffix}", "--bodies")

    assert "wound opposite ways" not in written(faces)
    assert "4 edges shared by faces that are wound opposite ways, so that one" in written([faces[0][::-1], *faces[1:]])
    assert json.loads(check(f"box.{suffix}", "--json"))["opposite_edges"] == 4
    assert "wound opposite ways" not in written([*faces, *(face[::-1] for face in faces)])  # both sides


@pytest.mark.parametrize("suffix", ["ply", "stl", "glb"])
def test_faces_of_other_files_are_checked(suffix, check):
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.icosphere(subdivisions=2).export(f"ball.{suffix}")
    arguments = ["--mesh"] if suffix == "ply" else []
    assert check(f"ball.{suffix}", *arguments).endswith("none in a patch that points inwards\n")


def test_only_one_reading_at_a_time(check, capsys):
    with pytest.raises(SystemExit):
        commands.main(["check", "room.ply", "--rooms", "--bodies"])
    assert "not allowed with" in capsys.readouterr().err


def test_where_normals_change_sides_and_nothing_tells_which_are_right_is_said(check):
    """Half of a square under houses, so coarse that links contradict each other at their feet: it was silent."""
    rng = np.random.default_rng(0)
    ground = np.column_stack([rng.uniform(-5, 5, (2000, 2)), np.zeros(2000)])
    vertices, faces, _ = shapes.box(size=[2, 3, 2])
    parts = [sf.Surfels(ground, np.tile([0, 0, 1.0], (2000, 1)))]
    for k, (x, y) in enumerate([(-3.5, -4), (1.5, -4), (-3.5, 1), (1.5, 1)]):
        sides = [face for face in faces if not np.all(vertices[face, 2] == 0)]
        parts.append(sf.Surfels.sample_mesh((vertices + np.array([x, y, 0]), sides), 333, k))
    points, normals = (np.concatenate([getattr(p, name) for p in parts]) for name in ("points", "normals"))
    sf.Surfels(points, normals).save("right.ply")
    assert check("right.ply") == "3332 surfels, none in a patch that points inwards\n"
    sf.Surfels(points, np.where(points[:, :1] > 0.3, -normals, normals)).save("half.ply")
    out = check("half.ply").splitlines()
    assert out[0] == "3332 surfels, none in a patch that is known to point inwards"
    assert "surfels around (0." in out[1]
    assert "stand on lines along which normals change sides: a part of their surface may be turned over" in out[1]
    assert json.loads(check("half.ply", "--json"))["unsure"] > 50
