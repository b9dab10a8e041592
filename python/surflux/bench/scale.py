"""`surflux bench --scale`: seconds, memory and errors from 2500 surfels to ten millions, one setting for all rows of a
solver.

Each row is measured in a process of its own, so that its peaks of memory are its own: the scene is loaded, normals and
radii included, and then solved; once to warm up, then `repeats` times, and from surfels and lights each time. Errors
are those of DESIGN sections 3 and 5, at 2000 area-sampled surfels, and of Solution.irradiance_at at 2000 random points
of the surface.

What share of the time Embree takes, perf tells (here for the gallery; libembree* against _core* in the list):

    perf record -F 199 -o scale.data python -c "import surflux as sf; sf.solve(sf.load_scene('data/gallery.toml'))"
    perf report -i scale.data --sort dso --stdio
"""

import contextlib
import gc
import math
import re
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import mitsuba_renderer, scenes
from surflux.bench.scale_truth import ScaleTruth
from surflux.bench.solvers import by_scene_surfel
from surflux.bench.truth import PATHS_A_ROUND, Truth, errors_against, even_squares, places_on

# Name -> (file in data/, surfels in all; None for what the file says).
SCENES = {
    "three spheres": ("three_spheres", None),
    "two bunnies": ("two_bunnies", None),
    "gallery": ("gallery", None),
    **{f"gallery of {count}": ("gallery", count) for count in (10_000, 30_000, 100_000, 300_000, 1_000_000)},
    **{f"statues of {count}": ("statues", count) for count in (100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)},
}
# And by solve_meshless.
MESHLESS = {
    "Cornell box, meshless": ("cornell", None),
    "statue, meshless": ("statue", None),
    "Sponza, meshless": ("sponza", None),
}
SCENES |= MESHLESS
GROWING = ("gallery", "statues")  # names of scenes begin so that differ in their number of surfels
DEFAULT_PATHS = 16 * PATHS_A_ROUND
MITSUBA_SCENE = "three spheres"
MITSUBA_SAMPLES = (4, 16, 64, 256)
FIGURES = ("links", "rays", "cut", "applications")  # of the last entry of Solution.history, where it has them


@dataclass
class Row:
    """One scene. Errors are shares of 1; see `truth.errors_against`."""

    scene: str
    surfels: int
    leaves: int  # of the solution, after insertion
    seconds: float  # of all stages of the solver, compiling included
    gigabytes: float | None  # the most memory its process had while it solved
    error: float = 0.0
    indirect: float = 0.0
    percentile_99: float = 0.0
    percentile_99_indirect: float = 0.0
    uncertainty: float = 0.0
    reference: float = 0.0  # standard error of the reference, relative
    reference_indirect: float = 0.0
    at_points: float | None = None  # error of irradiance_at
    at_points_99: float | None = None
    reference_at_points: float = 0.0
    own: float = math.nan  # Solution.error
    loading: float = 0.0  # seconds of reading or sampling the scene
    loading_gigabytes: float | None = None
    paths: int = 0  # of the reference for each surfel
    stages: dict = field(default_factory=dict)
    figures: dict = field(default_factory=dict)
    repeats: int = 1
    mitsuba: list = field(default_factory=list)  # [seconds, error] of its samples
    mitsuba_seconds: float | None = None  # until its error is ours

    def is_claimed(self, error, reference):
        """Whether the reference is sure enough for an error."""
        error = getattr(self, error)
        return error is None or getattr(self, reference) <= 0.25 * error


CLAIMS = (("error", "reference"), ("indirect", "reference_indirect"), ("at_points", "reference_at_points"))


def why_not(name):
    """Why a scene cannot be had here, or None."""
    return scenes.why_no_file(SCENES[name][0])


def measure(names, repeats, threads, cache=None, paths=None):
    """Rows of the scenes of these names that can be had."""
    rows = []
    for name in names:
        reason = why_not(name)
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
            continue
        stem, count = SCENES[name]
        print(f"bench: {name}, reference", file=sys.stderr)
        truth = ScaleTruth(stem, count, cache, threads)
        print(f"bench: {name}", file=sys.stderr)
        rows.append(of_scene(name, truth, repeats, threads, paths or DEFAULT_PATHS))
        if name == MITSUBA_SCENE:
            beside_mitsuba(rows[-1], truth, repeats, threads)
    return rows


