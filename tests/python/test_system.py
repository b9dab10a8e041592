"""What the system may do to a process: full disks, forks, little memory, Ctrl-C, several threads."""

import os
import resource
import signal
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import surflux as sf

SMALL_FILE = 4096  # bytes, all that the disk has room for


def run_apart(code, seconds=120, **options):
    """Runs Python code in a process of its own, which is ended where it hangs; gives its stdout."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, timeout=seconds, **options
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def full_disk():
    """No file grows beyond SMALL_FILE: writes fail as they do on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL_FILE, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, ignored)


def write_small(path, points=1):
    if path.suffix == ".ply":
        sf.Surfels(np.arange(3.0 * points).reshape(-1, 3), [[0, 0, 1]] * points, radii=1.0).save(path)
    else:
        sf.write_image(path, np.random.default_rng(0).uniform(size=(points, 3, 3)))


@pytest.mark.parametrize("name", ["a.png", "a.exr", "a.hdr", "a.ply"])
def test_a_full_disk_is_told_and_keeps_the_old_file(name, tmp_path, full_disk):
    path = tmp_path / name
    write_small(path)
    path.chmod(0o640)
    before = path.read_bytes()
    # Noise of 3 x 2000 pixels does not fit, however packed: 18000 bytes in 8 bits.
    with pytest.raises(sf.FileError, match=rf"a\{path.suffix}: cannot be written"):
        write_small(path, 2000)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == [name]
    write_small(path, 2)
    assert path.stat().st_mode & 0o777 == 0o640


FORK = """
    import os, signal, sys
    import numpy as np
    import surflux as sf

    def solved(solve=sf.solve):
        walls = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 1 / 400)
        lid = sf.Surfels.from_mesh(([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[3, 2, 1, 0]]), 1 / 400)
        return solve(sf.Scene([walls, lid], [sf.PointLight((0.5, 0.5, 0.5), 10)]))

    def pixels(solution):
        return solution.render(sf.Camera((0.5, 0.5, 0.9), (0.5, 0.5, 0), up=(0, 1, 0)), size=(32, 32))

    def in_a_fork(work):
        sys.stdout.flush()
        child = os.fork()
        if child == 0:
            signal.alarm(60)  # the end of a child that hangs
            try:
                print(work())
            except sf.DeviceError as error:
                print(error)
            finally:
                sys.stdout.flush()
                os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
"""


def test_drawing_in_a_process_forked_after_drawing_is_refused():
    said = run_apart(
        FORK
        + """
    solution = solved()
    in_a_fork(lambda: pixels(solution).shape)  # nothing was drawn before: the fork may
    pixels(solution)
    in_a_fork(lambda: pixels(solution).shape)
    print(pixels(solution).shape)
    """
    ).splitlines()
    assert said[0] == said[2] == "(32, 32, 3)"
    assert "after that drew by OpenGL" in said[1]
    assert '"spawn"' in said[1]


def test_solving_in_a_process_forked_after_solving_gives_the_same():
    said = run_apart(
        FORK
        + """
    for solve in sf.solve, sf.solve_meshless:
        before = solved(solve).radiosity
        in_a_fork(lambda: np.array_equal(solved(solve).radiosity, before))
    """
    )
    assert said.split() == ["True", "True"]


def test_two_threads_solve_at_once_each_by_its_own_limit():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 1 / 400)
    lid = sf.Surfels.from_mesh(([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[3, 2, 1, 0]]), 1 / 400)
    scene = sf.Scene([floor, lid], [sf.PointLight((0.5, 0.5, 0.5), 10)])
    alone = sf.solve(scene, transport="rays").radiosity
    limits = (1, 4, None, 2, 3)
    with ThreadPoolExecutor(max_workers=len(limits)) as pool:
        found = list(pool.map(lambda threads: sf.solve(scene, transport="rays", threads=threads), limits))
    for solution in found:
        np.testing.assert_array_equal(solution.radiosity, alone)
