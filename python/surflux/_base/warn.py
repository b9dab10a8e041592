"""Warnings that name the user's line, however deep inside the package they are found."""

import sys
import warnings
from pathlib import Path

_PACKAGE = str(Path(__file__).resolve().parents[1])


def warn(text):
    """A UserWarning at the first frame outside the package."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and str(Path(frame.f_code.co_filename).resolve()).startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, UserWarning, stacklevel=level)
