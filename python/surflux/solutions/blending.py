"""Which surfels blend with each other in pictures."""

import numpy as np

from surflux.solutions.seen_colors import SeenColors

ALIKE = 1e-6  # reflectance, and emission over the largest: what was inserted has means of its own, in files 7 digits
PATCHES_OF_A_MATERIAL = 8  # on average, from which on its borders are drawn sharp


def blended_groups(solution, dark=None):
    """(n,) a number of each surfel, whose light blends with that of the same number alone.

    Those of one object, but what is dark, as the floor below a plinth is, by itself; and of meshes patches of one
    material, so that what is painted on a face ends where the face does. A mesh of about as many colours as patches,
    as textures make it, blends as a whole; and so do its faces with textures that pictures have as they are.

    Args:
        dark: (n,) booleans; None for those without radiosity.
    """
    surfels = solution.surfels
    dark = (solution.radiosity == 0).all(axis=1) if dark is None else dark
    groups = 2 * np.asarray(solution.objects, np.int64) + dark
    is_patch = np.zeros(len(groups), bool)
    is_patch[surfels.triangle_surfel] = True
    patches = np.flatnonzero(is_patch)
    shining = surfels.emission[patches] / surfels.emission.max(initial=np.finfo(float).tiny)
    material = _numbered(np.column_stack([surfels.reflectance[patches], shining]), ALIKE)
    textured = SeenColors.of(solution).textured[patches]
    material[textured] = material.max(initial=0) + 1
    if material.any():
        count, object_of = material.max() + 1, groups[patches] // 2
        materials = np.bincount(np.unique(object_of * count + material) // count)
        few = PATCHES_OF_A_MATERIAL * materials[object_of] <= np.bincount(object_of)[object_of]
        own = np.zeros(len(groups), np.int64)
        own[patches] = np.where(few | textured, material, 0)
        groups = _numbered(np.column_stack([groups, own]))
    return groups.astype(np.int32)


def _numbered(rows, alike=0.0):
    """(n,) a number of each row, from 0 on: the same of rows that no column parts by a step of more than `alike`."""
    numbers = np.zeros(len(rows), np.int64)
    for column in rows.T:
        if len(column) and np.ptp(column) > alike:
            values, places = np.unique(column, return_inverse=True)
            steps = np.append(0, np.cumsum(np.diff(values) > alike))[places]
            numbers = np.unique(numbers * (steps.max() + 1) + steps, return_inverse=True)[1]
    return numbers
