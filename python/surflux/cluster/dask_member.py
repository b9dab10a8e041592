"""What a Dask worker runs: one of the processes that share a pass out, in a thread beside the worker's tasks.

The client asks by tasks that end within a second, so that a worker of one thread is never held up.
"""

import threading
from time import monotonic

from surflux import _core
from surflux._base.passes import thread_limit
from surflux.cluster.agreement import machine_facts
from surflux.scenes.scene_arrays import scene_of_arrays

# Seconds without a word of the client after which a process ends by itself.
FORSAKEN = 120.0
_POLL = 0.5
_MEMBERS = {}  # by job and rank
_LOCK = threading.Lock()


class Member:
    """One process of a job; it is also the team that the core asks: see core/team.h."""

    def __init__(self, rank, size, known, work):
        self.rank, self.size = rank, size
        self._known, self._rounds = known, 0
        self._given, self._part, self._told, self._outcome = {}, None, None, None
        self._changed, self._heard, self._is_over = threading.Condition(), monotonic(), False
        threading.Thread(target=self._run, args=(work,), daemon=True).start()

    def exchange(self, name, make):
        k = self._rounds
        self._rounds += 1
        part = make() if k >= self._known else None
        with self._changed:
            if part is not None:
                self._part = k, name, part
                self._changed.notify_all()
            while k not in self._given:
                if not self._goes_on():
                    raise _core.Cancelled("cancelled")
                self._changed.wait(_POLL)
            self._part = None
            was, parts = self._given.pop(k)
        if was != name:
            raise _core.DeviceError(f"process {self.rank} is at {name!r}, where the others were at {was!r}")
        return parts

    def answer(self, k, given, patience):
        """("part", name, bytes) of exchange k, ("done", result), ("failed", exception, text), or ("working", progress).

        given: [(exchange, name, parts)] that have not been told yet.
        """
        with self._changed:
            self._heard = monotonic()
            for index, name, parts in given:
                self._given[index] = name, parts
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._outcome is not None or self._is_at(k), patience)
            self._heard = monotonic()
            if self._outcome is not None:
                return self._outcome
            return ("part", *self._part[1:]) if self._is_at(k) else ("working", self._told)

    def end(self):
        with self._changed:
            self._is_over = True
            self._changed.notify_all()

    def _is_at(self, k):
        return self._part is not None and self._part[0] == k

    def _goes_on(self, *told):
        self._told = told
        return not self._is_over and monotonic() - self._heard < FORSAKEN

    def _run(self, work):
        try:
            found = "done", work(self, self._goes_on) if self.rank == 0 else work(self, self._goes_on) and None
        except BaseException as fault:
            found = "failed", type(fault).__name__, str(fault)
            if isinstance(fault, _core.Cancelled) and not self._is_over:
                found = "failed", "DeviceError", f"nothing was heard of the client for {FORSAKEN:g} s"
        with self._changed:
            self._outcome = found
            self._changed.notify_all()


def begin(job, rank, size, known, program, scene, arguments):
    """Starts process `rank` of a job, which is given the first `known` exchanges without having a part in them.

    scene: what scene_arrays gives; the core's scene is made of it, in one process of a worker after the other.
    """
    from distributed import get_worker

    threads = get_worker().state.nthreads

    def work(team, goes_on):
        with thread_limit(threads):
            with _LOCK:
                core = scene_of_arrays(*scene)._to_core()
            return program(core, arguments, team, goes_on)

    _MEMBERS[job, rank] = Member(rank, size, known, work)
    return True


def step(job, rank, k, given, patience):
    """Member.answer; ("unknown",) where the worker has started anew since."""
    member = _MEMBERS.get((job, rank))
    return ("unknown",) if member is None else member.answer(k, given, patience)


def end(job):
    """Ends what of a job runs in this worker, at its next look."""
    for key in [key for key in _MEMBERS if key[0] == job]:
        _MEMBERS.pop(key).end()


def facts_of_worker():
    """What must be the same in all workers."""
    return machine_facts()
