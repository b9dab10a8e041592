"""Outputs of commands take the place of no input, and of no other output."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux.cli.options import command_line
from surflux.cli.outputs import check_outputs
from surflux.meshes.named_files import files_of_mesh

PART = """
[[object]]
file = "${SURFLUX_PARTS}/part.ply"
[[light]]
type = "environment"
image = "sky.png"
"""


@pytest.fixture
def part(ball, monkeypatch):
    """A scene file, scene.toml, that names a cloud, part.ply, and a picture, sky.png."""
    ball.save("part.ply")
    sf.write_image("sky.png", np.ones((4, 8, 3)))
    monkeypatch.setenv("SURFLUX_PARTS", ".")
    Path("scene.toml").write_text(PART)


SKY = "part.ply", "--light", "sky", "-o", "lit.ply"


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("solve", "part.ply", "-o", "./part.ply"), "-o: is the input itself, 'part.ply'"),
        (("solve", *SKY, "--solution", "part.ply"), "--solution: is the input itself, 'part.ply'"),
        (("solve", *SKY, "--solution", "lit.ply"), "--solution: is what -o writes, 'lit.ply'"),
        (("solve", "part.ply", "--solution", "part_solved.ply"), "--solution: is what -o writes, 'part_solved.ply'"),
        (("solve", *SKY, "--image", "a.png", "--image", "./a.png"), "--image: is what --image writes, 'a.png'"),
        (("solve", "scene.toml", "-o", "part.ply"), "-o: is a file that scene.toml names, 'part.ply'"),
        (("solve", "scene.toml", "-o", "sky.ply"), "--image: is a file that scene.toml names, 'sky.png'"),
        (("solar", "part.ply", "--place", "0,0", "-o", "part.ply"), "-o: is the input itself, 'part.ply'"),
        (("render", "part.ply", "--gaussians", "part.ply"), "--gaussians: is the input itself, 'part.ply'"),
        (("area", "scene.toml", "-o", "part.ply"), "-o: is a file that scene.toml names, 'part.ply'"),
        (("check", "part.ply", "-o", "part.ply"), "-o: is the input itself, 'part.ply'"),
        (("relight", "scene.toml", "-o", "part.ply"), "-o: is a file that scene.toml names, 'part.ply'"),
        (("relight", "scene.toml", "-o", "a.ply", "--gaussians", "a.ply"), "--gaussians: is what -o writes, 'a.ply'"),
        (
            ("relight", "scene.toml", "--environment", "./sky.png", "--image", "sky.png"),
            "--image: is the file of --environment, 'sky.png'",
        ),
        (("view", "scene.toml", "--screenshot", "sky.png"), "--screenshot: is a file that scene.toml names, 'sky.png'"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_an_output_in_place_of_another_file_is_refused_before_any_work(part, run, command, said):
    before = {path.name: path.read_bytes() for path in Path().iterdir()}
    status, _, err = run(*command)
    assert (status, err) == (2, f"surflux: error: {said}; wanted another name\n")
    assert {path.name: path.read_bytes() for path in Path().iterdir()} == before


def test_a_linked_input_is_the_input(part, run):
    Path("link.ply").symlink_to("part.ply")
    status, _, err = run("area", "part.ply", "-o", "link.ply")
    assert (status, "-o: is the input itself, 'link.ply'" in err) == (2, True)


def refused(*arguments):
    options = command_line(dict.fromkeys(RUNS), 1000).parse_args(arguments)
    try:
        check_outputs(options)
    except ValueError as error:
        return str(error)
    return None


RUNS = ("solve", "area", "check", "doctor", "render", "relight", "solar", "view", "bench", "info", "completion")


def test_numbered_outputs_are_no_file_that_is_read(here):
    Path("scene.toml").write_text("[[object]]\nfile = 'part0012.ply'\n")
    Path("part0012.ply").write_text("")
    assert refused("relight", "scene.toml", "-o", "part%04d.ply") is not None
    assert refused("relight", "scene.toml", "-o", "lit%04d.ply") is None
    assert refused("relight", "scene.toml", "-o", "lit%04d.ply", "--image", "lit%04d.png") is None


def test_a_scene_may_have_the_name_of_its_output(here):
    Path("scene.toml").write_text("name = 'part.ply'\n[[object]]\nshape = 'sphere'\n")
    Path("part.ply").write_text("")
    assert refused("solve", "scene.toml", "-o", "part.ply") is None


def test_a_scene_file_that_cannot_be_read_is_told_where_it_is_read(here):
    Path("scene.toml").write_text("[[object")
    assert refused("solve", "scene.toml", "-o", "part.ply") is None
    assert refused("solve", "no.toml", "-o", "part.ply") is None


@pytest.mark.parametrize("source", ["house.obj", "scene.toml"])
@pytest.mark.parametrize("asked", [("-o", "lit.ply", "--image", "a wall.png"), ("-o", "a wall.ply")], ids=" ".join)
def test_textures_of_meshes_are_not_replaced(here, run, source, asked):
    """One picture took the place of the texture, and the next solve read it."""
    sf.write_image("a wall.png", np.ones((4, 4, 3)))
    Path("house.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd -s 2 2 1 a wall.png\n")
    corners = "".join(f"v {x} {y} 0\nvt {x} {y}\n" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    Path("house.obj").write_text(f"mtllib house.mtl\n{corners}usemtl a\nf 1/1 2/2 3/3 4/4\n")
    sky = "[[light]]\ntype = 'environment'\nradiance = 1.0\n"
    Path("scene.toml").write_text(f"[[object]]\nfile = 'house.obj'\nkind = 'mesh'\n{sky}")
    before = Path("a wall.png").read_bytes()
    status, _, err = run("solve", source, *asked, *(() if source == "scene.toml" else ("--light", "sky")))
    assert (status, err) == (
        2,
        f"surflux: error: --image: is a file that {'house.obj'} names, 'a wall.png'; wanted another name\n",
    )
    assert Path("a wall.png").read_bytes() == before


def test_files_that_meshes_name(here):
    for name in ("a b.png", "c.bin", "d.png"):
        Path(name).write_bytes(b"")
    Path("m.gltf").write_text(
        '{"asset": {"version": "2.0"}, "buffers": [{"uri": "c.bin"}], "images": [{"uri": "a%20b.png"}, {}]}'
    )
    Path("m.ply").write_text("ply\nformat ascii 1.0\ncomment TextureFile d.png\nend_header\n")
    Path("broken.gltf").write_text("{")
    assert {path.name for path in files_of_mesh("m.gltf")} == {"a b.png", "c.bin"}
    assert [path.name for path in files_of_mesh("m.ply")] == ["d.png"]
    assert files_of_mesh("broken.gltf") == files_of_mesh("none.obj") == files_of_mesh("a b.png") == []
