"""Checks of what the user hands in. Every ValueError names the argument, what came and what was wanted."""

import math
import numbers
import os
from collections.abc import Mapping

import numpy as np

from surflux import _core
from surflux._base.color import WHITE, rgb_of_grey

LARGEST = 1e30  # of lengths: the squares of products of four of them stay in the range of float64


def counted(n, what, several=None):
    """ "1 surfel", "2 surfels": a number with its noun."""
    return f"{n} {what if n == 1 else several or what + 's'}"


def listed(numbers, most):
    """ "3, 5, 8, ...": at most so many of some numbers."""
    return ", ".join(map(str, numbers[:most])) + (", ..." if len(numbers) > most else "")


def path(name, value):
    """value as a str, if it is a path: str, bytes or os.PathLike."""
    if not isinstance(value, (str, bytes, os.PathLike)):
        raise ValueError(f"{name}: wanted a path, got {type(value).__name__}")
    return os.fsdecode(value)


def surfels(name, value):
    """value, if it is Surfels: told by what they are compiled to, for their class stands above."""
    if not isinstance(getattr(value, "_core", None), _core.Surfels):
        raise ValueError(f"{name}: wanted Surfels, got {type(value).__name__}")
    return value


def some_surfels(name, value):
    """value, if it is Surfels and not empty."""
    if not len(surfels(name, value)):
        raise ValueError(f"{name}: wanted at least one surfel, got none")
    return value


def _shape_text(shape):
    names = iter("nmk")
    sides = [str(side) if side is not None else next(names) for side in shape]
    return f"({sides[0]},)" if len(sides) == 1 else f"({', '.join(sides)})"


def numeric(name, value, booleans=False):
    """value as an array of real numbers, of whatever shape; text, complex numbers and objects are refused, and booleans
    unless they are asked for."""
    if value is None:
        raise ValueError(f"{name}: wanted numbers, got None")
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise ValueError(f"{name}: wanted numbers throughout, got a masked array; leave masked ones out, or fill them")
    try:
        array = np.asarray(value)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{name}: wanted an array of numbers, got {type(value).__name__} ({error})") from None
    if array.size and array.dtype.kind not in "iuf" and not (booleans and array.dtype == bool):
        if array.dtype.kind == "U":
            text = next(entry for entry in np.asarray(value, object).flat if isinstance(entry, str))
            raise ValueError(f"{name}: wanted real numbers, got text ({str(text)!r}){_number_of_text(text)}")
        kind = {"b": "booleans", "c": "complex numbers", "S": "text"}.get(array.dtype.kind, "objects")
        raise ValueError(f"{name}: wanted real numbers, got {kind} ({array.dtype})")
    return array


