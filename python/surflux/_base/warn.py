"""Warnings that name the user's line, however deep inside the package they are found."""

import sys
import warnings
from pathlib import Path

import numpy as np

# And numpy, whose decorators call us.
_INSIDE = tuple(str(Path(file).resolve().parent) for file in (Path(__file__).parent, np.__file__))


def warn(text):
    """A UserWarning at the first frame outside the package."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and str(Path(frame.f_code.co_filename).resolve()).startswith(_INSIDE):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, UserWarning, stacklevel=level)
