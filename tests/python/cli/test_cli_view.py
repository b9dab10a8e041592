"""`surflux view`: what it shows of scenes, clouds, meshes and solutions, what it writes, and what it refuses."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import surflux as sf
from surflux.cli import commands
from surflux.scenes import shapes
from surflux.viewing.viewer import camera_writer

SCENE = """
[[object]]
shape = "rectangle"
patches = 6
reflectance = [0.8, 0.0, 0.0]
[[light]]
type = "point"
position = [0.5, 0.5, 1.0]
intensity = 3.0
[camera]
eye = [0.5, 0.5, 2.0]
target = [0.5, 0.5, 0.0]
up = [0, 1, 0]
"""
QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
LOOK = ("--eye", "0.5,0.5,2", "--target", "0.5,0.5,0", "--up", "0,1,0")


@pytest.fixture
def run(tmp_path, monkeypatch, capfd):
    """Runs `surflux view` in a folder with a scene of red patches, a cloud and a mesh."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "red.toml").write_text(SCENE)
    (tmp_path / "quad.obj").write_text(QUAD)
    sf.solve(sf.Scene([sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0)], [sf.Environment(1.0)])).save("damaged.ply")
    whole = (tmp_path / "damaged.ply").read_bytes()
    (tmp_path / "damaged.ply").write_bytes(whole.replace(b'"error"', b'"errar"'))
    sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=[0.3, 0.5]).save("cloud.ply")

    def call(*arguments):
        return commands.main(["view", *arguments]), *capfd.readouterr()

    return call


