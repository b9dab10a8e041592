"""Which faces of a mesh its patches lie in: two coplanar triangles that are one quadrilateral share patches."""

from typing import NamedTuple

import numpy as np

from surflux.meshes.face_colors import without_colors
from surflux.meshes.foreign_meshes import Mesh
from surflux.meshes.seen_textures import SeenTextures

# Heights over the shared edge, 1 at the apex, are rounding below this: far from the origin coordinates have few digits.
_ROUNDING = 1e-6


ARRAYS = ("of", "count", "pair", "pairs", "halves")  # of Faces


class Faces(NamedTuple):
    """Of each surfel the face in which its centre lies, and of patches of two triangles how much lies in each.

    of (n,): the face; on the edge between two of them the first. count: of the mesh's faces.
    pair (n,): which of the pairs a patch is a piece of; -1 of none.
    pairs (p, 2): first and second face; halves (p, 3, 3): the triangle of the first, its corner off the shared edge
    first. NaN where it is not known: then half of each patch lies in either.
    """

    of: np.ndarray
    count: int
    pair: np.ndarray
    pairs: np.ndarray
    halves: np.ndarray
    mesh: Mesh | None = None  # where parts of its faces have colours of their own
    filtered: dict | None = None  # its textures, as SeenTextures has them

    def with_colors(self, mesh):
        """Those of the Mesh, parts of whose faces have colours of their own."""
        return self._replace(mesh=mesh, filtered={})

    @property
    def textures(self):
        """SeenTextures of the mesh, for pictures; None where there are none."""
        return SeenTextures(self.mesh, self.filtered) if self.mesh is not None and self.mesh.textures else None

    def taken(self, rows):
        """Those of chosen surfels."""
        return self._replace(of=self.of[rows], pair=self.pair[rows])

    def divided(self, rows, centers):
        """Those of pieces (m,), by the surfel that each is of and its centre (m, 3)."""
        return self.taken(rows)._located(centers)

    def transformed(self, linear, shift):
        """Those of surfels that went to linear @ p + shift."""
        mesh = self.mesh and self.mesh._replace(vertices=self.mesh.vertices @ linear.T + shift)
        return self._replace(halves=self.halves @ linear.T + shift, mesh=mesh)

    def without_colors(self, of=("reflectance", "emission")):
        """Those of surfels that have got others of these; for files and other processes, of all."""
        mesh = self.mesh and without_colors(self.mesh, of)
        return self._replace(mesh=mesh, filtered=self.filtered if mesh else None)

    def shares(self, surfels):
        """(surfel (m,), face (m,), share (m,)): how much of the area of each surfel, from 0 to 1, lies in which face.

        surfels: these, or what stands for them row by row, with triangles.
        """
        row = np.arange(len(self.of))
        if not (self.pair >= 0).any():
            return row, self.of, np.ones(len(row))
        owner, triangles = surfels.triangle_surfel, surfels.triangles
        some = self.pair[owner] >= 0
        owner, triangles = owner[some], triangles[some]
        a, b, c = triangles.transpose(1, 0, 2)
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        heights = self._heights(triangles.reshape(-1, 3), self.pair[owner].repeat(3)).reshape(-1, 3)
        whole, inside = (np.bincount(owner, w, len(row)) for w in (areas, areas * _share_above(heights)))
        paired = np.flatnonzero((self.pair >= 0) & (whole > 0.0))
        share = inside[paired] / whole[paired]
        single = np.delete(row, paired)
        first, second = self.pairs[self.pair[paired]].T
        return (
            np.concatenate([single, paired, paired]),
            np.concatenate([self.of[single], first, second]),
            np.concatenate([np.ones(len(single)), share, 1.0 - share]),
        )

    def _located(self, centers):
        paired = np.flatnonzero(self.pair >= 0)
        pair = self.pair[paired]
        of = self.of.copy()
        beyond = self._heights(centers[paired], pair) < 0.0
        of[paired] = self.pairs[pair, beyond.astype(int)]
        return self._replace(of=of)

    def _heights(self, points, pair):
        """Of points (m, 3) over the shared edge of pairs (m,): 1 at the apex of the first triangle, below 0 beyond."""
        apex, b, c = self.halves[pair].transpose(1, 0, 2)
        normal = np.cross(c - b, apex - b)
        with np.errstate(invalid="ignore"):
            heights = np.sum(np.cross(c - b, points - b) * normal, axis=1) / np.sum(normal * normal, axis=1)
        return np.where(np.abs(heights) < _ROUNDING, 0.0, heights)


def faces_of_patches(patches, count):
    """Faces of Patches of a mesh that has so many faces."""
    return Faces(patches.faces, count, patches.pair, *patches.pairs)._located(patches.centroids)


def _share_above(heights):
    """(t,) shares of the area of triangles where a linear function is above 0, by its values at the corners (t, 3)."""
    low, middle, high = np.sort(heights, axis=1).T
    with np.errstate(divide="ignore", invalid="ignore"):
        tip = high / (high - low) * (high / (high - middle))  # above: one corner
        foot = low / (low - high) * (low / (low - middle))  # below: one corner
    return np.select([low >= 0.0, high <= 0.0, middle <= 0.0, middle > 0.0], [1.0, 0.0, tip, 1.0 - foot], 0.5)
