"""What patches of the sky and the ground bring to surfels straight away, by shadow rays from each."""

import numpy as np

from surflux import _core

RAYS = 577  # of a surfel over the sky, at least
_AT_ONCE = 2**14  # surfels, whose coefficients are found together


class SkyRays:
    """Rays from all surfels into every patch, of which it keeps a bit each: any sky is then a product.

    lines: SightLines; patches: SkyPatches.
    """

    def __init__(self, lines, patches, seed):
        self._core = _core.PatchRays(patches._core, -(-RAYS // (len(patches) - 1)), seed)
        self._normals = lines.normals
        self._free = lines.free(self._core.directions, "sky")

    def coefficients(self, surfels):
        """(m, patches) irradiance of surfels (m,), or a slice, by each patch where its radiance is 1."""
        return np.asarray(self._core.coefficients(self._normals[surfels], self._free[surfels]))

    def irradiance(self, radiances):
        """(n, k) of all surfels, under k skies (patches, k)."""
        out = np.empty((len(self._normals), radiances.shape[1]))
        for first in range(0, len(out), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            out[some] = self.coefficients(some) @ radiances
        return out
