"""Error against processor seconds: solve beside path tracing of the same scene at the same surfels, three seeds each.

python tests/support/error_seconds.py data/error_seconds.png

Three spheres in a room, 4326 surfels. Errors are relative RMS of the irradiance. That of solve is of its surfels,
inserted ones too, as in estimates.py; that of path tracing at the middles of 500 surfels drawn by area, against 16384
paths each, whose squared standard error is taken off.
"""

import sys
import time

import numpy as np
from matplotlib import pyplot

import surflux as sf
from estimates import Estimated

PATHS = (16, 64, 256)
ASKED = (0.04, 0.02, 0.01, 0.005)  # error=
SEEDS = (0, 1, 2)


def timed(function):
    began = time.process_time()
    return function(), time.process_time() - began


def main():
    scene = sf.examples.three_spheres()
    s = scene.surfels
    areas = np.concatenate([sf.effective_areas(part) for part in scene.objects])
    asked = np.random.default_rng(7).choice(len(s), 500, replace=True, p=areas / areas.sum())
    places = s.points[asked], s.normals[asked]
    known, noise = sf.reference_irradiance(scene, *places, samples=16384, seed=99)

    def error(found):
        off = ((found - known) ** 2).sum() - (noise**2).sum()
        return np.sqrt(max(off, 0.0) / (known**2).sum())

    true = Estimated(scene)
    figure, axes = pyplot.subplots(figsize=(6.4, 4.2))
    for name, mark, settings in (("path tracing", "s", PATHS), ("solve, error=", "o", ASKED)):
        means = []
        for setting in settings:
            runs = []
            for seed in SEEDS:
                if setting in ASKED:
                    options = {"error": setting, "seed": seed}
                    solution, seconds = timed(lambda options=options: sf.solve(scene, **options))
                    runs.append((seconds, true.error(solution)[0]))
                else:
                    options = {"samples": setting, "seed": seed}
                    traced = timed(lambda o=options: sf.reference_irradiance(scene, s.points, s.normals, **o))
                    runs.append((traced[1], error(traced[0][0][asked])))
            means.append(np.mean(runs, axis=0))
            print(name, setting, " ".join(f"{seconds:.2f} s {100 * e:.2f} %" for seconds, e in runs), flush=True)
        seconds, errors = np.transpose(means)
        axes.loglog(seconds, 100 * errors, marker=mark, label=name)
    axes.set(xlabel="processor seconds, all 4326 surfels", ylabel="error of the irradiance, %")
    axes.grid(which="both", linewidth=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(sys.argv[1], dpi=90)


if __name__ == "__main__":
    main()
