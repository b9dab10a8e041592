"""`surflux solve` in several processes."""

import contextlib
import os
from time import sleep

from surflux.cli.saying import fail

_NAP = 0.02  # seconds between two looks whether the first process has ended


def in_all_processes(options, run):
    """run(options) in each process of MPI where --mpi is given, of which the first alone speaks; the status."""
    if not getattr(options, "mpi", False):
        return run(options)
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as fault:  # RuntimeError: there is no library of MPI
        return fail(f"--mpi: needs mpi4py, pip install surflux[mpi], and a library of MPI ({fault})", 2)
    options.comm = comm = MPI.COMM_WORLD
    if comm.Get_rank() == 0:
        status = run(options)
    else:
        status = 0  # mpirun gives that of the first, then
        with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
            run(options)
    # Once one process has ended with a fault mpirun kills the others, before the first has said what was wrong.
    ended = comm.Ibarrier()
    while not ended.Test():
        sleep(_NAP)
    return status


def joined(options):
    """A block that ends in all processes where one fails."""
    if getattr(options, "comm", None) is None:
        return contextlib.nullcontext()
    from surflux.cluster.mpi import Members

    return Members(options.comm)


def is_first(options):
    """Whether this process writes files and prints."""
    comm = getattr(options, "comm", None)
    return comm is None or comm.Get_rank() == 0


def check_processes(options):
    """Refuses what does not go with several processes or a checkpoint."""
    for name in ("mpi", "checkpoint"):
        if getattr(options, name):
            if options.solver == "meshless":
                raise ValueError(f"--{name}: goes with --solver radiosity")
            if options.seconds:
                raise ValueError(f"--seconds: does not go with --{name}; wanted --error, or --zeta and --rays")


def processes_given(options):
    """cluster= and checkpoint= of sf.solve."""
    given = {"cluster": getattr(options, "comm", None), "checkpoint": options.checkpoint}
    return {name: value for name, value in given.items() if value is not None}
