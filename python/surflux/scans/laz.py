"""What laspy takes LAZ apart by: all threads, but in a forked process, which has none of the pool that they are in."""

from surflux._base.forks import is_forked


def backends():
    """The backends of laspy that work in this process, the fastest first; none where no package of them is there."""
    import laspy

    parallel = laspy.LazBackend.LazrsParallel
    return tuple(one for one in laspy.LazBackend.detect_available() if not (is_forked() and one is parallel))
