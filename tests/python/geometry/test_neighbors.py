"""The compiled searches let the rest of Python run."""

import threading
import time

import numpy as np
import pytest

from surflux import _core


def test_sampling_triangles_releases_the_gil():
    triangles = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    stop, ticks = threading.Event(), []

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    other = threading.Thread(target=tick)
    other.start()
    try:
        start = time.perf_counter()
        _core.sample_triangles(triangles, 3_000_000, 0)
        took = time.perf_counter() - start
    finally:
        stop.set()
        other.join()
    # With the GIL held, no tick could fall within the call; at its end numpy arrays are made.
    assert sum(start + 0.2 * took < t < start + 0.7 * took for t in ticks) >= 3


def test_radii_report_and_can_be_cancelled():
    points = np.random.default_rng(0).random((5000, 3))
    seen = []
    radii = _core.estimate_radii(points, None, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (5000, 5000)
    assert np.array_equal(radii, _core.estimate_radii(points, None))
    with pytest.raises(_core.Cancelled):
        _core.estimate_radii(points, None, progress=lambda done, total: False)


def test_even_samples_are_those_that_elimination_leaves():
    triangles = np.random.default_rng(3).random((50, 3, 3))
    corners = triangles[:, 1:] - triangles[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 0], corners[:, 1]), axis=1).sum()
    points, triangle = _core.sample_triangles(triangles, 5 * 700, 4)
    kept = _core.eliminate_samples(points, 700, area, 4)
    even, on = _core.sample_evenly(triangles, 700, 5, 4, progress=None)
    assert np.array_equal(even, points[kept])
    assert np.array_equal(on, triangle[kept])
