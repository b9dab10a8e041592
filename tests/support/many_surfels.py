"""Seconds, peaks of memory and silences of `solve` on as many surfels as wanted: four balls in a room of patches.

`python tests/support/many_surfels.py 1e6 [--meshless]`. Nothing is sampled, so that what counts is the solver's.
"""

import argparse
import re
import threading
from pathlib import Path
from time import perf_counter, sleep

import numpy as np

import surflux as sf
from surflux.scenes import shapes

CENTERS = [[1.0, 1.0, 0.5], [3.0, 1.0, 0.6], [1.0, 3.0, 0.7], [3.0, 3.0, 0.5]]
RADIUS = 0.45


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


def gigabytes(key):
    """VmRSS: what this process has; VmHWM: the most that it had."""
    return int(re.search(rf"{key}:\s+(\d+)", Path("/proc/self/status").read_text())[1]) * 1024 / 1e9


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("surfels", type=float)
    parser.add_argument("--meshless", action="store_true")
    options = parser.parse_args()
    scene = balls_in_a_room(int(options.surfels))
    start = reported = perf_counter()
    silences, sizes, done = [], [], threading.Event()

    def progress(finished, total):
        nonlocal reported
        now = perf_counter()
        silences.append(now - reported)
        reported = now
        return True

    def watch():
        while not done.is_set():
            sizes.append((perf_counter() - start, gigabytes("VmRSS")))
            sleep(0.02)

    print(f"{sum(len(s) for s in scene.objects)} surfels, {gigabytes('VmRSS'):.2f} GB")
    watcher = threading.Thread(target=watch)
    watcher.start()
    solution = (sf.solve_meshless if options.meshless else sf.solve)(scene, progress=progress)
    done.set()
    watcher.join()
    at, size = np.array(sizes).T
    print(f"{perf_counter() - start:.1f} s, {gigabytes('VmHWM'):.2f} GB at most, own estimate {solution.error:.2%}")
    print("longest silences, s:", *(f"{s:.2f}" for s in sorted(silences)[:-6:-1]))
    first = 0.0
    for stage, seconds in solution.timings.items():
        of_stage = size[(at >= first) & (at < first + seconds)]
        print(f"{stage:14} {seconds:7.2f} s {of_stage.max() if len(of_stage) else 0.0:6.2f} GB")
        first += seconds


if __name__ == "__main__":
    main()
