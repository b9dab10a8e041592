"""What 1, 2 and 4 processes of one thread take that share a pass out, on this machine: `surflux bench --cluster`.

Processor seconds and not seconds on the clock: processes on one machine share its cores, those of a cluster do not.
They count from when a process has imported surflux, what it takes to unpack messages included. "Replicated" is what
Amdahl's law makes of them: the share of the work that every process does by itself. Where there are cores enough, also
the seconds on the clock, beside those of as many threads in one process.
"""

import os
import resource
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench.many_surfels import balls_in_a_room
from surflux.bench.scale import peak_gigabytes

SIZES = (1, 2, 4)
KNOBS = ({}, {"rays": 4096, "zeta": 0.01})  # as it is, and where rays are most of the work
BALLS = 300_000  # surfels
TRACED, PATHS = 20, 4096  # every so many surfels of the statues are traced, by so many paths
MORE = (10, 100, 1000)  # machines of which it is reckoned what they would do
NETWORK = 10e9  # bits a second


@dataclass(frozen=True)
class Row:
    """seconds: of the processor, in the busiest process; efficiency: 1 where each of n processes takes an nth of what
    one alone takes. replicated: None of one process. megabytes: of all exchanges, which each process receives, None
    where it was not told. gigabytes: peak of the largest process, None where Linux does not tell. clock, by_threads: on
    the clock, of the processes and of as many threads in one, None where there are fewer cores.
    """

    what: str
    processes: int
    surfels: int  # of which H is found
    seconds: float
    seconds_in_all: float
    efficiency: float
    replicated: float | None
    exchanges: int | None
    megabytes: float | None
    gigabytes: float | None
    passes: bool  # the bits are those of this process alone
    clock: float | None = None
    by_threads: float | None = None


def why_not():
    """Why it cannot be measured here; None where it can."""
    try:
        import distributed  # noqa: F401
    except ImportError as fault:
        return f"needs `pip install 'surflux[dask]'` ({fault})"
    return None


def measure():
    """Rows of all passes that are measured."""
    statues = sf.examples.statues()
    rows = [row for knobs in KNOBS for row in of_solve(statues, SIZES, **knobs)]
    return [*rows, *of_solve(balls_in_a_room(BALLS), SIZES), *of_reference(statues, SIZES, TRACED, PATHS)]


def of_solve(scene, sizes, **knobs):
    """Rows of sizes of a cluster on this machine, which starts for each anew."""
    what = ", ".join(["`solve`", scene.name or "the scene", *(f"`{name}={value}`" for name, value in knobs.items())])

    def solved(client=None, folder=None, threads=None):
        return sf.solve(scene, **knobs, checkpoint=folder, cluster=client, threads=threads).irradiance

    return _rows(what, sum(len(s) for s in scene.objects), sizes, solved)


def of_reference(scene, sizes, every, paths):
    """Rows of reference_irradiance at one of `every` so many surfels of a scene."""
    surfels = scene.surfels[::every]
    places = scene, surfels.points, surfels.normals, paths

    def traced(client=None, folder=None, threads=None):
        return sf.reference_irradiance(*places, cluster=client, threads=threads)[0]

    what = f"`reference_irradiance`, {scene.name or 'the scene'}, {paths} paths"
    return _rows(what, len(surfels), sizes, traced)


def _rows(what, surfels, sizes, work):
    """Of work(client, folder for a checkpoint), which is to give the same as work(threads=) in this process."""
    rows, wanted = [], work(threads=1)
    for size in sizes:
        print(f"bench: {what}, processes: {size}", file=sys.stderr)
        clock = by_threads = None
        with tempfile.TemporaryDirectory() as folder:
            found, used, peak, seconds = in_workers(size, lambda client, folder=folder: work(client, folder))
            exchanged = [file.stat().st_size for file in Path(folder).rglob("*.exchange")]
        if size <= (os.cpu_count() or 1):
            start = perf_counter()
            work(threads=size)
            clock, by_threads = seconds, perf_counter() - start
        share = (rows[0].seconds if rows else max(used)) / max(used)
        rows.append(
            Row(
                what,
                size,
                surfels,
                max(used),
                sum(used),
                share / size,
                _replicated(share, size),
                len(exchanged) or None,
                sum(exchanged) / 1e6 or None,
                None if None in peak else max(peak),
                np.array_equal(found, wanted),
                clock,
                by_threads,
            )
        )
    return rows


def in_workers(size, work):
    """What work(client) gives, by workers of one thread on this machine, and what it took in each of them.

    Returns:
        (its result, processor seconds of each, peak GB of each, seconds on the clock).
    """
    from distributed import Client, LocalCluster

    options = {"n_workers": size, "threads_per_worker": 1, "dashboard_address": None, "memory_limit": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        client.run(_usage)  # imports surflux
        before = client.run(_usage)
        start = perf_counter()
        found = work(client)
        clock = perf_counter() - start
        after = client.run(_usage)
        used = [after[worker][0] - before[worker][0] for worker in before]
    return found, used, [peak for _, peak in after.values()], clock


def _usage():
    """(processor seconds, peak GB) of this process; getrusage has the peak of the process that started it, too."""
    found = resource.getrusage(resource.RUSAGE_SELF)
    return found.ru_utime + found.ru_stime, peak_gigabytes()


def _replicated(gain, size):
    """The share of one process's seconds that others do not take off it, by Amdahl's law; None of one."""
    return None if size == 1 else (1.0 / gain - 1.0 / size) / (1.0 - 1.0 / size)


def table(rows):
    """Markdown: a line for each pass and number of processes."""
    lines = [
        "| what | surfels | processes | s in the busiest | s in all | efficiency | replicated | exchanged, MB "
        "| GB, largest | s on the clock | by as many threads | bits |",
        "|---|" + "--:|" * 10 + "---|",
    ]
    for r in rows:
        cells = [r.what, str(r.surfels), str(r.processes), f"{r.seconds:.3g}", f"{r.seconds_in_all:.3g}"]
        cells += [f"{100 * r.efficiency:.0f} %", "" if r.replicated is None else f"{100 * r.replicated:.0f} %"]
        cells += ["" if r.megabytes is None else f"{r.megabytes:.3g}"]
        cells += ["" if r.gigabytes is None else f"{r.gigabytes:.2f}"]
        cells += ["" if seconds is None else f"{seconds:.3g}" for seconds in (r.clock, r.by_threads)]
        lines.append(f"| {' | '.join(cells)} | {'same' if r.passes else 'OTHERS'} |")
    return "\n".join(lines)


def reckoned(rows):
    """Markdown: how many times as fast more machines would be, by what the largest number of processes replicated, and
    in how many seconds each would receive what is exchanged.
    """
    heads = [f"{n} machines" for n in MORE]
    lines = [f"| what | replicated | {' | '.join(heads)} | received by each, s |", "|---|" + "--:|" * (len(MORE) + 2)]
    for r in {r.what: r for r in rows if r.replicated is not None}.values():
        share = min(1.0, max(0.0, r.replicated))
        gains = [f"{1.0 / (share + (1.0 - share) / n):.1f}" for n in MORE]
        received = "" if r.megabytes is None else f"{8e6 * r.megabytes / NETWORK:.2g}"
        lines.append(f"| {r.what} | {100 * share:.0f} % | {' | '.join(gains)} | {received} |")
    return "\n".join(lines)
