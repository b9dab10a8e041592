"""Surfels as the core holds them, from arrays that have been checked."""

import numpy as np

from surflux import _core


def make_core(points, normals, radii, areas=None, reflectance=0.5, emission=0.0, triangles=None, triangle_surfel=None):
    """_core.Surfels of arrays as Surfels takes them; one number stands for all surfels and channels."""
    reflectance, emission = (
        np.broadcast_to(np.asarray(v, np.float64), (len(points), 3)) for v in (reflectance, emission)
    )
    if triangles is None:
        triangles, triangle_surfel = np.zeros((0, 3, 3)), np.zeros(0, np.uint32)
    return _core.Surfels(points, normals, radii, areas, reflectance, emission, triangles, triangle_surfel)


def replaced(core, **arrays):
    """core with other arrays in place of some, by the names of its attributes."""
    names = ("positions", "normals", "radii", "areas", "reflectance", "emission", "triangles", "triangle_surfel")
    return _core.Surfels(*(arrays[name] if name in arrays else getattr(core, name) for name in names))
