"""The leaves of a solution: the surfels of its scene, and those inserted in place of some of them."""

import numpy as np


def inserted_among(parents):
    """(n,) booleans: which surfels stand for a part of one of the scene's, by Solution.parents."""
    return np.bincount(parents)[parents] > 1 if len(parents) else np.zeros(0, bool)


def insertion_depth(parents, areas):
    """0 for the scene's own surfels, and -1, -2 and so on for those inserted below them, which share their area."""
    whole = np.bincount(parents, areas)[parents] if len(parents) else areas
    share = np.divide(areas, whole, out=np.ones(len(parents)), where=inserted_among(parents) & (areas > 0.0))
    return np.round(np.log(share) / np.log(4.0))
