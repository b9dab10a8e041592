"""Solution.error beside the error against path tracing: `python tests/support/estimates.py SCENE.toml [--tight]`."""

import argparse

import numpy as np

import surflux as sf
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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--tight", action="store_true")
    parser.add_argument("--solvers", nargs="+", default=["rays", "meshless"], choices=list(DEFAULT))
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
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
