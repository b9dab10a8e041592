"""What inserted surfels do to the light of a cloud's own points: its error there, and processor seconds.

    python tests/support/light_of_points.py CLOUD [SEEDS]

As `surflux solve CLOUD` lights it, with `--insert` and without; against `reference_irradiance` at 4000 of the points,
whose own error is taken off.
"""

import sys
import time
import warnings

import numpy as np

import surflux as sf
from surflux.__main__ import main

COUNT, SAMPLES = 4000, 1024


class Seen(Exception):
    """The scene that a command would solve."""


def scene_of(path, *options):
    def solve(scene, **settings):
        raise Seen(scene)

    before, sf.solve = sf.solve, solve
    sys.argv = ["surflux", "solve", path, "--no-image", "-o", "never_written.npz", *options]
    try:
        main()
    except Seen as seen:
        return seen.args[0]
    finally:
        sf.solve = before
    raise SystemExit(f"{path}: could not be lit")


def run(path, seeds):
    scene = scene_of(path)
    surfels = scene.surfels
    rows = np.random.default_rng(5).choice(len(surfels), min(COUNT, len(surfels)), replace=False)
    wanted, error = sf.reference_irradiance(scene, surfels.points[rows], surfels.normals[rows], SAMPLES)
    total = (wanted**2).mean()
    for insert in (False, True):
        for seed in range(seeds):
            begin = time.process_time()
            solution = sf.solve(scene, insert=insert, seed=seed)
            seconds = time.process_time() - begin
            off = solution.per_surfel()[rows] - wanted
            rms = np.sqrt(max(0.0, (off**2).mean() - (error**2).mean()) / total)
            where = f"insert={insert}, seed {seed}: {len(solution.surfels)} surfels"
            print(f"{where}, {seconds:.1f} processor seconds, error {rms:.2%}", flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    run(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 3)
