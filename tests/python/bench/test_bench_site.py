"""Tables of `surflux bench --site` on small scenes: rows have the fields that data/figures keeps, and are right."""

import functools
import importlib.util
import json

import pytest

import quoted_figures
import surflux as sf
from scenes import cube_inside
from surflux.bench import (
    areas,
    dim_room,
    estimates,
    many_surfels,
    processes,
    ray_casting,
    scenes,
    site,
    transfer,
    transfer_cases,
)
from surflux.scenes import shapes

ROOM = """
name = "room"
[[object]]
shape = "room"
patches = 4
reflectance = 0.8
[[light]]
type = "point"
position = [0.5, 0.5, 0.7]
intensity = 1
[camera]
eye = [0.5, 0.1, 0.5]
target = [0.5, 1, 0.4]
"""


@pytest.fixture
def made(tmp_path, capsys):
    """What measures a table: its rows, and its text. They have the fields that data/figures has."""

    def make(name, seeds=1):
        site.write(tmp_path, seeds, None, {name})
        found, kept = json.loads((tmp_path / f"{name}.json").read_text()), quoted_figures.found(name)
        assert found["command"] == kept["command"].replace(site.FOLDER, str(tmp_path))
        assert {tuple(row) for row in found["rows"]} == {tuple(row) for row in kept["rows"]}
        assert f"bench: table {name}\n" in capsys.readouterr().err
        return found["rows"], (tmp_path / f"{name}.md").read_text()

    return make


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A folder data/ with one small room, of a known error."""
    (tmp_path / "room.toml").write_text(ROOM)
    monkeypatch.setattr(scenes, "data_folder", lambda: tmp_path)
    monkeypatch.setattr(estimates, "SCENES", {"room": ("room", True)})
    monkeypatch.setattr(estimates, "ASKED_SCENES", ("room",))
    monkeypatch.setattr(estimates, "MEASURED", 30)
    monkeypatch.setattr(estimates, "ASKED_MEASURED", 30)
    monkeypatch.setattr(scenes, "FILES", {"room": "room", "door ajar": "room"})


def test_own_estimates(room, made, monkeypatch):
    few = functools.partial(sf.solve, transport="rays", rays=16, insert=False)
    monkeypatch.setattr(estimates, "SOLVERS", {"rays": few})
    monkeypatch.setattr(estimates, "NAMES", {"rays": "`solve`"})
    monkeypatch.setitem(estimates.TIGHT, "rays", {"rays": 256})
    (few, many), text = made("estimates", 2)
    monkeypatch.setattr(estimates, "LARGE", ("room",))
    assert made("estimates_large")[0][1]["errors"] == many["errors"][:1]
    for row in (few, many):
        assert (row["scene"], row["surfels"]) == ("room", 96)
        assert len(row["errors"]) == len(row["estimates"]) == 2
        assert 0.0 < row["uncertainty"] < row["error"]
    assert (few["by"], many["by"]) == ("`solve`", "`solve`, tight")
    assert many["error"] < 0.7 * few["error"]
    assert 0.5 < few["estimate"] / few["error"] < 2.0
    errors = " ".join(f"{100 * error:.2f}" for error in few["errors"])
    assert f"| room | `solve` | 96 | {few['seconds']:.3g} | {errors} |" in text


def test_asked_for_an_error(room, made, monkeypatch):
    monkeypatch.setattr(estimates, "ASKED", (0.04,))
    (row,), text = made("asked")
    assert row["by"] == "error=0.04"
    assert row["estimate"] == row["estimates"][0] <= 0.04
    assert row["error"] < 0.08
    assert row["attempts"][0] >= 1
    assert "| room | `error=0.04` |" in text


def test_scenes_that_are_not_there_are_left_out_aloud(monkeypatch, capsys):
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    assert estimates.measure(["gallery"], 1) == []
    monkeypatch.setattr(scenes, "data_folder", lambda: None)
    assert estimates.measure_asked(["statues"], 1) == []
    err = capsys.readouterr().err
    assert "bench: gallery left out: SURFLUX_DATA names no folder of scans\n" in err
    assert "bench: statues left out: statues.toml is missing in this installation\n" in err


def test_a_dim_room(room, made, monkeypatch):
    """In place of the door a room of one light, whose surfels are dark but for those of the wall at x = 0."""
    drawn = dim_room.drawn_in_the_dark(dim_room.door_ajar(), 1000, 0)
    assert set(dim_room.door_ajar().surfels.points[drawn, 0] > 0.0) == {True}
    assert len(set(drawn)) == 80
    monkeypatch.setattr(dim_room, "MEASURED", 40)
    monkeypatch.setattr(dim_room, "PATHS", 1024)
    rows, text = made("dim_room")
    assert [row["by"] for row in rows] == list(dim_room.SOLVERS)
    for row in rows:
        assert len(row["seconds"]) == len(row["means"]) == 1
        for median, most in zip(row["medians"], row["percentiles_90"], strict=True):
            assert 0.0 <= median < most < 0.1
        assert abs(row["means"][0]) < 0.03
    assert "| `solve_meshless` |" in text


def test_many_surfels(made, monkeypatch, tmp_path):
    monkeypatch.setattr(many_surfels, "SIZES", (1000,))
    monkeypatch.setattr(many_surfels, "in_fresh_process", here)
    (row,), text = made("many_surfels")
    assert row["surfels"] == 1864
    assert 0.0 < row["silence"] < 2.0 * row["seconds"] * sf.info()["threads"]
    assert 0.0 < row["clock_silence"] < 2.0 * row["seconds"]
    assert 0.01 < row["gigabytes"] < 4.0
    assert "| 1 864 |" in text
    assert sf.read_image(tmp_path / "many_surfels.png").std() > 0.05


def test_pictures(room, made, monkeypatch):
    monkeypatch.setattr(ray_casting, "SCENES", ("room",))
    monkeypatch.setattr(ray_casting, "SIZE", (80, 60))
    (row,), text = made("pictures")
    assert 25.0 < row["decibels"] < 80.0
    assert f"| room | 80 x 60 | {row['decibels']:.1f} |" in text


def test_areas_of_ever_denser_clouds(made, monkeypatch):
    monkeypatch.setattr(areas, "DENSITIES", (100, 400))
    rows, _ = made("area_convergence")
    assert [row["n"] for row in rows] == [100, 400, "order in n"]
    assert rows[0]["total of a torus, %"] > rows[1]["total of a torus, %"]


@pytest.fixture
def ball(monkeypatch):
    """A room that is nearly a sphere, of triangles, in place of the scenes under lamps."""
    vertices, faces = shapes.icosphere(2)
    walls = sf.Surfels.from_mesh((vertices, faces[:, ::-1]), None, 0.5)
    scene = sf.Scene([walls], camera=sf.Camera([-0.5, 0, 0], [1, 0, 0]))
    case = transfer_cases.Case(lambda: scene, ((0.2, 0, 0), (0, 0.3, -0.2)), 1.0, {}, "", about=", hollow")
    monkeypatch.setattr(transfer, "CASES", {"ball": case})
    monkeypatch.setattr(transfer, "why_not", lambda: None)
    monkeypatch.setattr(transfer, "in_fresh_process", here)
    monkeypatch.setattr(transfer, "traced", functools.partial(transfer.traced, count=200))
    monkeypatch.setattr(transfer, "SIZE", (64, 48))
    monkeypatch.setattr(transfer, "FRAMES", 3)
    monkeypatch.setattr(transfer, "RELIT", 2)


def here(work, *arguments):
    """In place of a process of its own this one."""
    return work(*arguments)


def test_light_that_moves(ball, made):
    (row,), text = made("transfer", 2)
    assert (row["scene"], row["surfels"], row["seeds"]) == ("ball", 320, 2)
    assert 0.0 < row["seconds"][0] <= row["seconds"][1]
    assert set(row["frame_ms"]) == {"new renderer", "relight", "direct", "picture", "new camera"}
    assert min(row["frame_ms"].values()) > 0.0
    assert row["worst"][1] < 0.05
    # As much indirect light as direct; 3 of all bounces leave 1 / 16.
    assert row["worst_of_three"][1] == pytest.approx(1 / 16, abs=0.01 + row["worst"][1])
    assert "| ball, hollow | 320 | 2 |" in text


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs pip install surflux[dask]")
def test_processes(made, monkeypatch):
    small = sf.Scene([cube_inside(10, 0.6, 0.0)], [sf.PointLight([0.2, 0.3, 0.8], 1.0)])
    monkeypatch.setattr(processes.sf.examples, "statues", lambda: small)
    monkeypatch.setattr(processes, "SIZES", (1, 2))
    monkeypatch.setattr(processes, "KNOBS", ({},))
    monkeypatch.setattr(processes, "BALLS", 1000)
    monkeypatch.setattr(processes, "PATHS", 256)
    rows, text = made("cluster")
    assert [row["processes"] for row in rows] == [1, 2] * 3
    assert all(row["passes"] for row in rows)
    assert "Reckoned from these" in text
