"""Surfels, compiled, of a mesh that has been read and checked: one per patch, or points spread over it."""

from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux._base.passes import stage
from surflux.geometry.cores import make_core
from surflux.geometry.estimates import estimated_radii
from surflux.geometry.gloss import require_energy
from surflux.geometry.patches import make_patches
from surflux.geometry.sheets import sheet_faces, with_backs

CANDIDATES = 5  # for each sample: Yuksel 2015, section 4


class Faces(NamedTuple):
    """The face `of` (n,) each surfel, and for each face that was `merged` (f,) into another one which that is."""

    of: np.ndarray
    merged: np.ndarray


def surfels_of_patches(mesh, patch_area, reflectance, emission, gloss, back_of_sheets=False):
    """(_core.Surfels, Faces) of a Mesh with reflectance and emission (f, 3) and gloss (see gloss_arrays) per face."""
    materials = np.column_stack([reflectance, emission, *gloss.values()])
    patches = make_patches(*mesh[:3], patch_area, materials, divided=True)
    core = _core.Surfels(
        patches.centroids,
        patches.normals,
        patches.radii,
        patches.areas,
        reflectance[patches.faces],
        emission[patches.faces],
        patches.triangles,
        patches.triangle_patch,
        **{name: values[patches.faces] for name, values in gloss.items()},
    )
    if not back_of_sheets:
        return core, Faces(patches.faces, patches.merged)
    sheet = sheet_faces(mesh)[patches.faces]
    return with_backs(core, sheet), Faces(np.concatenate([patches.faces, patches.faces[sheet]]), patches.merged)


def sampled_surfels(mesh, n, seed, reflectance, emission, gloss):
    """_core.Surfels: n blue-noise ones on a Mesh; with reflectance and emission (n, 3), None for its own, and gloss."""
    patches = make_patches(*mesh[:3], paired=False)
    points, triangle = _core.sample_evenly(patches.triangles, n, CANDIDATES, seed, progress=stage("samples"))
    patch = patches.triangle_patch[triangle]
    normals = patches.normals[patch]
    if reflectance is None:
        reflectance = mesh.face_reflectance()[patches.faces[patch]]
    if emission is None:
        emission = mesh.face_emission()[patches.faces[patch]]
    require_energy(reflectance, gloss)
    return make_core(points, normals, estimated_radii(points, normals), None, reflectance, emission, **gloss)
