"""What the system may do to a process: full disks, forks, little memory, Ctrl-C, several threads."""

import os
import resource
import signal
import subprocess
import sys
import textwrap

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