def of_scene(name, truth, repeats, threads, paths):
    """The Row of a scene, with more paths for its reference until the errors can be claimed."""
    stem, count = SCENES[name]
    path = str(scenes.data_folder() / f"{stem}.toml")
    places = truth.points.points, truth.points.normals
    found = in_fresh_process(solved, path, count, repeats, threads, places, name in MESHLESS)
    row = Row(name, len(truth.place_of), found["leaves"], found["seconds"], found["gigabytes"], own=found["error"])
    row.stages, row.figures, row.repeats = found["stages"], found["figures"], repeats
    row.loading, row.loading_gigabytes = found["loading"]
    while True:
        index = truth.surfels.index
        for key, value in errors_against(truth.surfels, found["total"][index], found["indirect"][index]).items():
            setattr(row, key, value)
        row.paths = truth.surfels.paths // len(index)
        if found["at_points"] is not None:
            errors = errors_against(truth.points, found["at_points"], None)
            row.at_points, row.at_points_99 = errors["error"], errors["percentile_99"]
            row.reference_at_points = errors["reference"]
        if all(row.is_claimed(*claim) for claim in CLAIMS) or row.paths >= paths:
            return row
        truth.refine()


def solved(path, count, repeats, threads, places, meshless=False):
    """What a process of its own measures: medians of seconds, its peak, and values by the surfels of the scene."""
    start = perf_counter()
    loaded = sf.load_scene(path, surfels=count)
    loading = perf_counter() - start, peak_gigabytes()
    forget_peak()
    runs = []
    for turn in range(repeats + 1):
        solution = None  # two at once are nobody's memory
        scene = sf.Scene(loaded.objects, loaded.lights, solve_options=loaded.solve_options)  # not compiled yet
        start = perf_counter()
        solution = (sf.solve_meshless if meshless else sf.solve)(scene, threads=threads)
        runs.append({"seconds": perf_counter() - start, **solution.timings})
        if turn == 0:  # later ones take what this one has left
            gigabytes = peak_gigabytes()
    runs = runs[1:]
    middle = {stage: median(run[stage] for run in runs) for stage in runs[0]}
    n = sum(len(s) for s in scene.objects)
    total, direct = (by_scene_surfel(solution, values, n) for values in (solution.irradiance, solution.direct))
    at_points = None
    if hasattr(solution, "irradiance_at"):
        start = perf_counter()
        at_points = solution.irradiance_at(*places)
        middle[f"at {len(at_points)} points"] = perf_counter() - start
    last = solution.history[-1]
    return {
        "leaves": len(solution.surfels),
        "loading": loading,
        "seconds": middle.pop("seconds"),
        "stages": middle,
        "gigabytes": gigabytes,
        "error": solution.error,
        "figures": {name: last[name] for name in FIGURES if name in last} | {"iterations": len(solution.history)},
        "total": total,
        "indirect": total - direct,
        "at_points": at_points,
    }


def forget_peak():
    """Has peak_gigabytes() begin anew, where Linux can."""
    gc.collect()
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def in_fresh_process(work, *arguments):
    """work(*arguments), a function of a module, by a process of its own, whose peak of memory is its own."""
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        return fresh.submit(work, *arguments).result()


def peak_gigabytes():
    """The most memory this process has had since forget_peak(); None where Linux does not tell."""
    try:
        return int(re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text())[1]) * 1024 / 1e9
    except (OSError, TypeError):
        return None


def beside_mitsuba(row, truth, repeats, threads):
    """Gives the row the seconds in which Mitsuba has the row's error at as many places of the same scene as polygons.

    Its seconds are those of the paths alone, the scene loaded and the code compiled before.
    """
    mitsuba = mitsuba_renderer.load(threads)
    if mitsuba is None:
        return
    if not mitsuba_renderer.is_vectorized(mitsuba):
        print("bench: Mitsuba left out: its llvm variant finds no libLLVM, 16 or newer", file=sys.stderr)
        return
    built = scenes.build(row.scene)
    polygons = built.polygons()
    targets = scenes.targets_on(polygons, built.scene)
    theirs = Truth(polygons, targets, len(truth.surfels.index), threads=threads)
    while theirs.rounds < truth.surfels.rounds:
        theirs.refine()
    renderer = mitsuba_renderer.Renderer.of_surfels(mitsuba, polygons)
    some = targets[theirs.index]
    for samples in MITSUBA_SAMPLES:
        squares = even_squares(theirs.index, [1, samples], samples)
        places = places_on(targets, np.repeat(theirs.index, samples), squares)[0].reshape(-1, samples, 3)
        seconds = []
        for seed in range(repeats + 1):
            start = perf_counter()
            found = renderer.irradiance(places, some.normals, some.reflectance, some.emission, seed)
            seconds.append(perf_counter() - start)
        row.mitsuba.append([median(seconds[1:]), errors_against(theirs, found[:, 0], None)["error"]])
    row.mitsuba_seconds = seconds_until(row.error, row.mitsuba)


