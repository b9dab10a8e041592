"""`surflux bench --quick` and `--full`: for each scene, solver and knob, error against seconds.

Seconds are medians of several runs, each with a seed of its own, after one that is not counted, areas included; scenes
have normals. Errors are area means over area-sampled surfels (`truth`), the RMS over the seeds, the reference's own
squared standard error taken off. Where that standard error is more than a quarter of the error, the table marks the
error with ~: more paths would be needed to claim it.
"""

import contextlib
import ctypes
import functools
import re
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean, median
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import mitsuba_renderer, scenes
from surflux.bench.truth import (
    LEAST_PATHS,
    Truth,
    errors_against,
    even_squares,
    local_errors_against,
    places_on,
    with_areas,
)


@dataclass(frozen=True)
class Solver:
    """run(scene, threads=..., **options) -> Solution; of each knob the options to try beside the defaults."""

    run: Callable
    knobs: dict


def _by(transport):
    """sf.solve by one way of transport, with the signature of sf.solve: a plot asks it for defaults."""

    @functools.wraps(sf.solve)
    def run(scene, **options):
        return sf.solve(scene, transport=transport, **options)

    return run


PATHS = "path tracing"  # by reference_irradiance, among the solvers of a table
ASKED = [{"error": error} for error in (0.08, 0.04, 0.02, 0.01)]

# Whatever solves a Scene: here is where another one joins.
SOLVERS = {
    "rays": Solver(
        _by("rays"),
        {
            "error": ASKED,
            "rays": [{"rays": 32}, {"rays": 64}, {"rays": 1024}],
            "zeta": [{"zeta": 0.1}, {"zeta": 0.04}, {"zeta": 0.01}],
            "insert": [{"insert": False}],
            "shadow rays": [{"probes": n, "shadow_rays": 4 * n} for n in (1, 4, 64)],
        },
    ),
    "pairs": Solver(
        _by("pairs"),
        {
            "error": ASKED,
            "rays": [{"rays": 16}, {"rays": 64}, {"rays": 1024}],
            "shadow rays": [{"probes": n, "shadow_rays": 4 * n} for n in (1, 4, 64)],
            "tolerance": [{"tolerance": 1e-1}, {"tolerance": 1e-2}, {"tolerance": 1e-6}],
        },
    ),
    "meshless": Solver(
        sf.solve_meshless,
        {
            "error": ASKED,
            "rays": [{"rays": 64}, {"rays": 128}, {"rays": 1024}],
            "epsilon_e": [{"epsilon_e": 0.16}, {"epsilon_e": 0.08}, {"epsilon_e": 0.02}],
            "levels": [{"levels": 2}, {"levels": 3}, {"levels": 4}],
        },
    ),
}


@dataclass(frozen=True)
class Mode:
    """How much is measured. Densities are the knob `surfels`; the others are turned at the density `knobs_at`."""

    surfels: int  # whose error is measured
    rounds: int  # of the reference, at most
    densities: dict
    knobs_at: dict
    every_setting: bool  # else the first and the last of each knob but `error`
    samples: tuple  # of path tracers for each surfel
    mitsuba_rounds: int


def _of_all(densities, large):
    """Of all scenes; `large` of those that have many surfels as their files stand."""
    return dict.fromkeys(scenes.NAMES, densities) | {"two bunnies": large, "door ajar": large}


QUICK = Mode(
    96,
    8,
    _of_all((0.5, 1.0), (0.25, 0.5)),
    _of_all(0.5, 0.25) | {"three spheres": 1.0},  # as the first page of the site shows them
    False,
    (4, 16, 64, 256),
    4,
)
FULL = Mode(
    2000, 64, _of_all((0.25, 0.5, 1.0, 2.0), (0.25, 0.5, 1.0)), _of_all(1.0, 1.0), True, (4, 16, 64, 256, 1024), 8
)


