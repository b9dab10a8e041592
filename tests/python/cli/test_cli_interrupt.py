"""Ctrl-C: the command ends within a second, says so with status 130, and leaves no half-written file."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import surflux as sf

# Runs the command `info`, in place of which it does what is in `work`.
PROGRAM = """
import os, sys, time
from surflux.cli import commands

def work(options):
    {work}

commands.RUNS["info"] = work
sys.argv = ["surflux", "info"]
sys.exit(commands.main())
"""
STUBBORN = """
    from surflux._base.files import unfinished
    open(f"tile-{os.getpid()}.part1.laz", "w").close()
    for path in ("scan.ply.part0", "whole.ply"):
        globals()[path] = open(path, "w")
    kept = open("mine.ply.part1")
    with unfinished("out.las") as beside:
        beside.write_text("begun")  # and closed, as libraries do that open it again
        print("ready", flush=True)
        while True:
            try:
                time.sleep(60)
            except KeyboardInterrupt:
                pass
"""


def start(*command):
    """A process to which Ctrl-C gets through even where whoever runs the tests has it ignored."""
    return subprocess.Popen(
        [sys.executable, *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def pressed(process):
    """(seconds until the process has ended after Ctrl-C, what it said)."""
    begun = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    return time.monotonic() - begun, err


def test_what_cannot_be_asked_is_ended_and_what_it_was_writing_is_removed(here):
    Path("mine.ply.part1").write_text("somebody's")
    process = start("-c", PROGRAM.format(work=STUBBORN.strip()))
    assert process.stdout.readline() == "ready\n"
    _, err = pressed(process)
    assert process.returncode == 130
    assert err == "surflux: error: interrupted\n"
    # Only what this process had not written to its end: names alone say nothing, and whole.ply is no such name.
    assert sorted(os.listdir()) == ["mine.ply.part1", "room.toml", f"tile-{process.pid}.part1.laz", "whole.ply"]


def test_threads_that_go_on_are_not_waited_for(here):
    work = """
    import threading
    threading.Thread(target=time.sleep, args=(50,)).start()
    print("ready", flush=True)
    time.sleep(50)
    """
    process = start("-c", PROGRAM.format(work=work.strip()))
    assert process.stdout.readline() == "ready\n"
    seconds, err = pressed(process)
    assert (process.returncode, err) == (130, "surflux: error: interrupted\n")
    assert seconds < 20  # of 50


def test_a_second_ctrl_c_changes_nothing(here):
    process = start("-c", PROGRAM.format(work=STUBBORN.strip().replace("mine.ply.part1", "room.toml")))
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGINT)
    time.sleep(0.1)
    _, err = pressed(process)
    assert (process.returncode, err) == (130, "surflux: error: interrupted\n")


def test_commands_of_a_program_that_goes_on_leave_its_signals_alone(ball, run):
    before = signal.getsignal(signal.SIGINT), signal.set_wakeup_fd(-1)
    threads = threading.active_count()
    assert run("area", "ball.ply")[0] == 0
    assert (signal.getsignal(signal.SIGINT), signal.set_wakeup_fd(-1)) == before
    assert threading.active_count() == threads


def stopped_at(stage, *arguments):
    """(seconds, status, what was said, what is there then) of a command on which Ctrl-C is pressed in a stage."""
    there = set(os.listdir())
    process = start("-m", "surflux", *map(str, arguments))
    said = ""
    while stage not in said:
        line = process.stderr.readline()
        assert line, f"ended before {stage}: {said}"
        said += line
    seconds, err = pressed(process)
    return seconds, process.returncode, said + err, set(os.listdir()) - there


@pytest.mark.slow
def test_stages_of_a_cloud_end_at_once(here):
    sf.Surfels.sample_mesh(([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], [[0, 1, 2, 3]]), 20_000).save("flat.ply")
    for stage in ("areas", "hierarchy", "self-check"):
        _, status, said, left = stopped_at(f"surflux: {stage}", "solve", "flat.ply", "--no-insert")
        assert (status, left) == (130, set()), said
        assert said.endswith("surflux: error: interrupted\n")
        assert "Traceback" not in said


STAGES = ("reading", "normals", "radii", "areas", "trace", "hierarchy", "direct", "gathering", "solve", "insertion")
STAGES += ("refinement", "interpolation", "self-check", "picture")


@pytest.mark.slow
@pytest.mark.scans
@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_of_a_scan_ends_at_once(scans, here, stage):
    """Seconds are printed, not asserted: after half a second the process is ended by itself."""
    tile = scans / "scans" / "autzen_trim.laz"
    seconds, status, said, left = stopped_at(f"surflux: {stage}", "solve", tile, "--points", "20k", "--insert")
    assert status == 130, said
    assert left <= {"autzen_trim_solved.ply"}  # which is whole before the picture is begun
    assert not left or stage == "picture"
    print(f"{stage}: {seconds:.2f} s")


def test_ctrl_c_while_libraries_are_loaded_is_told_as_always(here):
    (here / "late").mkdir()
    (here / "late" / "numpy.py").write_text("import signal\nsignal.raise_signal(signal.SIGINT)\n")
    # surflux itself loads numpy: what it loads of it is there, the command line asks anew.
    program = "import sys, surflux, surflux.__main__; sys.path.insert(0, 'late'); "
    program += "[sys.modules.pop(name) for name in [*sys.modules] if name.partition('.')[0] == 'numpy']; "
    process = start("-c", program + "sys.exit(surflux.__main__.main())")
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "surflux: error: interrupted\n")
