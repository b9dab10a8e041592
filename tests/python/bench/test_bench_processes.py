"""`surflux bench --cluster`: what each process takes is measured in it, and Amdahl's law read off it."""

import importlib.util

import pytest

import surflux as sf
from scenes import cube_inside
from surflux.bench import processes


@pytest.mark.parametrize(("replicated", "size"), [(0.0, 4), (0.4, 2), (1.0, 3)])
def test_the_share_that_is_replicated_is_what_amdahl_has(replicated, size):
    gain = 1.0 / (replicated + (1.0 - replicated) / size)
    assert processes._replicated(gain, size) == pytest.approx(replicated)
    assert processes._replicated(1.0, 1) is None


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs pip install surflux[dask]")
def test_processes_are_measured_and_have_the_same_bits():
    scene = sf.Scene([cube_inside(10, 0.6, 0.0)], [sf.PointLight([0.2, 0.3, 0.8], 1.0)])
    rows = processes.of_solve(scene, (1, 2), transport="rays", zeta=0.05)
    assert [row.processes for row in rows] == [1, 2]
    assert all(row.passes for row in rows)
    assert (rows[0].clock, rows[0].by_threads) > (0.0, 0.0)
    assert rows[0].exchanges == rows[1].exchanges > 5
    assert rows[1].megabytes == pytest.approx(rows[0].megabytes, rel=0.05)  # and heads, checksums
    assert 0.0 < rows[1].seconds < rows[0].seconds  # of which each takes a part
    traced = processes.of_reference(scene, (1, 2), 5, 512)
    assert all(row.passes for row in traced)
    assert [row.exchanges for row in traced] == [None, None]
    assert f"| {len(scene.surfels)} | 2 |" in processes.table(rows)


def row(what, processes_, replicated, megabytes=None):
    return processes.Row(what, processes_, 100, 1.0, 2.0, 0.5, replicated, None, megabytes, 0.1, True)


def test_more_machines_are_reckoned_by_what_the_most_processes_replicated():
    rows = [row("a", 1, None), row("a", 2, 0.4, 60.0), row("a", 4, 0.5, 60.0), row("b", 2, -0.1)]
    *_, a, b = processes.reckoned(rows).splitlines()
    # 1 / (r + (1 - r) / n); 60 MB are 480 Mbit of 10 Gbit a second. Noise does not make more than n of n machines.
    assert a == "| a | 50 % | 1.8 | 2.0 | 2.0 | 0.048 |"
    assert b == "| b | 0 % | 10.0 | 100.0 | 1000.0 |  |"