@dataclass
class Row:
    """One line of the table. Errors are shares of 1; see `truth.errors_against` and `truth.local_errors_against`."""

    scene: str
    solver: str
    knob: str
    value: str
    surfels: int
    seconds: float
    error: float
    indirect: float | None
    percentile_99: float
    uncertainty: float
    reference: float  # standard error of the reference at single surfels, RMS, relative
    reference_indirect: float
    percentile_99_indirect: float | None = None
    local: float = 0.0
    local_90: float = 0.0
    reference_local: float = 0.0
    rays: int | None = None  # as the solver counts them
    bytes: int | None = None  # by which the peak of the process grew in the pass
    reference_paths: int = 0  # for each surfel that is measured
    options: dict = field(default_factory=dict)  # those that are not the solver's defaults
    stages: dict = field(default_factory=dict)
    repeats: int = 1

    def is_claimed(self, name):
        """Whether the reference is sure enough for one of `OF_REFERENCE`; what is not measured claims nothing."""
        return getattr(self, name) is None or getattr(self, OF_REFERENCE[name]) <= 0.25 * getattr(self, name)


OF_REFERENCE = {"error": "reference", "indirect": "reference_indirect", "local_90": "reference_local"}


def measure(mode, names, repeats, threads):
    """Rows of all the scenes."""
    mitsuba = mitsuba_renderer.load(threads)
    if mitsuba is not None and not mitsuba_renderer.is_vectorized(mitsuba):
        print("bench: Mitsuba left out: its llvm variant finds no libLLVM, 16 or newer", file=sys.stderr)
        mitsuba = None
    rows = []
    for name in names:
        for density in mode.densities[name]:
            print(f"bench: {name}, density {density:g}", file=sys.stderr)
            built = scenes.build(name, density)
            at_knobs = density == mode.knobs_at[name]
            rows += of_solvers(name, built, mode, at_knobs, repeats, threads)
            if at_knobs and mitsuba is not None and built.polygons is not None:
                print(f"bench: {name}, Mitsuba", file=sys.stderr)
                rows += of_mitsuba(mitsuba, name, built, mode, repeats, threads)
    return rows


def of_solvers(name, built, mode, with_knobs, repeats, threads):
    """Rows of all solvers on one scene: their defaults, and all knobs, and path tracing, where these are asked for."""
    scene = built.scene
    count = sum(len(s) for s in scene.objects)
    surfels = with_areas(scene)
    truth = Truth(scene, surfels, mode.surfels, exact=built.exact, threads=threads)
    measured = []
    for solver_name, solver in SOLVERS.items():
        for knob, options in _settings(solver, scene, mode, with_knobs):
            try:
                seconds, solutions, taken = timed_solves(solver, scene, options, repeats, threads)
            except MemoryError as error:
                print(f"bench: {name}, {solver_name}, {knob} left out: {error}", file=sys.stderr)
                continue
            found = []
            for solution in solutions:
                total, direct = (by_scene_surfel(solution, h, count) for h in (solution.irradiance, solution.direct))
                found.append((total[truth.index], (total - direct)[truth.index]))
            row = Row(name, solver_name, knob, _value(options) if options else str(count), count, seconds, *6 * (0.0,))
            if solution.error > options.get("error", 1.0):
                row.value += f", own estimate {_percent(solution.error)} %"
            row.rays = _rays(solution)
            row.bytes, row.options, row.stages, row.repeats = taken, options, solution.timings, repeats
            measured.append((row, found))
    if with_knobs:
        measured += _by_paths(name, scene, surfels, truth.index, mode, repeats, threads)

    def judge():
        for row, found in measured:
            _fill(row, truth, found)
        return all(row.is_claimed(error) for row, _ in measured for error in ("error", "indirect"))

    for _ in range(mode.rounds if built.exact is None else 1):
        if judge():
            break
        if truth.rounds < mode.rounds:
            truth.refine()
    return [row for row, _ in measured]


