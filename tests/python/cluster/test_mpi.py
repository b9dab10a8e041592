"""Processes of mpirun that share a pass out have the bits of one alone, and end together where one fails."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from mpi import mpirun, needs_mpi

PROGRAM = Path(__file__).parents[2] / "support" / "mpi_program.py"


@pytest.mark.slow
@needs_mpi
@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_all_processes_have_the_bits_of_one_alone_and_end_together(size, tmp_path):
    done = mpirun(size, PROGRAM, tmp_path / "kept", timeout=400)  # while they wait they keep a core busy
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len(found["bits"]) == 15
    assert [what for what, is_same in found["bits"].items() if not is_same] == []
    if size == 2:
        require_faults(found["faults"])


def require_faults(told):
    assert told.pop("after all that") == ["nothing", "nothing"]
    same = {
        "option": "ValueError: cluster: process 1 of 2 has another option zeta (0.06000000",
        "scene": "ValueError: cluster: process 1 of 2 has another scene's array positions (array of ",
        "seconds": "ValueError: seconds: does not go with cluster or checkpoint",
        "seconds of a scene": "ValueError: seconds: does not go with cluster or checkpoint",
        "elsewhere": "ValueError: cluster: process 1 of 2 has another solver (reference) than process 0 (radiosity)",
        "one call less": "DeviceError: process 1 of 2 is at 'the start', process 0 at 'the end': all must",
        "version": "ValueError: cluster: process 1 of 2 has another version of surflux (0.0.1) than process 0",
    }
    for name, wanted in same.items():
        assert [text[: len(wanted)] for text in told.pop(name)] == [wanted, wanted]
    others = {
        "argument": (1, "ValueError: zeta: wanted values above 0, got -1"),
        "no scene": (1, "ValueError: scene: wanted a Scene, got NoneType"),
        "cancelled": (1, "Cancelled: "),
        "damaged": (0, "FileError: "),
        "memory": (1, "MemoryError: there is no room"),
    }
    for name, (rank, wanted) in others.items():
        texts = told.pop(name)
        assert texts[rank].startswith(wanted)
        assert texts[1 - rank] == f"DeviceError: process {rank} of 2 has failed: {texts[rank]}"
    assert told == {}


@pytest.mark.parametrize("cluster", [4, "tcp://127.0.0.1:8786", object()])
def test_what_is_no_cluster_is_refused(cluster):
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    with pytest.raises(ValueError, match="cluster: wanted a communicator of mpi4py or a client of dask"):
        sf.solve(sf.Scene([floor]), cluster=cluster)


SCENE = """
[[object]]
shape = "room"
size = 3.0
patches = 6
reflectance = 0.6

[[light]]
type = "point"
position = [1.0, 1.2, 2.5]
intensity = 20.0
"""


def solve_command(folder, *options, size=2):
    command = ["-m", "surflux", "solve", folder / "room.toml", "--transport", "rays", "--no-image", *options]
    return mpirun(size, *command, cwd=folder)


@pytest.mark.slow
@needs_mpi
def test_the_command_solves_in_all_processes_and_the_first_writes(tmp_path):
    (tmp_path / "room.toml").write_text(SCENE)
    done = solve_command(tmp_path, "--mpi", "-o", "two.ply", "--checkpoint", "kept", "--json", size=3)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["output"] == "two.ply"
    alone = sf.solve(sf.load_scene(tmp_path / "room.toml"), transport="rays")
    assert np.array_equal(sf.load_solution(tmp_path / "two.ply").irradiance, alone.irradiance.astype(np.float32))
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["kept", "room.toml", "two.ply"]


@pytest.mark.slow
@needs_mpi
def test_the_command_solves_meshless_in_all_processes(tmp_path):
    (tmp_path / "room.toml").write_text(SCENE)
    command = ["-m", "surflux", "solve", tmp_path / "room.toml", "--solver", "meshless", "--no-image", "--mpi"]
    done = mpirun(2, *command, "-o", tmp_path / "two.ply")
    assert done.returncode == 0, done.stderr
    alone = sf.solve_meshless(sf.load_scene(tmp_path / "room.toml"))
    assert np.array_equal(sf.load_solution(tmp_path / "two.ply").irradiance, alone.irradiance.astype(np.float32))


@pytest.mark.slow
@needs_mpi
@pytest.mark.parametrize(
    ("options", "status", "wanted"),
    [
        (["--rays", "3"], 2, "surflux: error: --rays: wanted a whole number from 16 to 65535, got 3"),
        (["--seconds", "3"], 2, "surflux: error: --seconds: does not go with --mpi"),
        (["-o", "/dev/full/out.ply"], 2, "surflux: error: /dev/full/out.ply: cannot be written"),
    ],
)
def test_the_command_says_once_what_is_wrong_and_ends_in_all_processes(tmp_path, options, status, wanted):
    (tmp_path / "room.toml").write_text(SCENE)
    done = solve_command(tmp_path, "--mpi", *options)
    assert done.returncode == status
    assert [line[: len(wanted)] for line in done.stderr.splitlines() if "error:" in line] == [wanted]


@pytest.mark.slow
@needs_mpi
def test_the_command_ends_where_another_process_cannot_read(tmp_path):
    """As on a machine that lacks a file: the second process stands in another folder."""
    (tmp_path / "room.toml").write_text(SCENE)
    (tmp_path / "elsewhere").mkdir()
    command = [sys.executable, "-m", "surflux", "solve", "room.toml", "--no-image", "--mpi"]
    done = mpirun(1, *command[1:], ":", "-n", "1", "-wdir", tmp_path / "elsewhere", *command, cwd=tmp_path)
    assert done.returncode == 1
    (said,) = [line for line in done.stderr.splitlines() if "error:" in line]
    assert said.startswith("surflux: error: process 1 of 2 has failed: FileError: room.toml: ")


UNFORESEEN = """
import sys
from surflux.cli import commands

def solve(options):
    raise ZeroDivisionError("nobody foresaw it")

if "1" not in sys.argv[1:2]:
    commands.RUNS["solve"] = solve
sys.exit(commands.main(["solve", "room.toml", "--no-image", "--mpi"]))
"""


@pytest.mark.slow
@needs_mpi
@pytest.mark.parametrize("sound", [0, 1])
def test_a_fault_that_nobody_foresaw_ends_all_processes(tmp_path, sound):
    """In the other process, too, which speaks of nothing else."""
    (tmp_path / "room.toml").write_text(SCENE)
    (tmp_path / "program.py").write_text(UNFORESEEN)
    each = [("program.py", "1" if rank == sound else "0") for rank in (0, 1)]
    done = mpirun(1, *each[0], ":", "-n", "1", sys.executable, *each[1], cwd=tmp_path, timeout=60.0)
    assert done.returncode != 0
    assert "nobody foresaw it" in done.stderr
