"""What is seen of textures at places on faces: filtered, as small as a pixel sees them."""

from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux.meshes.face_colors import interpolated

_LARGEST = 1 << 24  # texels of a texture; of larger ones the mean of as many as it takes
_KEPT = 1 << 30  # bytes of filtered textures, beyond which others are filtered anew for each picture
_FARTHEST = 1e9  # as texel_means has it
_BARE = 1e-4  # of what is seen: if less is there, it has no colour of its own
_WHOLE = np.zeros((1, 2)), np.eye(2)[None]


class SeenTextures:
    """The textures of a Mesh."""

    def __init__(self, mesh, filtered):
        """filtered: a dict of _Filtered, by what reads a texture, to keep them."""
        self._mesh = mesh
        self._filtered = filtered

    def on(self, face):
        """(m,) whether faces (m,) have a texture."""
        has = np.zeros(len(self._mesh.offsets) - 1, bool)
        for use in self._mesh.textures:
            has[use.faces] = True
        return has[face]

    def paint(self, face, points, sides, reflectance, emission):
        """Puts into reflectance and emission (m, 3), in place, what textures have at points (m, 3) on faces (m,).

        The mean over the parallelogram of two sides (m, 2, 3) around each. Rows of faces without textures stay.
        """
        corners = np.concatenate([points[:, None], points[:, None] + sides], axis=1)
        for use, some in self._used(face):
            row = np.searchsorted(use.faces, face[some])
            at = interpolated(self._mesh, self._mesh.places, face[some], corners[some])
            at = (at * use.scale + use.shift) * [1.0, -1.0]  # rows go down
            at = np.where(np.abs(at) < _FARTHEST, at, 0.0)
            seen = self._means(use.read, at[:, 0], at[:, 1:] - at[:, :1])
            values = emission if use.shines else reflectance
            values[some] = np.clip(use.tint[row] * seen, 0.0, use.most)

    def _used(self, face):
        """Of each texture that some of the faces (m,) have, its use and which of them, ascending."""
        for shines in (False, True):
            use_of = np.full(len(self._mesh.offsets) - 1, -1)
            for number, use in enumerate(self._mesh.textures):
                if use.shines == shines:
                    use_of[use.faces] = number
            number = use_of[face]
            order = np.argsort(number, kind="stable")
            first = np.searchsorted(number[order], np.arange(len(self._mesh.textures) + 1))
            for use, begin, end in zip(self._mesh.textures, first[:-1], first[1:], strict=True):
                if end > begin:
                    yield use, order[begin:end]

    def _means(self, read, places, sides):
        texture, whole, texels = self._of(read)
        means = texture.means(places, sides)
        if texels is not None:
            size = np.array(texels.shape[1::-1])
            magnified = np.linalg.norm(sides * size, axis=2).max(axis=1) <= 1.0
            column, row = np.floor(places[magnified] * size).astype(np.int64).T
            means[magnified] = texels[row % size[1], column % size[0]]
        if means.shape[1] == 3:
            return means
        there = means[:, 3:]
        return np.where(there < _BARE, whole, means[:, :3] / np.maximum(there, _BARE))

    def _of(self, read):
        """The _Filtered of a texture."""
        found = self._filtered.get(read)
        if found is None:
            texture = read()
            texels = _texels(texture)
            levels = _core.MipMap(texels)
            whole = levels.means(*_WHOLE)[0]
            whole = whole[:3] if len(whole) == 3 else whole[:3] / max(whole[3], _BARE)
            found = _Filtered(levels, whole, texels if texture.nearest else None)
            # Pictures ask for one after the other: were the oldest dropped, none would be there when it is asked for.
            if sum(one.bytes() for one in (found, *self._filtered.values())) <= _KEPT:
                self._filtered[read] = found
        return found


class _Filtered(NamedTuple):
    levels: _core.MipMap
    whole: np.ndarray  # (3,): the mean of all that is there of it
    texels: np.ndarray | None  # where the nearest one is seen

    def bytes(self):
        return self.levels.bytes + (0 if self.texels is None else self.texels.nbytes)


def _texels(texture):
    """(h, w, 3) float32, linear; with a cover (h, w, 4), colours times it, and it."""
    height, width = texture.pixels.shape[:2]
    step = 1
    while (height // step) * (width // step) > _LARGEST:
        step *= 2
    total = 0.0
    rows, columns = (np.arange(size // step) * step for size in (height, width))
    for i in range(step):
        for j in range(step):
            place = (rows + i)[:, None], (columns + j)[None, :]
            channels = [texture.values(*place, c) for c in range(3 if texture.cover is None else 4)]
            total = total + np.stack(channels, axis=-1, dtype=np.float32, casting="same_kind")
    return total / np.float32(step * step)
