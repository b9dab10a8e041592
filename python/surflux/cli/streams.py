"""stdout and stderr of commands, whatever the caller has made of them."""

import contextlib
import os
import sys


@contextlib.contextmanager
def usable_streams(own=False):
    """A block whose stdout and stderr take all text: what they cannot encode is escaped, and closed ones lead nowhere.

    own: whether the process is the command's, and ends with it: then what they do not take by then is dropped.
    """
    with contextlib.ExitStack() as streams:
        if own:
            _fill_standard_files()
            streams.callback(_drop_the_rest)
        for name, redirected in (("stdout", contextlib.redirect_stdout), ("stderr", contextlib.redirect_stderr)):
            stream = getattr(sys, name)
            if stream is None:  # its file was closed when the process began
                escaped = {"encoding": "utf-8", "errors": "backslashreplace"}
                streams.enter_context(redirected(streams.enter_context(open(os.devnull, "w", **escaped))))
            elif getattr(stream, "errors", None) in ("strict", "surrogateescape") and hasattr(stream, "reconfigure"):
                streams.callback(_reconfigure, stream, stream.errors)
                stream.reconfigure(errors="backslashreplace")
        yield


def _fill_standard_files():
    """Nothing that is opened later gets the number of a closed stdin, stdout or stderr, to which libraries write."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free


def _reconfigure(stream, errors):
    with contextlib.suppress(OSError):  # of a reader that has gone
        stream.reconfigure(errors=errors)


def _drop_the_rest():
    """Where readers have gone, or disks are full, the interpreter would end with an exit status of its own."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
