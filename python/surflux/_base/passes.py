"""What every long pass takes beside its own options: threads and progress."""

import contextlib
import sys
import threading

from surflux import _core
from surflux._base import check

_stop = threading.local()


def stop_callback():
    """What a pass asks that nobody watches: the callback of stoppable() on this thread; None where there is none."""
    return getattr(_stop, "callback", None)


@contextlib.contextmanager
def stoppable(event):
    """Passes that this thread begins in the block are cancelled once a threading.Event is set.

    For threads that work for another: Ctrl-C reaches the main thread alone.
    """
    before = stop_callback()
    _stop.callback = lambda done, total: not event.is_set()
    try:
        yield
    finally:
        _stop.callback = before


@contextlib.contextmanager
def progress_callback(progress, label):
    """The callback (done, total) -> bool of one pass: None, the caller's own, or a tqdm bar on stderr.

    Where stderr is no terminal, a log is not filled with bars: one line says which pass begins.
    """
    if callable(progress):
        yield progress
    elif check.flag("progress", progress):
        if not sys.stderr.isatty():
            print(f"surflux: {label}", file=sys.stderr, flush=True)
            yield lambda done, total: True
            return
        from tqdm import tqdm

        with tqdm(desc=label, unit_scale=True, leave=False) as bar:

            def show(done, total):
                bar.total = total
                bar.update(done - bar.n)
                return True

            yield show
    else:
        yield stop_callback()


@contextlib.contextmanager
def stage_callback(progress):
    """For a pass of several stages, which the core names: one bar each, or the caller's own callback."""
    if callable(progress):
        yield lambda _, done, total: progress(done, total)
        return
    if not check.flag("progress", progress):
        yield None
        return
    current, bar = None, None
    with contextlib.ExitStack() as bars:

        def show(stage, done, total):
            nonlocal current, bar
            if stage != current:
                bars.close()
                bar, current = bars.enter_context(progress_callback(True, stage)), stage
            return bar(done, total)

        yield show


def report(callback, done, total):
    """Tells a pass's callback, or None, how far it is; raises Cancelled where that answers False."""
    if callback is not None and (answer := callback(done, total)) is not None and not answer:
        raise _core.Cancelled("cancelled")


@contextlib.contextmanager
def thread_limit(threads):
    """At most that many threads while the block runs; None is all of them."""
    limit = None if threads is None else _core.ThreadLimit(check.count("threads", threads))
    try:
        yield
    finally:
        del limit
