"""Examples of the gallery: each is short, runs as it stands, and ends in a picture."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf

EXAMPLES = sorted((Path(__file__).parents[2] / "python" / "guide" / "examples").glob("*.py"))
FAST = ("effective_areas", "first_solve", "view_factors")
MOST_LINES = 29


def test_there_is_a_gallery():
    assert len(EXAMPLES) >= 12
    assert set(FAST) <= {example.stem for example in EXAMPLES}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_is_short(example):
    lines = example.read_text().splitlines()
    assert lines[0] == '"""'
    assert lines[2] == "=" * len(lines[1])
    assert len(lines) <= MOST_LINES


@pytest.mark.parametrize(
    "example",
    [pytest.param(e, id=e.stem, marks=[pytest.mark.slow] * (e.stem not in FAST)) for e in EXAMPLES],
)
def test_an_example_ends_in_a_picture(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    monkeypatch.setattr("pyvista.OFF_SCREEN", True)
    exec(compile(example.read_text(), example, "exec"), {"__name__": "__main__"})
    (picture,) = tmp_path.glob("*.png")
    assert np.ptp(sf.read_image(picture), axis=(0, 1)).max() > 0.3  # of black to white: something is to be seen
