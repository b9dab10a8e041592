"""`surflux solve` in several processes."""

import contextlib
import os
import sys
import traceback
from time import sleep

from surflux.cli.saying import fail

_CONNECT = 10.0  # seconds in which a scheduler has to answer
_NAP = 0.02  # seconds between two looks whether the first process has ended


def in_all_processes(options, run):
    """run(options) in each process of MPI where --mpi is given, of which the first alone speaks; the status."""
    if not getattr(options, "mpi", False):
        return run(options)
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as fault:  # RuntimeError: there is no library of MPI
        return fail(f"--mpi: needs mpi4py, pip install 'surflux[mpi]', and a library of MPI ({fault})", 2)
    options.comm = comm = MPI.COMM_WORLD
    try:
        if comm.Get_rank() == 0:
            status = run(options)
        else:
            status = 0  # mpirun gives that of the first, then
            with (
                open(os.devnull, "w") as nowhere,
                contextlib.redirect_stdout(nowhere),
                contextlib.redirect_stderr(nowhere),
            ):
                run(options)
    except Exception:  # one that is not foreseen: the others would wait for this process, and it for them at its exit
        traceback.print_exc()
        sys.stderr.flush()
        comm.Abort(1)
    # Once one process has ended with a fault mpirun kills the others, before the first has said what was wrong.
    ended = comm.Ibarrier()
    while not ended.Test():
        sleep(_NAP)
    return status


@contextlib.contextmanager
def joined(options):
    """A block with what --mpi or --cluster names, that ends in all processes of MPI where one fails."""
    if getattr(options, "comm", None) is not None:
        from surflux.cluster.mpi import Members

        with Members(options.comm):
            yield
    elif getattr(options, "cluster", None) is not None:
        with _client(options.cluster) as options.client:
            yield
    else:
        yield


def _client(address):
    try:
        from distributed import Client
    except ImportError as fault:
        raise ImportError(f"--cluster: needs dask.distributed, pip install 'surflux[dask]' ({fault})") from fault
    try:
        return Client(address, timeout=_CONNECT)
    except (OSError, ValueError) as fault:
        raise ValueError(
            f"--cluster: wanted the address of a Dask scheduler, tcp://HOST:PORT; {address}: {fault}"
        ) from fault


def is_first(options):
    """Whether this process writes files and prints."""
    comm = getattr(options, "comm", None)
    return comm is None or comm.Get_rank() == 0


def check_processes(options):
    """Refuses what does not go with several processes or a checkpoint."""
    if options.mpi and options.cluster:
        raise ValueError("--mpi: does not go with --cluster; wanted one of the two")
    for name in ("mpi", "cluster", "checkpoint"):
        if getattr(options, name) and options.seconds:
            raise ValueError(f"--seconds: does not go with --{name}; wanted --error, or --rays and its like")


def processes_given(options):
    """cluster= and checkpoint= of solvers."""
    cluster = getattr(options, "client", None) if getattr(options, "comm", None) is None else options.comm
    given = {"cluster": cluster, "checkpoint": options.checkpoint}
    return {name: value for name, value in given.items() if value is not None}