def seconds_until(error, curve):
    """When a curve of (seconds, error) reaches an error: between two of its points by a power of time, beyond them by
    the root."""
    curve = sorted(curve)
    x, y = (np.log([point[k] for point in curve]) for k in (0, 1))
    y = np.minimum.accumulate(y)  # chance may have a longer run a hair worse
    wanted = np.log(error)
    if wanted >= y[0]:
        return float(np.exp(x[0] + 2.0 * (y[0] - wanted)))
    if wanted <= y[-1]:
        return float(np.exp(x[-1] + 2.0 * (y[-1] - wanted)))
    return float(np.exp(np.interp(-wanted, -y, x)))


def table(rows):
    """The rows as Markdown: what they took, how far they are off, and where the seconds went."""
    took = [
        "| scene | surfels | leaves | seconds | GB | loading: seconds | GB | links | rays | cut | iterations |",
        "|---|" + "--:|" * 10,
    ]
    off = [
        "| scene | error of H, % | of its indirect part, % | 99th percentile, % | of the indirect part, % "
        "| irradiance_at, % | its 99th percentile, % | own estimate, % | reference's own: H, indirect, points, % |",
        "|---|" + "--:|" * 8,
    ]
    stages = ["| scene | seconds of each stage |", "|---|---|"]
    for r in rows:
        figures = [_figure(r.figures.get(name)) for name in ("links", "rays", "cut", "iterations")]
        solving, loading = (_two_digits(size) for size in (r.gigabytes, r.loading_gigabytes))
        took.append(
            f"| {r.scene} | {r.surfels} | {r.leaves} | {r.seconds:.2f} | {solving} | {r.loading:.2f} | {loading} "
            f"| {' | '.join(figures)} |"
        )
        errors = [f"{_claimed(r, 0)} ± {_percent(r.uncertainty)}", _claimed(r, 1)]
        errors += [_percent(v) for v in (r.percentile_99, r.percentile_99_indirect)]
        errors += ["" if r.at_points is None else _claimed(r, 2)]
        errors += [_percent(r.at_points_99), _percent(r.own)]
        reference = [_percent(getattr(r, claim[1])) for claim in CLAIMS if getattr(r, claim[0]) is not None]
        off.append(f"| {r.scene} | {' | '.join(errors)} | {', '.join(reference)} |")
        seconds = ", ".join(f"{stage} {value:.3f}" for stage, value in r.stages.items() if value >= 0.0005)
        stages.append(f"| {r.scene} | {seconds} |")
    text = "\n\n".join("\n".join(lines) for lines in (took, off, stages))
    for scene in GROWING:
        grown = sorted((r.surfels, r.seconds) for r in rows if r.scene.startswith(scene))
        if len(grown) < 2:
            continue
        power = math.log(grown[-1][1] / grown[0][1]) / math.log(grown[-1][0] / grown[0][0])
        steps = [math.log(b[1] / a[1]) / math.log(b[0] / a[0]) for a, b in pairwise(grown)]
        text += (
            f"\n\nFrom {grown[0][0]} to {grown[-1][0]} surfels of the {scene} seconds grow as n^{power:.2f}, from row "
        )
        text += f"to row as {', '.join(f'n^{step:.2f}' for step in steps)}."
    for r in rows:
        if r.mitsuba_seconds is not None:
            text += (
                f"\n\n{r.scene}: Mitsuba 3 (llvm) has an error of {_percent(r.error)} % at as many places of the same "
                f"polygons after {r.mitsuba_seconds:.2f} s, {r.mitsuba_seconds / r.seconds:.1f} times as long."
            )
    return text


def short_table(rows):
    """What a reader wants to know first, as one Markdown table."""
    lines = [
        "| scene | surfels | seconds | GB | loading, seconds | error of H, % | of its indirect part, % "
        "| irradiance_at, % | own estimate, % |",
        "|---|" + "--:|" * 8,
    ]
    for r in rows:
        errors = [_claimed(r, 0), _claimed(r, 1), "" if r.at_points is None else _claimed(r, 2), _percent(r.own)]
        took = f"{r.seconds:.2f} | {_two_digits(r.gigabytes)} | {r.loading:.2f}"
        lines.append(f"| {r.scene} | {r.surfels} | {took} | {' | '.join(errors)} |")
    return "\n".join(lines)


def _two_digits(value):
    return "" if value is None else f"{value:.2f}"


def _figure(value):
    return "" if value is None else f"{value:.3g}" if value >= 1e5 else str(value)


def _claimed(row, k):
    """An error in percent, with ~ where the reference is not sure enough of it."""
    return f"{'' if row.is_claimed(*CLAIMS[k]) else '~ '}{_percent(getattr(row, CLAIMS[k][0]))}"


def _percent(value):
    if value is None or math.isnan(value):
        return ""
    return f"{100 * value:.2g}" if value < 0.995 else f"{100 * value:.0f}"