def _settings(solver, scene, mode, with_knobs):
    """[(knob, options)] of a solver on a scene, its defaults first."""
    settings = [("surfels", {})]
    for knob, values in solver.knobs.items() if with_knobs else ():
        if knob == "shadow rays" and not scene.lights:
            continue
        whole = mode.every_setting or knob == "error" or len(values) == 1
        settings += [(knob, options) for options in (values if whole else (values[0], values[-1]))]
    return settings


def _fill(row, truth, found):
    """Puts the errors of what several seeds found, [(total, indirect or None)], into a row: their RMS."""
    errors = [errors_against(truth, *one) | local_errors_against(truth, one[0]) for one in found]
    for key in errors[0]:
        values = [one[key] for one in errors]
        setattr(row, key, None if values[0] is None else float(np.sqrt(fmean(value**2 for value in values))))
    row.reference_paths = truth.paths // len(truth.index)


def timed_solves(solver, scene, options, repeats, threads):
    """(median seconds, a Solution for each seed, bytes by which the peak grew or None)."""
    seconds, solutions = [], []
    taken = None
    for turn in range(repeats + 1):
        fresh = sf.Scene(scene.objects, scene.lights)  # a scene remembers areas that it has computed
        with peak_bytes() as peak:
            start = perf_counter()
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "error: wanted")  # the row says what was reached
                solution = solver.run(fresh, seed=max(0, turn - 1), threads=threads, **options)
            seconds.append(perf_counter() - start)
        if turn == 0:  # later ones take what this one has left
            taken = peak.get("bytes")
        else:
            solutions.append(solution)
    return median(seconds[1:]), solutions, taken


def _by_paths(name, scene, surfels, index, mode, repeats, threads):
    """[(Row, what was found)] of reference_irradiance as a solver: so many paths from places on each of all surfels."""
    measured = []
    rows = np.arange(len(surfels))
    for samples in mode.samples:
        if samples < LEAST_PATHS:
            continue
        seconds, found = [], []
        for turn in range(repeats + 1):
            start = perf_counter()
            count = samples // LEAST_PATHS
            places = places_on(surfels, np.repeat(rows, count), even_squares(rows, [turn, samples], count))
            seed = 10_000 + turn  # not one of the reference
            h, _ = sf.reference_irradiance(scene, *places, samples=LEAST_PATHS, seed=seed, threads=threads)
            seconds.append(perf_counter() - start)
            found.append((h.reshape(len(rows), count, 3).mean(axis=1)[index], None))
        row = Row(name, PATHS, "samples", str(samples), len(rows), median(seconds[1:]), *6 * (0.0,), repeats=repeats)
        measured.append((row, found[1:]))
    return measured


@contextlib.contextmanager
def peak_bytes():
    """A dict whose "bytes" says afterwards by how much the process's peak grew; empty where Linux does not tell."""
    found = {}
    process = Path("/proc/self")

    def status(name):
        return 1024 * int(re.search(name + r":\s+(\d+)", (process / "status").read_text())[1])

    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).malloc_trim(0)  # or the pass would fill what earlier ones have freed
    try:
        (process / "clear_refs").write_text("5")
        before = status("VmRSS")
    except (OSError, TypeError):
        before = None
    yield found
    if before is not None:
        found["bytes"] = max(0, status("VmHWM") - before)


def by_scene_surfel(solution, values, count):
    """Area means of values (m, 3) of a solution's surfels over the surfels of the scene that they stand for."""
    areas = solution.surfels.areas
    total = np.bincount(solution.parents, areas, count)
    sums = [np.bincount(solution.parents, areas * column, count) for column in values.T]
    return np.stack(sums, axis=1) / total[:, None]


