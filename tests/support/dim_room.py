"""A dim room beside a bright one, and errors by local light: what an eye sees that has grown used to the dark.

`python tests/support/dim_room.py [--density 1] [--surfels 400] [--paths 32768] [--seeds 3] [--solver meshless]`
"""

import argparse
import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
import surflux as sf
from surflux.bench import scenes
from surflux.bench.solvers import by_scene_surfel
from surflux.bench.truth import even_squares, local_errors, places_on

PLACES = 8
WALL = 0.1  # m


def door_ajar(density=1.0):
    """data/door.toml; at density 1 with patches of 5 cm."""
    return scenes.build("door ajar", density).scene


def in_the_dark(scene):
    """Whether each surfel (n,) is in the dim room: not on the wall's or the door's other side, nor beneath them."""
    s = scene.surfels
    leaf = np.repeat(np.arange(len(scene.objects)), [len(o) for o in scene.objects]) == 4
    face = (s.normals[:, 0] > 0.9) & (s.points[:, 0] > WALL - 1e-3)  # of the wall
    return (face | (s.points[:, 0] > WALL + 1e-3)) & ~(leaf & (s.normals[:, 0] < -0.5))


class Reference:
    """Irradiance (m, 3) of surfels of a scene by path tracing, means over patches, with its standard error."""

    def __init__(self, scene, rows, paths, rounds=8, seed=0):
        self.scene, self.rows = scene, rows
        found = []
        for k in range(rounds):
            squares = even_squares(rows, [seed, k], PLACES)
            points, normals = places_on(scene.surfels, np.repeat(rows, PLACES), squares)
            samples = max(16, paths // (rounds * PLACES))
            values, _ = sf.reference_irradiance(scene, points, normals, samples=samples, seed=1000 * seed + k)
            found.append(values.reshape(len(rows), PLACES, 3).mean(axis=1))
        self.mean = np.mean(found, axis=0)
        self.error = np.std(found, axis=0, ddof=1) / np.sqrt(rounds)

    def of(self, solution):
        """What a solution has at these surfels: means, by area, over those inserted below each."""
        return by_scene_surfel(solution, solution.irradiance, len(self.scene.surfels))[self.rows]


def rms_of(solution):
    return np.sqrt(np.average((solution.irradiance**2).sum(axis=1), weights=solution.surfels.areas))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--density", type=float, default=1.0)
    parser.add_argument("--surfels", type=int, default=400)
    parser.add_argument("--paths", type=int, default=32768)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--solver", default="solve", choices=("solve", "meshless"))
    options = parser.parse_args()
    scene = door_ajar(options.density)
    areas = np.concatenate([sf.effective_areas(o) if o.areas is None else o.areas for o in scene.objects])
    chance = areas * in_the_dark(scene)
    rows = np.random.default_rng(3).choice(len(areas), options.surfels, p=chance / chance.sum())
    reference = Reference(scene, rows, options.paths)
    print("| seed | CPU s | dark: median, % | 90th, % | mean, % | own: RMS, % | local, % | 90th, % |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for seed in range(options.seeds):
        begin = process_time()
        solution = (sf.solve if options.solver == "solve" else sf.solve_meshless)(door_ajar(options.density), seed=seed)
        seconds, found = process_time() - begin, reference.of(solution)
        errors = local_errors(found, reference.mean, reference.error, rms_of(solution))
        last = solution.history[-1]
        figures = [
            *np.quantile(errors, [0.5, 0.9]),
            found.sum() / reference.mean.sum() - 1.0,
            solution.error,
            last["local_error"],
            last["local_error_p90"],
        ]
        print(f"| {seed} | {seconds:.1f} | " + " | ".join(f"{100 * f:.1f}" for f in figures) + " |", flush=True)


if __name__ == "__main__":
    main()
