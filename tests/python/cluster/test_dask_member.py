"""One process of a job, without Dask."""

import time

import pytest

import surflux as sf
from surflux.cluster import dask_member


@pytest.fixture
def member():
    """Process 0 of two, which exchanges once and gives what it is told."""
    made = dask_member.Member(0, 2, 0, lambda team, goes_on: team.exchange("sum", lambda: b"one"))
    yield made
    made.end()


def test_it_gives_its_part_and_is_told_all(member):
    assert member.answer(0, [], 5.0) == ("part", "sum", b"one")
    assert member.answer(1, [(0, "sum", [b"one", b"two"])], 5.0) == ("done", [b"one", b"two"])


def test_without_a_word_of_the_client_it_ends_and_says_so(monkeypatch, member):
    """It told that it was cancelled."""
    assert member.answer(0, [], 5.0)[0] == "part"
    monkeypatch.setattr(dask_member, "FORSAKEN", 0.01)
    time.sleep(3.0 * dask_member._POLL)
    kind, *what = member.answer(1, [], 5.0)
    assert (kind, *what) == ("failed", "DeviceError", "nothing was heard of the client for 0.01 s")


def test_what_another_exchange_gave_is_refused(member):
    member.answer(0, [(0, "product", [b"one", b"two"])], 0.0)
    kind, name, text = member.answer(1, [], 5.0)
    assert (kind, name) == ("failed", sf.DeviceError.__name__)
    assert "process 0 is at 'sum', where the others were at 'product'" in text
