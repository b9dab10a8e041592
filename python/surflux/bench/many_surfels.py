"""Seconds, memory and silences of `solve` on as many surfels as wanted: four balls in a room of patches.

Nothing is sampled and all balls are of one colour, so that what counts is the solver's. Each size has a process of its
own: its peak of memory is its own.
"""

import signal
import sys
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter, process_time

import numpy as np

import surflux as sf
from surflux.bench.scale import in_fresh_process, peak_gigabytes
from surflux.scenes import shapes

SIZES = (100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
CENTERS = [[1.0, 1.0, 0.5], [3.0, 1.0, 0.6], [1.0, 3.0, 0.7], [3.0, 3.0, 0.5]]
RADIUS = 0.45
_EVERY = 0.01  # seconds between two signals


@dataclass
class Row:
    """One size."""

    surfels: int
    seconds: float
    gigabytes: float | None  # the most that the process had
    estimate: float  # Solution.error
    silence: float  # longest time in which Ctrl-C would not be heard, seconds of all cores
    clock_silence: float  # the same on the clock


def balls_in_a_room(surfels):
    """A scene of about that many surfels."""
    each = surfels // len(CENTERS)
    k = np.arange(each) + 0.5
    z, turn = 1.0 - 2.0 * k / each, k * np.pi * (3.0 - np.sqrt(5.0))
    sideways = np.sqrt(1.0 - z * z)
    normals = np.stack([sideways * np.cos(turn), sideways * np.sin(turn), z], axis=1)
    radii = np.full(each, 2.6 * RADIUS / np.sqrt(each))
    objects = [sf.Surfels(RADIUS * normals + c, normals, reflectance=0.6, radii=radii) for c in CENTERS]
    vertices, faces, _ = shapes.box(4.0, 12, inward=True)
    objects.append(sf.Surfels.from_mesh((vertices, faces), reflectance=0.7))
    return sf.Scene(objects, [sf.PointLight([2.0, 2.0, 3.5], 30.0)], name="four balls in a room")


def measure(sizes, threads=None):
    """A Row for each size."""
    rows = []
    for size in sizes:
        print(f"bench: {size} surfels", file=sys.stderr)
        rows.append(in_fresh_process(solved, size, threads))
    return rows


def solved(size, threads=None):
    """The Row of one size, of this process."""
    scene = balls_in_a_room(size)
    start = perf_counter()
    with heard() as times:
        solution = sf.solve(scene, threads=threads)
    return Row(
        sum(len(surfels) for surfels in scene.objects),
        perf_counter() - start,
        peak_gigabytes(),
        float(solution.error),
        *(float(longest) for longest in np.diff(times, axis=0).max(axis=0)),
    )


@contextmanager
def heard():
    """[(process_time(), perf_counter()) of each signal that was heard]: signals come all the time, as Ctrl-C might."""
    times = [_now()]
    before = signal.signal(signal.SIGALRM, lambda *_: times.append(_now()))
    signal.setitimer(signal.ITIMER_REAL, _EVERY, _EVERY)
    try:
        yield times
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        times.append(_now())


def _now():
    return process_time(), perf_counter()


def table(rows):
    """Markdown: a line for each size."""
    lines = [
        "| surfels | seconds | GB | own estimate, % | longest silence, processor seconds | on the clock |",
        "|--:|--:|--:|--:|--:|--:|",
    ]
    for row in rows:
        cells = [f"{row.surfels:,}".replace(",", " "), f"{row.seconds:.3g}"]
        cells += ["" if row.gigabytes is None else f"{row.gigabytes:.2f}", f"{100 * row.estimate:.2f}"]
        cells += [f"{row.silence:.2g}", f"{row.clock_silence:.2g}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
