"""Solid textures for scene files: reflectance as a function of position, the same for the same seed."""

import numpy as np

from surflux._base import check

PATTERNS = ("marble", "spots", "checker")


def pattern_colors(pattern, points, colors, size=0.1, seed=0):
    """Reflectance (n, 3) of a pattern at points (n, 3).

    Args:
        pattern: "marble", bands bent by turbulence; "spots", a leopard's rosettes; or "checker", cubes.
        colors: (k, 3), k >= 2, in [0, 1). marble fades from the first to the last; checker takes them in turn; spots
            has the ground first, then the spots, then (where there are three) the middle of the spots.
        size: of a band, a spot or a cube, in the unit of points; above 0.
        seed: chooses another pattern of the same kind.
    """
    check.choice("pattern", pattern, PATTERNS)
    colors = check.in_range("colors", check.finite_array("colors", colors, (None, 3)), 0.0, 1.0, high_open=True)
    if len(colors) < 2:
        raise ValueError(f"colors: wanted at least 2, got {len(colors)}")
    size = check.number("size", size, 0.0, low_open=True)
    seed = check.seed("seed", seed)
    points = check.positions("points", points, (None, 3))
    least = np.abs(points).max() * 2.0**-40  # whole numbers of finer cells are lost in rounding
    if size < least:
        raise ValueError(f"size: wanted at least {least:g} for points as far from the origin, got {size:g}")
    scaled = points / size
    return {"marble": _marble, "spots": _spots, "checker": _checker}[pattern](scaled, colors, seed)


def _marble(p, colors, seed):
    turbulence = sum(np.abs(_noise(p * 2.0**octave * 0.5, seed + octave)) / 2.0**octave for octave in range(5))
    axis = np.array([0.6, 0.4, 0.7])
    # Narrow dark veins between wide light bands: the sine's absolute value, sharpened.
    band = np.abs(np.sin(0.5 * np.pi * (p @ axis + 3.0 * turbulence))) ** 0.6
    at = (1.0 - band) * (len(colors) - 1)
    low = np.minimum(at.astype(int), len(colors) - 2)
    t = (at - low)[:, None]
    return (1 - t) * colors[low] + t * colors[low + 1]


def _spots(p, colors, seed):
    p = p + 0.25 * np.stack([_noise(p, seed + k) for k in range(3)], axis=1)
    cell = np.floor(p).astype(np.int64)
    nearest, owner = np.full(len(p), np.inf), np.zeros((len(p), 3), np.int64)
    for step in np.ndindex(3, 3, 3):
        other = cell + np.array(step) - 1
        center = other + 0.15 + 0.7 * np.stack([_hash(other, seed + k) for k in range(3)], axis=1)
        distance = np.linalg.norm(p - center, axis=1)
        closer = distance < nearest
        nearest[closer], owner[closer] = distance[closer], other[closer]
    reach = 0.3 + 0.15 * _hash(owner, seed + 3)
    ring, middle = nearest < reach, nearest < 0.5 * reach
    return np.where(ring[:, None], np.where(middle[:, None], colors[2 % len(colors)], colors[1]), colors[0])


def _checker(p, colors, seed):
    # A surface that lies on the border of two cubes must not flicker between them by rounding.
    return colors[np.floor(p + 1e-6).astype(np.int64).sum(axis=1) % len(colors)]


def _hash(cell, seed):
    """A number in [0, 1) for each integer cell (n, 3), by the mixing of splitmix64."""
    with np.errstate(over="ignore"):
        key = cell.astype(np.uint64)
        z = np.full(len(cell), (seed + 1) % 2**64, np.uint64)
        for axis in range(3):
            z = (z ^ key[:, axis]) * np.uint64(0x9E3779B97F4A7C15)
            z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            z ^= z >> np.uint64(27)
        return (z >> np.uint64(11)).astype(float) * 2.0**-53


def _noise(p, seed):
    """Gradient noise in about [-1, 1] with one feature per unit (Perlin 2002)."""
    cell = np.floor(p).astype(np.int64)
    f = p - cell
    fade = f * f * f * (f * (f * 6 - 15) + 10)
    total = np.zeros(len(p))
    for step in np.ndindex(2, 2, 2):
        corner = cell + np.array(step)
        z = 2 * _hash(corner, 2 * seed) - 1
        phi = 2 * np.pi * _hash(corner, 2 * seed + 1)
        ring = np.sqrt(1 - z * z)
        offset = f - np.array(step)
        slope = ring * (np.cos(phi) * offset[:, 0] + np.sin(phi) * offset[:, 1]) + z * offset[:, 2]
        total += slope * np.prod(np.where(step, fade, 1 - fade), axis=1)
    return 1.5 * total
