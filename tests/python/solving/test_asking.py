"""sf.solve and sf.solve_meshless asked for an error, or for the best within a time."""

import itertools
import math
import warnings

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux.solving.asking import Ladder, solve_asked
from surflux.solving.run import Overdue, until


class Found:
    """A Solution as far as solve_asked looks into one: of an estimate, at a thousand surfels in a row."""

    def __init__(self, error, shift=0.0):
        self.error, self.history, self.timings = error, [{}], {}
        self.surfels = sf.Surfels(np.arange(3000.0).reshape(1000, 3), np.tile([0.0, 0.0, 1.0], (1000, 1)))
        self.surfels.areas = np.ones(1000)
        self.parents = np.arange(1000)
        self.light = np.full((1000, 3), 1.0)
        self.light[-1] += shift

    def per_surfel(self, name):
        return self.light


@pytest.fixture
def ladder():
    return Ladder(lambda rung: {"fineness": rung}, top=7.0)


def attempts_of(law):
    """(attempt, list of its rungs), of which the estimates follow a law."""
    rungs = []

    def attempt(settings, deadline):
        rungs.append(settings["fineness"])
        return Found(law(rungs[-1]), shift=0.1 * len(rungs)), lambda: None

    return attempt, rungs


@pytest.mark.parametrize(("gain", "first"), [(0.4, 0.03), (0.7, 0.01), (1.0, 0.1)])
@pytest.mark.parametrize("wanted", [0.05, 0.02, 0.005])
def test_the_error_is_reached_in_few_attempts(ladder, gain, first, wanted):
    attempt, rungs = attempts_of(lambda rung: first * 2.0 ** (-gain * rung))
    solution = solve_asked(ladder, attempt, wanted, None)
    if first * 2.0 ** (-gain * ladder.top) <= wanted:
        assert solution.error <= wanted
    assert len(rungs) <= 5
    assert all(a < b for a, b in itertools.pairwise(rungs))
    # Not much finer than asked for: one that had half the error would cost several times as much.
    assert solution.error > 0.4 * wanted or rungs == rungs[:1]
    assert solution.attempts[-1]["error"] == solution.error
    assert solution.history[-1]["wanted_error"] == wanted
    assert solution.history[-1]["attempts"] == len(rungs)
    assert solution.attempts[-1]["fineness"] == rungs[-1]


def test_what_gains_nothing_any_more_ends_and_says_where(ladder):
    attempt, rungs = attempts_of(lambda rung: 0.02 + 0.02 * 4.0**-rung)
    with pytest.warns(
        UserWarning, match=r"error: wanted 1 %, reached an estimated 2(\.\d)? %, for finer settings gain"
    ) as said:
        solution = solve_asked(ladder, attempt, 0.01, None)
    assert len(rungs) <= 5
    assert solution.error == min(entry["error"] for entry in solution.attempts)
    assert "100% of what the last attempt changed is around (2997, 2998, 2999)" in str(said[0].message)


def test_a_step_of_several_rungs_has_to_gain_for_each(ladder):
    """6 % a rung, as of coarse surfels: two rungs took off more than 5 % at once, and it went on."""
    attempt, rungs = attempts_of(lambda rung: 0.025 * 0.94**rung)
    with pytest.warns(UserWarning, match="finer settings gain nothing any more"):
        solve_asked(ladder, attempt, 0.01, None)
    assert len(rungs) == 2
    assert rungs[1] - rungs[0] > 1.8


def test_the_finest_settings_are_the_last():
    attempt, rungs = attempts_of(lambda rung: 0.5 * 2.0 ** (-0.5 * rung))
    with pytest.warns(UserWarning, match="for these are the finest settings"):
        solve_asked(Ladder(lambda rung: {"fineness": rung}, top=3.0), attempt, 0.001, None)
    assert rungs[-1] == 3.0


def test_the_best_of_the_attempts_counts(ladder):
    """Where a finer one is worse, by chance, the coarser one is what was found, and says so."""
    estimates = iter([0.05, 0.06])
    attempt, rungs = attempts_of(lambda rung: next(estimates))
    with pytest.warns(UserWarning, match="gain nothing"):
        solution = solve_asked(ladder, attempt, 0.01, None)
    assert solution.error == 0.05
    assert [entry["error"] for entry in solution.attempts] == [0.05, 0.06]
    assert len(rungs) == 2


def test_where_there_is_no_light_one_attempt_is_enough(ladder):
    attempt, rungs = attempts_of(lambda rung: math.nan)
    assert math.isnan(solve_asked(ladder, attempt, 0.01, None).error)
    assert len(rungs) == 1


def test_an_attempt_that_is_overdue_leaves_the_one_before(ladder):
    def attempt(settings, deadline):
        if deadline is not None:
            raise Overdue
        return Found(0.05), lambda: None

    solution = solve_asked(ladder, attempt, None, 1000.0)
    assert solution.error == 0.05
    assert [math.isnan(entry["error"]) for entry in solution.attempts] == [False, True]


