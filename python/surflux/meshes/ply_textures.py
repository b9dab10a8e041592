"""Textures of PLY files, as MeshLab writes them: comments name them, and faces or vertices have places on them."""

import os

import numpy as np

from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn
from surflux.meshes.obj_textures import Words, paint
from surflux.meshes.textures import NO_PLACE, TexturedFaces

_KEYWORD = "texturefile "
_OF_VERTICES = (("texture_u", "texture_v"), ("s", "t"), ("u", "v"))
_FARTHEST = 1e9  # place on a texture, which repeats itself
_WORDS = Words("colours of faces or vertices count", "texcoord", "the texture")


def with_textures(path, mesh, ply):
    """A Mesh with the textures that comments of its file name (TextureFile), where faces have places on them.

    Faces (`texcoord`) or vertices (`texture_u`, `s`, `u`, ...) have these, v going up; `texnumber` of faces says which
    texture is theirs. A texture counts before colours; what is not there is warned of.
    """
    names = [text.strip() for text in ply["comments"]]
    names = [os.fsencode(name[len(_KEYWORD) :].strip()) for name in names if name.lower().startswith(_KEYWORD)]
    faces = len(mesh.offsets) - 1
    if not names or not faces:
        return mesh
    which = ply["columns"]["face"].get("texnumber")
    which = np.zeros(faces) if which is None else which
    beyond = which >= len(names)
    if beyond.any():
        there = f"texnumber {which[np.argmax(beyond)]:.0f} of {counted(len(names), 'texture')}, numbered from 0"
        has = "has" if np.count_nonzero(beyond) == 1 else "have"
        warn(f"{path}: {counted(np.count_nonzero(beyond), 'face')} {has} {there}; {_WORDS.without} there")
    which = np.where((which >= 0) & ~beyond, which, len(names)).astype(np.int64)
    used = np.isin(np.arange(len(names)), which)
    materials = [
        {b"newmtl": name, b"map_kd": ((path, 0), [name])} if has_faces else None
        for name, has_faces in zip(names, used, strict=True)
    ]
    textured, rho = _places(mesh, ply), mesh.face_reflectance().copy()
    uses = paint(path, materials, which, {b"kd": (rho, WHITE)}, textured, _WORDS)
    if not uses:
        return mesh
    return mesh._replace(of_faces=rho, places=textured.of_each_corner(), textures=tuple(uses))


def _places(mesh, ply):
    """The TexturedFaces of a Mesh, or None where nothing has a place."""
    begin, values = ply["face_texcoord"]
    if len(begin) == len(mesh.offsets):
        corners = np.diff(mesh.offsets)
        face = np.repeat(np.arange(len(corners)), corners)
        at = begin[face] + 2 * (np.arange(len(face)) - mesh.offsets[face])
        whole = (np.diff(begin) == 2 * corners)[face]
        places = np.full((len(face), 2), np.nan)
        places[whole] = values[at[whole, None] + np.arange(2)]
        of_corners = np.arange(len(face))
    else:
        vertex = ply["columns"]["vertex"]
        names = next((names for names in _OF_VERTICES if all(name in vertex for name in names)), None)
        if names is None:
            return None
        places, of_corners = np.stack([vertex[name] for name in names], axis=1), mesh.indices
    known = (np.abs(places) < _FARTHEST).all(axis=1)
    of_corners = np.where(known[of_corners], of_corners, NO_PLACE)
    return TexturedFaces(mesh.vertices, mesh.offsets, mesh.indices, places, of_corners)
