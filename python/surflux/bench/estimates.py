"""Solution.error beside the error that path tracing tells, of solutions as they are and of those asked for an error.

Errors are relative RMS errors of H over the surface, from surfels drawn by area, the squares of standard errors of the
reference taken off. Seconds are those of the processor on all cores.
"""

import functools
import sys
from dataclasses import dataclass
from statistics import median
from time import process_time

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.truth import Truth, with_areas

MEASURED = 2000  # surfels
SHADOWS = {"probes": 64, "shadow_rays": 256}
SOLVERS = {
    "rays": functools.partial(sf.solve, transport="rays"),
    "pairs": functools.partial(sf.solve, transport="pairs"),
    "meshless": sf.solve_meshless,
}
NAMES = {"rays": "`solve`", "meshless": "`solve_meshless`"}  # of those that tables have
TIGHT = {
    "rays": {"rays": 1024, "zeta": 0.01, **SHADOWS},
    "pairs": {"rays": 64, **SHADOWS},
    "meshless": {"rays": 2048, **SHADOWS},
}
# Name -> (file in data/, is it solved by tight options, too?).
SCENES = {
    "Cornell box": ("cornell", True),
    "three spheres": ("three_spheres", True),
    "two bunnies": ("two_bunnies", True),
    "statues": ("statues", True),
    "statue": ("statue", True),
    "gallery": ("gallery", False),
    "Sponza": ("sponza", False),
}
LARGE = ("gallery", "Sponza")  # in a table of their own, which takes as long as that of all others
ASKED_SCENES = ("Cornell box", "three spheres", "statues")
ASKED = (0.02, 0.01, 0.005)
ASKED_MEASURED = 400


@dataclass
class Row:
    """One solver on one scene. Lists have an entry for each seed, single numbers are the RMS or the median of these."""

    scene: str
    by: str  # the solver, or what it was asked for
    surfels: int
    error: float
    estimate: float
    seconds: float | None  # of the processor
    errors: list
    estimates: list
    all_seconds: list
    attempts: list
    uncertainty: float | None  # of each of the errors from the choice of surfels, the largest


class Estimated:
    """Errors of solutions of a scene at some of their surfels; those that were not split are traced once for all."""

    def __init__(self, scene, count=MEASURED, rounds=4, threads=None):
        self.scene, self.rounds, self.threads = scene, rounds, threads
        self.truth = self._refined(Truth(scene, with_areas(scene), count, direct_places=64, threads=threads))

    def _refined(self, truth):
        while truth.rounds < self.rounds:
            truth.refine()
        return truth

    def error(self, solution):
        """Relative RMS error of H at the solution's surfels, drawn by area, and its standard error from that."""
        own, areas = self.truth.index, solution.surfels.areas
        order = np.argsort(solution.parents, kind="stable")
        first = np.searchsorted(solution.parents[order], own, "left")
        last = np.searchsorted(solution.parents[order], own, "right")
        # Of each surfel of the scene one of those below it, by area.
        up_to = np.concatenate([[0.0], np.cumsum(areas[order])])
        chosen = up_to[first] + np.random.default_rng(0).random(len(own)) * (up_to[last] - up_to[first])
        leaves = order[np.clip(np.searchsorted(up_to, chosen, side="right") - 1, first, last - 1)]
        true, noise = self.truth.total.copy(), self.truth.total_error.copy()
        split = last - first > 1
        if split.any():
            state = {"index": leaves[split], "sums": np.zeros((4, split.sum(), 3)), "rounds": 0, "paths": 0}
            options = {"direct_places": 64, "threads": self.threads, "state": state}
            below = self._refined(Truth(self.scene, solution.surfels, split.sum(), **options))
            true[split], noise[split] = below.total, below.total_error
        size = np.mean((true**2 - noise**2).sum(axis=1))
        off = ((solution.irradiance[leaves] - true) ** 2 - noise**2).sum(axis=1) / size
        error = np.sqrt(max(0.0, off.mean()))
        return float(error), float(off.std() / np.sqrt(len(off)) / (2 * max(error, 1e-12)))


def measure(names, seeds, threads=None):
    """Rows of both solvers, by default and with TIGHT options."""
    rows = []
    for name, scene in _there(names):
        estimated = Estimated(scene, MEASURED, threads=threads)
        for tight in (False, True) if SCENES[name][1] else (False,):
            for solver, by in NAMES.items():
                options = TIGHT[solver] if tight else {}
                rows.append(_row(estimated, solver, by + ", tight" * tight, seeds, threads, options))
    return rows


def measure_asked(names, seeds, threads=None):
    """Rows of `solve` by rays, asked for each of ASKED."""
    rows = []
    for _, scene in _there(names):
        estimated = Estimated(scene, ASKED_MEASURED, threads=threads)
        rows += [_row(estimated, "rays", f"error={e:g}", seeds, threads, {"error": e}) for e in ASKED]
    return rows


def _there(names):
    """(name, scene) of those that can be had; of the others it is said why."""
    for name in names:
        stem, _ = SCENES[name]
        if reason := scenes.why_no_file(stem):
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
        else:
            yield name, sf.load_scene(scenes.data_folder() / f"{stem}.toml")


def _row(estimated, solver, by, seeds, threads, options):
    scene = estimated.scene
    surfels = sum(len(o) for o in scene.objects)
    row, doubts = Row(scene.name, by, surfels, 0.0, 0.0, 0.0, [], [], [], [], 0.0), []
    for seed in range(seeds):
        fresh = sf.Scene(scene.objects, scene.lights)  # not compiled yet
        begun = process_time()
        solution = SOLVERS[solver](fresh, seed=seed, threads=threads, **options)
        row.all_seconds.append(process_time() - begun)
        error, doubt = estimated.error(solution)
        row.errors.append(error)
        doubts.append(doubt)
        row.estimates.append(float(solution.error))
        row.attempts.append(max(1, len(solution.attempts)))
        print(f"bench: {scene.name}, {by}, seed {seed}: off {error:.2%}", file=sys.stderr)
    row.error, row.estimate = (float(np.sqrt(np.mean(np.square(of)))) for of in (row.errors, row.estimates))
    row.seconds, row.uncertainty = median(row.all_seconds), max(doubts)
    return row


def table(rows):
    """Markdown: errors of all seeds, and how far estimates are from them."""
    lines = ["| scene | by | surfels | processor seconds | error, % | estimate / error |", "|---|---|--:|--:|---|---|"]
    for row in rows:
        pairs = zip(row.estimates, row.errors, strict=True)
        ratios = " ".join(f"{own / error:.2f}" if error else "-" for own, error in pairs)  # "-": it is below its noise
        seconds = "" if row.seconds is None else f"{row.seconds:.3g}"
        cells = [row.scene, row.by, str(row.surfels), seconds, _percents(row.errors), ratios]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def asked_table(rows):
    """Markdown: what was asked for, and what came of it, seed by seed."""
    lines = ["| scene | asked | error, % | estimate, % | processor seconds | attempts |", "|---|---|---|---|---|---|"]
    for row in rows:
        seconds = " ".join(f"{s:.2g}" for s in row.all_seconds)
        cells = [f"`{row.by}`", _percents(row.errors), _percents(row.estimates), seconds]
        attempts = " ".join(map(str, row.attempts))
        lines.append(f"| {' | '.join([row.scene, *cells, attempts])} |")
    return "\n".join(lines)


def _percents(errors):
    return " ".join(f"{100 * error:.2f}" for error in errors)
