"""What parts of faces have of textures, and of colours that vertices have: a face that is cut, or sampled, has many."""

import numpy as np

from surflux import _core
from surflux.meshes.fans import cut_along_fans, shares_of_rows, sums_of_rows
from surflux.meshes.texel_means import mean_texels

_ALIKE = 1e-5  # texture coordinates and colours
_MANY = 1 << 19  # parts of faces that are looked at together


def vary_within_faces(mesh):
    """Whether parts of a face of a Mesh may have (another reflectance, another exitance) than the face."""
    shines = {use.shines for use in mesh.textures}
    return False in shines or _has_shades(mesh), True in shines


def without_colors(mesh, of=("reflectance", "emission")):
    """The Mesh whose faces have the same of these all over; None where nothing else varies within faces."""
    rho = mesh.face_reflectance() if "reflectance" in of else None
    mesh = mesh.with_materials(rho, mesh.face_emission() if "emission" in of else None)
    return mesh if any(vary_within_faces(mesh)) else None


def _has_shades(mesh):
    """Whether vertices of a Mesh have colours that differ."""
    rho = mesh.reflectance
    return mesh.of_faces is None and rho is not None and bool(np.any(rho != rho[:1]))


def colors_of_patches(mesh, face, patch, triangles):
    """(reflectance, exitance), (p, 3) each, of patches, each on a face (p,) of a Mesh, of triangles (t, 3, 3).

    patch (t,): of each triangle.

    The mean of the texture over a patch where there is one, of the colours of vertices that of their linear
    interpolation; else what the face has.
    """
    of, parts = cut_along_fans(mesh.vertices, mesh.offsets, mesh.indices, face[patch], triangles)
    patch = patch[of]
    a, b, c = parts.transpose(1, 0, 2)
    shares = shares_of_rows(patch, np.linalg.norm(np.cross(b - a, c - a), axis=1), len(face))
    return [
        sums_of_rows(patch, shares[:, None] * values, len(face))
        for values in _colors_of_parts(mesh, face[patch], parts)
    ]


def _colors_of_parts(mesh, face, triangles):
    """colors_of_patches of single triangles (t, 3, 3), each in one of the fan of a face (t,)."""
    reflectance, exitance = mesh.face_reflectance()[face], mesh.face_emission()[face]
    if _has_shades(mesh):
        of_corners = mesh.reflectance[mesh.indices]
        reflectance = np.clip(interpolated(mesh, of_corners, face, triangles.mean(axis=1)), 0.0, of_corners.max())
    read = None
    for use in mesh.textures:
        values = exitance if use.shines else reflectance
        row = np.minimum(np.searchsorted(use.faces, face), len(use.faces) - 1)
        on_it = np.flatnonzero(use.faces[row] == face)
        if len(on_it) and use.read is not read:  # else it is that of the use before
            read, texture = use.read, use.read()
        for first in range(0, len(on_it), _MANY):
            some = on_it[first : first + _MANY]
            corners = triangles[some]
            points = np.concatenate([corners.mean(axis=1, keepdims=True), corners], axis=1)
            places = interpolated(mesh, mesh.places, face[some], points)[:, 1:]
            means = mean_texels(texture, places * use.scale + use.shift)
            values[some] = np.clip(use.tint[row[some]] * means, 0.0, use.most)
    return reflectance, exitance


def go_on(mesh, face, other):
    """(t,) whether, of triangles `face` (t,) of a Mesh, colours go on as they are on triangles `other` (t,) beside."""
    corner = mesh.offsets[other][:, None] + np.arange(3)
    points = mesh.vertices[mesh.indices[corner]]
    result = np.ones(len(face), bool)
    if _has_shades(mesh):
        result &= _near(mesh, mesh.reflectance[mesh.indices], face, points, corner, repeats=False)
    if mesh.textures:
        one = np.full((len(mesh.offsets) - 1, 2), -1)  # the texture of each face, and the one of what it sends
        for number, use in enumerate(mesh.textures):
            one[use.faces, int(use.shines)] = number
        result &= (one[face] == one[other]).all(axis=1)
        for number, use in enumerate(mesh.textures):
            on_it = np.flatnonzero(result & (one[face, int(use.shines)] == number))
            if len(on_it):
                places = mesh.places * use.scale
                result[on_it] = _near(mesh, places, face[on_it], points[on_it], corner[on_it], repeats=True)
    return result


def _near(mesh, values, face, points, corner, repeats):
    """(t,) whether values (k, d) at corners (t, 3) are those of the face (t,) there."""
    there = interpolated(mesh, values, face.repeat(3), points.reshape(-1, 3))
    off = there.reshape(*corner.shape, values.shape[1]) - values[corner]
    if repeats:  # a texture repeats itself
        off -= np.round(off[:, :1])
    return (np.abs(off) < _ALIKE).all(axis=(1, 2))


def interpolated(mesh, values, face, points):
    """(t, ..., d): values (k, d) at the corners of faces of a Mesh, at points (t, ..., 3) in planes of faces (t,).

    Linear over a triangle of the fan around a face's first corner: the one in which the first point of a face is, or
    nearest to it.
    """
    return _core.polygon_values(mesh.vertices, mesh.offsets, mesh.indices, values, face, points)
