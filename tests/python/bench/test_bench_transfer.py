"""`surflux bench --transfer`: errors are those that were made, and what is wanted is judged cell by cell."""

import json

import numpy as np
import pytest
import trimesh

import surflux as sf
from surflux.bench import transfer, transfer_cases, transfer_truth
from surflux.bench.transfer_truth import LampTruth, errors_of, traced, traced_pictures
from surflux.cli import commands
from surflux.scenes import shapes

REFLECTANCE = 0.5


@pytest.fixture(scope="module")
def ball():
    """A room that is nearly a sphere of radius 1, of triangles."""
    vertices, faces = shapes.icosphere(3)
    return sf.Scene([sf.Surfels.from_mesh((vertices, faces[:, ::-1]), None, REFLECTANCE)])


def test_the_truth_of_a_lamp_in_a_ball(ball):
    """Of a lamp of I in its middle the inside of a sphere of radius 1 has I directly, and I rho / (1 - rho) else.

    Those of area A have, of 4 pi I, 4 pi / A times as much in the mean over A; A is .6 % less than that of the sphere.
    """
    surfels = ball.surfels
    found = traced(ball, sf.PointLight([0, 0, 0], 3.0), surfels, count=400)
    direct = 3.0 * 4 * np.pi / surfels.areas.sum()
    np.testing.assert_allclose((found.total - found.indirect).mean(), direct, rtol=2e-3)
    off = found.indirect - direct * REFLECTANCE / (1 - REFLECTANCE)
    # The mean, by its standard error; variances are those that were told, to 1 / sqrt(2 * 7 * 400) of 1.3 %, times 4.
    assert abs(off.mean()) < 4 * np.sqrt(np.mean(found.indirect_error**2) / len(off)) + 2e-3 * direct
    assert np.mean(off**2) == pytest.approx(np.mean(found.indirect_error**2), rel=0.15)


def test_the_truth_is_that_of_reference_irradiance(ball, monkeypatch):
    """The core is asked without areas: bit by bit what the public function has."""
    seen = []
    core = transfer_truth._core.reference_irradiance

    def recorded(scene, points, normals, paths, seed):
        seen.append((points, normals, paths, seed, core(scene, points, normals, paths, seed)[0]))
        return seen[-1][-1], None, None

    monkeypatch.setattr(transfer_truth._core, "reference_irradiance", recorded)
    lamp = sf.PointLight([0.3, 0.1, 0], 1.0)
    traced(ball, lamp, ball.surfels, count=20, seed=5)
    monkeypatch.undo()
    points, normals, paths, seed, found = seen[0]
    expected, _ = sf.reference_irradiance(sf.Scene(ball.objects, [lamp]), points, normals, samples=paths, seed=seed)
    np.testing.assert_array_equal(found, expected)


def noisy_truth(true, spread, rng):
    """As if it had been traced with a standard error of spread."""
    shape = len(true), transfer_truth.ROUNDS, 3
    rounds = true[:, None] + spread * np.sqrt(transfer_truth.ROUNDS) * rng.normal(size=shape)
    indirect, error = rounds.mean(axis=1), rounds.std(axis=1, ddof=1) / np.sqrt(transfer_truth.ROUNDS)
    return LampTruth(np.arange(len(true)), indirect + 3.0 * true, indirect, error, error)


@pytest.mark.parametrize("off", [0.0, 0.05, 0.2])
def test_errors_are_without_the_noise_of_the_truth(off):
    """Every colour is off by one share of itself; noise is .3 of what is true, and all light 4 times the indirect."""
    rng = np.random.default_rng(1)
    true = rng.uniform(0.5, 1.5, (20_000, 3))
    of_all, of_own, _, own_doubt = errors_of((1.0 + off) * true, noisy_truth(true, 0.3, rng))
    # Squares are unbiased, not errors, which are cut off at 0: within 4 standard errors of a square.
    assert abs(of_own**2 - off**2) < 4 * max(2 * of_own * own_doubt, (2 * own_doubt) ** 2)
    assert of_all == pytest.approx(of_own / 4, rel=0.02)


def test_standard_errors_are_what_errors_scatter_by():
    rng = np.random.default_rng(2)
    runs = []
    for _ in range(200):
        true = rng.uniform(0.5, 1.5, (300, 3))
        runs.append(errors_of(true * rng.uniform(0.8, 1.3, (300, 1)), noisy_truth(true, 0.1, rng)))
    of_all, of_own, doubt, own_doubt = np.transpose(runs)
    # A standard deviation of 200 is known to 1 / sqrt(400), 5 %: three times that.
    assert doubt.mean() == pytest.approx(of_all.std(), rel=0.15)
    assert own_doubt.mean() == pytest.approx(of_own.std(), rel=0.15)


def test_the_truth_of_a_picture():
    """An even sky of radiance 2 on a convex glossy ball: both reflectances times 2, where lobes are above it."""
    vertices, faces = shapes.icosphere(3)
    looks = {"reflectance": 0.3, "specular": 0.2, "exponent": 2000.0}
    scene = sf.Scene([sf.Surfels.from_mesh((vertices, faces), **looks)], [sf.Environment(2.0)])
    camera, size = sf.Camera([0, -4, 0], [0, 0, 0], fov=20), (40, 40)
    traced = traced_pictures(sf.solve(scene, insert=False), scene, camera, size, glossy_bounces=True)
    assert traced.shape == (2, 40, 40, 3)
    np.testing.assert_allclose(traced[:, 10:30, 10:30], (0.3 + 0.2) * 2.0, rtol=0.05)
    assert transfer_truth.picture_error(1.1 * traced.mean(axis=0), traced)[0] == pytest.approx(0.1, abs=0.005)


