"""A solution as glTF, for viewers: lit triangles of meshes and lit points of clouds."""

import numpy as np

from surflux._base.color import white_of
from surflux._base.files import file_error
from surflux.geometry.cores import disks_among
from surflux.scans.gltf import Primitive, placed, write_primitives

# Triangles around a corner that are one surface, in the same light: cosine between normals, ratio of their light.
_ALIKE, _CONTRAST = 0.8, 3.0
_MOST = 64  # triangles before and behind each around a corner that it is compared with
_LEAST = np.finfo(np.float64).tiny


def save_gltf(path, solution, up):
    """Writes the surfels of a solution, patches as triangles and disks as points, with the light that leaves them.

    Light varies over triangles: a corner has the mean of those around it that face alike and have about as much light,
    for those beyond a wall or the border of a shadow have another.

    Args:
        path: Path, ending in .glb or .gltf.
        up: (3,), a unit vector, which becomes y.

    Raises:
        FileError: the file cannot be written.
    """
    s, white = solution.surfels, white_of(solution.radiosity, solution.surfels.emission)
    middle = np.median(s.points, axis=0)  # where floats are finest
    parts = []
    if len(s.triangles):
        owner = np.repeat(s.triangle_surfel, 3)
        irradiance = _at_corners(s.triangles, s.normals[s.triangle_surfel], solution.irradiance[s.triangle_surfel])
        radiosity = s.emission[owner] + s.reflectance[owner] * irradiance
        whole = s.triangles.reshape(-1, 3) - middle, s.normals[owner], irradiance, radiosity
        corners = _in_floats(np.hstack(whole)).reshape(-1, 3, 12)
        corners = corners[_have_area(corners[..., :3])].reshape(-1, 12)
        table, indices = np.unique(corners, axis=0, return_inverse=True)
        if len(table):
            parts.append(_primitive(*np.hsplit(table, 4), white, indices.reshape(-1, 3)))
    disks = disks_among(s)
    if len(disks):
        light = (_in_floats(values[disks]) for values in (solution.irradiance, solution.radiosity))
        parts.append(_primitive(s.points[disks] - middle, s.normals[disks], *light, white))
    if not parts:
        raise file_error(path, "cannot be written: all triangles are points in floats of 32 bits")
    write_primitives(path, parts, placed(middle, up))


def _in_floats(values):
    """values in 32 bits, the largest of those for what is larger."""
    return np.minimum(values, np.finfo(np.float32).max).astype(np.float32)


def _primitive(positions, normals, irradiance, radiosity, white, indices=None):
    color = np.clip(radiosity / white, 0.0, 1.0)
    arrays = {"POSITION": positions, "NORMAL": normals, "COLOR_0": color}
    return Primitive(arrays | {"_IRRADIANCE": irradiance, "_RADIOSITY": radiosity}, indices, unlit=True)


def _have_area(triangles):
    """(t,) booleans: which of triangles (t, 3, 3) have three corners, as floats of 32 bits have them."""
    return np.all(np.any(triangles != np.roll(triangles, 1, axis=1), axis=2), axis=1)


def _at_corners(triangles, normals, values):
    """(3 t, k) at the corners of triangles (t, 3, 3): means of values (t, k), weighted by the angle there."""
    normals, values = np.repeat(normals, 3, axis=0), np.repeat(values, 3, axis=0)
    weights = _angles(triangles).ravel()
    _, place = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    order = np.argsort(place.ravel(), kind="stable")
    place = place.ravel()[order]
    sums, whole = weights[:, None] * values, weights.copy()
    first, light = np.arange(len(order)), values.sum(axis=1)
    for step in range(1, _MOST + 1):  # each corner with the others in its place
        first = first[first + step < len(order)]
        first = first[place[first] == place[first + step]]
        one, other = order[first], order[first + step]
        alike = np.einsum("ij,ij->i", normals[one], normals[other]) > _ALIKE
        alike &= np.maximum(light[one], light[other]) <= _CONTRAST * np.minimum(light[one], light[other])
        for here, there in ((one[alike], other[alike]), (other[alike], one[alike])):  # none twice in either
            sums[here] += weights[there, None] * values[there]
            whole[here] += weights[there]
    return sums / whole[:, None]


def _angles(triangles):
    """(t, 3) of triangles (t, 3, 3), in radians; a trifle where there is none."""
    ahead = np.roll(triangles, -1, axis=1) - triangles
    behind = np.roll(triangles, 1, axis=1) - triangles
    sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.maximum(np.arctan2(sine, np.einsum("ijk,ijk->ij", ahead, behind)), _LEAST)
