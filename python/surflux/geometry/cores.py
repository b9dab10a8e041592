"""Surfels as the core holds them, from arrays that have been checked."""

import numpy as np

from surflux import _core


def make_core(
    points,
    normals,
    radii,
    areas=None,
    reflectance=0.5,
    emission=0.0,
    triangles=None,
    triangle_surfel=None,
    specular=None,
    exponent=None,
):
    """_core.Surfels of arrays as Surfels takes them; one number stands for all surfels and channels.

    specular, exponent: (n, 3) and (n,), or None for none and for the usual one.
    """
    reflectance, emission = (
        np.broadcast_to(np.asarray(v, np.float64), (len(points), 3)) for v in (reflectance, emission)
    )
    if triangles is None:
        triangles, triangle_surfel = np.zeros((0, 3, 3)), np.zeros(0, np.uint32)
    materials = (reflectance, emission, triangles, triangle_surfel, specular, exponent)
    return _core.Surfels(points, normals, radii, areas, *materials)


def replaced(core, **arrays):
    """core with other arrays in place of some, by the names of its attributes."""
    names = ("positions", "normals", "radii", "areas", "reflectance", "emission", "triangles", "triangle_surfel")
    names += ("specular", "exponent") if core.has_gloss or "specular" in arrays else ()
    return _core.Surfels(*(arrays[name] if name in arrays else getattr(core, name) for name in names))


def gloss_at(core, indices):
    """The arrays specular and exponent of make_core, of the surfels at the indices; {} where nothing is specular."""
    if not core.has_gloss:
        return {}
    return {"specular": core.specular[indices], "exponent": core.exponent[indices]}


def moved(core, scale, rotation, translation):
    """core by p -> scale rotation p + translation: normals turn, radii grow with the scale and areas with its square.

    rotation: (3, 3), orthogonal; where it mirrors, triangles keep facing the way of their normals.
    """

    def place(points):
        return scale * (points @ rotation.T) + translation

    corners = place(core.triangles.reshape(-1, 3)).reshape(-1, 3, 3)
    return replaced(
        core,
        positions=place(core.positions),
        normals=core.normals @ rotation.T,
        radii=scale * core.radii,
        areas=None if core.areas is None else scale**2 * core.areas,
        triangles=corners if np.linalg.det(rotation) > 0.0 else corners[:, ::-1],
    )


def disks_among(s):
    """(m,) indices of the surfels that are disks, and no patches."""
    is_disk = np.ones(len(s), bool)
    is_disk[s.triangle_surfel] = False
    return np.flatnonzero(is_disk)
