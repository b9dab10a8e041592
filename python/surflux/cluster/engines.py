"""How a pass of the core is called: by this process alone, by several that share it out, or on from a checkpoint."""

from collections.abc import Callable
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

from surflux.cluster.agreement import call_facts
from surflux.cluster.checkpoint import Checkpoint, checkpoint_folder

Pass = TypeVar("Pass", bound=Callable[..., Any])


class Engine:
    """This process, and the others of an MPI communicator where there are any.

    members: surflux.cluster.mpi.Members, or None. folder: of the checkpoint, or None.
    """

    def __init__(self, members=None, folder=None):
        self._members, self._folder, self._calls = members, folder, 0

    @property
    def is_alone(self):
        """Whether a call leaves nothing to others, and keeps nothing."""
        return self._members is None and self._folder is None

    def call(self, program, scene, arguments, progress):
        """program(compiled scene, arguments, team, progress), a function of a module.

        Raises:
            ValueError: in all processes, where one has another scene, other options or another surflux.
            DeviceError: another process has failed.
            FileError: the checkpoint is damaged, of another call, or cannot be written.
        """
        core = scene._to_core()
        if self.is_alone:
            return program(core, arguments, None, progress)
        facts = call_facts(program, scene, arguments)
        if self._members is not None:
            self._members.require_same(facts)
        return program(core, arguments, _Team(self._members, self._opened(facts)), progress)

    def _opened(self, facts):
        """The Checkpoint of this call, one of several where an error was asked for; None where there is none."""
        checkpoint = None
        if self._folder is not None and (self._members is None or self._members.rank == 0):
            checkpoint = Checkpoint(Path(self._folder) / f"call-{self._calls}", facts)
        self._calls += 1
        return checkpoint


class _Team:
    """What the core asks for where processes share a pass out: see core/team.h."""

    def __init__(self, members, checkpoint):
        self._members, self._checkpoint, self._rounds = members, checkpoint, 0
        self.rank, self.size = (0, 1) if members is None else (members.rank, members.size)
        self._known = 0 if checkpoint is None else checkpoint.count
        if members is not None:
            self._known = members.meet("the checkpoint", self._known)[0]

    def exchange(self, name, make):
        k, checkpoint = self._rounds, self._checkpoint
        self._rounds += 1
        if k < self._known:
            parts = None if checkpoint is None else checkpoint.read(k, name)
            return parts if self._members is None else self._members.from_first(name, parts)
        parts = [make()] if self._members is None else self._members.exchange(name, make())
        if checkpoint is not None:
            checkpoint.write(k, name, parts)
        return parts


@contextmanager
def engine_of(cluster, checkpoint=None):
    """The engine of what users give as cluster= and checkpoint=, while the block runs.

    Raises:
        ValueError: cluster is neither an mpi4py communicator nor a Dask client.
    """
    packages = {base.__module__.partition(".")[0] for base in type(cluster).__mro__}
    if cluster is None:
        yield Engine(folder=checkpoint_folder(checkpoint))
    elif "mpi4py" in packages:
        from surflux.cluster.mpi import Members

        with Members(cluster) as members:
            yield Engine(members, checkpoint_folder(checkpoint))
    elif "distributed" in packages and hasattr(cluster, "submit"):
        from surflux.cluster.dask_engine import DaskEngine

        yield DaskEngine(cluster, checkpoint_folder(checkpoint))
    else:
        wanted = "wanted a communicator of mpi4py or a client of dask.distributed"
        raise ValueError(f"cluster: {wanted}, got {type(cluster).__name__}")


def shared_out(function: Pass) -> Pass:
    """The pass with an engine in place of cluster= and checkpoint=, which it calls the core by.

    Outermost, so that whatever fails in one process, ill arguments too, ends the call in all.
    """

    @wraps(function)
    def call(*args, cluster=None, checkpoint=None, **given):
        with engine_of(cluster, checkpoint) as engine:
            return function(*args, **given, cluster=engine)

    return cast(Pass, call)  # wraps keeps the signature
