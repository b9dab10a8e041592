"""Where positions in 32-bit floats begin."""

import numpy as np

_FAR = 256.0  # times half the size: floats of larger coordinates are off by 1.5e-5 of it


def origin_of(positions, scales):
    """A point (3,) amid the positions, with few digits; 0 where floats hold them as they are, to 1.5e-5 of half their
    size."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    half = max(0.5 * float((high - low).max()), float(scales.max()))
    if half == 0.0 or max(np.abs(low).max(), np.abs(high).max()) <= _FAR * half:
        return np.zeros(3)
    step = 2.0 ** np.floor(np.log2(half))  # positions less such a number are exact in double
    return np.round(0.5 * (low + high) / step) * step


def to_origin(positions, scales):
    """(positions (n, 3) float32 from an origin, the origin (3,))."""
    origin = origin_of(positions, scales)
    return (positions - origin).astype(np.float32), origin
