"""Ctrl-C: a command ends within a second, whatever it is at, and leaves no half-written file."""

import contextlib
import os
import re
import signal
import sys
import threading
from pathlib import Path

from surflux._base.files import UNFINISHED

INTERRUPTED = 130  # status of what Ctrl-C ended, as shells have it
_PATIENCE = 0.5  # seconds in which passes may end by themselves, which they do where they tell how far they are
_OF_THE_CORE = re.compile(r"\.part\d+$")  # names of files that the core has not written to their end


@contextlib.contextmanager
def ended_by_ctrl_c():
    """Ends the process, with status 130, soon after Ctrl-C, even if a library that cannot be asked is at work.

    For the main thread of a program of its own: nothing behind the block is reached then.
    """
    if (
        threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield
        return
    read, write = os.pipe()
    os.set_blocking(write, False)
    before = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(read,), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(write)  # which ends the thread


def _watch(read):
    while pressed := os.read(read, 1):
        if pressed[0] == signal.SIGINT:
            threading.Event().wait(_PATIENCE)
            leave()


def leave(*, said=False):
    """Ends the process as Ctrl-C does, without what is half written, and without waiting for any thread.

    said: whether the user has been told.
    """
    _remove_unfinished()
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write("" if said else "surflux: error: interrupted\n")
        sys.stderr.flush()
    os._exit(INTERRUPTED)


def _remove_unfinished():
    """Removes what this process, or a library in it, has begun to write and not renamed yet."""
    for path in [*UNFINISHED, *(path for path in _written() if _OF_THE_CORE.search(path.name))]:
        with contextlib.suppress(OSError):
            path.unlink()


def _written():
    """Paths of the files that this process has open for writing, where the system tells."""
    for number in os.listdir("/proc/self/fd") if os.path.isdir("/proc/self/fd") else ():
        with contextlib.suppress(OSError, StopIteration):  # of one that is closed meanwhile
            lines = Path(f"/proc/self/fdinfo/{number}").read_text().splitlines()
            flags = int(next(line for line in lines if line.startswith("flags:")).split()[1], 8)
            if flags & os.O_ACCMODE != os.O_RDONLY:
                yield Path(os.readlink(f"/proc/self/fd/{number}"))