def picture(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def test_a_scene_is_solved_first(run):
    status, out, err = run("red.toml", "--screenshot", "a.png", "--size", "200x160")
    assert (status, out) == (0, "picture: a.png\n")
    assert "surflux: solve" in err
    lit = picture("a.png")
    assert lit[80, 100, 0] > lit[110, 60, 0] + 10  # brighter below the light
    assert lit[80, 100, 1] == 0
    status, _, err = run("red.toml", "--screenshot", "b.png", "--size", "200x160", "--no-solve")
    assert (status, err) == (0, "")
    assert picture("b.png")[110, 60].tolist() == picture("b.png")[80, 100].tolist() == [231, 0, 0]


def test_meshes_and_the_faces_of_ply(run):
    assert run("quad.obj", "--screenshot", "a.png", "--size", "200x160", *LOOK)[0] == 0
    gray = picture("a.png")
    assert 60 < gray[80, 100, 0] < 240
    with open("quad.ply", "w") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n")
        file.write(
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"
        )
    assert run("quad.ply", "--mesh", "--screenshot", "b.png", "--size", "200x160", *LOOK)[0] == 0
    assert (picture("b.png") == gray).all()
    _, _, err = run("quad.ply", "--screenshot", "c.png", "--size", "200x160", *LOOK)
    assert "warning: quad.ply: has 1 face, left out, as its points are shown: --mesh shows the faces\n" in err


def test_what_is_up_of_a_mesh_is_what_solve_takes(run):
    """An empty room that is open along z, with a lamp below its ceiling along y."""
    corners = "\n".join(f"v {x} {y} {z}" for z in (-1, 1) for y in (-1, 1) for x in (-1, 1))
    lamp = "\nusemtl lamp\n" + "\n".join(f"v {x} 0.99 {z}" for x, z in ((-0.2, -0.2), (0.2, -0.2), (0.2, 0.2)))
    Path("room.mtl").write_text("newmtl wall\nKd .5 .5 .5\nnewmtl lamp\nKe 9 9 9\n")
    walls = "\nusemtl wall\nf 1 2 4 3\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4"
    Path("room.obj").write_text(f"mtllib room.mtl\n{corners}{walls}{lamp}\nf 9 10 11\n")
    pictures = {}
    for name, up in (("told.png", []), ("y.png", ["--up", "0,1,0"]), ("z.png", ["--up", "0,0,1"])):
        status, _, err = run("room.obj", "--screenshot", name, "--size", "160x120", *up)
        assert status == 0, err
        assert ("y is taken for up: there lamps hang at a ceiling" in err) == (not up)
        pictures[name] = picture(name)
    assert (pictures["told.png"] == pictures["y.png"]).all()
    assert (pictures["told.png"] != pictures["z.png"]).any()


@pytest.mark.slow
def test_how_it_looks_is_chosen(run):
    base = ("red.toml", "--screenshot", "a.png", "--size", "200x160")
    seen = set()
    looks = (
        "",
        "--style splats",
        "--style points",
        "--light direct --stops -2",
        "--color group --level 1",
        "--pick 3",
    )
    for look in (*looks, "--color cut"):
        assert run(*base, *look.split())[0] == 0
        seen.add(picture("a.png").tobytes())
    assert len(seen) == 7
    assert run("cloud.ply", "--screenshot", "b.png", "--color", "radius", "--size", "200x160")[0] == 0


@pytest.mark.slow
def test_a_page_is_exported(run, browser, tmp_path):
    status, out, _ = run("red.toml", "--export", "red.html", "--color", "reflectance")
    assert status == 0
    assert out.startswith("page: red.html (0.")
    assert out.endswith(" surfels)\n")
    browser.open(tmp_path / "red.html")
    assert browser.run("document.title") == "red"
    assert browser.run("document.getElementById('color').value") == "reflectance"
    assert browser.picture()[180, 240].tolist() == pytest.approx([231, 0, 0], abs=1)


WRONG = [
    (["none.toml", "--zeta", "0.1", "--no-solve"], "--zeta: goes with a scene that is solved"),
    (["cloud.ply", "--zeta", "0.1"], "--zeta: goes with a scene that is solved"),
    (["red.toml", "--zeta", "0"], "--zeta: wanted values above 0, got 0"),
    (["none.ply", "--export", "a.png"], "--export: wanted a name ending in .html, got 'a.png'"),
    (["none.ply", "--export", "no/a.html"], "no/a.html: cannot be written: there is no folder no"),
    (["none.ply", "--export", "a.html", "--screenshot", "a.png"], "--export: wanted without --screenshot"),
    (["none.ply", "--export", "a.html", "--style", "points"], "--style: is the window's; wanted without --export"),
    (["none.ply", "--export", "a.html", "--pick", "0"], "--pick: is the window's; wanted without --export"),
    (
        ["none.toml", "--color", "foo"],
        "--color: wanted one of 'radiosity', 'irradiance', 'direct', 'indirect', 'emission'",
    ),
    (
        ["none.ply", "--areas", "--color", "cut"],
        "--color: wanted one of 'coverage', 'area', 'radius', 'normal', got 'cut'",
    ),
    (["none.ply", "--fov", "180"], "--fov: wanted values in (0, 180), got 180"),
    (
        ["cloud.ply", "--export", "a.html", "--color", "cut"],
        "--color: wanted one of 'reflectance', 'normal', 'radius', 'area'",
    ),
    (["cloud.ply", "--style", "cubes"], "--style: wanted one of 'disks', 'splats', 'points', got 'cubes'"),
    (["cloud.ply", "--light", "red"], "--light: wanted one of 'all', 'direct', 'indirect', got 'red'"),
    (["cloud.ply", "--pick", "2"], "--pick: wanted a whole number from 0 to 1, got 2"),
    (["cloud.ply", "--level", "-1"], "--level: wanted a whole number from 0"),
    (["none.obj"], "none.obj"),
    (["damaged.ply"], "damaged.ply: its description of the solution is damaged"),
    (["cloud.ply", "--mesh"], "cloud.ply"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG, ids=lambda v: " ".join(v) if isinstance(v, list) else "")
def test_what_is_refused(run, arguments, message):
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert "surflux: error: " in err
    assert message in err


def test_w_changes_nothing_but_the_camera_of_a_lit_cloud(run):
    """Nor the points without light, which no Solution has, the cloud's own columns and comments, and its pixels."""
    points = np.vstack([shapes.sphere(500, 1.0).points, [[30.0, 30.0, 30.0]]])
    sf.Scan(points, attributes={"classification": np.arange(501) % 7}).save("ball.ply", comments=["of May"])
    assert commands.main(["solve", "ball.ply", "--light", "sky", "--no-image", "-q"]) == 0
    path, camera = Path("ball_solved.ply"), sf.Camera([5, 0, 0], [0, 0, 0], fov=30.0)
    path.write_bytes(path.read_bytes().replace(b"1.0\n", b"1.0\ncomment of May\n", 1))
    before, scan = path.read_bytes(), sf.read_scan(path)
    assert len(scan) == 501
    assert scan.attributes["left_out"].sum() == 1
    whole = sf.load_solution(path)
    window = SimpleNamespace(subject=SimpleNamespace(solution=whole))
    assert camera_writer(window, path)(camera) == "the camera is in ball_solved.ply now"
    after = path.read_bytes()
    assert after.partition(b"end_header\n")[2] == before.partition(b"end_header\n")[2]
    ours = b"comment surflux "
    kept = [
        [line for line in data.partition(b"end_header")[0].split(b"\n") if ours not in line] for data in (before, after)
    ]
    assert kept[0] == kept[1]
    assert b"comment of May" in kept[1]
    solution = sf.load_solution(path)
    assert repr(solution.camera) == repr(camera)
    assert solution.history == whole.history
    sf.Scan(points).save("cloud.ply")
    with pytest.raises(sf.FileError, match=r"cloud\.ply: holds points but no solution"):
        camera_writer(window, "cloud.ply")(camera)
