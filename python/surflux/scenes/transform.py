"""Placing things in a scene: stand them up, scale, then rotate about x, y and z, then translate."""

from dataclasses import dataclass

import numpy as np

from surflux._base import check
from surflux.geometry.cores import moved
from surflux.points.surfels import Surfels


@dataclass(frozen=True, eq=False)
class Transform:
    """p -> rotation (scale p) + translation."""

    scale: float
    rotation: np.ndarray
    translation: np.ndarray

    def points(self, points):
        return self.scale * (points @ self.rotation.T) + self.translation

    def surfels(self, s):
        """The surfels moved: normals turn, radii grow with the scale and areas with its square."""
        return Surfels._from_core(moved(s._core, self.scale, self.rotation, self.translation))


def make_transform(scale=1.0, rotate=(0.0, 0.0, 0.0), translate=(0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0)):
    """A Transform from a scale above 0, degrees about x, then y, then z, and a translation.

    up: the direction that becomes z before that, by the shortest turn.
    """
    rotation = turn_to_z(check.direction("up", up))
    for axis, degrees in enumerate(check.positions("rotate", rotate)):
        rotation = _about(axis, degrees) @ rotation
    return Transform(
        check.length("scale", scale),
        rotation,
        check.positions("translate", translate),
    )


def turn_to_z(up):
    """(3, 3) the shortest rotation that takes a unit vector to z; of -z about x."""
    sine = up[0] ** 2 + up[1] ** 2  # squared
    if up[2] < 0.0 and sine == 0.0:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.cross(up, [0.0, 0.0, 1.0])
    cross = np.cross(axis, np.eye(3)).T  # cross @ v = axis x v
    return np.eye(3) + cross + cross @ cross * ((1.0 - up[2]) / sine if up[2] < 0.0 else 1.0 / (1.0 + up[2]))


def _about(axis, degrees):
    # Quarter turns are exact, so that walls stay where they were said to be.
    quarter, rest = divmod(degrees, 90.0)
    angle = np.radians(rest)
    c, s = [(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))][int(quarter) % 2]
    if int(quarter) % 4 >= 2:
        c, s = -c, -s
    if rest == 0.0:
        c, s = round(c), round(s)
    matrix = np.eye(3)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix[a, a], matrix[a, b], matrix[b, a], matrix[b, b] = c, -s, s, c
    return matrix
