"""Checks of arguments; every refusal is a ValueError that names the argument, what it got and what was wanted."""

from __future__ import annotations

import numpy as np


def finite_array(name, value, shape):
    """`value` as a float64 array of `shape` (None: any length) with finite values."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: wanted an array of numbers") from None
    if array.ndim != len(shape) or any(
        want is not None and got != want for got, want in zip(array.shape, shape, strict=True)
    ):
        wanted = ", ".join("n" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "")
        raise ValueError(f"{name}: wanted shape ({wanted}), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: wanted finite numbers")
    return array


def vector3(name, value):
    return finite_array(name, value, (3,)).copy()


def number(name, value, low, high):
    """`value` as a float, finite and within [low, high]."""
    try:
        x = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: wanted a number") from None
    if not np.isfinite(x) or not low <= x <= high:
        raise ValueError(f"{name}: wanted a number from {low:g} to {high:g}, got {value}")
    return x
