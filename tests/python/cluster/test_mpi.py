"""Processes of mpirun that share a pass out have the bits of one alone, and end together where one fails."""

import json
from pathlib import Path

import pytest

import surflux as sf
from mpi import mpirun, needs_mpi

PROGRAM = Path(__file__).parents[2] / "support" / "mpi_program.py"


@pytest.mark.slow
@needs_mpi
@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_all_processes_have_the_bits_of_one_alone_and_end_together(size, tmp_path):
    done = mpirun(size, PROGRAM, tmp_path / "kept")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert len(found["bits"]) == 10
    assert [what for what, is_same in found["bits"].items() if not is_same] == []
    if size == 2:
        require_faults(found["faults"])


def require_faults(told):
    assert told.pop("after all that") == ["nothing", "nothing"]
    same = {
        "option": "ValueError: cluster: process 1 of 2 has another option zeta (0.06000000",
        "scene": "ValueError: cluster: process 1 of 2 has another scene (",
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
    }
    for name, (rank, wanted) in others.items():
        texts = told.pop(name)
        assert texts[rank].startswith(wanted)
        assert texts[1 - rank] == f"DeviceError: process {rank} of 2 has failed: {texts[rank]}"
    assert told == {}


@pytest.mark.parametrize("cluster", [4, "tcp://127.0.0.1:8786", object()])
def test_what_is_no_cluster_is_refused(cluster):
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    with pytest.raises(ValueError, match="cluster: wanted a communicator of mpi4py"):
        sf.solve(sf.Scene([floor]), cluster=cluster)
