"""Parametrizations of which some are quick, and the others for `script/test --all`."""

import pytest


def quick(*values, of):
    """All of `of`, those marked slow that are not among the values."""
    return [v if any(v is q or v == q for q in values) else pytest.param(v, marks=pytest.mark.slow) for v in of]