def _number_of_text(text):
    """ "; as a number that is 0.02" of "2%": for messages; nothing of what is no number."""
    try:
        number = float(text.rstrip("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        return ""
    return f"; as a number that is {number:.10g}" if np.isfinite(number) else ""


def finite_array(name, value, shape):
    """value as a float64 array of that shape, where None stands for any length but 0; every number is finite."""
    array = numeric(name, value)
    fits = array.ndim == len(shape) and all(
        want is None or got == want for got, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        raise ValueError(f"{name}: wanted shape {_shape_text(shape)}, got {array.shape}")
    if array.size == 0 and 0 not in shape:
        raise ValueError(f"{name}: wanted shape {_shape_text(shape)} with at least one entry, got {array.shape}")
    array = np.ascontiguousarray(array, dtype=np.float64)
    return all_finite(name, array)


def all_finite(name, array):
    """array, if every number of it is finite."""
    bad = ~np.isfinite(array)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        place = "" if not where else f" at index {where[0] if len(where) == 1 else where}"
        raise ValueError(f"{name}: wanted finite numbers, got {array[where]}{place} ({np.count_nonzero(bad)} in all)")
    return array


def in_range(name, array, low=-math.inf, high=math.inf, *, low_open=False, high_open=False):
    """array, if all of its entries lie in the interval; an open end is not part of it."""
    under = array <= low if low_open else array < low
    over = array >= high if high_open else array > high
    bad = under | over
    if np.any(bad):
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        if high == math.inf:
            wanted = f"{'above' if low_open else 'at least'} {low:g}"
        elif low == -math.inf:
            wanted = f"{'below' if high_open else 'at most'} {high:g}"
        else:
            wanted = f"in {'(' if low_open else '['}{low:g}, {high:g}{')' if high_open else ']'}"
        place = "" if not where else f" at index {where[0] if len(where) == 1 else where}"
        got = np.asarray(array)[where]
        hint = ""
        if name == "reflectance" and 2.0 <= got <= 255.0:
            hint = f"; 8-bit values become reflectance by * {WHITE:g} / 255"
        raise ValueError(f"{name}: wanted values {wanted}, got {got:g}{place}{hint}")
    return array


def vector3(name, value):
    """value as a float64 array of shape (3,)."""
    return finite_array(name, value, (3,))


def positions(name, value, shape=(3,)):
    """value as a float64 array of that shape, points or lengths that passes can calculate with."""
    return in_range(name, finite_array(name, value, shape), -LARGEST, LARGEST)


def direction(name, value):
    """value as a unit vector of shape (3,); zero length is refused."""
    return unit_vectors(name, vector3(name, value)[None, :])[0]


def unit_vectors(name, vectors):
    """The rows of vectors (n, 3), normalized; a zero row is refused."""
    largest = np.max(np.abs(vectors), axis=1)
    if not np.all(largest > 0):
        index = int(np.argmin(largest > 0))
        raise ValueError(f"{name}: wanted vectors of non-zero length, got (0, 0, 0) at index {index}")
    # By the largest component first: squares of very large or small ones leave the range of float64.
    scaled = vectors / largest[:, None]
    length = np.linalg.norm(scaled, axis=1)
    already_unit = np.abs(length * largest - 1.0) <= 4e-16
    return np.where(already_unit[:, None], vectors, scaled / length[:, None])


def rgb(name, value, low=0.0, high=math.inf, *, high_open=False):
    """A scalar or an RGB triple as a float64 array of shape (3,), at least 0 unless said otherwise."""
    array = numeric(name, value)
    if array.ndim == 0:
        array = rgb_of_grey(finite_array(name, array.reshape(1), (1,))[0])
    elif array.shape == (3,):
        array = finite_array(name, array, (3,))
    else:
        raise ValueError(f"{name}: wanted a number or RGB, shape () or (3,), got {array.shape}")
    return in_range(name, array, low, high, high_open=high_open)


def sides(name, value):
    """two_sided of a mesh: a bool or "sheets"."""
    if isinstance(value, str) and value == "sheets":
        return value
    try:
        return flag(name, value)
    except ValueError:
        raise ValueError(f'{name}: wanted True, False or "sheets", got {value!r}') from None


def per_surfel_rgb(name, value, n, low=0.0, high=math.inf, *, high_open=False, what="surfel"):
    """(n, 3) from a number, RGB (3,), one number each (n,) or one RGB each (n, 3). With n = 3, (3,) is one RGB."""
    array = numeric(name, value)
    if array.ndim == 0 or array.shape == (3,):
        return np.tile(rgb(name, array, low, high, high_open=high_open), (n, 1))
    if array.shape == (n,):
        array = rgb_of_grey(finite_array(name, array, (n,)))
    elif array.shape == (n, 3):
        array = finite_array(name, array, (n, 3))
    else:
        raise ValueError(f"{name}: wanted shape (), (3,), ({n},) or ({n}, 3) for {counted(n, what)}, got {array.shape}")
    return in_range(name, array, low, high, high_open=high_open)


def per_surfel(name, value, n, low=0.0, *, low_open=False):
    """(n,) from a number or one number each."""
    array = numeric(name, value)
    if array.ndim == 0:
        array = finite_array(name, array.reshape(1), (1,)).repeat(n)
    elif array.shape == (n,):
        array = finite_array(name, array, (n,))
    else:
        raise ValueError(f"{name}: wanted shape () or ({n},) for {counted(n, 'surfel')}, got {array.shape}")
    return in_range(name, in_range(name, array, low, low_open=low_open), high=LARGEST**2)


def per_row(name, value, n):
    """Numbers of n surfels, shape (n,) or (n, k)."""
    array = numeric(name, value)
    if array.ndim not in (1, 2) or len(array) != n:
        raise ValueError(f"{name}: wanted shape ({n},) or ({n}, 3) for {counted(n, 'surfel')}, got {array.shape}")
    return array


def rows(name, value, n, width=None):
    """Numbers or booleans of n rows: (n,) or (n, k), or (n, width); NaN may be among them."""
    array = numeric(name, value, booleans=True)
    fits = array.ndim in (1, 2) if width is None else array.shape[1:] == (width,)
    if not fits or len(array) != n:
        wanted = f"({n},) or ({n}, k)" if width is None else f"({n}, {width})"
        raise ValueError(f"{name}: wanted shape {wanted}, got {array.shape}")
    return array


def arrays_by_name(name, value):
    """value, if it is a dict or another Mapping; what it holds is not looked at."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{name}: wanted a dict of arrays by their names, got {type(value).__name__}")
    return value


def byte_colors(name, value, n):
    """(n, 3) uint8 from whole numbers from 0 to 255: fractions would all be black, and larger ones wrap around."""
    array = rows(name, value, n, 3)
    if array.dtype.kind not in "iu":
        raise ValueError(
            f"{name}: wanted bytes ({n}, 3), whole numbers from 0 to 255, got {array.dtype}; "
            "np.rint(255 * rgb).astype(np.uint8) makes them of sRGB from 0 to 1"
        )
    return in_range(name, array, 0, 255).astype(np.uint8)


def number(name, value, low=-math.inf, high=math.inf, *, low_open=False, high_open=False):
    """value as a float in the interval."""
    array = numeric(name, value)
    if array.ndim != 0:
        raise ValueError(f"{name}: wanted one number, got shape {array.shape}")
    result = float(array)
    if not math.isfinite(result):
        raise ValueError(f"{name}: wanted a finite number, got {result}")
    in_range(name, np.asarray(result), low, high, low_open=low_open, high_open=high_open)
    return result


def length(name, value):
    """value as a float above 0 that passes can calculate with."""
    result = number(name, value, 0.0, low_open=True)
    in_range(name, np.asarray(result), high=LARGEST)
    return result


def count(name, value, low=1, high=2**31 - 1):
    """value as an int in [low, high]; floats are refused, whole ones too."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, numbers.Integral):
        hint = _number_of_text(value) if isinstance(value, str) else ""
        raise ValueError(f"{name}: wanted a whole number, got {value!r}{hint}")
    if not low <= value <= high:
        raise ValueError(f"{name}: wanted a whole number from {low} to {high}, got {value}")
    return int(value)


def seed(name, value):
    """value as an unsigned 64-bit seed."""
    return count(name, value, 0, 2**64 - 1)


def flag(name, value):
    """value as a bool; numbers are refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name}: wanted True or False, got {value!r}")
    return bool(value)


def choice(name, value, choices):
    """value, one of the texts in choices."""
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{name}: wanted one of {', '.join(map(repr, choices))}, got {value!r}")
    return value


def selection(name, value, n):
    """Indices (m,) uint32 of what a mask (n,), indices or a slice choose out of n surfels, which may be none."""
    if isinstance(value, slice):
        indices = np.arange(n)[value]
    else:
        array = np.asarray(value)
        if array.dtype == bool and array.shape == (n,):
            indices = np.flatnonzero(array)
        elif array.dtype.kind in "iu" and array.ndim <= 1:
            indices = np.atleast_1d(array)
            outside = (indices < -n) | (indices >= n)
            if outside.any():
                raise IndexError(f"{name}: index {indices[outside][0]} is out of range for {counted(n, 'surfel')}")
            indices = indices % n
        elif array.shape == (0,) and array.dtype != bool:  # an empty list
            indices = np.zeros(0)
        else:
            raise ValueError(
                f"{name}: wanted a mask ({n},) of booleans, indices (m,) or a slice, got {array.dtype} {array.shape}"
            )
    return indices.astype(np.uint32)
