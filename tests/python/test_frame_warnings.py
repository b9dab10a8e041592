"""Warnings of a film: each once, with the frames that it is of."""

import warnings

import pytest

from surflux._base.warn import FrameWarnings, warn


def said_of(count, frames):
    """What is said of a film whose frames, by their numbers from 0 on, warn of those texts."""
    said = FrameWarnings(count)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        for k, text in frames:
            with said.of(k):
                warn(text)
        before = len(found)
        said.say()
        said.say()  # of nothing more
    return before, [str(w.message) for w in found]


@pytest.mark.parametrize(
    ("frames", "wanted"),
    [
        ([(4, "dark")], ["frame 5: dark"]),
        ([(0, "10% of 3"), (1, "9% of 3"), (2, "9.5% of 3"), (6, "9% of 3")], ["frames 1 to 3, 7: 9% to 10% of 3"]),
        ([(0, "10% of 3"), (1, "10% of 4")], ["frame 1: 10% of 3", "frame 2: 10% of 4"]),
        ([(3, "7%"), (3, "7%"), (1, "7%")], ["frames 2, 4: 7%"]),
    ],
)
def test_what_differs_in_percentages_alone_is_said_once(frames, wanted):
    assert said_of(12, frames) == (0, wanted)


def test_of_one_frame_all_is_said_as_it_is():
    assert said_of(1, [(0, "10% of 3"), (0, "9% of 3")]) == (2, ["10% of 3", "9% of 3"])
