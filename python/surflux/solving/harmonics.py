"""Spherical harmonics: functions of directions as a few numbers, which are turned, multiplied and convolved as such."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.types import Floats


def _coefficients(name, value):
    """(coefficients (n, channels), the shape they came in), if n is a square."""
    array = check.numeric(name, value)
    if array.ndim not in (1, 2):
        raise ValueError(f"{name}: wanted shape (n,) or (n, channels), got {array.shape}")
    array = check.finite_array(name, array, (None,) * array.ndim)
    most = _core.largest_harmonic_order
    if round(len(array) ** 0.5) ** 2 != len(array) or len(array) > most**2:
        raise ValueError(f"{name}: wanted 1, 4, 9, 16, 25, ... coefficients, at most {most**2}, got {len(array)}")
    return array.reshape(len(array), -1), array.shape


def spherical_harmonics(directions: ArrayLike, order: int = 5) -> Floats:
    """Real spherical harmonics in given directions, orthonormal over the sphere.

    Y_lm of band l < order and -l <= m <= l stands in column l (l + 1) + m: order 5 makes 25. A function with the
    coefficients c has the values spherical_harmonics(directions, order) @ c, and c is its integral times each harmonic.
    Signs are those of graphics (Ramamoorthi and Hanrahan 2001), without the Condon-Shortley phase: band 0 is
    1 / sqrt(4 pi), band 1 is sqrt(3 / (4 pi)) (y, z, x). With scipy, Y_lm is, times (-1)^m sqrt(2), the real part of
    sph_harm_y(l, m, theta, phi) for m > 0, and the imaginary part of that of -m for m < 0.

    Args:
        directions: (n, 3), of any length but 0.
        order: number of bands, 1 to 32. Their recurrences are stable: errors stay at some 1e-14.

    Returns:
        (n, order**2).

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> sf.spherical_harmonics([[0, 0, 2]], order=2).round(4).tolist()
    [[0.2821, 0.0, 0.4886, 0.0]]
    """
    directions = check.unit_vectors("directions", check.finite_array("directions", directions, (None, 3)))
    order = check.count("order", order, 1, _core.largest_harmonic_order)
    return np.asarray(_core.spherical_harmonics(directions, order))


def rotate_harmonics(coefficients: ArrayLike, rotation: ArrayLike) -> Floats:
    """Turns a function given by its spherical harmonics: what it was in direction d, the result is in rotation @ d.

    By the recurrence of Ivanic and Ruedenberg (1996, corrected 1998), exact to rounding. Bands do not mix, so that
    nothing is lost: a light turns by its 25 numbers.

    Args:
        coefficients: (n,) or (n, channels), n = order**2.
        rotation: (3, 3). Within 1e-5 of a rotation, which the nearest one is taken for; a matrix that stretches or
            mirrors is refused.

    Returns:
        Coefficients of the same shape.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> along_x = [0, 0, 0, 1.0]  # the harmonic of x
    >>> sf.rotate_harmonics(along_x, [[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(9).tolist()  # x to y, by a quarter turn
    [0.0, 1.0, 0.0, 0.0]
    """
    array, shape = _coefficients("coefficients", coefficients)
    rotation = check.finite_array("rotation", rotation, (3, 3))
    return np.asarray(_core.rotate_harmonics(array, rotation)).reshape(shape)


def multiply_harmonics(a: ArrayLike, b: ArrayLike, order: int | None = None) -> Floats:
    """The product of two functions given by their spherical harmonics, as the harmonics of the product.

    A product has as many bands as both together, less one; those up to `order` are exact, by a quadrature that
    integrates such polynomials exactly.

    Args:
        a, b: (n,) or (n, channels) each, of orders of their own; where one has a single channel, or none, it is taken
            for all of the other's.
        order: bands of the product that are wanted, 1 to 32; None for as many as the longer of a and b has.

    Returns:
        (order**2,), or (order**2, channels) where a or b has channels.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> z = [0, 0, 2.0, 0]  # 2 Y_10
    >>> sf.multiply_harmonics(z, z, order=3).round(4)[[0, 6]].tolist()  # z^2 is a constant and Y_20
    [1.1284, 1.0093]
    """
    (left, shape_a), (right, shape_b) = _coefficients("a", a), _coefficients("b", b)
    if left.shape[1] != right.shape[1] and 1 not in (left.shape[1], right.shape[1]):
        raise ValueError(f"b: wanted {left.shape[1]} channels, as a has, or one, got {right.shape[1]}")
    if order is None:
        order = round(max(len(left), len(right)) ** 0.5)
    order = check.count("order", order, 1, _core.largest_harmonic_order)
    channels = max(left.shape[1], right.shape[1])
    rows = [np.broadcast_to(array, (len(array), channels)).T for array in (left, right)]
    product = np.ascontiguousarray(np.asarray(_core.multiply_harmonics(*rows, order)).T)
    return product[:, 0] if len(shape_a) == len(shape_b) == 1 else product


def convolve_harmonics(coefficients: ArrayLike, exponent: float = 1.0) -> Floats:
    """What a lobe max(cos, 0)**exponent around each direction gathers of a function given by its spherical harmonics.

    Each band is multiplied by a number with a closed form. Exponent 1 makes irradiance by normal of radiance, with
    pi, 2 pi/3, pi/4, 0, -pi/24, ... for the bands (Ramamoorthi and Hanrahan 2001, eq. 19). Others are Phong lobes
    around the mirrored direction (Kautz, Sloan and Snyder 2002, L07 sec. 6.4); times (exponent + 1) / (2 pi) they are
    means over the lobe.

    Args:
        coefficients: (n,) or (n, channels), n = order**2.
        exponent: at least 0, whole or not; 0 is the integral over the hemisphere.

    Returns:
        Coefficients of the same shape.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> sky = sf.Environment([[[1.0, 1, 1]], [[0, 0, 0]]])  # white above, black below
    >>> irradiance = sf.convolve_harmonics(sky.harmonics(order=5))
    >>> (sf.spherical_harmonics([[0, 0, 1], [1, 0, 0]]) @ irradiance).round(3)[:, 0].tolist()  # pi and pi/2, in 5 bands
    [3.142, 1.571]
    """
    array, shape = _coefficients("coefficients", coefficients)
    exponent = check.number("exponent", exponent, 0.0)
    return np.asarray(_core.convolve_harmonics(array, exponent)).reshape(shape)