@pytest.mark.slow
def test_a_scene_under_lamps(ball, monkeypatch):
    """A small one in place of the large ones."""
    case = transfer_cases.Case(lambda: ball, ((0.2, 0, 0), (0, 0.3, -0.2)), 1.0, {}, "")
    monkeypatch.setitem(transfer.CASES, "statue", case)
    row = transfer.of_lamps("statue", 2, None)
    assert (row.seeds, row.surfels, row.triangles) == (2, 1280, 1280)
    assert row.links > 0
    assert 0.0 < row.seconds[0] <= row.seconds[1]
    assert 0.0 <= row.rms[0] <= row.worst[1] < 0.05
    # As much indirect light as direct: relative to it alone errors are twice as large; 3 of all bounces leave 1 / 16.
    assert row.worst_of_indirect[1] == pytest.approx(2 * row.worst[1], rel=0.1)
    assert row.worst_of_three[1] == pytest.approx(1 / 16, abs=0.01 + row.worst[1])
    assert row.relight_ms > 0.0
    assert row.frames > 0.0
    assert row.gigabytes > 0.01


@pytest.mark.slow
def test_a_row_in_a_process_of_its_own(tmp_path, monkeypatch, capsys):
    """The scene of the statue, in whose place a ball stands."""
    monkeypatch.setenv("SURFLUX_DATA", str(tmp_path))
    (tmp_path / "statues").mkdir()
    vertices, faces = shapes.icosphere(4)
    trimesh.Trimesh(5.0 * np.add(vertices, [0, 1, 0]), faces).export(tmp_path / "statues" / "dragon_50k.ply")
    kept = tmp_path / "rows.json"
    status = commands.main(["bench", "--transfer", "--scene", "statue", "--repeats", "1", "--json", str(kept)])
    (row,) = json.loads(kept.read_text())["rows"]
    assert status == (0 if all(row["kept"].values()) else 1)
    assert row["wanted"] == transfer.CASES["statue"].wanted
    assert row["triangles"] > len(faces) == 5120
    assert 0.0 < row["worst"][1] < 0.05
    out = capsys.readouterr().out
    assert "| statue |" in out
    assert out.endswith("\n\nstatue: precomputed with epsilon_t=0.1, rays=256.\n")


def sponza_row(**changed):
    found = {
        "seconds": (100.0, 160.0),
        "megabytes": 90.0,
        "worst": (0.01, 0.07),
        "uncertainty": 0.004,
        "rms": (0.01,) * 2,
    }
    found |= {"relight_ms": 30.0, "bounce_ms": 4.0, "frames": 12.0, "core_seconds": (50.0, 60.0)}
    row = transfer.Row("Sponza", 12, 10, 20, 3, **found | changed, worst_of_three=(0.02, 0.02), estimate=(0.05, 0.06))
    row.judge(transfer.CASES["Sponza"].wanted)
    return row


def test_the_table_says_of_each_cell_whether_it_is_kept():
    row = sponza_row()
    assert [name for name, kept in row.kept.items() if not kept] == ["seconds", "relight_ms"]
    assert not row.passes
    cells = [cell.strip() for cell in transfer.table([row]).splitlines()[-1].split("|")]
    assert cells[1:-2] == [
        *["Sponza", "12", "10", "20", "3"],
        "100 to 160 (<= 150: NO)",
        "50 to 60",
        "90 (<= 103: yes)",
        "",
        "1.0 to 7.0 ± 0.4 (<= 8: yes)",
        "1.0",
        "",
        "5.0 to 6.0",
        "2.0",
        "30 (<= 20: NO)",
        "4.0 (<= 10: yes)",
        "12.0 (>= 10: yes)",
    ]
    assert sponza_row(seconds=(140.0, 150.0), relight_ms=20.0).passes


@pytest.mark.parametrize("changed", [{"frames": 9.9}, {"frames": None}, {"worst": (0.01, 0.081)}, {"megabytes": 104.0}])
def test_what_is_missed_or_not_found_does_not_pass(changed):
    row = sponza_row(seconds=(1.0, 1.0), relight_ms=1.0, **changed)
    assert [name for name, kept in row.kept.items() if not kept] == list(changed)


def test_missing_what_is_wanted_is_the_exit_status(monkeypatch, capsys):
    for row, status in ((sponza_row(), 1), (sponza_row(seconds=(1.0, 1.0), relight_ms=1.0), 0)):
        monkeypatch.setattr(transfer, "measure", lambda names, repeats, threads, found=row: [found])
        assert commands.main(["bench", "--transfer"]) == status
        assert "| Sponza |" in capsys.readouterr().out


def test_scenes_are_listed_and_left_out_without_scans(monkeypatch, capsys, tmp_path):
    assert commands.main(["bench", "--transfer", "--list"]) == 0
    assert capsys.readouterr().out.split("\n")[:-1] == list(transfer.CASES)
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    kept = tmp_path / "rows.json"
    assert commands.main(["bench", "--transfer", "--json", str(kept)]) == 0
    assert capsys.readouterr().err.count("left out: SURFLUX_DATA names no folder of scans") == len(transfer.CASES)
    assert json.loads(kept.read_text())["rows"] == []
    monkeypatch.setenv("SURFLUX_DATA", str(tmp_path))
    monkeypatch.setattr(transfer.scenes, "data_folder", lambda: None)
    assert transfer.measure(["statue"], 1, None) == []
    assert "bench: statue left out: its scene file is missing in this installation" in capsys.readouterr().err
    assert commands.main(["bench", "--transfer", "--scene", "chapel"]) == 2
    assert "--scene: there is no 'chapel'" in capsys.readouterr().err
