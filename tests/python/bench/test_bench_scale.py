"""`surflux bench --scale`: what a row says is what was solved, and references that are kept are gone on from."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import surflux as sf
from surflux.bench import mitsuba_renderer, plot, scale, scenes
from surflux.bench.scale_truth import ScaleTruth
from surflux.bench.truth import PATHS_A_ROUND, PointTruth, Truth
from surflux.cli import commands

# A closed room that is all of one colour and glows: H = E / (1 - rho) = 2 everywhere.
FURNACE = """
[[object]]
shape = "room"
patches = 2
reflectance = 0.5
emission = 1.0
[[object]]
shape = "sphere"
points = 42
radius = 0.2
translate = [0.5, 0.5, 0.5]
reflectance = 0.5
emission = 1.0
"""
LIT = """
[[object]]
shape = "room"
patches = 3
[[light]]
type = "spot"
position = [0.5, 0.5, 0.9]
direction = [0, 0, -1]
intensity = 1
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder data/ of small scenes, as the rows of the bench."""
    (tmp_path / "furnace.toml").write_text(FURNACE)
    (tmp_path / "lit.toml").write_text(LIT)
    monkeypatch.setattr(scenes, "data_folder", lambda: tmp_path)
    monkeypatch.setattr("surflux.bench.scale_truth.data_folder", lambda: tmp_path)
    monkeypatch.setattr(ScaleTruth.__init__, "__defaults__", (None, None, None, 40))
    monkeypatch.setattr(scale, "SCENES", {"furnace": ("furnace", None), "denser": ("furnace", 90)})
    monkeypatch.setattr(scale, "why_not", lambda name: None)
    return tmp_path


@pytest.mark.slow
def test_rows_from_a_process_of_their_own(folder, tmp_path, capsys):
    rows, text = tmp_path / "rows.json", tmp_path / "rows.md"
    arguments = ["--repeats", "1", "--cache", str(tmp_path / "kept"), "--paths", "4096"]
    assert commands.main(["bench", "--scale", *arguments, "--json", str(rows), "--markdown", str(text)]) == 0
    out, err = capsys.readouterr()
    assert out == text.read_text()
    assert "bench: denser, reference" in err
    whole, denser = json.loads(rows.read_text())["rows"]
    assert (whole["scene"], whole["surfels"], denser["surfels"]) == ("furnace", 24 + 42, 90)
    for row in (whole, denser):
        assert row["leaves"] >= row["surfels"]
        assert row["seconds"] >= row["stages"]["areas"] > 0.0
        assert row["loading"] > 0.0
        assert 0.01 < row["gigabytes"] < 4.0
        assert 0.01 < row["loading_gigabytes"] < 4.0
        assert row["figures"]["rays"] > 0
        assert row["paths"] == 4096
        assert row["error"] < 0.02  # a furnace
        assert row["reference"] < 0.01
        assert f"| {row['scene']} | {row['surfels']} |" in out
    assert len(list((tmp_path / "kept").glob("furnace-*.npz"))) == 2


@pytest.mark.slow
def test_what_is_kept_is_gone_on_from(folder, tmp_path):
    first = ScaleTruth("lit", cache=tmp_path / "kept")
    assert first.surfels.rounds == first.points.rounds == 4
    first.refine()
    again = ScaleTruth("lit", cache=tmp_path / "kept")
    assert again.surfels.paths == 40 * 5 * PATHS_A_ROUND
    for one, other in ((first.surfels, again.surfels), (first.points, again.points)):
        np.testing.assert_array_equal(one.total, other.total)
        np.testing.assert_array_equal(one.indirect_error, other.indirect_error)
    alone = ScaleTruth("lit")
    assert alone.surfels.rounds == 4
    alone.refine()
    np.testing.assert_array_equal(alone.surfels.total, again.surfels.total)
    # Another scene has a file of its own; the file of other surfels is refused.
    (file,) = (tmp_path / "kept").iterdir()
    (tmp_path / "lit.toml").write_text(LIT.replace("0.9", "0.8"))
    assert ScaleTruth("lit", cache=tmp_path / "kept").surfels.rounds == 4
    assert len(list((tmp_path / "kept").iterdir())) == 2
    (tmp_path / "lit.toml").write_text(LIT)
    with np.load(file) as data:
        changed = {**data, "all_points": "others"}
    np.savez(file, **changed)
    with pytest.raises(ValueError, match=r"^--cache: .*lit-whole-.*npz is of a scene with other surfels; remove it$"):
        ScaleTruth("lit", cache=tmp_path / "kept")


def test_points_lie_on_the_surface_and_their_truth_is_there():
    """Over the middle of a square the light of 3 W/sr at height 1 falls off as (1 + r^2)^-3/2."""
    floor = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]))
    scene = sf.Scene([floor], [sf.PointLight([0, 0, 1], 3.0)])
    truth = PointTruth(scene, floor, 50)
    x, y, z = truth.points.T
    assert np.all(z == 0.0)
    assert min(x.max(), y.max(), -x.min(), -y.min()) > 0.7
    np.testing.assert_allclose(truth.total[:, 0], 3.0 * (1 + x**2 + y**2) ** -1.5, rtol=1e-6)
    disks = sf.Surfels(np.eye(3), np.eye(3), radii=0.1, areas=0.03)
    assert {tuple(p) for p in PointTruth(sf.Scene([disks]), disks, 30).points} == {tuple(p) for p in np.eye(3)}


def test_direct_light_from_more_places_is_the_same_with_less_noise():
    """A patch that the border of a spot crosses: 16 places on it see it worse than 128."""
    floor = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]))
    scene = sf.Scene([floor], [sf.SpotLight([0, 0, 1], [0, 0, -1], 3.0, cone=60, penumbra=2)])
    few, many = (Truth(scene, floor, 20, direct_places=n) for n in (0, 128))
    assert np.mean(many.total_error) < 0.5 * np.mean(few.total_error)
    assert abs(many.total.mean() - few.total.mean()) < 5 * np.mean(few.total_error) / np.sqrt(20)
    assert np.all(many.indirect == 0.0)


@pytest.mark.slow
def test_values_at_points_count_where_a_solution_has_them(folder, monkeypatch):
    truth = ScaleTruth("furnace", measured=30)
    n = len(truth.points.points)
    seen = {}

    def irradiance_at(points, normals):
        seen.update(points=points, normals=normals)
        return np.full((len(points), 3), 2.2)

    monkeypatch.setattr(sf.Solution, "irradiance_at", lambda self, *a, **k: irradiance_at(*a, **k), raising=False)
    result = scale.solved(str(folder / "furnace.toml"), None, 1, None, (truth.points.points, truth.points.normals))
    assert np.array_equal(seen["points"], truth.points.points)
    assert np.array_equal(seen["normals"], truth.points.normals)
    assert result["at_points"].shape == (n, 3)
    assert np.abs(result["total"] - 2.0).max() < 0.1
    assert result["stages"][f"at {n} points"] >= 0.0

    monkeypatch.setattr(scale, "in_fresh_process", lambda *arguments: result)
    row = scale.of_scene("furnace", truth, 1, None, 1024)
    assert row.at_points == pytest.approx(0.1, rel=0.1)  # 2.2 for 2
    assert f"| {100 * row.at_points:.2g} |" in scale.table([row])


def test_when_a_curve_reaches_an_error():
    curve = [[1.0, 0.04], [4.0, 0.02], [16.0, 0.012]]
    assert scale.seconds_until(0.02, curve) == pytest.approx(4.0)
    assert scale.seconds_until(0.04 / 2**0.5, curve) == pytest.approx(2.0)
    assert scale.seconds_until(0.08, curve) == pytest.approx(0.25)  # beyond: by the root
    assert scale.seconds_until(0.006, curve) == pytest.approx(64.0)
    worse = [[1.0, 0.04], [2.0, 0.041], [4.0, 0.02]]
    assert 2.0 <= scale.seconds_until(0.03, worse) <= 4.0


def test_mitsuba_beside_it(folder, monkeypatch):
    monkeypatch.setattr(mitsuba_renderer, "load", lambda threads: None)
    row = scale.Row("furnace", 66, 66, 1.0, 0.1, error=0.01)
    scale.beside_mitsuba(row, None, 1, None)
    assert row.mitsuba_seconds is None
    row.mitsuba_seconds = 8.0
    assert "error of 1 % at as many places of the same polygons after 8.00 s, 8.0 times" in scale.table([row])


def test_seconds_until_mitsuba_is_as_good(monkeypatch):
    pytest.importorskip("mitsuba")
    monkeypatch.setattr(scale, "MITSUBA_SAMPLES", (4, 64))
    row = scale.Row("three spheres", 4326, 4326, 1.0, 0.1, error=0.01)
    truth = SimpleNamespace(surfels=SimpleNamespace(index=np.arange(60), rounds=4))
    scale.beside_mitsuba(row, truth, 1, None)
    (_, rough), (_, fine) = row.mitsuba
    assert 0.0 < fine < rough
    assert row.mitsuba_seconds > 0.0


@pytest.mark.slow
def test_growth_is_told_and_drawn(tmp_path):
    rows = [scale.Row(f"gallery of {n}", n, n, 1e-5 * n**1.5, 1e-6 * n, 0.02, 0.03) for n in (100, 10_000)]
    rows.append(scale.Row("three spheres", 1, 1, 1.0, 0.1))
    for row in rows:
        row.stages = {"direct": 0.6 * row.seconds, "solve": 0.01 * row.seconds}
    text = scale.table(rows)
    assert "From 100 to 10000 surfels of the gallery seconds grow as n^1.50, from row to row as n^1.50." in text
    plot.draw_growth(rows, tmp_path / "growth.png")
    assert sf.read_image(tmp_path / "growth.png").std() > 0.05
    with pytest.raises(ValueError, match="--plot: wanted galleries or statues among the scenes, got none"):
        plot.draw_growth(rows[-1:], tmp_path / "none.png")
    rows = [replace(row, scene=row.scene.replace("gallery", "statues")) for row in rows[:2]] + rows[:1]
    plot.draw_growth(rows, tmp_path / "statues.png")  # of which there are more
    assert sf.read_image(tmp_path / "statues.png").std() > 0.05


def test_errors_that_the_reference_is_not_sure_of_are_marked():
    row = scale.Row("x", 1, 1, 1.0, None, error=0.02, reference=0.004, indirect=0.02, reference_indirect=0.006)
    text = scale.table([row])
    assert "| 2 ± 0 | ~ 2 |" in text
    assert scale.short_table([row]).splitlines()[-1] == "| x | 1 | 1.00 |  | 0.00 | 2 | ~ 2 |  |  |"
    assert row.is_claimed("at_points", "reference_at_points")  # there is none


def test_scenes_that_cannot_be_had_are_left_out_aloud(monkeypatch, capsys):
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    assert scale.measure(["gallery"], 1, None) == []
    assert "bench: gallery left out: SURFLUX_DATA names no folder of scans" in capsys.readouterr().err
    monkeypatch.setattr(scenes, "data_folder", lambda: None)
    assert scale.measure(["three spheres"], 1, None) == []
    assert "three spheres left out: three_spheres.toml is missing" in capsys.readouterr().err
    assert commands.main(["bench", "--scale", "--list"]) == 0
    assert capsys.readouterr().out.split("\n")[:-1] == list(scale.SCENES)
