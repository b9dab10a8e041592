"""Workers of Dask that share a pass out have the bits of one alone, also where some are lost."""

import importlib.util
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import surflux as sf
from scenes import cube_inside, same_bits

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs pip install surflux[dask]"),
]
KNOBS = {"zeta": 0.1, "rays": 32, "probes": 4, "transport": "rays", "seed": 3}


def scene():
    sky = sf.Environment(np.random.default_rng(0).uniform(size=(8, 16, 3)))
    return sf.Scene([cube_inside(5, [0.7, 0.5, 0.3], 0.0)], [sf.PointLight([0.2, 0.3, 0.8], 1.0), sky])


@pytest.fixture(scope="module")
def alone():
    return sf.solve(scene(), **KNOBS)


class Workers:
    """Three workers on this machine and their client."""

    def __enter__(self):
        from distributed import Client, LocalCluster

        self._cluster = LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None)
        self.client = Client(self._cluster)
        return self

    def __exit__(self, *_):
        self.client.close()
        self._cluster.close()

    def whole(self, seconds):
        """Whether all workers are there, or come back within some seconds."""
        try:
            self.client.wait_for_workers(3, timeout=seconds)
        except TimeoutError:
            return False
        return True


@pytest.fixture(scope="module")
def started():
    with Workers() as workers:
        yield workers


@pytest.fixture
def workers(started):
    """The client, with all of its workers: new ones where a test killed one as it started, which Dask gives up."""
    if not started.whole(20):
        started.__exit__()
        started.__enter__()
        assert started.whole(60)
    return started.client


def test_solve_meshless_and_transfer_have_the_bits_of_one_process(workers):
    knobs = {"levels": 3, "rays": 32, "seed": 3}
    found = [sf.solve_meshless(scene(), **knobs, cluster=engine) for engine in (None, workers)]
    assert same_bits(*found)
    at, up = [[0.3, 0.4, 0.0]], [[0.0, 0.0, 1.0]]
    assert np.array_equal(*(solution.irradiance_at(at, up) for solution in found))
    lamp = sf.PointLight([0.5, 0.4, 0.6], 1.0)
    local = [sf.precompute_transfer(scene(), **knobs, cluster=engine) for engine in (None, workers)]
    assert np.array_equal(*(transfer.indirect(lamp) for transfer in local))


def running(client):
    """How many processes of jobs there are in all workers."""
    return sum(client.run(lambda: len(sys.modules["surflux.cluster.dask_member"]._MEMBERS), on_error="ignore").values())


class Killing:
    """In place of a job's log: kills workers of processes, as the machine would, after some exchanges."""

    def __init__(self, monkeypatch, client, when):
        from surflux.cluster import dask_job

        self.kills = 0
        killing, begin, write = self, dask_job.Job._begin, dask_job.MemoryLog.write
        job = []

        def begun(job_, *arguments):
            job[:] = [job_]
            return begin(job_, *arguments)

        def written(log, k, name, parts):
            write(log, k, name, parts)
            for rank in when.get(k, ()):
                pid = client.run(os.getpid, workers=[job[0]._place[rank]])
                os.kill(next(iter(pid.values())), signal.SIGKILL)
                killing.kills += 1

        monkeypatch.setattr(dask_job.Job, "_begin", begun)
        monkeypatch.setattr(dask_job.MemoryLog, "write", written)


def test_workers_have_the_bits_of_one_alone(workers, alone, tmp_path):
    assert same_bits(sf.solve(scene(), **KNOBS, cluster=workers), alone)
    for _ in range(2):
        assert same_bits(sf.solve(scene(), **KNOBS, cluster=workers, checkpoint=tmp_path / "kept"), alone)
    wanted = sf.form_factor_operator(scene(), rays=64)
    assert np.array_equal(sf.form_factor_operator(scene(), rays=64, cluster=workers).escape, wanted.escape)
    at = [[0.5, 0.5, 0.0]], [[0, 0, 1]], 64
    assert np.array_equal(sf.reference_irradiance(scene(), *at), sf.reference_irradiance(scene(), *at, cluster=workers))
    assert running(workers) == 0


@pytest.mark.parametrize("when", [{0: [0]}, {1: [1]}, {5: [2], 7: [0]}, {6: [0, 1]}, {4: [0, 1, 2]}])
def test_lost_workers_are_replaced_and_the_bits_stay(workers, alone, monkeypatch, when):
    killing = Killing(monkeypatch, workers, when)
    assert same_bits(sf.solve(scene(), **KNOBS, cluster=workers), alone)
    assert killing.kills == sum(map(len, when.values()))


