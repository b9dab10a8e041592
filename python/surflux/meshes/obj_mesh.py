"""Meshes of OBJ files, with colours of vertices, materials and textures."""

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.warn import warn
from surflux.meshes.file_colors import reflectance_in_file
from surflux.meshes.foreign_meshes import Mesh
from surflux.meshes.obj_materials import USUAL, looks_of_faces
from surflux.meshes.textures import TexturedFaces


def read_obj_mesh(path):
    """The Mesh of an OBJ file.

    A face has its texture (map_Kd), else the colours of its vertices, else Kd. Colours are no factors of the texture,
    as they are in glTF: files of photogrammetry say the same by either.
    Where some face has a texture, or a corner without a colour, all others have the means of their vertices, so that
    pieces of them are alike; else their colours are linear between vertices.
    """
    vertices, offsets, indices, colors, materials, (places, of_corners) = _core.read_obj(path)
    mesh = Mesh(vertices, offsets, indices.astype(np.int64), None)
    has_color, rho = _colors_of_vertices(path, colors)
    colored = np.zeros(len(offsets) - 1, bool)
    if rho is not None and len(colored):
        colored = np.logical_and.reduceat(has_color[indices], offsets[:-1])
    textured = TexturedFaces(vertices, offsets, indices, places.reshape(-1, 2), of_corners) if len(places) else None
    of_faces, exitance, uses = looks_of_faces(path, *materials, textured, colored)
    if uses:
        mesh = mesh._replace(places=textured.of_each_corner(), textures=uses)
    painted = np.zeros(len(colored), bool)
    for use in uses:
        painted[use.faces] |= not use.shines
    mesh = mesh._replace(exitance=exitance)
    if not colored.any():
        return mesh._replace(of_faces=of_faces)
    if colored.all() and not painted.any():
        return mesh._replace(reflectance=rho)
    bare = np.count_nonzero(~colored & ~painted)
    if bare:
        has = "has a corner" if bare == 1 else "have corners"
        warn(f"{path}: {counted(bare, 'face')} {has} without a colour: Kd counts there, else {USUAL:g}")
    if of_faces is None:
        of_faces = np.full((len(colored), 3), USUAL)
    by_vertices = (colored & ~painted)[:, None]
    return mesh._replace(of_faces=np.where(by_vertices, mesh.mean_over_faces(rho), of_faces))


def _colors_of_vertices(path, colors):
    """((v,) which vertices have a colour, (v, 3) reflectance, of the others black), the latter None without any."""
    if colors is None:
        return None, None
    has_color = ~np.all(np.isnan(colors), axis=1)
    return has_color, reflectance_in_file(path, np.where(has_color[:, None], colors, 0.0), "float")
