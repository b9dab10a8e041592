"""Arrays as the bytes of a page: what a browser reads, packed."""

import numpy as np

LARGEST = 32767  # of int16


class Store:
    """Arrays one after another, little-endian, each at a multiple of four bytes."""

    def __init__(self):
        self._parts, self._size = [], 0

    def add(self, array, dtype):
        """[type, first byte, how many] of what was added."""
        flat = np.ascontiguousarray(array).astype(np.dtype(dtype).newbyteorder("<")).ravel()
        part = flat.tobytes()
        part += bytes(-len(part) % 4)
        place = [np.dtype(dtype).name, self._size, len(flat)]
        self._parts.append(part)
        self._size += len(part)
        return place

    def bytes(self):
        return b"".join(self._parts)


def folded(normals):
    """(n, 2) int16: unit vectors on an octahedron, unfolded into a square (Meyer and others 2010)."""
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    turned = (1 - np.abs(flat[:, 1::-1])) * np.where(flat[:, :2] < 0, -1, 1)
    return np.rint(LARGEST * np.where(flat[:, 2:] < 0, turned, flat[:, :2])).astype(np.int16)


def packed_light(rgb):
    """(n,) uint32: nine bits of each channel with a common exponent of five, as OpenGL's RGB9_E5; clipped to it."""
    rgb = np.clip(rgb, 0.0, 65408.0)
    top = rgb.max(axis=1)
    exponent = np.clip(np.floor(np.log2(np.maximum(top, 2.0**-40))), -16, 15) + 1
    exponent += np.rint(top / 2.0 ** (exponent - 9)) >= 512  # rounded up to the next power of two
    mantissa = np.rint(rgb / 2.0 ** (exponent - 9)[:, None]).astype(np.uint32)
    return mantissa[:, 0] | mantissa[:, 1] << 9 | mantissa[:, 2] << 18 | (exponent + 15).astype(np.uint32) << 27


def packed_waves(waves):
    """Waves (w, n, 3) as (int16 (n, w, 3), scales (n,)): of each surfel its largest coefficient is 32767 scales.

    Each is off by half a scale at most, and their sum at any angle by 1 + 4 sqrt(2) halves of nine of them: by .0001 of
    the largest.
    """
    scales = (np.abs(waves).max(axis=(0, 2)) / LARGEST).astype(np.float32)
    whole = np.divide(waves, scales[:, None], out=np.zeros_like(waves), where=scales[:, None] > 0)
    return np.rint(whole).astype(np.int16).transpose(1, 0, 2), scales
