"""Commands whose stdout or stderr is closed, full, or takes ASCII alone."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import surflux as sf
from surflux.scenes import shapes

FACES = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2
"""


@pytest.fixture
def shell(ball):
    """surflux in a process of its own, by a line of the shell; its result."""
    if os.name == "nt" or not Path("/dev/full").exists():
        pytest.skip("needs a shell, and /dev/full")
    env = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}

    def call(line, **more):
        line = f'exec "{sys.executable}" -m surflux {line}'
        return subprocess.run(["sh", "-c", line], capture_output=True, timeout=240, env=env | more)

    return call


def test_a_closed_stderr_takes_nothing_and_stops_nothing(shell):
    done = shell("solve ball.ply -o lit.ply --no-image 0<&- 2>&-")
    assert (done.returncode, done.stderr) == (0, b"")
    assert len(sf.load_solution("lit.ply").surfels) == 162


def test_stdout_has_nothing_of_a_closed_stderr(shell):
    Path("faces.ply").write_text(FACES)
    assert b"has 1 face" in shell("area faces.ply --json").stderr
    done = shell("area faces.ply --json 2>&-")
    assert (done.returncode, json.loads(done.stdout)["surfels"]) == (0, 4)
    done = shell("area none.ply 2>&-")
    assert (done.returncode, done.stdout) == (2, b"")


def test_a_closed_stdout_is_no_failure(shell):
    done = shell("area ball.ply -q >&-")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_a_full_stderr_stops_nothing(shell):
    done = shell("area ball.ply 2>/dev/full")
    assert (done.returncode, b"162 surfels" in done.stdout) == (0, True)


def test_a_full_stdout_is_told_once(shell):
    done = shell("area ball.ply -q >/dev/full")
    assert (done.returncode, done.stderr.count(b"\n"), b"No space left" in done.stderr) == (2, 1, True)


def test_names_that_stdout_cannot_encode_are_escaped(shell):
    done = shell("area ball.ply -q -o '\u70b9.ply'", PYTHONIOENCODING="latin-1")
    assert (done.returncode, b"\\u70b9.ply" in done.stdout) == (0, True)


@pytest.mark.parametrize("stderr", [None, type("Stream", (), {"write": len})()], ids=["none", "no isatty"])
def test_progress_without_a_stderr(monkeypatch, stderr):
    s = shapes.sphere(162)
    monkeypatch.setattr(sys, "stderr", stderr)
    assert sf.effective_areas(s, progress=True).shape == (162,)


def test_a_closed_stdout_takes_names_that_are_no_text(shell):
    name = os.fsdecode(b"a\xff.ply")
    done = shell(f"area ball.ply -q -o {name} >&-")
    assert (done.returncode, done.stderr) == (0, b"")
    assert Path(name).exists()
