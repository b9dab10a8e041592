"""The leaves of a solution: the surfels of its scene, and those inserted in place of some of them."""

import numpy as np


def inserted_among(parents):
    """(n,) booleans: which surfels stand for a part of one of the scene's, by Solution.parents."""
    return np.bincount(parents)[parents] > 1 if len(parents) else np.zeros(0, bool)


def insertion_depth(parents, areas):
    """-1, -2 and so on for all that was inserted below surfels, whose area it shares."""
    whole = np.bincount(parents, areas)[parents] if len(parents) else areas
    share = np.divide(areas, whole, out=np.ones(len(parents)), where=areas > 0.0)
    return np.round(np.log(share) / np.log(4.0))


def means_of_parents(parents, areas, values):
    """(n, k) means by area of values (m, k) at leaves, over the surfels of the scene that they stand for.

    Plain means of those whose leaves have no area.
    """
    count = int(parents.max()) + 1 if len(parents) else 0
    whole = np.bincount(parents, areas, count)
    weights = np.where(whole[parents] > 0.0, areas, 1.0)
    total = np.bincount(parents, weights, count)
    return np.stack([np.bincount(parents, weights * column, count) / total for column in values.T], axis=1)


def means_of_faces(solution, values, index, faces):
    """(f, 3) means by area of values (n, 3) at the leaves of one object, over the faces of its mesh; NaN of none.

    faces: geometry.faces.Faces of the object. Of a leaf that lies in two of them each has the area in it.
    """
    leaves = np.flatnonzero(solution.objects == index)
    first = sum(len(s) for s in solution._scene.objects[:index])
    surfels, values = solution.surfels[leaves], values[leaves]
    leaf, face, share = faces.taken(solution.parents[leaves] - first).shares(surfels)
    weight = share * surfels.areas[leaf]
    area = np.bincount(face, weight, faces.count)[:, None]
    sums = np.stack([np.bincount(face, weight * column, faces.count) for column in values[leaf].T], axis=1)
    return np.divide(sums, area, out=np.full((faces.count, 3), np.nan), where=area > 0)
