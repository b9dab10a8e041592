"""Solution.error beside the true error, by path tracing or, in the table of cases, by closed forms.

`python tests/support/estimates.py SCENE.toml [--tight | --asked .02 .01]`, `python tests/support/estimates.py --cases`

With --asked the solvers get each of these as error=, and processor seconds and attempts are told, too.
"""

import argparse
import functools
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
import surflux as sf
from cases import CASES
from cases.case import problem_of
from cases.solvers import at_surfels
from surflux.bench.truth import Truth

MEASURED = 2000  # surfels
SHADOWS = {"probes": 64, "shadow_rays": 256}
DEFAULT = {
    "rays": lambda scene, seed: sf.solve(scene, transport="rays", seed=seed),
    "pairs": lambda scene, seed: sf.solve(scene, transport="pairs", seed=seed),
    "meshless": sf.solve_meshless,
}
TIGHT = {
    "rays": lambda scene, seed: sf.solve(scene, transport="rays", seed=seed, rays=1024, zeta=0.01, **SHADOWS),
    "pairs": lambda scene, seed: sf.solve(scene, transport="pairs", seed=seed, rays=64, **SHADOWS),
    "meshless": lambda scene, seed: sf.solve_meshless(scene, seed=seed, rays=2048, **SHADOWS),
}


def with_areas(scene):
    """The scene's surfels, with the areas that a solver gives them."""
    surfels = scene.surfels
    surfels.areas = np.concatenate([sf.effective_areas(o) if o.areas is None else o.areas for o in scene.objects])
    return surfels


class Estimated:
    """Errors of solutions of a scene at some of their surfels; those that were not split are traced once for all."""

    def __init__(self, scene, count=MEASURED, rounds=4):
        self.scene, self.rounds = scene, rounds
        self.truth = self._refined(Truth(scene, with_areas(scene), count, direct_places=64))

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
            below = self._refined(Truth(self.scene, solution.surfels, split.sum(), direct_places=64, state=state))
            true[split], noise[split] = below.total, below.total_error
        size = np.mean((true**2 - noise**2).sum(axis=1))
        off = ((solution.irradiance[leaves] - true) ** 2 - noise**2).sum(axis=1) / size
        error = np.sqrt(max(0.0, off.mean()))
        return error, off.std() / np.sqrt(len(off)) / (2 * max(error, 1e-12))


ASKED = {
    "rays": functools.partial(sf.solve, transport="rays"),
    "pairs": functools.partial(sf.solve, transport="pairs"),
    "meshless": sf.solve_meshless,
}

# A case has one value of each surfel: nothing is inserted.
OF_CASES = {
    "pairs": lambda scene, seed: sf.solve(scene, transport="pairs", tolerance=1e-7, insert=False, seed=seed),
    "rays": lambda scene, seed: sf.solve(scene, transport="rays", tolerance=1e-7, insert=False, seed=seed),
    "meshless": lambda scene, seed: sf.solve_meshless(scene, levels=3, tolerance=1e-7, seed=seed),
}
WITHIN = 0.7, 1.5
EXACT = 1e-8  # errors and estimates below this agree
MOST_PAIRS = 3000  # surfels


def cases():
    """(name, solver, solution, true relative RMS error) of each case whose truth covers all of its surfels."""
    for case in CASES:
        problem = problem_of(case, case.densities[-1])
        known = np.zeros(len(problem.scene.surfels), bool)
        for wanted in problem.wanted:
            known[wanted.surfels] |= not wanted.mean
        for solver, solve in OF_CASES.items():
            if known.all() and not (solver == "pairs" and len(known) > MOST_PAIRS):
                solution = solve(problem.scene, 0)
                yield case.name, solver, solution, problem.error(at_surfels(solution, problem.scene))


def report_cases():
    print("| case | solver | error, % | estimate, % | ratio |\n|---|---|---|---|---|")
    held = total = 0
    for name, solver, solution, error in cases():
        own, doubt = solution.error, solution.history[-1]["error_uncertainty"]
        good = WITHIN[0] * error <= own <= WITHIN[1] * error or max(own, error) < EXACT
        held, total = held + good, total + 1
        ratio = f"{own / error:.2f}" if error > EXACT else ""
        ratio += "" if good else " off"
        print(f"| {name} | {solver} | {100 * error:.3g} | {100 * own:.3g} +- {100 * doubt:.2g} | {ratio} |")
    print(f"\n{held} of {total} within {WITHIN[0]} and {WITHIN[1]}")


def report_asked(path, solvers, wanted, seeds):
    scene = sf.load_scene(path)
    estimated = Estimated(scene)
    for solver in solvers:
        for error in wanted:
            for seed in range(seeds):
                begun = process_time()
                solution = ASKED[solver](scene, error=error, seed=seed)
                seconds = process_time() - begun
                true, doubt = estimated.error(solution)
                print(
                    f"| {path} | {solver} | {100 * error:g} | {seed} | {100 * true:.2f} +- {100 * doubt:.2f} "
                    f"| {100 * solution.error:.2f} | {len(solution.attempts)} | {seconds:.1f} |",
                    flush=True,
                )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--cases", action="store_true")
    parser.add_argument("--tight", action="store_true")
    parser.add_argument("--asked", nargs="+", type=float, metavar="ERROR")
    parser.add_argument("--solvers", nargs="+", default=["rays", "meshless"], choices=list(DEFAULT))
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    if options.cases:
        report_cases()
    if not options.scenes:
        return
    if options.asked:
        print("| scene | solver | asked, % | seed | error, % | estimate, % | attempts | processor s |")
        print("|---|---|---|---|---|---|---|---|")
        for path in options.scenes:
            report_asked(path, options.solvers, options.asked, options.seeds)
        return
    print("| scene | solver | seed | error, % | estimate, % | ratio |\n|---|---|---|---|---|---|")
    for path in options.scenes:
        scene = sf.load_scene(path)
        estimated = Estimated(scene)
        for solver in options.solvers:
            for seed in range(options.seeds):
                solution = (TIGHT if options.tight else DEFAULT)[solver](scene, seed=seed)
                error, doubt = estimated.error(solution)
                own, own_doubt = solution.error, solution.history[-1]["error_uncertainty"]
                print(
                    f"| {path} | {solver} | {seed} | {100 * error:.2f} +- {100 * doubt:.2f} "
                    f"| {100 * own:.2f} +- {100 * own_doubt:.2f} | {own / error:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
