"""Holding what is found by chance, with its standard error, against what is known."""

import numpy as np
from scipy import stats

LARGEST_SCORE, LEAST_PROBABILITY = 4.5, 1e-3


def scores(value, expected, error, samples, off=0.0):
    """z of each estimate (k,): what Student's t of about sqrt(samples) batches is on the normal scale.

    off: a share of the expected value that it may be wrong by itself: as much of the difference does not count.
    """
    difference = value - expected
    difference = np.sign(difference) * np.maximum(0.0, np.abs(difference) - off * np.abs(expected))
    return stats.norm.isf(stats.t.sf(difference / error, max(16, round(samples**0.5)) - 1))


def agreement(z):
    """(largest |z|, p of the sum of their squares, mean of z over its own spread)."""
    return np.abs(z).max(), stats.chi2.sf((z**2).sum(), len(z)), z.mean() * np.sqrt(len(z))
