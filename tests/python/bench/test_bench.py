"""`surflux bench`: the table says what was run, and its errors are those of the closed forms."""

import json
import sys

import numpy as np
import pytest

import surflux as sf
from surflux.bench import areas, cases, factors, scenes, sky
from surflux.cli import commands


def test_a_case_gives_a_row_in_all_three_forms(tmp_path, capsys):
    markdown, rows = tmp_path / "bench.md", tmp_path / "bench.json"
    arguments = ["--case", "furnace in a cube", "--repeats", "1", "--markdown", str(markdown), "--json", str(rows)]
    assert commands.main(["bench", *arguments]) == 0
    printed = capsys.readouterr().out
    assert printed == markdown.read_text()
    found = json.loads(rows.read_text())
    (row,) = found["rows"]
    assert (row["case"], row["surfels"]) == ("furnace in a cube", 6 * 13 * 13)
    assert row["error"] < 1e-3  # the furnace is closed: B = E / (1 - rho) on every surfel
    assert row["seconds"] >= sum(row["stages"].values()) > 0
    assert "exchange" in row["stages"]
    assert f"| furnace in a cube | {row['surfels']} |" in printed
    assert found["machine"]["threads"] >= 1


@pytest.mark.parametrize(
    ("name", "largest"),
    [
        ("areas of an icosphere", 0.001),
        ("areas of an icosphere, paper's", 0.04),  # D04 reports 2.63 %
        ("sphere inside", 0.01),
        ("form factors in a cube", 0.005),
    ],
)
@pytest.mark.slow
def test_errors_are_those_of_the_closed_forms(name, largest):
    row = cases.measure(name, cases.CASES[name][1], 1, None)
    assert 0.0 < row.error < largest


@pytest.mark.scans
@pytest.mark.slow
def test_the_sky_of_a_lidar_tile():
    surfels, seconds, error, against, stages = sky.tile(None)
    assert surfels == 110_000
    assert seconds == pytest.approx(sum(stages.values()))
    assert 0.002 < error < 0.015
    assert against == "4096 rays of another seed, RMS"


def test_cases_without_their_data_are_left_out_aloud(monkeypatch, capsys):
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    assert commands.main(["bench", "--case", "two bunnies"]) == 0
    out, err = capsys.readouterr()
    assert "two bunnies left out" in err
    assert "two bunnies" not in out


def test_view_factors_are_measured_beside_a_peer():
    class Peer:
        """One that is off by one per cent, from column to row."""

        @staticmethod
        def compute_viewfactor_matrix(mesh, skip_obstruction):
            faces = mesh.regular_faces
            corners = mesh.points[faces[:, [0, 1, 3]]].astype(float)
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            assert np.all(np.sum(normals * (0.5 - corners.mean(axis=1)), axis=1) > 0)  # it sees the inside
            assert skip_obstruction
            return 0.99 * sf.form_factors(sf.Scene([sf.Surfels.from_mesh((mesh.points, faces))])).T

    surfels, seconds, error, against, stages = factors.cube_factors(None, Peer)
    assert surfels == 864
    assert error < 1e-10
    assert seconds == stages["surflux"]
    assert stages["pyviewfactor"] > 0
    assert against.startswith("between faces, largest; row sums ")
    assert against.endswith("; pyviewfactor 2.0e-03, row sums 1.0e-02")


