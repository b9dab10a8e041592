"""Ctrl-C: a command ends within a second, whatever it is at, and leaves no half-written file."""

import contextlib
import os
import re
import signal
import sys
import threading
from pathlib import Path

INTERRUPTED = 130  # status of what Ctrl-C ended, as shells have it
_PATIENCE = 0.5  # seconds in which passes may end by themselves, which they do where they tell how far they are
_UNFINISHED = re.compile(r"\.part\d+$|-\d+\.part[^/]*$")  # names that the core and unfinished_name give


@contextlib.contextmanager
def ended_by_ctrl_c(folders=()):
    """Ends the process, with status 130, soon after Ctrl-C, even if a library that cannot be asked is at work.

    For the main thread of a program of its own: nothing behind the block is reached then.

    Args:
        folders: where the program writes through others, whose files are removed as well.
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
    threading.Thread(target=_watch, args=(read, folders), daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(write)  # which ends the thread


def _watch(read, folders):
    while pressed := os.read(read, 1):
        if pressed[0] == signal.SIGINT:
            threading.Event().wait(_PATIENCE)
            leave(folders)


def leave(folders=(), *, said=False):
    """Ends the process as Ctrl-C does, without what is half written, and without waiting for any thread.

    said: whether the user has been told.
    """
    _remove_unfinished(folders)
    with contextlib.suppress(OSError, ValueError):
        sys.stderr.write("" if said else "surflux: error: interrupted\n")
        sys.stderr.flush()
    os._exit(INTERRUPTED)


def _remove_unfinished(folders):
    """Removes what this process is writing under the name of an unfinished file, and those of its number in folders."""
    unfinished = [path for path in _written() if _UNFINISHED.search(path.name)]
    for folder in folders:
        with contextlib.suppress(OSError):
            unfinished += [path for path in Path(folder).iterdir() if f"-{os.getpid()}.part" in path.name]
    for path in unfinished:
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
