"""Whether this process was forked: pools of threads that libraries began before are not in it."""

import os

_forked = False


def is_forked():
    """True in a process that was forked from one in which surflux was imported."""
    return _forked


def _mark_forked():
    global _forked
    _forked = True


if hasattr(os, "register_at_fork"):  # not on Windows, which has no fork
    os.register_at_fork(after_in_child=_mark_forked)
