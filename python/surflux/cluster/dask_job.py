"""One call of a pass in the workers of a Dask cluster, from the client's side."""

import threading
import uuid
from collections import Counter
from contextlib import suppress
from functools import partial
from time import monotonic, sleep

from surflux import _core
from surflux._base.passes import LOG, goes_on
from surflux.cluster import dask_member
from surflux.cluster.agreement import difference, machine_facts

# Seconds: of one question to a worker; until a free worker has to do for a lost one; until there has to be any.
QUESTION, SPARE, ANY = 1.0, 5.0, 20.0
_LOSSES = 3  # of the same process at the same exchange, which end the job
_NOTICED = 1.0  # seconds until the scheduler knows that a worker has gone
_SMALL = 1 << 16  # bytes that go along with a question; what is more is sent from worker to worker, too
_REACHED = 2.0  # seconds in which a worker answers this process itself, past the scheduler


class Job:
    """Runs program(compiled scene, arguments, team, progress) in every worker, and has the result of the first.

    Lost workers are replaced: by a free one, or by one that has a process already. What was exchanged is known here,
    and the new process goes on after it.

    Args:
        client: distributed.Client.
        log: of exchanges: a Checkpoint or a MemoryLog.
        progress: callback of the pass, which is told what process 0 tells; False of it cancels.
    """

    def __init__(self, client, log, progress):
        self._client, self._log, self._progress = client, log, progress
        self._name = f"surflux-{uuid.uuid4().hex}"
        self._place, self._asked, self._lost, self._reached = {}, {}, Counter(), {}
        self._event = threading.Event()

    def run(self, program, scene, arguments, workers):
        self._work = program, scene, arguments
        size = len(workers)
        try:
            held = self._sent(scene, workers[0])
            for rank, address in enumerate(workers):
                self._begin(rank, size, address, held)
            del held
            given = [self._entry(k) for k in range(self._log.count)]
            while True:
                k = self._log.count
                answers = self._answers(k, size, given)
                if answers[0][0] == "done":
                    return answers[0][1]
                names = {answer[1] if answer[0] == "part" else "the end" for answer in answers}
                if len(names) > 1:
                    raise _core.DeviceError(
                        f"cluster: processes are at different exchanges: {', '.join(sorted(names))}"
                    )
                (name,), parts = names, [part for _, _, part in answers]
                self._log.write(k, name, parts)
                given = [(k, name, parts)]
        finally:
            self._end()

    def _entry(self, k):
        return (k, *self._log.entry(k))

    def _begin(self, rank, size, address, scene=None):
        """Starts a process; what is asked of it later waits behind. scene: in the worker already, or None."""
        self._place[rank] = address
        program, arrays, arguments = self._work
        if scene is None:
            scene = self._sent(arrays, address)
        if scene is not None:  # else the worker is lost, as will be seen
            call = dask_member.begin, self._name, rank, size, self._log.count, program, scene, arguments
            self._asked[rank] = "begin", self._submit(address, *call)

    def _sent(self, data, worker):
        """A future of what this worker has then, and others have from it; None where it was lost meanwhile.

        Not broadcast: the scheduler would go on trying to reach a worker that has gone.
        """
        try:
            return self._client.scatter([data], workers=[worker], hash=False, direct=self._is_reached(worker))[0]
        except Exception as fault:  # of many kinds, also from inside the scheduler
            sleep(_NOTICED)
            if worker in self._client.nthreads():
                raise _core.DeviceError(f"cluster: data do not reach worker {worker} ({fault!r})") from fault
            return None

    def _is_reached(self, worker):
        """Whether this process reaches the worker itself: what goes through the scheduler takes twice as long."""
        if worker not in self._reached:
            self._reached[worker] = self._client.sync(_answers_at_once, worker, self._client.connection_args)
        return self._reached[worker]

    def _submit(self, address, *call):
        future = self._client.submit(*call, workers=[address], allow_other_workers=False, pure=False)
        future.add_done_callback(lambda _: self._event.set())
        return future

    def _answers(self, k, size, given):
        """[("part", name, bytes) or ("done", result) of each process], which are told the exchanges `given` first."""
        answers, news = {}, dict.fromkeys(range(size), given)
        shared = self._shared(given)
        while len(answers) < size and answers.get(0, ("",))[0] != "done":
            self._event.clear()
            living = self._client.nthreads()
            for rank in range(size):
                if rank in answers:
                    continue
                if self._place[rank] not in living:
                    news[rank] = self._replaced(rank, size, k)
                    continue
                if rank not in self._asked:
                    told = shared if news[rank] is given else news[rank]
                    call = dask_member.step, self._name, rank, k, told, QUESTION
                    self._asked[rank] = "step", self._submit(self._place[rank], *call)
                    continue
                what, future = self._asked[rank]
                if not future.done():
                    continue
                del self._asked[rank]
                place = self._place[rank]
                answer = _result(self._client, future, place, self._is_reached(place))
                if answer is None and what == "step":
                    # Lost, as will be seen; or what it was to be told was, with the worker that had it.
                    news[rank] = list(news[rank])
                elif answer is None or (what == "step" and answer[0] == "unknown"):
                    news[rank] = self._replaced(rank, size, k)
                elif what == "step":
                    news[rank] = []
                    if answer[0] == "failed":
                        raise _failure(rank, self._place[rank], *answer[1:])
                    if answer[0] == "working":
                        self._tell(rank, answer[1])
                    else:
                        answers[rank] = answer
                self._event.set()
            self._event.wait(0.2)
        return [answers[rank] for rank in sorted(answers)]

    def _shared(self, given):
        """`given` as an argument of all questions."""
        if sum(len(part) for _, _, parts in given for part in parts) < _SMALL:
            return given
        while workers := sorted(set(self._place.values()) & set(living_workers(self._client))):
            if (held := self._sent(given, workers[0])) is not None:
                return held
        return given  # all are about to be replaced, and told by themselves

    def _replaced(self, rank, size, k):
        """Starts a lost process anew; the exchanges that it has to be told."""
        self._asked.pop(rank, None)
        self._lost[rank, k] += 1
        if self._lost[rank, k] >= _LOSSES:
            raise _core.DeviceError(
                f"cluster: process {rank} was lost {_LOSSES} times at exchange {k}, the last time in worker "
                f"{self._place[rank]}; its log says why, perhaps for want of memory"
            )
        begun, address = monotonic(), None
        while address is None:
            living = living_workers(self._client)
            busy = Counter(place for other, place in self._place.items() if other != rank)
            free = [address for address in living if not busy[address]]
            if free or monotonic() - begun > SPARE:
                address = min(living, key=lambda address: (busy[address], address))
            if address is None or require_same_facts(self._client, [address]) is None:
                address = None
                sleep(0.2)
        LOG.info("process %d was lost with worker %s, and goes on in %s", rank, self._place[rank], address)
        self._begin(rank, size, address)
        return [self._entry(index) for index in range(k)]

    def _tell(self, rank, told):
        if rank == 0 and told and self._progress is not None and not goes_on(self._progress(*told)):
            raise _core.Cancelled("cancelled")

    def _end(self):
        self._asked.clear()
        with suppress(OSError):  # of what ended the call more is known than that nobody answers now
            self._client.run(dask_member.end, self._name, on_error="ignore")


