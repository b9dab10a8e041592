"""What every long call takes beside its own options: threads and progress."""

import contextlib
import logging
import sys
import threading
from concurrent.futures import ThreadPoolExecutor, wait
from functools import partial
from time import monotonic

import numpy as np

from surflux import _core
from surflux._base import check

LOG = logging.getLogger("surflux")
OF_PROGRESS = {"of_progress": True}  # what records of the log have that tell how far a stage is
_POLL = 0.1  # seconds between two looks at what threads do
_watch = threading.local()


def goes_on(answer):
    """Whether a callback's answer lets a pass go on: all but False do, None and 0 too."""
    return not (isinstance(answer, (bool, np.bool_)) and not answer)


def report(callback, done, total):
    """Tells a pass's callback, or None, how far it is; raises Cancelled where that answers False."""
    if callback is not None and not goes_on(callback(done, total)):
        raise _core.Cancelled("cancelled")


def stage(label):
    """The callback (done, total) of a pass within a long call of this thread; None where nobody watches one."""
    show = getattr(_watch, "show", None)
    return None if show is None else partial(show, label)


@contextlib.contextmanager
def watched(threads, progress):
    """What a long call does with its threads and its progress, while the block runs.

    Passes that this thread begins in it keep to the limit, and report to stage(their name): to the caller's callback,
    or to a bar each.
    """
    with thread_limit(threads), stage_callback(progress) as show, shown_by(show):
        yield


@contextlib.contextmanager
def progress_callback(progress, label):
    """The callback (done, total) -> bool of a call of one pass: None, the caller's own, or a bar."""
    with stage_callback(progress) as show:
        yield None if show is None else partial(show, label)


@contextlib.contextmanager
def stage_callback(progress):
    """The callback (stage, done, total) -> bool of a call of several passes: a bar each, or the caller's own.

    progress: a callback (done, total); True for bars of tqdm; False for what the call is part of, or None.
    """
    if callable(progress):
        yield lambda _, done, total: progress(done, total)
        return
    if not check.flag("progress", progress) or getattr(_watch, "silent", False):
        yield getattr(_watch, "show", None)
        return
    current, bar, begun = None, None, set()
    with contextlib.ExitStack() as bars:

        def show(label, done, total):
            nonlocal current, bar
            if label != current:
                bars.close()
                bar, current = bars.enter_context(_bar(label, label not in begun)), label
                begun.add(label)
            return bar(done, total)

        yield show


@contextlib.contextmanager
def thread_limit(threads):
    """At most that many threads while the block runs; None is all of them."""
    limit = None if threads is None else _core.ThreadLimit(check.count("threads", threads))
    try:
        yield
    finally:
        del limit


def in_threads(jobs, names, threads=None, order=None):
    """[job() for job in jobs], two at a time, for work of which much cannot be shared by threads.

    What the jobs report is shown on the thread that called, under their names, of one after another. Ctrl-C and a
    callback that answers False end all of them at their next report.

    Args:
        threads: of all jobs together; None for all.
        order: indices, which to begin with; None for the first.
    """
    show, stop, told = getattr(_watch, "show", None), threading.Event(), {}
    workers = 2 if threads is None else min(2, threads)

    def run(k):
        def note(label, done, total):
            told[k] = f"{names[k]}: {label}", done, total
            return not stop.is_set()

        with thread_limit(None if threads is None else threads // workers), shown_by(note):
            try:
                return jobs[k]()
            finally:
                told.pop(k, None)

    pool = ThreadPoolExecutor(workers)
    try:
        futures = {k: pool.submit(run, k) for k in (range(len(jobs)) if order is None else order)}
        results = []
        for k in range(len(jobs)):
            while wait([futures[k]], _POLL).not_done:
                for label, done, total in sorted(told.copy().values())[:1]:
                    report(show and partial(show, label), done, total)
            results.append(futures[k].result())
        return results
    except BaseException:
        stop.set()
        raise
    finally:  # nobody waits for what stops: it may be a while until it is asked
        pool.shutdown(wait=False, cancel_futures=True)


@contextlib.contextmanager
def shown_by(show):
    """Passes of this thread report to show(stage, done, total) while the block runs."""
    before = getattr(_watch, "show", None)
    _watch.show = show
    try:
        yield
    finally:
        _watch.show = before


@contextlib.contextmanager
def without_progress():
    """progress=True shows nothing while the block runs in this thread; callbacks are asked as always."""
    before = getattr(_watch, "silent", False)
    _watch.silent = True
    try:
        yield
    finally:
        _watch.silent = before


@contextlib.contextmanager
def _bar(label, is_new):
    """A tqdm bar, in a notebook a widget; where stderr is no terminal, which bars would fill, lines now and then."""
    from tqdm.auto import tqdm

    begun = monotonic()
    try:
        if not getattr(sys.stderr, "isatty", bool)() and "notebook" not in tqdm.__module__:
            yield ProgressLines(label, is_new)
            return
        with tqdm(desc=label, unit_scale=True, leave=False) as bar:

            def show(done, total):
                bar.total = total
                bar.update(done - bar.n)
                return True

            yield show
    finally:
        LOG.debug("%s: %.2f s", label, monotonic() - begun, extra=OF_PROGRESS)


class ProgressLines:
    """Progress of a stage as lines of the log: its name, and while it goes on how far it is and how long it may take.

    A line comes after 5 s at the earliest, and then only for a tenth more or after half a minute.
    """

    EVERY, AT_LEAST, SHARE = 5.0, 30.0, 0.1
    _EARLY = 0.02  # of which nobody can tell how long the rest takes

    def __init__(self, label, is_new=True):
        self._label = label
        self._begun = self._said = monotonic()
        self._share = 0.0
        if is_new:
            LOG.info(label, extra=OF_PROGRESS)

    def __call__(self, done, total):
        now = monotonic()
        waited = now - self._said
        if waited < self.EVERY:
            return True
        share = min(1.0, done / total) if total else 0.0
        if share - self._share < self.SHARE and waited < self.AT_LEAST:
            return True
        self._said, self._share = now, share
        if not total:
            LOG.info("%s: %d so far", self._label, done, extra=OF_PROGRESS)
        elif share < self._EARLY:
            LOG.info("%s: %.0f %%", self._label, 100.0 * share, extra=OF_PROGRESS)
        else:
            rest = (now - self._begun) * (1.0 - share) / share
            LOG.info("%s: %.0f %%, about %s left", self._label, 100.0 * share, duration(rest), extra=OF_PROGRESS)
        return True


def duration(seconds):
    """Seconds as text, no finer than anybody needs: "8 s", "3 min", "2.1 h"."""
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5970.0 else f"{seconds / 3600.0:.1f} h"