def test_a_process_that_is_lost_again_and_again_ends_the_solve(workers, monkeypatch):
    from surflux.cluster import dask_job

    begin = dask_job.Job._begin

    def killed(job, rank, size, address, scene=None):
        begin(job, rank, size, address, scene)
        if rank == 1 and job._log.count == 0:
            for pid in workers.run(os.getpid, workers=[address], on_error="ignore").values():
                os.kill(pid, signal.SIGKILL)

    monkeypatch.setattr(dask_job.Job, "_begin", killed)
    with pytest.raises(sf.DeviceError, match=r"cluster: process \d was lost 3 times at exchange \d+, the last time in"):
        sf.solve(scene(), **KNOBS, cluster=workers)


def test_all_workers_gone_is_told_soon(monkeypatch):
    from distributed import Client, LocalCluster

    options = {"threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(n_workers=1, **options) as cluster, Client(cluster) as client:
        begun = []

        def gone(done, total):
            if not begun:
                cluster.scale(0)
                begun.append(time.monotonic())
            return True

        with pytest.raises(sf.DeviceError, match=r"cluster: tcp://.* has had no worker for 20 s"):
            sf.solve(scene(), **{**KNOBS, "rays": 4096}, cluster=client, progress=gone)
        assert time.monotonic() - begun[0] < 30.0


def test_a_worker_of_another_version_is_refused_by_its_address(workers):
    address = sorted(workers.nthreads())[1]

    def patched(version):
        from surflux.cluster import dask_member

        facts = {"version of surflux": version} if version else {}
        told = dask_member.machine_facts
        dask_member.machine_facts = (lambda: {**told(), **facts}) if version else told.__globals__["machine_facts"]

    workers.run(patched, "0.0.1", workers=[address])
    with pytest.raises(ValueError, match=rf"worker {address} has another version of surflux \(0\.0\.1\) than this"):
        sf.solve(scene(), **KNOBS, cluster=workers)
    for pid in workers.run(os.getpid, workers=[address]).values():
        os.kill(pid, signal.SIGKILL)
    time.sleep(1.0)


def test_an_end_from_outside_frees_the_workers(workers):
    for fault in (KeyboardInterrupt, ZeroDivisionError):

        def stopped(done, total, fault=fault):
            raise fault

        with pytest.raises(fault):
            sf.solve(scene(), **{**KNOBS, "rays": 4096}, cluster=workers, progress=stopped)
        assert running(workers) == 0
    with pytest.raises(sf.Cancelled):
        sf.solve(scene(), **{**KNOBS, "rays": 4096}, cluster=workers, progress=lambda done, total: False)


def test_what_fails_in_a_worker_is_raised_here(workers):
    with pytest.raises(ValueError, match="seconds: does not go with cluster"):
        sf.solve(scene(), seconds=1.0, cluster=workers)
    with pytest.raises(ValueError, match="rays: wanted a whole number"):
        sf.solve(scene(), rays=1, cluster=workers)


def test_the_command_solves_in_a_cluster(workers, tmp_path):
    text = '[[object]]\nshape = "room"\nsize = 3.0\npatches = 6\n[[light]]\ntype = "point"\n'
    (tmp_path / "room.toml").write_text(text + "position = [1.0, 1.2, 2.5]\nintensity = 20.0\n")
    command = [sys.executable, "-m", "surflux", "solve", "room.toml", "--no-image", "--transport", "rays"]

    def run(*more):
        return subprocess.run([*command, *more], cwd=tmp_path, capture_output=True, text=True, check=False)

    done = run("-o", "found.ply", "--cluster", workers.scheduler.address)
    assert done.returncode == 0, done.stderr
    wanted = sf.solve(sf.load_scene(tmp_path / "room.toml"), transport="rays").irradiance.astype(np.float32)
    assert np.array_equal(sf.load_solution(tmp_path / "found.ply").irradiance, wanted)
    for address, said in (
        ("nonsense", "--cluster: wanted the address"),
        ("tcp://127.0.0.1:9", "--cluster: wanted the"),
    ):
        done = run("--cluster", address)
        assert (done.returncode, said in done.stderr) == (2, True), done.stderr
