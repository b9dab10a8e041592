"""What laspy takes LAZ apart by: all threads, but in a forked process, which has none of the pool that they are in."""

import os

_forked = False


def backends():
    """The backends of laspy that work in this process, the fastest first; none where no package of them is there."""
    import laspy

    parallel = laspy.LazBackend.LazrsParallel
    return tuple(one for one in laspy.LazBackend.detect_available() if not (_forked and one is parallel))


def _mark_forked():
    global _forked
    _forked = True


if hasattr(os, "register_at_fork"):  # not on Windows, which has no fork
    os.register_at_fork(after_in_child=_mark_forked)
