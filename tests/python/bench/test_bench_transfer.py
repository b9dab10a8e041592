"""`surflux bench --transfer`: precomputed light transport beside what it is to reach."""

import json

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from surflux.bench import transfer
from surflux.bench.truth import Truth
from surflux.cli import commands

LAMP = sf.PointLight([0.4, 0.5, 0.7], 1.0)


@pytest.fixture(scope="module")
def room():
    return sf.Scene([cube_inside(6, 0.5)], [LAMP])


def test_errors_are_relative_and_without_the_noise_of_the_truth(room):
    truth = Truth(room, room.surfels, 200)
    found = np.zeros((len(room.surfels), 3))
    found[truth.index] = 1.1 * truth.indirect
    of_all, of_indirect = transfer.errors_of(found, truth)
    assert of_indirect == pytest.approx(0.1, abs=0.01)
    assert 0.0 < of_all < of_indirect
    noise = np.sqrt(transfer._squared(truth.indirect_error) / transfer._squared(truth.indirect))
    found[truth.index] = truth.indirect
    assert transfer.errors_of(found, truth) == (0.0, 0.0)
    assert 0.0 < noise < 0.05


@pytest.mark.slow
def test_a_scene_under_lamps(room, monkeypatch):
    """A small one in place of the large ones."""
    monkeypatch.setitem(transfer.BUILDERS, "statue", lambda: (room, 1.0))
    monkeypatch.setitem(transfer.LAMPS, "statue", [(0.4, 0.5, 0.7), (0.6, 0.3, 0.4)])
    row = transfer.of_lamps("statue", 2, None)
    assert len(row.seconds) == 2
    assert row.surfels == len(room.surfels)
    assert row.links > 0
    assert 0.0 <= row.error[0] <= row.error[1] < 0.05
    assert row.error[1] < row.of_indirect[1] < 0.1
    assert row.relight_ms > row.bounce_ms
    assert row.passes


def test_the_table_marks_what_is_beyond_its_limit():
    row = transfer.Row("Sponza", 10, 5, 20, [100.0, 160.0], 90.0, None, (0.01, 0.07), (0.1, 0.4), 30.0, 4.0, 12.0)
    assert row.missed() == ["seconds", "relight_ms"]
    assert not row.passes
    cells = [cell.strip() for cell in transfer.table([row]).splitlines()[-1].split("|")]
    assert cells[4:12] == [
        "100 to 160 (**<= 150**)",
        "90 (<= 103)",
        "",
        "1.0 to 7.0 (<= 8)",
        "10 to 40",
        "30 (**<= 20**)",
        "4.0 (<= 10)",
        "12.0 (>= 10)",
    ]
    row.frames = 8.0
    assert "frames" in row.missed()


def test_scenes_are_listed_and_left_out_without_scans(monkeypatch, capsys, tmp_path):
    assert commands.main(["bench", "--transfer", "--list"]) == 0
    assert capsys.readouterr().out.split() == list(transfer.NAMES)
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    kept = tmp_path / "rows.json"
    assert commands.main(["bench", "--transfer", "--json", str(kept)]) == 0
    assert capsys.readouterr().err.count("left out: SURFLUX_DATA names no folder of scans") == len(transfer.NAMES)
    assert json.loads(kept.read_text())["rows"] == []
    assert commands.main(["bench", "--transfer", "--scene", "chapel"]) == 2
    assert "--scene: there is no 'chapel'" in capsys.readouterr().err
