"""Tables of `surflux bench --site` that say how far surflux is off, with tiny settings."""

import numpy as np
import pytest

import surflux as sf
from surflux.bench import areas, closed_forms, facing, limits, site, sky, solar, tiles


def test_limits_say_what_is_better(monkeypatch, capsys):
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    some = {
        key: found for key, found in limits.LIMITS.items() if found[1] in (limits.grid_square, limits.thinned_statue)
    }
    monkeypatch.setattr(limits, "LIMITS", some)
    (row,) = site.TABLES["limits"].measure(1, None)
    assert "bench: area, too few points, armadillo, 3000 points, left out: " in capsys.readouterr().err
    assert (row["what"], row["better"]) == ("area, open border", "40 x 40")
    # Half a cell is missing on every side, but for .05 of the spacing that surfaces are taken to go on.
    for n, column in ((20, "error, %"), (40, "error then, %")):
        assert row[column] == pytest.approx(100.0 * ((1.0 - 0.9 / n) ** 2 - 1.0), abs=0.5)
    text = site.TABLES["limits"].text([row])
    assert text.splitlines()[1] == "|---|---|--:|---|--:|"


def test_plates_are_right_by_pairs(monkeypatch):
    monkeypatch.setattr(limits, "SEEDS", (0,))
    rays, pairs = limits.small_plates(count=2)
    assert pairs < 1e-4 < rays


def test_a_hole_is_bridged(monkeypatch):
    monkeypatch.setattr(limits, "SEEDS", (0,))
    coarse, fine = limits.hole_in_a_square((200, 800))
    assert 0.0 < fine < coarse < 0.5


def test_noise_falls_with_rays():
    room = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.05)
    wall = sf.Surfels.from_mesh(([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], [[0, 1, 2, 3]]), 0.05)
    few, many = limits.noise_of_rays(lambda: sf.Scene([room, wall], [sf.PointLight([0.5, 0.5, 1.5], 1.0)]))()
    assert 0.0 < many < 0.8 * few


def test_errors_beside_closed_forms(monkeypatch):
    monkeypatch.setattr(closed_forms, "SEEDS", (0,))
    monkeypatch.setattr(closed_forms, "SCENES", {"points": lambda: closed_forms.of_points(100)})
    found = closed_forms.rows()
    assert [row["solver"] for row in found] == list(closed_forms.SOLVERS)
    assert [row["surfels"] for row in found] == [500] * 3
    for row in found:
        assert 0.0 < row["error, %"] < 5.0
        assert 0.0 < row["its own estimate, %"] < 5.0


@pytest.mark.parametrize("make", [lambda: closed_forms.sphere(400), lambda: closed_forms.of_triangles(2)])
def test_closed_forms_are_what_pairs_come_to(make):
    scene, exact = make()
    solution = closed_forms.SOLVERS["`solve`, pairs"](scene, 0)
    assert closed_forms.relative_rms(solution, exact[:, None]) < 0.01


def test_facing_of_a_room(monkeypatch, capsys):
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    monkeypatch.setattr(facing, "POINTS", 3000)
    monkeypatch.setattr(facing, "SEEDS", (0,))
    monkeypatch.setattr(facing, "CLOUDS", {k: v for k, v in facing.CLOUDS.items() if "room with" in k or k == "bunny"})
    (full,) = facing.rows()
    assert "bench: bunny left out: " in capsys.readouterr().err
    assert full["points"] == 3450
    for column in ("estimated, %", "given, %", "turned over, %", "in pieces, %"):
        assert full[column] > 99.0


def test_sky_view_by_more_rays(monkeypatch):
    xy = np.random.default_rng(0).uniform(0.0, 20.0, (400, 2))
    rough = sf.Surfels(np.column_stack([xy, 3.0 * np.sin(xy[:, 0])]), viewpoint=(10.0, 10.0, 100.0))
    monkeypatch.setenv("SURFLUX_DATA", "")
    assert sky.rows() == []
    assert areas.as_markdown([])
    monkeypatch.setenv("SURFLUX_DATA", "there")
    monkeypatch.setattr(sky, "_surfels", lambda: rough)
    few, many = sky.rows()
    assert 0.0 < many["error, % of the sky"] < 0.6 * few["error, % of the sky"]
    assert few["error, % of what is seen"] > few["error, % of the sky"]


@pytest.mark.slow
def test_a_year_on_open_planes(monkeypatch, capsys):
    pytest.importorskip("pvlib", reason="needs surflux[solar]")
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    monkeypatch.setattr(solar, "PLACES", {"Zurich": solar.PLACES["Zurich"]})
    (row,) = solar.rows()
    assert "bench: weather and tile left out: " in capsys.readouterr().err
    assert abs(row["off, %"]) < 0.3
    assert row["kWh/m²"] == pytest.approx(row["expected"], rel=0.004)


def test_chance_is_taken_off_what_tiles_differ_by():
    row = tiles._row("halo 20 m", 10, 0.125, np.array([25e-4, 9e-4]), np.array([9e-4, 16e-4]))
    assert (row["error, %"], row["chance, %"], row["left, %"]) == (5.0, 3.0, 4.0)
    assert (row["error by borders, %"], row["chance by borders, %"], row["left by borders, %"]) == (3.0, 4.0, 0.0)


def test_squares_are_of_points_that_both_know():
    ones, border = np.ones((3, 3)), np.array([True, False, False])
    other = np.array([[1.5] * 3, [1.0] * 3, [np.nan] * 3])
    np.testing.assert_allclose(tiles.squares(other, ones, border), [0.125, 0.25])


def test_rows_have_as_many_tiles_as_they_say(monkeypatch):
    pytest.importorskip("laspy", reason="needs surflux[scans]")
    monkeypatch.setattr(tiles, "DENSE", 6.0)
    monkeypatch.setattr(tiles, "in_fresh_process", lambda _, paths, *of: 0.1 * len(list(paths[0].parent.glob("tile*"))))
    assert [(row["tiles in a row"], row["GB"]) for row in tiles.memory()] == [(2, 0.2), (4, 0.4), (8, 0.8)]
    few, _, many = (row["points"] for row in tiles.memory())
    assert 3.0 < many / few < 5.0


@pytest.mark.slow
def test_tiles_of_a_small_town(monkeypatch):
    pytest.importorskip("laspy", reason="needs surflux[scans]")
    monkeypatch.setattr(tiles, "SIDE", 120.0)
    monkeypatch.setattr(tiles, "CUT", 2)
    monkeypatch.setattr(tiles, "HALOS", (60.0,))
    whole, tiled = tiles.rows()
    assert (whole["run"], tiled["run"]) == ("untiled", "halo 60 m")
    assert whole["points"] == tiled["points"] > 1000
    assert 0.0 <= tiled["left, %"] < tiled["error, %"] < 20.0
