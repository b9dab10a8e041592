"""Processes that MPI has started, which exchange what each gives by an mpi4py communicator."""

from time import sleep

import numpy as np

from surflux import _core
from surflux.cluster.agreement import difference, machine_facts

# Bytes that one call of MPI moves at most: its counts are 32-bit.
CHUNK = 1 << 30
_NAPS = 1e-4, 1e-2  # seconds between two looks whether all have come: the first, and at most


class Members:
    """The processes of a communicator, while the block runs. An exception in one of them ends the block in all.

    Blocks may stand in each other. All processes must come to the same blocks in the same order; inside of them whoever
    fails tells the others, which see it when they next meet.
    """

    def __init__(self, comm):
        if comm.Is_inter():
            raise ValueError("cluster: wanted an intracommunicator, got an intercommunicator")
        self._comm, self._pending = comm, None
        self.rank, self.size = comm.Get_rank(), comm.Get_size()

    def __enter__(self):
        return self

    def __exit__(self, kind, fault, trace):
        if fault is None:
            self.meet("the end")
        elif not getattr(fault, "is_told", False):
            self._gather(None, f"{type(fault).__name__}: {fault}" if str(fault) else type(fault).__name__)
            fault.is_told = True
        return False

    def meet(self, place, item=None):
        """[item of each process], where all have come to the same place."""
        told = self._gather((place, item), None)
        for rank, (_, fault) in enumerate(told):
            if fault is not None:
                raise _told(_core.DeviceError(f"process {rank} of {self.size} has failed: {fault}"))
        places = [where for (where, _), _ in told]
        for rank, where in enumerate(places):
            if where != places[0]:
                at = f"process {rank} of {self.size} is at {where!r}, process 0 at {places[0]!r}"
                raise _told(_core.DeviceError(f"{at}: all must make the same calls in the same order"))
        return [item for (_, item), _ in told]

    def require_same(self, facts):
        """Refuses, in all processes, facts that are not the same for all."""
        ours = {**machine_facts(), **facts}
        for rank, theirs in enumerate(all_facts := self.meet("the start", ours)):
            if found := difference(all_facts[0], theirs):
                name, first, other = found
                text = f"cluster: process {rank} of {self.size} has another {name} ({other}) than process 0 ({first})"
                raise _told(ValueError(text))

    def exchange(self, name, mine):
        """[bytes of each process]."""
        lengths = self.meet(name, len(mine))
        step = max(1, CHUNK // self.size)
        parts = [bytearray(length) for length in lengths]
        received = np.empty(sum(min(length, step) for length in lengths), np.uint8)
        self.meet(f"{name}: memory")  # whoever lacks it says so here, and not while others wait in MPI
        for begin in range(0, max(lengths), step):
            counts = [min(max(length - begin, 0), step) for length in lengths]
            sent = np.frombuffer(mine, np.uint8, counts[self.rank], min(begin, len(mine)))
            self._comm.Allgatherv(sent, [received[: sum(counts)], counts])
            for part, count, end in zip(parts, counts, np.cumsum(counts), strict=True):
                part[begin : begin + count] = received[end - count : end].data
        for rank, part in enumerate(parts):
            parts[rank] = bytes(part)  # one after another, so that few are there twice
        return parts

    def from_first(self, name, parts):
        """The parts of an exchange that process 0 knows, in all processes; the others give None."""
        lengths = self.meet(name, None if parts is None else [len(part) for part in parts])[0]
        whole = np.frombuffer(b"".join(parts), np.uint8) if self.rank == 0 else np.empty(sum(lengths), np.uint8)
        self.meet(f"{name}: memory")
        for begin in range(0, len(whole), CHUNK):
            self._comm.Bcast(whole[begin : begin + CHUNK])
        return [piece.tobytes() for piece in np.split(whole, np.cumsum(lengths)[:-1])]

    def _gather(self, item, fault):
        """What each gives, once all have come. MPI itself would wait at full speed, on a core that others may use."""
        request = self._pending or self._comm.Ibarrier()
        self._pending, nap = request, _NAPS[0]
        while not request.Test():
            sleep(nap)  # where Ctrl-C may come: then the barrier stays for the next call
            nap = min(1.5 * nap, _NAPS[1])
        self._pending = None
        return self._comm.allgather((item, fault))


def _told(fault):
    """The exception as one that all processes raise."""
    fault.is_told = True
    return fault
