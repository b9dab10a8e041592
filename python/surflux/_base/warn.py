"""Warnings that name the user's line, however deep inside the package they are found."""

import re
import sys
import warnings
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

import numpy as np

# And numpy, whose decorators call us.
_INSIDE = tuple(str(Path(file).resolve().parent) for file in (Path(__file__).parent, np.__file__))
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?=%)")
# Of a film: what takes the warnings of the frame that is made now.
_frame: ContextVar = ContextVar("frame", default=None)


def warn(text):
    """A UserWarning at the first frame outside the package."""
    if _frame.get() is not None:
        _frame.get()(text)
        return
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and str(Path(frame.f_code.co_filename).resolve()).startswith(_INSIDE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, UserWarning, stacklevel=level)


class FrameWarnings:
    """Warnings of the frames of a film, each once: what differs in percentages alone is one, with the frames named."""

    def __init__(self, count):
        """count: of all frames; those of one are as they are."""
        self._count, self._said = count, {}

    @contextmanager
    def of(self, k):
        """While the block runs, warnings are of frame k, from 0 on."""
        if self._count == 1:
            yield
            return
        before = _frame.set(lambda text: self._said.setdefault(_NUMBER.sub("", text), {}).setdefault(k, text))
        try:
            yield
        finally:
            _frame.reset(before)

    def say(self):
        """Warns of all that was found so far."""
        said, self._said = self._said, {}
        for texts in said.values():
            numbers = sorted(k + 1 for k in texts)
            which = f"frame {numbers[0]}" if len(numbers) == 1 else f"frames {_runs(numbers)}"
            warn(f"{which}: {_spanned(list(texts.values()))}")


def _runs(numbers):
    """ "1 to 3, 7, 9 to 10" of sorted whole numbers."""
    breaks = [k for k in range(1, len(numbers)) if numbers[k] != numbers[k - 1] + 1]
    runs = [numbers[i:j] for i, j in zip([0, *breaks], [*breaks, len(numbers)], strict=True)]
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]} to {r[-1]}" for r in runs)


def _spanned(texts):
    """One of texts that differ in percentages alone, with the span of each."""
    columns = iter(zip(*(_NUMBER.findall(text) for text in texts), strict=True))

    def span(_):
        column = sorted(set(next(columns)), key=float)
        return column[0] if len(column) == 1 else f"{column[0]}% to {column[-1]}"

    return _NUMBER.sub(span, texts[0])
