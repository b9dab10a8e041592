"""Which surfels blend with each other in pictures."""

import numpy as np

PATCHES_OF_A_MATERIAL = 8  # on average, from which on its borders are drawn sharp


def blended_groups(solution, dark=None):
    """(n,) a number of each surfel, whose light blends with that of the same number alone.

    Those of one object, but what is dark, as the floor below a plinth is, by itself; and of meshes patches of one
    material, so that what is painted on a face ends where the face does. A mesh of about as many colours as patches,
    as textures make it, blends as a whole.

    Args:
        dark: (n,) booleans; None for those without radiosity.
    """
    surfels = solution.surfels
    dark = (solution.radiosity == 0).all(axis=1) if dark is None else dark
    groups = 2 * np.asarray(solution.objects, np.int64) + dark
    is_patch = np.zeros(len(groups), bool)
    is_patch[surfels.triangle_surfel] = True
    patches = np.flatnonzero(is_patch)
    material = _numbered(np.column_stack([surfels.reflectance[patches], surfels.emission[patches]]))
    if material.any():
        count, object_of = material.max() + 1, groups[patches] // 2
        materials = np.bincount(np.unique(object_of * count + material) // count)
        few = PATCHES_OF_A_MATERIAL * materials[object_of] <= np.bincount(object_of)[object_of]
        own = np.zeros(len(groups), np.int64)
        own[patches] = np.where(few, material, 0)
        groups = _numbered(np.column_stack([groups, own]))
    return groups.astype(np.int32)


def _numbered(rows):
    """(n,) a number of each row, the same of those alone that are equal."""
    numbers = np.zeros(len(rows), np.int64)
    for column in rows.T:
        if len(column) and (column != column[0]).any():
            values = np.unique(column, return_inverse=True)[1]
            numbers = np.unique(numbers * (values.max() + 1) + values, return_inverse=True)[1]
    return numbers
