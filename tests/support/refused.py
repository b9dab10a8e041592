"""What arguments of the public face cannot be: tables of tests/python/test_refusals*.py draw on these."""

import re

import numpy as np
import pytest

NAN, INF = float("nan"), float("inf")

# What no array of numbers may be, whatever its name.
NEVER = [
    "text",
    None,
    object(),
    {},
    [[[0.0]]],
    [1j, 1j, 1j],
    [True, True, True],
    [[1, 2], [3]],
    [NAN, 0, 0],
    [0, INF, 0],
]
VECTORS = [*NEVER, [], [1, 2], [1, 2, 3, 4], 5]
COLORS = [*NEVER[:1], *NEVER[2:], [], [1, 2], NAN, INF, -1, [-1, 0, 0], True, 1j]
NUMBERS = ["1", [], [1, 2], {}, True, 1j, NAN, INF]
COUNTS = ["2", 2.0, 1.5, True, [], [3], NAN, -1, 1]
NO_ORDERS = [*(v for v in COUNTS if v != 1), 0, 33]
NO_HARMONICS = [*NEVER, [], 1.0, [1, 2], np.zeros(24), np.zeros((0, 3)), np.zeros((4, 3, 1)), np.zeros(33**2)]
RHO = [1.0, 1.5, [0.5, 0.5, 1.0], [0.1, 0.2, 0.3, 1.0]]


def says_its_name(function, argument, value):
    """The call refuses the value by a message that begins with the argument's name, so that nobody has to guess."""
    with pytest.raises(ValueError, match=rf"^{argument}\b.*: (wanted|cannot|must)"):
        function(**{argument: value})


def cases(refused):
    """Parameters of tests: function, argument, value; of (function, argument, values)."""
    for function, argument, values in refused:
        for value in values:
            said = re.sub(r" at 0x[0-9a-f]+", "", repr(value))  # workers have to agree on names
            yield pytest.param(function, argument, value, id=f"{function.__name__}-{argument}-{said}"[:80])
