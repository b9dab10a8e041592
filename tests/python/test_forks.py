"""Files are read and written in processes that are forked after the same was done before."""

import os
import subprocess
import sys

import pytest

JOB = """
import multiprocessing
import numpy as np
import surflux as sf


def picture(name):
    sf.write_image(name, np.full((64, 64, 3), 0.5))
    return sf.read_image(name).shape[0]


def by_laspy_alone(name):
    if not name.startswith("before"):
        return len(sf.read_scan("before.laz"))
    import laspy

    las = laspy.create()
    las.x = las.y = las.z = np.arange(3000.0)
    las.write("before.laz")
    return len(laspy.read("before.laz").points)


def points(name):
    sf.Scan(np.random.default_rng(0).random((3000, 3))).save(name)
    return len(sf.read_scan(name))


if __name__ == "__main__":
    job, suffix = {job}
    before = job(f"before{{suffix}}")
    with multiprocessing.get_context("fork").Pool(2) as pool:
        after = pool.map_async(job, [f"{{k}}{{suffix}}" for k in range(4)]).get(60)
    assert after == [before] * 4, after
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.parametrize("job", ['picture, ".exr"', 'points, ".laz"', 'by_laspy_alone, ".laz"'])
def test_forked_processes_read_and_write(tmp_path, job):
    if "laz" in job:
        pytest.importorskip("laspy")
        pytest.importorskip("lazrs")
    (tmp_path / "job.py").write_text(JOB.format(job=job))
    done = subprocess.run([sys.executable, "job.py"], cwd=tmp_path, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
