"""Nodes of glTF files, and where they stand."""

import numpy as np

from surflux.geometry.rotation import rotation_matrices
from surflux.meshes.gltf_container import numbers

_LAST_ROW = np.array([0.0, 0.0, 0.0, 1.0])  # of matrices
_ROUNDING = 1e-5  # of floats, in what programs have multiplied and inverted


def nodes_shown(file):
    """(node, global matrix (4, 4)) of all nodes of the scene that a Container shows, or of all without one.

    In the file's order, parents before their children.
    """
    header, met = file.header, set()
    if "scenes" in header:
        roots = file.entry("scenes", header.get("scene", 0)).get("nodes", [])
    else:
        children = {child for node in header.get("nodes", []) for child in node.get("children", [])}
        roots = [k for k in range(len(header.get("nodes", []))) if k not in children]
    left = [(root, np.eye(4)) for root in reversed(roots)]
    while left:
        index, above = left.pop()
        node = file.entry("nodes", index)
        if index in met:
            raise ValueError(f"node {index} is in the scene twice")
        met.add(index)
        matrix = above @ _matrix(node)
        left += [(child, matrix) for child in reversed(node.get("children", []))]
        yield node, matrix


def _matrix(node):
    """(4, 4) of a node in the one above it."""
    if "matrix" in node:
        found = numbers("matrix", node["matrix"], 16).reshape(4, 4).T
        if np.abs(found[3] - _LAST_ROW).max() > _ROUNDING:
            raise ValueError("the matrix of a node is no translation, rotation and scale")
        found[3] = _LAST_ROW
        return found
    out = np.eye(4)
    quaternion = numbers("rotation", node.get("rotation", [0, 0, 0, 1]), 4)
    if not quaternion.any():
        raise ValueError("the rotation of a node is 0 0 0 0; wanted a unit quaternion")
    quaternion /= np.abs(quaternion).max()  # so that squares neither overflow nor vanish
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    rotation = rotation_matrices(np.array([[w, x, y, z]]))[0]
    out[:3, :3] = rotation * numbers("scale", node.get("scale", [1, 1, 1]), 3)
    out[:3, 3] = numbers("translation", node.get("translation", [0, 0, 0]), 3)
    return out