def test_a_peer_that_is_not_installed_is_left_out_aloud(monkeypatch, capsys):
    monkeypatch.setattr(factors.importlib.util, "find_spec", lambda name: None)
    assert commands.main(["bench", "--case", factors.NAME]) == 0
    out, err = capsys.readouterr()
    assert err == "bench: view factors beside pyviewfactor left out: needs pip install 'surflux[bench]'\n"
    assert "pyviewfactor" not in out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--case", "nothing"], "--case: there is no 'nothing'; --list names them all"),
        (["--repeats", "0"], "--repeats: wanted at least 1, got 0"),
        (["--threads", "0"], "--threads: wanted a whole number from 1"),
        (["--plot", "knobs.png"], "--plot: goes with --quick, --full, --scale or --areas"),
        (["--reference", "--plot", "knobs.png"], "--plot: goes with --quick, --full, --scale or --areas"),
        (["--areas", "--case", "statues"], "--case: does not go with --areas"),
        (["--quick", "--case", "statues"], "--case: does not go with --quick"),
        (["--scene", "statues"], "--scene: goes with --quick, --full, --scale, --constants or --transfer"),
        (["--full", "--scene", "gallery"], "--scene: there is no 'gallery'; --list names them all"),
        (["--paths", "4096"], "--paths: goes with --quick, --full, --scale or --reference"),
        (["--reference", "--paths", "1000"], "--paths: wanted a whole number from 1024"),
        (["--cache", "kept"], "--cache: goes with --scale"),
        (["--scale", "--scene", "statues"], "--scene: there is no 'statues'; --list names them all"),
        (["--json", "no/a.json"], "no/a.json: cannot be written: there is no folder no"),
        (["--quick", "--plot", "no/a.png"], "no/a.png: cannot be written: there is no folder no"),
        (["--markdown", "/"], "/: is a folder, not a file"),
        (["--areas", "--plot", "knobs.doc"], "--plot: wanted a name ending in .png, got 'knobs.doc'"),
        (["--constants", "--plot", "a.png"], "--plot: goes with --quick, --full, --scale or --areas"),
        (["--transfer", "--plot", "a.png"], "--plot: goes with --quick, --full, --scale or --areas"),
        (["--transfer", "--paths", "4096"], "--paths: goes with --quick, --full, --scale or --reference"),
        (["--transfer", "--quick"], "--transfer: does not go with --quick"),
        (["--cluster", "--quick"], "--cluster: does not go with --quick"),
        (["--constants", "--quick"], "--constants: does not go with --quick"),
        (["--scale", "--quick"], "--scale: does not go with --quick"),
        (["--full", "--quick"], "--full: does not go with --quick"),
        (["--site", "figures", "--quick"], "--site: does not go with --quick"),
        (["--site", "figures", "--json", "a.json"], "--json: does not go with --site, which writes both"),
        (["--site", "figures", "--case", "statues"], "--case: does not go with --site"),
        (["--site", __file__], "--site: wanted a folder, and "),
    ],
)
def test_wrong_arguments(capsys, arguments, message):
    assert commands.main(["bench", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_plot_that_cannot_be_drawn_is_told_before_anything_is_measured(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib.backend_bases", None)
    assert commands.main(["bench", "--quick", "--plot", "a.png"]) == 2
    assert "--plot: needs `pip install 'surflux[bench]'`" in capsys.readouterr().err


def test_cases_of_scene_files_that_are_not_there_are_left_out_aloud(monkeypatch, capsys):
    monkeypatch.setattr(scenes, "data_folder", lambda: None)
    assert commands.main(["bench", "--case", "statues"]) == 0
    assert "statues left out" in capsys.readouterr().err


def test_the_cases_can_be_listed(capsys):
    assert commands.main(["bench", "--list"]) == 0
    assert capsys.readouterr().out.split("\n")[:-1] == list(cases.CASES)
    assert commands.main(["bench", "--quick", "--list"]) == 0
    assert capsys.readouterr().out.split("\n")[:-1] == list(scenes.NAMES)


@pytest.mark.slow
def test_tables_of_areas(monkeypatch, tmp_path, capsys):
    small = {
        "CLOUDS": {"icosphere 642": areas.CLOUDS["icosphere 642"]},
        "DENSITIES": (100, 400, 1600),
        "SIZES": (300, 600),
        "SPEED_CLOUD": 300,
        "KNOB_CLOUD": 300,
    }
    for name, value in small.items():
        monkeypatch.setattr(areas, name, value)
    markdown, rows, plot = tmp_path / "areas.md", tmp_path / "areas.json", tmp_path / "knobs.png"
    options = ["--markdown", str(markdown), "--json", str(rows), "--plot", str(plot)]
    assert commands.main(["bench", "--areas", "--repeats", "1", *options]) == 0
    assert markdown.read_text() in capsys.readouterr().out
    clouds, densities, knobs, growth, methods = json.loads(rows.read_text())["tables"].values()
    assert clouds[0]["cloud"] == "icosphere 642"
    assert abs(clouds[0]["total, %"]) < 0.1 < clouds[0]["paper's total, %"]
    assert densities[-1]["n"] == "order in n"
    assert densities[-1]["harmonics, RMS"] > 1.0
    errors = [row["single against resolution 512, RMS %"] for row in knobs if row["knob"] == "resolution"]
    assert errors == sorted(errors, reverse=True)
    assert [row["surfels"] for row in growth] == [300, 600]
    assert {"curved, cpu", "paper, cpu"} <= {row["what"] for row in methods}
    assert sf.read_image(plot).std() > 0.05  # something is drawn
