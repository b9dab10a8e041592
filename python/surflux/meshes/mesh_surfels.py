"""Surfels, compiled, of a mesh that has been read and checked: one per patch, or points spread over it."""

from functools import partial

import numpy as np

from surflux import _core
from surflux._base.passes import stage
from surflux.geometry.cores import make_core, replaced
from surflux.geometry.estimates import estimated_radii
from surflux.geometry.gloss import require_energy
from surflux.geometry.sheets import sheet_faces, with_backs
from surflux.meshes.face_colors import colors_of_patches, go_on, vary_within_faces
from surflux.meshes.faces import faces_of_patches
from surflux.meshes.patches import make_patches

CANDIDATES = 5  # for each sample: Yuksel 2015, section 4


def surfels_of_patches(mesh, patch_area, gloss, back_of_sheets=False):
    """(_core.Surfels, faces.Faces) of a Mesh with gloss (see gloss_arrays) per face."""
    materials = np.column_stack([mesh.face_reflectance(), mesh.face_emission(), *gloss.values()])
    varies = any(vary_within_faces(mesh))
    alike = partial(go_on, mesh) if varies else None
    patches = make_patches(*mesh[:3], patch_area, materials, divided=True, go_on=alike)
    reflectance, emission = mesh.face_reflectance()[patches.faces], mesh.face_emission()[patches.faces]
    if varies:
        cut = (np.bincount(patches.faces) > 1)[patches.faces]
        parts = _colors_of_some(mesh, patches.faces, cut, patches.triangle_patch, patches.triangles)
        reflectance[cut], emission[cut] = parts
    gloss = require_energy(reflectance, {name: values[patches.faces] for name, values in gloss.items()}, "patch")
    core = _core.Surfels(
        patches.centroids,
        patches.normals,
        patches.radii,
        patches.areas,
        reflectance,
        emission,
        patches.triangles,
        patches.triangle_patch,
        **gloss,
    )
    faces = faces_of_patches(patches, len(mesh.offsets) - 1)
    if varies:
        faces = faces.with_colors(mesh)
    if not back_of_sheets:
        return core, faces
    sheet = sheet_faces(mesh)[patches.faces]
    return with_backs(core, sheet), faces.taken(np.append(np.arange(len(sheet)), np.flatnonzero(sheet)))


def with_colors_of_pieces(core, of, faces):
    """core, whose surfels are pieces of surfels (n,) before, with the colours of pieces from where faces.Faces lie."""
    if faces.mesh is None:
        return core
    cut = (np.bincount(of) > 1)[of]
    parts = _colors_of_some(faces.mesh, faces.of, cut, core.triangle_surfel, core.triangles)
    colors = {}
    for name, part, varies in zip(("reflectance", "emission"), parts, vary_within_faces(faces.mesh), strict=True):
        if varies:
            colors[name] = np.array(getattr(core, name))
            colors[name][cut] = part
    if "reflectance" in colors and core.has_specular:
        require_energy(colors["reflectance"], {"specular": core.specular}, "patch")
    return replaced(core, **colors)


def _colors_of_some(mesh, face, some, owner, triangles):
    """(reflectance, emission) of some (n,) of patches on a face (n,) of a Mesh, whose triangles have an owner (t,)."""
    of_some = some[owner]
    row = np.cumsum(some) - 1
    return colors_of_patches(mesh, face[some], row[owner[of_some]], triangles[of_some])


def sampled_surfels(mesh, n, seed, reflectance, emission, gloss):
    """_core.Surfels: n blue-noise ones on a Mesh; with reflectance and emission (n, 3), None for its own, and gloss."""
    patches = make_patches(*mesh[:3], paired=False)
    points, triangle = _core.sample_evenly(patches.triangles, n, CANDIDATES, seed, progress=stage("samples"))
    patch = patches.triangle_patch[triangle]
    normals = patches.normals[patch]
    if reflectance is None or emission is None:
        own = _colors_around(mesh, points, patches.faces[patch], patches.triangles[triangle], patches.areas.sum() / n)
        reflectance, emission = (
            mine if its is None else its for mine, its in zip(own, (reflectance, emission), strict=True)
        )
    require_energy(reflectance, gloss)
    return make_core(points, normals, estimated_radii(points, normals), None, reflectance, emission, **gloss)


def _colors_around(mesh, points, face, triangles, area):
    """Reflectance and emission (n, 3) that a Mesh has around points on faces (n,), each in one of triangles (n, 3, 3):
    the mean over so much of that, shrunk towards the point, as `area`."""
    if not any(vary_within_faces(mesh)):
        return mesh.face_reflectance()[face], mesh.face_emission()[face]
    a, b, c = triangles.transpose(1, 0, 2)
    share = np.sqrt(np.minimum(1.0, area / (0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))))
    middle = points[:, None]
    return colors_of_patches(mesh, face, np.arange(len(face)), middle + share[:, None, None] * (triangles - middle))
