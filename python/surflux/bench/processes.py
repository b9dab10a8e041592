"""What a solve costs when 1, 2 and 4 processes of one thread share it out, on this machine: `surflux bench --cluster`.

Processor seconds and not seconds on the clock: processes on one machine share its cores, those of a cluster do not.
"""

import os
import resource
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base.check import counted

SIZES = (1, 2, 4)
KNOBS = ({}, {"rays": 4096, "zeta": 0.01})  # as it is, and where rays are most of the work


@dataclass(frozen=True)
class Row:
    """seconds: of the processor, in the busiest process; efficiency: 1 where each of n processes takes an nth of what
    one alone takes. megabytes: of all exchanges, which each process receives. gigabytes: peak of the largest process.
    """

    scene: str
    knobs: dict
    surfels: int
    processes: int
    seconds: float
    seconds_in_all: float
    efficiency: float
    replicated: float
    exchanges: int
    megabytes: float
    gigabytes: float
    passes: bool  # the bits are those of this process alone


def why_not():
    """Why it cannot be measured here; None where it can."""
    try:
        import distributed  # noqa: F401
    except ImportError as fault:
        return f"needs `pip install surflux[dask]` ({fault})"
    return None


def measure(scene=None, sizes=SIZES, **knobs):
    """Rows of sizes of a cluster on this machine, which starts for each anew."""
    scene = scene or sf.examples.statues()
    wanted = sf.solve(scene, **knobs)
    rows = []
    for size in sizes:
        with tempfile.TemporaryDirectory() as folder:
            given = {**knobs, "checkpoint": folder}
            found, used, peak = in_workers(size, lambda client, given=given: sf.solve(scene, **given, cluster=client))
            exchanged = [file.stat().st_size for file in Path(folder).rglob("*.exchange")]
        first = rows[0].seconds if rows else max(used)
        share = first / max(used)
        rows.append(
            Row(
                scene.name or "the scene",
                knobs,
                sum(len(s) for s in scene.objects),
                size,
                max(used),
                sum(used),
                share / size,
                _replicated(share, size),
                len(exchanged),
                sum(exchanged) / 1e6,
                max(peak) / 1e9,
                np.array_equal(found.irradiance, wanted.irradiance),
            )
        )
    return rows


def in_workers(size, work):
    """What work(client) gives, by workers of one thread on this machine, and what it took in each of them.

    Returns:
        (its result, processor seconds of each, peak bytes of each).
    """
    from distributed import Client, LocalCluster

    options = {"n_workers": size, "threads_per_worker": 1, "dashboard_address": None, "memory_limit": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        client.run(_usage)  # imports surflux
        before = client.run(_usage)
        found = work(client)
        after = client.run(_usage)
        used = [after[worker][0] - before[worker][0] for worker in before]
    return found, used, [peak for _, peak in after.values()]


def _usage():
    """(processor seconds, peak bytes) of this process."""
    found = resource.getrusage(resource.RUSAGE_SELF)
    return found.ru_utime + found.ru_stime, found.ru_maxrss * (1 if os.uname().sysname == "Darwin" else 1024)


def _replicated(gain, size):
    """The share of one process's seconds that others do not take off it, by Amdahl's law; not a number of one."""
    return float("nan") if size == 1 else (1.0 / gain - 1.0 / size) / (1.0 - 1.0 / size)


def table(rows):
    head = "| processes | s in the busiest | s in all | efficiency | replicated | exchanges | MB | GB, largest | bits |"
    knobs = "".join(f", {name} {value}" for name, value in rows[0].knobs.items())
    surfels = counted(rows[0].surfels, "surfel")
    lines = [f"{rows[0].scene}, {surfels}{knobs}; processor seconds of one thread each\n"]
    lines += [head, "|--:|--:|--:|--:|--:|--:|--:|--:|---|"]
    for r in rows:
        replicated = "" if r.processes == 1 else f"{100 * r.replicated:.0f} %"
        same = "same" if r.passes else "OTHERS"
        lines.append(
            f"| {r.processes} | {r.seconds:.2f} | {r.seconds_in_all:.2f} | {100 * r.efficiency:.0f} % | {replicated} "
            f"| {r.exchanges} | {r.megabytes:.1f} | {r.gigabytes:.2f} | {same} |"
        )
    return "\n".join(lines)
