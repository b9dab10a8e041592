"""`surflux bench --constants`: what each constant of the solvers that is no option trades, error against seconds.

Each is halved and doubled by itself, over several seeds. Errors and seconds are beside those of the constants as they
are, seed by seed and in turn, so that what the surfels that are measured have in common, and most of the load of the
machine, drops out; seconds are those of all cores together. A change is known to +- its standard error over the seeds:
below twice that nothing is said. A constant that changes neither on any scene would be none that is needed.
"""

import sys
from dataclasses import dataclass
from functools import partial
from time import process_time

import numpy as np

import surflux as sf
from surflux import _core
from surflux.bench import scenes
from surflux.bench.solvers import by_scene_surfel
from surflux.bench.truth import Truth, errors_against, with_areas
from surflux.solving.run import tuned

SCENES = ("Cornell box", "three spheres", "statues")
FACTORS = (0.5, 2.0)
# And their constants: cpp/surflux/radiosity/tuning.h, cpp/surflux/meshless/tuning.h.
PAIRS = "solve, pairs"  # of scenes as coarse as those are that solve() takes all pairs of by itself
SOLVERS = {
    "solve": (partial(sf.solve, transport="rays"), _core.refinement_tuning),
    "solve_meshless": (sf.solve_meshless, _core.meshless_tuning),
    PAIRS: (partial(sf.solve, transport="pairs"), _core.pairs_tuning),
}
MEASURED = 400  # surfels
ROUNDS = 8  # of the reference
LEAST_SEEDS = 3


@dataclass
class Row:
    """One constant at one value on one scene: what it changes, means over seeds, and their standard errors."""

    solver: str
    scene: str
    constant: str
    value: float
    seconds: float  # over those with the constants as they are, less 1
    seconds_uncertainty: float
    error: float  # likewise
    error_uncertainty: float
    usual_error: float  # with the constants as they are, RMS over seeds
    seeds: int


def measure(names, repeats, threads):
    """Rows of all scenes; `repeats`: seeds, at least 3."""
    seeds = range(max(LEAST_SEEDS, repeats))
    rows = []
    for name in names:
        whole = scenes.build(name)
        for built, solvers in ((whole, SOLVERS.keys() - {PAIRS}), (_coarse(name, whole), {PAIRS})):
            truth = _truth(built, threads)
            for solver in SOLVERS:
                if solver in solvers:
                    rows += _of_solver(solver, name, built.scene, truth, seeds, threads)
    return rows


def _coarse(name, built):
    """The scene with no more surfels than solve() takes all pairs of by itself."""
    density = 1.0
    while (count := sum(len(s) for s in built.scene.objects)) > _core.PAIRS_UP_TO:
        density *= min(0.9, np.sqrt(_core.PAIRS_UP_TO / count))
        built = scenes.build(name, density)
    return built


def _truth(built, threads):
    truth = Truth(built.scene, with_areas(built.scene), MEASURED, exact=built.exact, threads=threads)
    while built.exact is None and truth.rounds < ROUNDS:
        truth.refine()
    return truth


def _of_solver(solver, name, scene, truth, seeds, threads):
    solve, constants = SOLVERS[solver]
    for constant, value in constants().items():
        print(f"bench: {name}, {solver}, {constant}", file=sys.stderr)
        # In turn with the constants as they are, for the load of the machine changes.
        settings = [{}, *({constant: factor * value} for factor in FACTORS)]
        turns = [[_solved(solve, scene, truth, tuning, seed, threads) for tuning in settings] for seed in seeds]
        usual, *others = np.swapaxes(np.array(turns), 0, 1)
        for factor, found in zip(FACTORS, others, strict=True):
            yield Row(solver, name, constant, factor * value, *_changes(found, usual), len(seeds))


def _solved(solve, scene, truth, tuning, seed, threads):
    """Seconds of all cores, and the error."""
    start = process_time()
    with tuned(tuning):
        solution = solve(scene, seed=seed, threads=threads)
    seconds = process_time() - start
    count = sum(len(s) for s in scene.objects)
    total, direct = (by_scene_surfel(solution, h, count) for h in (solution.irradiance, solution.direct))
    return seconds, errors_against(truth, total[truth.index], (total - direct)[truth.index])["error"]


def _changes(found, usual):
    """Mean change and standard error of seconds, then of the error; and the usual error."""
    out = []
    for k in range(2):
        change = found[:, k] / np.maximum(usual[:, k], np.finfo(float).tiny) - 1.0
        out += [float(change.mean()), float(change.std(ddof=1) / np.sqrt(len(change)))]
    return *out, float(np.sqrt(np.mean(usual[:, 1] ** 2)))


def table(rows):
    """Markdown: a line for each row; what is within twice its standard error in brackets."""
    lines = ["| solver | scene | constant | value | seconds | error | usual error |", "|---|---|---|---|---|---|---|"]
    for row in rows:
        cells = [_said(row.seconds, row.seconds_uncertainty), _said(row.error, row.error_uncertainty)]
        lines.append(
            f"| {row.solver} | {row.scene} | {row.constant} | {row.value:.3g} | {' | '.join(cells)} "
            f"| {100 * row.usual_error:.2f} % |"
        )
    return "\n".join(lines)


def _said(change, uncertainty):
    text = f"{100 * change:+.0f} +- {100 * uncertainty:.0f} %"
    return text if abs(change) > 2.0 * uncertainty else f"({text})"
