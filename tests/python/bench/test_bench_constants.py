"""`surflux bench --constants`: what constants that are no options trade."""

import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.bench import constants, scenes
from surflux.cli import commands
from surflux.scenes import shapes
from surflux.solving.run import tuned


@pytest.mark.slow
def test_each_constant_is_halved_and_doubled(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(scenes, "build", partial(scenes.build, density=0.5))
    turned = {
        "solve": ("surfels_per_first_node", 500.0),
        "solve_meshless": ("least_rays", 128.0),
        "solve, pairs": ("lamp_rays", 16.0),
        "solve_meshless, anywhere": ("largest_part", 0.1),
        "form_factors": ("disk_error", 0.05),
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
        ("solve_meshless, anywhere", "largest_part", 0.05),
        ("solve_meshless, anywhere", "largest_part", 0.2),
        ("form_factors", "disk_error", 0.025),
        ("form_factors", "disk_error", 0.1),
    ]
    assert all(row["seeds"] == constants.LEAST_SEEDS and row["usual_error"] < 0.1 for row in rows)
    for row in rows:
        # Nothing stands between the spheres, so that no share is sampled.
        assert row["usual_error"] > 0.0 or row["solver"] == "form_factors"
        # The error that a solution says it has: where it is a fifth of a per cent, chance. A field and form factors say
        # nothing.
        says = row["solver"] in ("solve", "solve_meshless", "solve, pairs")
        assert (0.3 < row["usual_estimate"] < 30.0) if says else np.isnan(row["usual_estimate"])
    out = capsys.readouterr().out
    assert out.count("| solve | concentric spheres | surfels_per_first_node |") == 2


@pytest.mark.slow
def test_constants_of_the_self_check_change_the_estimate_alone(monkeypatch):
    monkeypatch.setattr(scenes, "build", partial(scenes.build, density=0.5))
    rows = constants.measure(["concentric spheres"], 1, None, ["known_error", "least_check_rays", "checked_surfels"])
    assert {row.solver for row in rows} == {"solve", "solve_meshless", "solve, pairs"}
    assert all(row.error == row.error_uncertainty == 0.0 for row in rows)
    assert any(row.estimate != 0.0 for row in rows if row.constant == "checked_surfels")


def test_names_of_constants_choose_those_that_are_turned(capsys):
    refusal = ["bench", "--constants", "--constant", "litle"]
    assert commands.main(refusal) != 0
    assert "--constant: no solver has a 'litle'" in capsys.readouterr().err
    assert commands.main(["bench", "--constant", "little"]) != 0
    assert "--constant: goes with --constants" in capsys.readouterr().err
    assert {"slope_neighbors", "disk_error", "largest_part", "largest_scale"} <= constants.all_names()


@pytest.mark.parametrize("room", ["radiosity", "meshless", "solution"])
def test_each_constant_of_a_tuning_is_turned(room):
    # A member that for_each() leaves out could not be.
    text = (Path(__file__).parents[3] / "cpp" / "surflux" / room / "tuning.h").read_text()
    members = re.findall(r"(\w+) = [-+.\de]+[,;]", "\n".join(re.findall(r"^    double .*?;$", text, re.M | re.S)))
    assert len(members) > 20
    assert not set(members) - constants.all_names()
    assert sorted(members) == sorted(re.findall(r'visit\("(\w+)", \1\)', text))


def test_changes_are_taken_seed_by_seed():
    # Seconds twice as many for each seed, errors a tenth more or less by turns.
    # What is said of them is one and a half times as much.
    usual = np.array([[1.0, 0.010, 0.8], [3.0, 0.020, 1.0], [2.0, 0.010, 0.8], [5.0, 0.020, 1.0]])
    found = usual * [[2.0, 1.1, 1.5], [2.0, 0.9, 1.5], [2.0, 1.1, 1.5], [2.0, 0.9, 1.5]]
    seconds, of_seconds, error, of_error, estimate, of_estimate, usual_error, usual_estimate = constants._changes(
        found, usual
    )
    assert (seconds, of_seconds) == (1.0, 0.0)
    assert error == pytest.approx(0.0, abs=1e-12)
    assert of_error == pytest.approx(np.sqrt(4 * 0.01 / 3) / 2)  # standard deviation over the root of their number
    assert usual_error == pytest.approx(np.sqrt(2.5e-4))
    assert (estimate, of_estimate) == (pytest.approx(0.5), pytest.approx(0.0, abs=1e-12))
    assert usual_estimate == pytest.approx(0.9)


def test_what_has_no_error_and_gets_none_does_not_change():
    usual = np.array([[1.0, 0.0, np.nan]] * 3)
    changes = constants._changes(usual, usual)
    assert changes[:4] == (0.0, 0.0, 0.0, 0.0)
    assert np.isnan(changes[4])


def test_what_is_not_known_stands_in_brackets():
    row = constants.Row("solve", "room", "little", 0.002, -0.3, 0.1, 0.04, 0.03, -0.5, 0.1, 0.0123, 0.9, 4)
    line = constants.table([row]).splitlines()[-1]
    assert line == "| solve | room | little | 0.002 | -30 +- 10 % | (+4 +- 3 %) | -50 +- 10 % | 1.23 % | 0.90 |"


def test_what_does_not_change_and_what_is_not_said():
    row = constants.Row("form_factors", "room", "a", 1.0, 0.1, 0.01, 0.0, 0.0, np.nan, np.nan, 0.0123, np.nan, 4)
    line = constants.table([row]).splitlines()[-1]
    assert line == "| form_factors | room | a | 1 | +10 +- 1 % | same |  | 1.23 % |  |"


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
        ("solve_meshless", {"slope_neighbors": 9.0}, "tuning: wanted names of the solver's own constants"),
        ("solve, pairs", {"least_turn": 0.3}, "tuning: wanted names of the solver's own constants"),
        ("form_factors", {"disk_error": 0.0}, "tuning: wanted disk_error above 0, got 0"),
    ],
)
def test_refusals(scene, solver, wrong, message):
    solve, _ = constants.SOLVERS[solver]
    with tuned(wrong), pytest.raises(ValueError, match=message):
        solve(scene)


@pytest.mark.parametrize("solver", constants.SOLVERS)
def test_all_that_there_are_can_be_set(scene, solver):
    solve, known = constants.SOLVERS[solver]

    def found():
        # of all pairs fewer surfels
        solution = solve(_glowing() if solver == constants.FORM_FACTORS else scene)
        return solution if solver == constants.FORM_FACTORS else solution.irradiance

    with tuned(known()):
        tuned_as_usual = found()
    assert np.array_equal(tuned_as_usual, found())
    assert np.any(tuned_as_usual > 0.0)


def _glowing():
    """A sphere of 162 points that glows, beside one that does not, and a third between them."""
    points = shapes.icosphere(2)[0]
    balls = [sf.Surfels(0.5 * points + [x, 0.0, 0.0], points, emission=e) for x, e in ((-2, 1.0), (0, 0.0), (2, 0.0))]
    return sf.Scene(balls)


@pytest.mark.parametrize("name", ["three spheres", "Cornell box"])
def test_pairs_are_turned_on_scenes_that_solve_takes_pairs_of(name):
    whole = scenes.build(name)
    coarse = constants._coarse(name, whole)
    counts = [sum(len(s) for s in built.scene.objects) for built in (whole, coarse)]
    assert counts[1] <= min(counts[0], _core.PAIRS_UP_TO)
    assert counts[1] > 500