def of_mitsuba(mitsuba, name, built, mode, repeats, threads):
    """Rows of Mitsuba on the polygons of the scene, at as many places as the scene has surfels.

    Judged by the reference on those polygons. Seconds are those of the paths alone, the scene loaded and the code
    compiled before.
    """
    polygons = built.polygons()
    targets = scenes.targets_on(polygons, built.scene)
    renderer = mitsuba_renderer.Renderer.of_surfels(mitsuba, polygons)
    truth = Truth(polygons, targets, mode.surfels, threads=threads)
    while truth.rounds < mode.mitsuba_rounds:
        truth.refine()
    rows = np.arange(len(targets))
    measured = []
    for samples in mode.samples:
        squares = even_squares(rows, [1, samples], samples)
        places = places_on(targets, np.repeat(rows, samples), squares)[0].reshape(len(targets), samples, 3)
        seconds, found = [], []
        for seed in range(repeats + 1):
            start = perf_counter()
            h = renderer.irradiance(places, targets.normals, targets.reflectance, targets.emission, seed)
            seconds.append(perf_counter() - start)
            found.append((h[truth.index, 0], None))
        row = Row(name, "Mitsuba", "samples", str(samples), len(targets), median(seconds[1:]), *6 * (0.0,))
        row.repeats = repeats
        _fill(row, truth, found[1:])
        measured.append(row)
    return measured


def _rays(solution):
    counts = [figures["rays"] for figures in solution.history if "rays" in figures]
    return int(counts[-1]) if counts else None


def _value(options):
    return " / ".join(f"{value:g}" for value in options.values())


def table(rows):
    """The rows as a Markdown table; errors in percent."""
    columns = "scene|solver|knob|value|surfels|seconds|error of H, %|of its indirect part, %|99th percentile, %|"
    columns += "local, median and 90th, %|reference's own, %|its paths|rays|MB"
    lines = ["| " + columns.replace("|", " | ") + " |", "|---|---|---|---|" + "--:|" * 10]
    for r in rows:
        error = f"{'' if r.is_claimed('error') else '~ '}{_percent(r.error)} ± {_percent(r.uncertainty)}"
        indirect = ""
        if r.indirect is not None:
            indirect = f"{'' if r.is_claimed('indirect') else '~ '}{_percent(r.indirect)}"
        local = f"{_percent(r.local)}, {'' if r.is_claimed('local_90') else '~ '}{_percent(r.local_90)}"
        rays = "" if r.rays is None else f"{r.rays:.3g}"
        size = "" if r.bytes is None else f"{r.bytes / 1e6:.0f}"
        reference = f"{_percent(r.reference)}" if r.reference_paths else "closed form"
        lines.append(
            f"| {r.scene} | {r.solver} | {r.knob} | {r.value} | {r.surfels} | {r.seconds:.3f} | {error} | {indirect} "
            f"| {_percent(r.percentile_99)} | {local} | {reference} | {r.reference_paths or ''} | {rays} | {size} |"
        )
    return "\n".join(lines)


def short_table(rows):
    """Of each scene what some 2 % cost: both solvers that are asked for them, and path tracers with 256 samples."""
    lines = ["| scene | by | seconds | error of H, % | local error, 90th percentile, % |", "|---|---|--:|--:|--:|"]
    chosen = {("rays", "error"): "`solve`, error=.02", ("meshless", "error"): "`solve_meshless`, error=.02"}
    chosen |= {(PATHS, "samples"): "`reference_irradiance`, 256 paths", ("Mitsuba", "samples"): "Mitsuba 3, 256 paths"}
    for r in rows:
        if (r.solver, r.knob) in chosen and (r.options.get("error") == 0.02 or r.value == "256"):
            errors = [
                f"{'' if r.is_claimed(name) else '~ '}{_percent(getattr(r, name))}" for name in ("error", "local_90")
            ]
            lines.append(f"| {r.scene} | {chosen[r.solver, r.knob]} | {r.seconds:.2f} | {' | '.join(errors)} |")
    return "\n".join(lines)


def _percent(value):
    return f"{100 * value:.2g}" if value < 0.995 else f"{100 * value:.0f}"
