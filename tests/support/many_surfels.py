"""Seconds, memory of each stage and silences of `solve` on as many surfels as wanted: four balls in a room of patches.

`python tests/support/many_surfels.py 1e5 1e6 1e7 [--meshless]`. Nothing is sampled: what counts is the solver's.
"""

import argparse
import resource
import threading
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import perf_counter, process_time

import numpy as np

import surflux as sf
from surflux._base import passes
from surflux.bench.scale import peak_gigabytes
from surflux.scenes import shapes

CENTERS = [[1.0, 1.0, 0.5], [3.0, 1.0, 0.6], [1.0, 3.0, 0.7], [3.0, 3.0, 0.5]]
RADIUS = 0.45
LONGEST = 12  # silences that are told


def balls_in_a_room(surfels):
    each = surfels // len(CENTERS)
    k = np.arange(each) + 0.5
    z, turn = 1.0 - 2.0 * k / each, k * np.pi * (3.0 - np.sqrt(5.0))
    sideways = np.sqrt(1.0 - z * z)
    normals = np.stack([sideways * np.cos(turn), sideways * np.sin(turn), z], axis=1)
    radii = np.full(each, 2.6 * RADIUS / np.sqrt(each))
    objects = [sf.Surfels(RADIUS * normals + c, normals, reflectance=0.6, radii=radii) for c in CENTERS]
    vertices, faces, _ = shapes.box(4.0, 12, inward=True)
    objects.append(sf.Surfels.from_mesh((vertices, faces), reflectance=0.7))
    return sf.Scene(objects, [sf.PointLight([2.0, 2.0, 3.5], 30.0)])


def gigabytes_now():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e9


def measured(count, solve=sf.solve):
    scene = balls_in_a_room(count)
    start = perf_counter()
    reported = start, process_time()
    silences, before = [], "start"
    most, ended = defaultdict(float), threading.Event()

    def watch():
        while not ended.wait(0.02):
            stage = before.split(":")[0]
            most[stage] = max(most[stage], gigabytes_now())

    def progress(stage, finished, total):
        nonlocal reported, before
        now = perf_counter(), process_time()
        here = f"{stage}: {finished} of {total}"
        silences.append((now[1] - reported[1], now[0] - reported[0], f"{before} -> {here}"))
        reported, before = now, here
        return True

    watcher = threading.Thread(target=watch)
    watcher.start()
    with passes.shown_by(progress):
        solution = solve(scene)
    ended.set()
    watcher.join()
    seconds = perf_counter() - start
    silences.append((process_time() - reported[1], perf_counter() - reported[0], f"{before} -> end"))
    return {
        "surfels": sum(len(surfels) for surfels in scene.objects),
        "seconds": round(seconds, 1),
        "gigabytes": round(peak_gigabytes(), 2),
        "own estimate, %": round(100 * solution.error, 2),
        "silences, seconds of all cores, seconds, where": [
            (round(busy, 2), round(passed, 2), where) for busy, passed, where in sorted(silences)[: -LONGEST - 1 : -1]
        ],
        "gigabytes by stage": {stage: round(peak, 2) for stage, peak in most.items()},
        "stages": {stage: round(seconds, 2) for stage, seconds in solution.timings.items()},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("surfels", type=float, nargs="+")
    parser.add_argument("--meshless", action="store_true")
    options = parser.parse_args()
    for surfels in options.surfels:
        # Each in a process of its own: its peak of memory is its own.
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            solve = sf.solve_meshless if options.meshless else sf.solve
            print(fresh.submit(measured, int(surfels), solve).result())


if __name__ == "__main__":
    main()