def test_the_first_attempt_within_a_time_is_a_coarse_one(ladder):
    attempt, rungs = attempts_of(lambda rung: 0.03 * 2.0**-rung)
    solve_asked(ladder, attempt, None, 1000.0)
    assert rungs[0] == -1.5


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_the_first_attempt_within_a_time_has_few_rays(spheres, solver):
    first = solver(spheres, seconds=1e-3).attempts[0]
    assert first["rays"] == {sf.solve: 16, sf.solve_meshless: 32}[solver]


def test_an_attempt_without_memory_leaves_the_one_before(ladder):
    def attempt(settings, deadline):
        if settings["fineness"] > 2.0:
            raise MemoryError
        return Found(0.05), lambda: None

    with pytest.warns(UserWarning, match="for there is no memory for finer settings"):
        assert solve_asked(ladder, attempt, 0.01, None).error == 0.05
    with pytest.raises(MemoryError):
        solve_asked(Ladder(lambda rung: {"fineness": 3.0}, top=7.0), attempt, 0.01, None)


def test_nothing_is_better_than_an_error_of_0(ladder):
    estimates = iter([0.02, 0.0])
    attempt, rungs = attempts_of(lambda rung: next(estimates))
    assert solve_asked(ladder, attempt, None, 1000.0).error == 0.0
    assert len(rungs) == 2


def cancelled_pass(deadline, callback):
    with until(deadline, callback) as goes_on:
        assert not goes_on("direct", 0, 1)
        raise sf.Cancelled("cancelled")


def test_a_pass_ends_at_its_deadline_and_a_no_of_the_user_stays_one():
    with pytest.raises(Overdue):
        cancelled_pass(0.0, None)
    with pytest.raises(sf.Cancelled):
        cancelled_pass(math.inf, lambda *_: False)


@pytest.fixture(scope="module")
def spheres():
    return sf.load_scene("data/three_spheres.toml", surfels=3000)


@pytest.mark.parametrize("solver", quick(sf.solve, of=[sf.solve, sf.solve_meshless]))
def test_solvers_reach_an_error(spheres, solver):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution = solver(spheres, error=0.02, seed=3)
    assert solution.error <= 0.02
    chosen = solution.attempts[-1]
    assert solution.history[-1]["rays"] > 1000 * chosen["rays"]  # of all nodes, as ever
    options = {
        name: chosen[name]
        for name in ("zeta", "epsilon_e", "levels", "rays", "probes", "shadow_rays", "max_surfels")
        if name in chosen
    }
    # What history says is what gives this very solution.
    assert np.array_equal(solver(spheres, **options, seed=3).irradiance, solution.irradiance)


@pytest.mark.slow
def test_all_pairs_reach_an_error(spheres):
    assert sf.solve(spheres, transport="pairs", error=0.01).error <= 0.01


def test_a_time_is_kept(spheres):
    """What is not done in time is given up: however slow the machine, no more than one coarse attempt goes beyond."""
    solution = sf.solve(spheres, seconds=1e-3)
    assert len(solution.attempts) == 1
    solution = sf.solve(spheres, seconds=30.0, error=0.03)
    assert solution.error <= 0.03


def test_attempts_are_kept_in_files(spheres, tmp_path):
    solution = sf.solve(spheres, error=0.03)
    solution.save(tmp_path / "solution.ply")
    found = sf.load_solution(tmp_path / "solution.ply")
    assert found.attempts == solution.attempts
    assert found.history[-1]["wanted_error"] == 0.03


def test_knobs_and_error_exclude_each_other(spheres):
    with pytest.raises(ValueError, match="zeta: is chosen where error is given; wanted one of the two"):
        sf.solve(spheres, error=0.02, zeta=0.01)
    with pytest.raises(ValueError, match="epsilon_e: is chosen where seconds is given; wanted one of the two"):
        sf.solve_meshless(spheres, seconds=2.0, epsilon_e=0.01)
    with pytest.raises(ValueError, match=r"error: wanted .*1"):
        sf.solve(spheres, error=1.5)
    with pytest.raises(ValueError, match="seconds: wanted"):
        sf.solve(spheres, seconds=-1.0)
    with pytest.raises(ValueError, match="bounces: estimates of the error are of all of them"):
        sf.solve_meshless(spheres, error=0.02, bounces=1)


@pytest.mark.slow
def test_a_scene_can_ask_for_an_error(spheres):
    scene = sf.Scene(spheres.objects, spheres.lights, solve_options={"error": 0.04})
    assert sf.solve(scene).history[-1]["wanted_error"] == 0.04
    # A call's knobs take the place of the scene's error, and a call's error that of the scene's knobs.
    assert sf.solve(scene, zeta=0.1).attempts == []
    scene.solve_options = {"zeta": 0.5}
    assert sf.solve(scene, error=0.04).history[-1]["wanted_error"] == 0.04
    with pytest.raises(ValueError, match="solve_options: zeta: is chosen where error is given"):
        scene.solve_options = {"zeta": 0.5, "error": 0.04}
