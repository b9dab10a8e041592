"""The compiled searches let the rest of Python run."""

import sys
import threading
import time

import numpy as np
import pytest

from surflux import _core


def test_sampling_triangles_releases_the_gil():
    triangles = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    gate, ran = threading.Lock(), []
    gate.acquire()
    other = threading.Thread(target=lambda: (gate.acquire(), ran.append(True)))
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)  # the other thread runs only where this one waits or lets it
    try:
        other.start()
        time.sleep(0.1)  # until it waits at the gate
        gate.release()
        before = list(ran)
        _core.sample_triangles(triangles, 2_000_000, 0)
        after = list(ran)
    finally:
        sys.setswitchinterval(interval)
        other.join()
    assert (before, after) == ([], [True])


def test_radii_report_and_can_be_cancelled():
    points = np.random.default_rng(0).random((5000, 3))
    seen = []
    radii = _core.estimate_radii(points, 6, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (5000, 5000)
    assert np.array_equal(radii, _core.estimate_radii(points, 6))
    with pytest.raises(_core.Cancelled):
        _core.estimate_radii(points, 6, progress=lambda done, total: False)
