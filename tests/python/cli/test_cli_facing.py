"""`surflux solve CLOUD` does not light a cloud from its back in silence."""

import json

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.cli.commands import main
from surflux.scenes import shapes

SOLVE = ("--no-image", "--rays", "16", "--no-insert", "--json")


@pytest.fixture
def solved(tmp_path, capsys):
    """What main says and writes for points with normals."""

    def run(points, normals, *options):
        columns = [
            (f"{kind}{name}", "float", of[:, k])
            for kind, of in (("", points), ("n", normals))
            for k, name in enumerate("xyz")
        ]
        path, out = tmp_path / "cloud.ply", tmp_path / "out.ply"
        _core.write_ply(path, [("vertex", len(points), columns)], None, [])
        assert main(["solve", str(path), "-o", str(out), *SOLVE, *options]) == 0
        said = capsys.readouterr()
        assert json.loads(said.out)["surfels"] == len(points)
        return said.err, sf.load_solution(out).surfels

    return run


@pytest.fixture(scope="module")
def blob():
    return shapes.blob(1500)


def outwards(surfels, blob):
    return np.mean(np.sum(surfels.normals * blob.normals, axis=1) > 0)


@pytest.mark.slow
def test_a_body_turned_inside_out_is_turned_over_and_this_is_said(solved, blob):
    said, surfels = solved(blob.points, -blob.normals)
    assert outwards(surfels, blob) == 1.0
    assert "cloud.ply: 100 % of the points faced inwards and are turned over (a room seen from inside stays" in said
    assert "`--normals keep`" in said
    said, surfels = solved(blob.points, np.where(blob.points[:, 2:] > 0.3, -1, 1) * blob.normals)
    assert outwards(surfels, blob) == 1.0
    assert "of the points faced inwards and are turned over; `--normals keep`" in said


def test_what_is_right_is_left_in_silence(solved, blob):
    said, surfels = solved(blob.points, blob.normals)
    assert outwards(surfels, blob) == 1.0
    assert "turned" not in said


def test_what_most_of_an_open_scan_says_is_named_as_that(solved):
    x, y = np.random.default_rng(0).uniform(-1, 1, (2, 2000))
    points, up = np.stack([x, y, 0.1 * x * y], axis=1), np.tile([0.0, 0.0, 1.0], (2000, 1))
    said, surfels = solved(points, np.where(x[:, None] > 0.4, -up, up))
    assert np.mean(surfels.normals[:, 2] > 0) > 0.99
    assert "30 % of the points are turned to the side that most of their open surface faces, which may be wrong" in said


@pytest.mark.slow
def test_normals_keep_and_flip(solved, blob):
    said, surfels = solved(blob.points, -blob.normals, "--normals", "keep", "--light", "sky")
    assert outwards(surfels, blob) == 0.0
    assert "turned over" not in said
    assert outwards(solved(blob.points, -blob.normals, "--normals", "flip")[1], blob) == 1.0


@pytest.mark.slow
def test_a_room_with_a_camera_or_viewpoint_in_it_stays(solved, blob):
    for option in ("--eye=0,0,0.1", "--viewpoint=0,0,0.1"):
        said, surfels = solved(blob.points, -blob.normals, option)
        assert outwards(surfels, blob) == 0.0
        assert "turned over" not in said


def test_scene_files_have_a_key(tmp_path, capsys):
    path = tmp_path / "room.toml"
    path.write_text('[[object]]\nshape = "room"\n')
    assert main(["solve", str(path), "--normals", "keep"]) == 2
    assert "--normals: is for a cloud; a scene file turns an object by its key orient" in capsys.readouterr().err


def test_read_turns_when_asked(tmp_path, blob):
    path = sf.Surfels(blob.points, -blob.normals).save(tmp_path / "blob.ply")
    assert outwards(sf.read(path), blob) == 0.0
    assert outwards(sf.read(path, orient=True), blob) == 1.0
    assert outwards(sf.read(path, orient=[0, 0, 0.1]), blob) == 0.0
    with pytest.raises(ValueError, match=r"orient: wanted shape \(n, 3\), got \(2,\)"):
        sf.read(path, orient=[0, 0])
    room = sf.Surfels.from_mesh(shapes.box(patches=6, inward=True)[:2])  # patches stay
    assert np.array_equal(sf.read(room.save(tmp_path / "room.ply"), orient=True).normals, room.normals)
