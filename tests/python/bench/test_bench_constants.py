"""`surflux bench --constants`: what constants that are no options trade."""

import json
from functools import partial

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.bench import constants, scenes
from surflux.cli import commands
from surflux.solving.run import tuned


@pytest.mark.slow
def test_each_constant_is_halved_and_doubled(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scenes, "build", partial(scenes.build, density=0.5))
    turned = {
        "solve": ("surfels_per_first_node", 500.0),
        "solve_meshless": ("least_rays", 128.0),
        "solve, pairs": ("lamp_rays", 16.0),
    }
    for solver, (constant, value) in turned.items():
        solve, _ = constants.SOLVERS[solver]
        monkeypatch.setitem(constants.SOLVERS, solver, (solve, partial(dict, {constant: value})))
    kept = tmp_path / "rows.json"
    chosen = ["--scene", "concentric spheres", "--json", str(kept)]
    assert commands.main(["bench", "--constants", "--repeats", "1", *chosen]) == 0
    rows = json.loads(kept.read_text())["rows"]
    assert [(row["solver"], row["constant"], row["value"]) for row in rows] == [
        ("solve", "surfels_per_first_node", 250.0),
        ("solve", "surfels_per_first_node", 1000.0),
        ("solve_meshless", "least_rays", 64.0),
        ("solve_meshless", "least_rays", 256.0),
        ("solve, pairs", "lamp_rays", 8.0),
        ("solve, pairs", "lamp_rays", 32.0),
    ]
    assert all(row["seeds"] == constants.LEAST_SEEDS and 0.0 < row["usual_error"] < 0.1 for row in rows)
    out = capsys.readouterr().out
    assert out.count("| solve | concentric spheres | surfels_per_first_node |") == 2


def test_changes_are_taken_seed_by_seed():
    # Seconds twice as many for each seed, errors a tenth more or less by turns.
    usual = np.array([[1.0, 0.010], [3.0, 0.020], [2.0, 0.010], [5.0, 0.020]])
    found = usual * [[2.0, 1.1], [2.0, 0.9], [2.0, 1.1], [2.0, 0.9]]
    seconds, of_seconds, error, of_error, usual_error = constants._changes(found, usual)
    assert (seconds, of_seconds) == (1.0, 0.0)
    assert error == pytest.approx(0.0, abs=1e-12)
    assert of_error == pytest.approx(np.sqrt(4 * 0.01 / 3) / 2)  # standard deviation over the root of their number
    assert usual_error == pytest.approx(np.sqrt(2.5e-4))


def test_what_is_not_known_stands_in_brackets():
    row = constants.Row("solve", "room", "little", 0.002, -0.3, 0.1, 0.04, 0.03, 0.0123, 4)
    line = constants.table([row]).splitlines()[-1]
    assert line == "| solve | room | little | 0.002 | -30 +- 10 % | (+4 +- 3 %) | 1.23 % |"


@pytest.fixture(scope="module")
def scene():
    points = np.random.default_rng(0).random((3000, 3)) * [1.0, 1.0, 0.0]
    floor = sf.Surfels(points, np.tile([0.0, 0.0, 1.0], (3000, 1)))
    return sf.Scene([floor], [sf.PointLight([0.5, 0.5, 0.3], 1.0)])


@pytest.mark.slow
def test_constants_count_within_the_block_alone(scene):
    solved = partial(sf.solve, scene, transport="rays")
    usual = solved().irradiance
    with tuned({"smallest_share": 1.0}):  # nothing is inserted
        coarse = solved()
        with tuned({}):
            assert np.array_equal(solved().irradiance, usual)
        assert len(solved().surfels) == len(coarse.surfels) == 3000
    assert len(usual) > 3000
    assert np.array_equal(solved().irradiance, usual)


@pytest.mark.parametrize(
    ("solver", "wrong", "message"),
    [
        ("solve", {"litle": 1.0}, "tuning: wanted names of the solver's own constants"),
        ("solve", {"little": 0.0}, "tuning: wanted little above 0, got 0"),
        ("solve", {"little": np.nan}, "tuning: wanted little above 0, got nan"),
        ("solve", {"little": np.inf}, "tuning: wanted little above 0, got inf"),
        ("solve, pairs", {"little": 1.0}, "tuning: wanted names of the solver's own constants"),
        ("solve, pairs", {"near_rays": 0.0}, "tuning: wanted near_rays above 0, got 0"),
        ("solve_meshless", {"little": 1.0}, "tuning: wanted names of the solver's own constants"),
        ("solve_meshless", {"stricter": -1.0}, "tuning: wanted stricter above 0, got -1"),
    ],
)
def test_refusals(scene, solver, wrong, message):
    solve, _ = constants.SOLVERS[solver]
    with tuned(wrong), pytest.raises(ValueError, match=message):
        solve(scene)


@pytest.mark.parametrize("solver", constants.SOLVERS)
def test_all_that_there_are_can_be_set(scene, solver):
    solve, known = constants.SOLVERS[solver]
    with tuned(known()):
        tuned_as_usual = solve(scene).irradiance
    assert np.array_equal(tuned_as_usual, solve(scene).irradiance)


@pytest.mark.parametrize("name", ["three spheres", "Cornell box"])
def test_pairs_are_turned_on_scenes_that_solve_takes_pairs_of(name):
    whole = scenes.build(name)
    coarse = constants._coarse(name, whole)
    counts = [sum(len(s) for s in built.scene.objects) for built in (whole, coarse)]
    assert counts[1] <= min(counts[0], _core.PAIRS_UP_TO)
    assert counts[1] > 500
