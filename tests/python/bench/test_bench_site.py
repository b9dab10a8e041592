"""Tables of `surflux bench --site` on small scenes: rows have the fields that data/figures keeps, and are right."""

import functools
import json

import pytest

import quoted_figures
import surflux as sf
from surflux.bench import site, transfer, transfer_cases
from surflux.scenes import shapes


def made(name, folder, seeds=1):
    """The rows of a table that is measured, its text, and whether data/figures has the same fields."""
    site.write(folder, seeds, None, {name})
    found, kept = json.loads((folder / f"{name}.json").read_text()), quoted_figures.found(name)
    assert found["command"] == kept["command"]
    assert {tuple(row) for row in found["rows"]} == {tuple(row) for row in kept["rows"]}
    return found["rows"], (folder / f"{name}.md").read_text()


@pytest.fixture
def ball(monkeypatch):
    """A room that is nearly a sphere, of triangles, in place of the scenes under lamps."""
    vertices, faces = shapes.icosphere(2)
    scene = sf.Scene(
        [sf.Surfels.from_mesh((vertices, faces[:, ::-1]), None, 0.5)], camera=sf.Camera([-0.5, 0, 0], [1, 0, 0])
    )
    case = transfer_cases.Case(lambda: scene, ((0.2, 0, 0), (0, 0.3, -0.2)), 1.0, {}, "", about=", hollow")
    monkeypatch.setattr(transfer, "CASES", {"ball": case})
    monkeypatch.setattr(transfer, "measure", lambda names, seeds, threads: [transfer.of_lamps("ball", seeds, threads)])
    monkeypatch.setattr(transfer, "traced", functools.partial(transfer.traced, count=200))
    monkeypatch.setattr(transfer, "SIZE", (64, 48))
    monkeypatch.setattr(transfer, "FRAMES", 3)
    monkeypatch.setattr(transfer, "RELIT", 2)


def test_light_that_moves(ball, tmp_path):
    (row,), text = made("transfer", tmp_path, 2)
    assert (row["scene"], row["surfels"], row["seeds"]) == ("ball", 320, 2)
    assert 0.0 < row["seconds"][0] <= row["seconds"][1]
    # A frame is its parts; that from a new camera, and the first of a renderer, have more to do.
    parts = row["frame_ms"]
    assert sum(parts[part] for part in ("relight", "direct", "picture")) < 1e3 / row["frames"]
    assert min(parts["new renderer"], parts["new camera"]) > parts["picture"]
    assert row["worst"][1] < 0.05
    # As much indirect light as direct; 3 of all bounces leave 1 / 16.
    assert row["worst_of_three"][1] == pytest.approx(1 / 16, abs=0.01 + row["worst"][1])
    assert "| ball, hollow | 320 | 2 |" in text
