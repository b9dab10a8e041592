"""Arrays of results, which nobody changes once they are there."""

import numpy as np


def frozen(values, dtype=None):
    """A copy that cannot be written to; the array itself where it is so and its memory is its own, or the core's."""
    is_own = type(values) is np.ndarray and not values.flags.writeable
    is_own = is_own and (values.base is None or type(values.base).__name__ == "PyCapsule")
    if is_own and dtype in (None, values.dtype):
        return values
    values = np.array(values, dtype)
    values.setflags(write=False)
    return values


def given_away(values):
    """An array that its maker keeps no hold of, so that `frozen` takes it without a copy; None stays."""
    if values is not None:
        values.setflags(write=False)
    return values