class MemoryLog:
    """What was exchanged, in memory."""

    def __init__(self):
        self._entries = []

    @property
    def count(self):
        return len(self._entries)

    def entry(self, k):
        return self._entries[k]

    def write(self, k, name, parts):
        self._entries.append((name, parts))


def living_workers(client):
    """Addresses of the workers, sorted; waits a while for one."""
    begun = monotonic()
    while not (found := sorted(client.nthreads())):
        if monotonic() - begun > ANY:
            raise _core.DeviceError(f"cluster: {client.scheduler.address} has had no worker for {ANY:g} s")
        sleep(0.2)
    return found


async def _answers_at_once(worker, how):
    from distributed.comm import connect

    try:
        comm = await connect(worker, timeout=_REACHED, **how)
    except OSError:
        return False
    await comm.close()
    return True


def _result(client, future, worker, direct=None):
    """What a task in that worker gives, past the scheduler where `direct`; None where the worker is lost."""
    from distributed.client import FutureCancelledError
    from distributed.scheduler import KilledWorker

    gathered = partial(client.gather, future, direct=direct, asynchronous=True)
    patience = _NOTICED
    while True:
        try:
            return client.sync(gathered, callback_timeout=patience)
        except TimeoutError:  # it takes long, is large, or whoever has it has gone
            if worker not in client.nthreads():
                return None
            patience *= 2.0  # each time it is sent from the beginning
        except (KilledWorker, FutureCancelledError, OSError):
            return None


def require_same_facts(client, workers):
    """Facts of the workers, None where all were lost meanwhile.

    Refuses one that is not as this process, or not as the first, by its address.
    """
    call = {"allow_other_workers": False, "pure": False}
    asked = {address: client.submit(dask_member.facts_of_worker, workers=[address], **call) for address in workers}
    ours, first = machine_facts(), None
    for address, future in asked.items():
        try:
            theirs = _result(client, future, address)
        except Exception as fault:  # whatever keeps it from being imported
            raise ValueError(f"cluster: worker {address} has no surflux that runs ({fault})") from fault
        if theirs is None:
            continue  # lost, which whoever asks it next will see
        first = first or (address, theirs)
        # What this process runs on does not matter: it computes areas alone.
        for other, wanted in (("this process", ours | {"instruction set": theirs["instruction set"]}), first):
            if fact := difference(wanted, theirs):
                raise ValueError(
                    f"cluster: worker {address} has another {fact[0]} ({fact[2]}) than {other} ({fact[1]})"
                )
    return None if first is None else first[1]


def _failure(rank, address, kind, text):
    """The exception of a process, as this one raises it."""
    if kind in ("Cancelled", "MemoryError"):
        return _core.DeviceError(f"cluster: process {rank}, worker {address}, has ended: {kind} {text}".rstrip())
    known = {"ValueError": ValueError, "DeviceError": _core.DeviceError, "FileError": _core.FileError}
    return known.get(kind, _core.DeviceError)(
        text if kind in known else f"process {rank}, worker {address}: {kind}: {text}"
    )
