"""`surflux bench --constants`: what each constant of the solvers that is no option trades, error against seconds.

Each is halved and doubled by itself, over several seeds. Errors and seconds are beside those of the constants as they
are, seed by seed and in turn, so that what the surfels that are measured have in common, and most of the load of the
machine, drops out; seconds are those of all cores together. A change is known to +- its standard error over the seeds:
below twice that nothing is said. The estimate is what a solution says of its error over what that is: constants of the
self-check change nothing else. A constant that changes none of the three on any scene would be none that is needed.

Errors are those of surfels; of constants that only the field between these goes by, those of points anywhere on them;
and of form factors that of the light that surfels exchange by them, beside factors found ten times as precisely.
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
from surflux.bench.truth import PointTruth, Truth, errors_against, with_areas
from surflux.solving.run import tuned

SCENES = ("Cornell box", "three spheres", "statues")
FACTORS = (0.5, 2.0)
PAIRS = "solve, pairs"  # of scenes as coarse as those are that solve() takes all pairs of by itself
FIELD = "solve_meshless, anywhere"
FORM_FACTORS = "form_factors"  # of those coarse scenes, too, with lamps as surfels: where these are all their lights
OF_FIELD = ("largest_deviation", "largest_part")
# Of form factors that are measured, and of those that they are measured by, with shares of disks as precise.
FACTORS_ERROR, TRUE_FACTORS_ERROR = 1e-2, 1e-3
OF_TRUE_FACTORS = {"disk_error": 5e-3, "most_points_of_disks": 4096.0}
MEASURED = 400  # surfels
ROUNDS = 8  # of the reference
LEAST_SEEDS = 3


def _of_field(which):
    """The constants of solve_meshless that only the field anywhere goes by, or the others."""
    return {name: value for name, value in _core.meshless_tuning().items() if (name in OF_FIELD) is which}


def exchanged(scene, *, seed=0, threads=None, error=FACTORS_ERROR):
    """Irradiance (n, 3) of surfels that emit and reflect, by their form factors."""
    F = sf.form_factors(scene, error=error, seed=seed, threads=threads)
    surfels = scene.surfels
    sent = surfels.emission.copy()
    received = F @ sent
    while True:
        sent = surfels.emission + surfels.reflectance * received
        last, received = received, F @ sent
        if np.abs(received - last).max() <= 1e-9 * np.abs(received).max():
            return received


# And their constants: cpp/surflux/radiosity/tuning.h, cpp/surflux/meshless/tuning.h, cpp/surflux/solution/tuning.h.
SOLVERS = {
    "solve": (partial(sf.solve, transport="rays"), _core.refinement_tuning),
    "solve_meshless": (sf.solve_meshless, partial(_of_field, False)),
    PAIRS: (partial(sf.solve, transport="pairs"), _core.pairs_tuning),
    FIELD: (sf.solve_meshless, partial(_of_field, True)),
    FORM_FACTORS: (exchanged, _core.form_factor_tuning),
}


def all_names():
    """Of all constants of all solvers."""
    return {name for _, constants in SOLVERS.values() for name in constants()}


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
    estimate: float  # likewise, of what the solution says of its error over what that is; NaN where it says nothing
    estimate_uncertainty: float
    usual_error: float  # with the constants as they are, RMS over seeds
    usual_estimate: float  # likewise, the mean
    seeds: int


class AtSurfels:
    """The scene, and errors of the surfels of a solution of it."""

    def __init__(self, built, threads):
        self.scene = built.scene
        self._count = sum(len(s) for s in built.scene.objects)
        self._truth = _refined(
            Truth(built.scene, with_areas(built.scene), MEASURED, exact=built.exact, threads=threads), built.exact
        )

    def errors(self, solution):
        """(error, the error by the solution itself)."""
        total, direct = (by_scene_surfel(solution, h, self._count) for h in (solution.irradiance, solution.direct))
        index = self._truth.index
        return errors_against(self._truth, total[index], (total - direct)[index])["error"], solution.error


class Anywhere:
    """The scene, and errors of the field of a solution at points all over its surfels."""

    def __init__(self, built, threads):
        self.scene, self._threads = built.scene, threads
        self._truth = _refined(PointTruth(built.scene, with_areas(built.scene), MEASURED, threads=threads), None)

    def errors(self, solution):
        found = solution.irradiance_at(self._truth.points, self._truth.normals, threads=self._threads)
        return errors_against(self._truth, found, None)["error"], np.nan


class Exchange:
    """The scene with lamps as surfels, and errors of the light that these exchange."""

    def __init__(self, built, threads):
        self.scene = scenes.with_solid_lamps(built.scene) if built.scene.lights else built.scene
        self._areas = with_areas(self.scene).areas[:, None]
        with tuned(OF_TRUE_FACTORS):
            self._true = exchanged(self.scene, seed=1000, threads=threads, error=TRUE_FACTORS_ERROR)

    def errors(self, received):
        off, whole = (np.sum(self._areas * x**2) for x in (received - self._true, self._true))
        return np.sqrt(off / whole), np.nan


def measure(names, repeats, threads, only=()):
    """Rows of all scenes; `repeats`: seeds, at least 3. only: names of constants; empty for all."""
    seeds = range(max(LEAST_SEEDS, repeats))
    rows = []
    for name in names:
        whole = scenes.build(name)
        coarse = _coarse(name, whole)
        judges = {}
        for solver, (_, constants) in SOLVERS.items():
            turned = {constant: value for constant, value in constants().items() if not only or constant in only}
            if not turned or (solver == FORM_FACTORS and whole.polygons is None):
                continue
            kind, built = {
                PAIRS: (AtSurfels, coarse),
                FIELD: (Anywhere, whole),
                FORM_FACTORS: (Exchange, coarse),
            }.get(solver, (AtSurfels, whole))
            key = kind, id(built)
            judges[key] = judges.get(key) or kind(built, threads)
            rows += _of_solver(solver, name, turned, judges[key], seeds, threads)
    return rows


def _coarse(name, built):
    """The scene with no more surfels than solve() takes all pairs of by itself."""
    density = 1.0
    while (count := sum(len(s) for s in built.scene.objects)) > _core.PAIRS_UP_TO:
        density *= min(0.9, np.sqrt(_core.PAIRS_UP_TO / count))
        built = scenes.build(name, density)
    return built


def _refined(truth, exact):
    while exact is None and truth.rounds < ROUNDS:
        truth.refine()
    return truth


def _of_solver(solver, name, constants, judge, seeds, threads):
    solve, _ = SOLVERS[solver]
    for constant, value in constants.items():
        print(f"bench: {name}, {solver}, {constant}", file=sys.stderr)
        # In turn with the constants as they are, for the load of the machine changes.
        settings = [{}, *({constant: factor * value} for factor in FACTORS)]
        turns = [[_solved(solve, judge, tuning, seed, threads) for tuning in settings] for seed in seeds]
        usual, *others = np.swapaxes(np.array(turns), 0, 1)
        for factor, found in zip(FACTORS, others, strict=True):
            yield Row(solver, name, constant, factor * value, *_changes(found, usual), len(seeds))


def _solved(solve, judge, tuning, seed, threads):
    """Seconds of all cores, the error, and what the solution says of it over that."""
    start = process_time()
    with tuned(tuning):
        solution = solve(judge.scene, seed=seed, threads=threads)
    seconds = process_time() - start
    error, said = judge.errors(solution)
    return seconds, error, said / error if error > 0.0 else np.nan


def _changes(found, usual):
    """Mean change and standard error of seconds, of the error and of the estimate; the usual error and estimate."""
    out = []
    for k in range(3):
        change = (found[:, k] - usual[:, k]) / np.maximum(usual[:, k], np.finfo(float).tiny)
        out += [float(change.mean()), float(change.std(ddof=1) / np.sqrt(len(change)))]
    return *out, float(np.sqrt(np.mean(usual[:, 1] ** 2))), float(usual[:, 2].mean())


def table(rows):
    """Markdown: a line for each row; what is within twice its standard error in brackets."""
    columns = "solver", "scene", "constant", "value", "seconds", "error", "estimate", "usual error", "usual estimate"
    lines = [f"| {' | '.join(columns)} |", len(columns) * "|---" + "|"]
    for row in rows:
        cells = [
            _said(row.seconds, row.seconds_uncertainty),
            _said(row.error, row.error_uncertainty),
            _said(row.estimate, row.estimate_uncertainty),
            f"{100 * row.usual_error:.2f} %",
            "" if np.isnan(row.usual_estimate) else f"{row.usual_estimate:.2f}",
        ]
        lines.append(f"| {row.solver} | {row.scene} | {row.constant} | {row.value:.3g} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _said(change, uncertainty):
    if np.isnan(change):
        return ""
    if change == uncertainty == 0.0:
        return "same"
    text = f"{100 * change:+.0f} +- {100 * uncertainty:.0f} %"
    return text if abs(change) > 2.0 * uncertainty else f"({text})"
