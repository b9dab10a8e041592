"""Points that others face so closely that no light comes between: both sides of a sheet, at places of their own."""

import numpy as np

from surflux import _core
from surflux.geometry.cores import disks_among

# A disk that faces another, over the cosine of their normals, and how far above it, over its radius: the two sides of a
# sheet that is bent. Rays begin a little behind, for what lies in one plane lies before or behind by rounding.
_OPPOSITE, _HEIGHT, _BEHIND = -0.9, 0.05, 1e-3
# Of an object's points, by itself, or by another: what stands on a floor, or hangs on a wall, shuts off some, rightly.
_BY_ITSELF, _BY_ANOTHER = 0.05, 0.6
_ASKED = 4096  # at most, of each object
_LEAST = 3


def shut_off(scene):
    """Of objects that have many: [(object, points, the object that faces most of them, or itself)]."""
    owner = np.repeat(np.arange(len(scene.objects)), [len(o) for o in scene.objects])
    all_normals = np.concatenate([o.normals for o in scene.objects])
    found, first = [], 0
    for which, of in enumerate(scene.objects):
        disks = disks_among(of)
        every = -(-len(disks) // _ASKED) if len(disks) else 1
        asked = disks[::every]
        points, normals, radii = of.points[asked], of.normals[asked], of.radii[asked]
        met, _, far = _core.closest_hits(
            scene._to_core(), (first + asked).astype(np.uint32), points - _BEHIND * radii[:, None] * normals, normals
        )
        first += len(of)
        is_near = (met >= 0) & (far < _HEIGHT * radii)
        by, facing = met[is_near], normals[is_near]
        by = owner[by[np.einsum("ij,ij->i", all_normals[by], facing) < _OPPOSITE]]
        for other, count in zip(*np.unique(by, return_counts=True), strict=True):
            least = _BY_ITSELF if other == which else _BY_ANOTHER
            if count >= max(_LEAST, least * len(asked)):
                found.append((which, int(min(len(disks), count * every)), int(other)))
    return found
