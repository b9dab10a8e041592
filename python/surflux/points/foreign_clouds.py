"""Clouds of other libraries: Open3D's and trimesh's are told by what they have and not by their class."""

import sys

import numpy as np

from surflux.meshes.foreign_meshes import colors_among, is_gltf, reflectance_of
from surflux.meshes.gltf_looks import linear_reflectance


def unpacked(points, normals, reflectance):
    """(points, normals, reflectance) where points may be a cloud: what it has, where nothing else is given.

    A cloud has `points`, and `normals` and `colors` that may be empty, as open3d.geometry.PointCloud; tensor clouds of
    Open3D are made such ones. trimesh.PointCloud has `vertices` and `colors`. pyvista.PolyData has `points`, and among
    its arrays normals ("Normals" or "normals") and colours ("RGB" or "RGBA"). Reflectance None is that of the colours,
    or .5.
    """
    if hasattr(points, "to_legacy"):
        points = points.to_legacy()
    pyvista = sys.modules.get("pyvista")
    own, colors = None, None
    if pyvista is not None and isinstance(points, pyvista.PolyData):
        data, points = points.point_data, np.asarray(points.points)
        own = next((np.asarray(data[name]) for name in ("Normals", "normals") if name in data), None)
        colors = colors_among(data)
    elif all(hasattr(points, name) for name in ("points", "normals", "colors")):
        own, colors = np.asarray(points.normals), reflectance_of(points.colors) if len(points.colors) else None
        points = np.asarray(points.points)
    elif all(hasattr(points, name) for name in ("vertices", "colors")) and not hasattr(points, "faces"):
        colors = np.asarray(points.colors)
        of_colors = linear_reflectance if is_gltf(points) else reflectance_of
        colors = of_colors(colors) if len(colors) else None
        points = np.asarray(points.vertices)
    if normals is None and own is not None and len(own):
        normals = own
    if reflectance is None:
        reflectance = colors
    return points, normals, 0.5 if reflectance is None else reflectance
