"""The sun of many hours in few directions, for rays: finer than patches of the sky."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surflux._base.types import Floats


@dataclass(frozen=True, eq=False)
class SunPaths:
    """Where the sun is in h hours, in `steps` positions each.

    Attributes:
        suns: (h, steps, 3) directions.
        shares: (h, steps) of the hour's beam that come from each; 0 while the sun is down, 1 in all of an hour in which
            it is up at all.
        cell: (h, steps) which direction of `directions` stands for it; -1 while it is down or brings nothing.
        directions: (cells, 3), where rays go: the means of what falls into each cell, by energy.
        energy: (cells, 3) sums of direction times energy: what a plane that faces all of a cell has of it is its normal
            times this, exactly.
    """

    suns: Floats
    shares: Floats
    cell: Any
    directions: Floats
    energy: Floats


def sun_paths(suns, beams, width):
    """SunPaths of suns (h, steps, 3) with the energy (h,) of each hour, in cells of about width degrees a side."""
    up = suns[..., 2] > 0.0
    shares = up / np.maximum(up.sum(axis=1, keepdims=True), 1)
    power = shares * beams[:, None]
    at = np.flatnonzero(power.ravel() > 0.0)
    places, weights = suns.reshape(-1, 3)[at], power.ravel()[at]
    step = np.radians(width)
    row = (np.arcsin(places[:, 2].clip(-1.0, 1.0)) / step).astype(int)
    count = np.maximum(1, np.round(2.0 * np.pi * np.cos((row + 0.5) * step) / step)).astype(int)
    column = (np.arctan2(places[:, 0], places[:, 1]) % (2.0 * np.pi) / (2.0 * np.pi) * count).astype(int) % count
    _, which = np.unique(row * (1 + int(2.0 * np.pi / step)) + column, return_inverse=True)
    energy = np.zeros((int(which.max()) + 1 if len(which) else 0, 3))
    np.add.at(energy, which, weights[:, None] * places)
    cell = np.full(power.size, -1)
    cell[at] = which
    directions = energy / np.linalg.norm(energy, axis=1, keepdims=True)
    return SunPaths(suns, shares, cell.reshape(power.shape), directions, energy)


def beam_hours(normals, beams, paths, lit):
    """(m, h) of each hour, on planes with normals (m, 3); lit: their rows of SightLines.free(paths.directions)."""
    out = np.zeros((len(normals), len(beams)))
    bits = np.unpackbits(lit, axis=1, count=len(paths.directions))  # (m, cells)
    for step in range(paths.suns.shape[1]):
        cell = paths.cell[:, step]
        seen = np.flatnonzero(cell >= 0)
        cosine = (normals @ paths.suns[seen, step].T).clip(0.0)
        out[:, seen] += bits[:, cell[seen]] * cosine * (beams * paths.shares[:, step])[seen]
    return out
