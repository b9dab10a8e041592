"""Errors and seconds of precomputed transfer, for lamps where none was before, beside path tracing.

`python tests/support/moving_lamps.py SCENE.toml LAMP...`, where a LAMP is x,y,z; `--option name=value` goes to
precompute_transfer. Errors are RMS over the surface, relative to that of all irradiance, and of indirect irradiance.
"""

import argparse
import ast
import time

import numpy as np

import surflux as sf
from surflux.bench.transfer_truth import errors_of, traced

REPEATS = 9


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("lamps", nargs="+")
    parser.add_argument("--option", action="append", default=[])
    parser.add_argument("--seeds", type=int, default=1)
    given = parser.parse_args()
    options = {name: ast.literal_eval(value) for name, value in (text.split("=") for text in given.option)}
    scene = sf.load_scene(given.scene)
    lamps = [sf.PointLight([float(x) for x in lamp.split(",")], 100.0) for lamp in given.lamps]
    start = time.perf_counter()
    surfels = sf.precompute_transfer(scene, levels=1, rays=16, senders=1).relight([]).surfels  # with areas
    print(f"compiled and tried in {time.perf_counter() - start:.1f} s")
    truths = [traced(scene, lamp, surfels) for lamp in lamps]
    print("| seed | lamp | of all, % | of indirect, % | mean, % | indirect, ms |\n|---|---|---|---|---|---|")
    for seed in range(given.seeds):
        start = time.perf_counter()
        transfer = sf.precompute_transfer(scene, bounces=None, seed=seed, **options)
        seconds = time.perf_counter() - start
        for text, lamp, truth in zip(given.lamps, lamps, truths, strict=True):
            taken = []
            for _ in range(REPEATS):
                start = time.perf_counter()
                found = transfer.indirect(lamp, bounces=3)
                taken.append(time.perf_counter() - start)
            found = transfer.indirect(lamp)
            of_all, of_indirect, *_ = errors_of(found, truth)
            mean = found[truth.index].mean() / truth.indirect.mean() - 1
            print(
                f"| {seed} | {text} | {100 * of_all:.1f} | {100 * of_indirect:.0f} | {100 * mean:+.1f} | "
                f"{1e3 * np.median(taken):.0f} |"
            )
        print(f"\n{transfer}, {seconds:.1f} s: {dict((k, round(v, 1)) for k, v in transfer.timings.items())}\n")


if __name__ == "__main__":
    main()
