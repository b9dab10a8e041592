"""Clouds of other libraries, such as Open3D's, told by what they have and not by their class."""

import numpy as np

from surflux.geometry.foreign_meshes import reflectance_of


def unpacked(points, normals, reflectance):
    """(points, normals, reflectance) where points may be a cloud: what it has, where nothing else is given.

    A cloud has `points`, and `normals` and `colors` that may be empty, as open3d.geometry.PointCloud; tensor clouds of
    Open3D are made such ones. Reflectance None is that of the colours, or .5.
    """
    if hasattr(points, "to_legacy"):
        points = points.to_legacy()
    if all(hasattr(points, name) for name in ("points", "normals", "colors")):
        cloud, points = points, np.asarray(points.points)
        if normals is None and len(cloud.normals):
            normals = np.asarray(cloud.normals)
        if reflectance is None and len(cloud.colors):
            reflectance = reflectance_of(cloud.colors)
    return points, normals, 0.5 if reflectance is None else reflectance
