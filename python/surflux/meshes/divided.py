"""Patches of several meshes, cut where faces of one stand on those of another."""

import numpy as np

from surflux import _core
from surflux._base.passes import stage
from surflux.geometry.cores import gloss_at, make_core
from surflux.meshes.patches import assemble_patches

# Faces that stand close together cut a patch one after the other: what is between them is a small part of the patch,
# but a large one of the piece.
PASSES = 4


def cut_at_walls(cores):
    """For each of _core.Surfels None, or (core, of): it with cut patches, and for each surfel the one that it is of."""
    found = [None] * len(cores)
    for _ in range(PASSES):
        again = _cut_once([core if cut is None else cut[0] for core, cut in zip(cores, found, strict=True)])
        if not any(again):
            break
        found = [
            before if now is None else now if before is None else (now[0], before[1][now[1]])
            for before, now in zip(found, again, strict=True)
        ]
    return found


def _cut_once(cores):
    if sum(len(core.triangles) > 0 for core in cores) < 2:
        return [None] * len(cores)
    outlines = [_outlines(core) for core in cores]
    first = np.cumsum([0, *(len(core) for core in cores)])
    corners = np.concatenate([c.reshape(-1, 3) for rings in outlines for _, c in rings])
    counts = np.concatenate([np.full(len(c), c.shape[1]) for rings in outlines for _, c in rings])
    surfel = np.concatenate([first[k] + patch for k, rings in enumerate(outlines) for patch, _ in rings])
    walls = np.concatenate([core.triangles.reshape(-1, 3) for core in cores])
    pieces, begin, source = _core.divide_patches(
        corners, np.append(0, np.cumsum(counts)), walls, np.arange(0, len(walls) + 1, 3), stage("walls")
    )
    source = surfel[source]
    object_of = np.searchsorted(first, source, side="right") - 1
    found = [None] * len(cores)
    for k in np.unique(object_of):
        mine = np.flatnonzero(object_of == k)
        rings = [
            (source[mine][size == n] - first[k], pieces[begin[mine][size == n, None] + np.arange(n)])
            for size in [np.diff(begin)[mine]]
            for n in np.unique(size)
        ]
        found[k] = _with_pieces(cores[k], rings)
    return found


def _outlines(core):
    """Patches as rings of one length together: (patch (m,), corners (m, k, 3)). Those that are no fans are left out."""
    owner = core.triangle_surfel
    patch, begin, count = np.unique(owner, return_index=True, return_counts=True)
    rings = []
    for k in np.unique(count):
        of_k = count == k
        fan = core.triangles[begin[of_k, None] + np.arange(k)]  # (m, k, 3, 3)
        # Those that were turned round begin at their last corner, or go the other way.
        rolled = (fan[:, :, 0] != fan[:, :1, 0]).any(axis=(1, 2))
        fan[rolled] = fan[rolled][:, :, [2, 0, 1]]
        backward = (fan[:, :-1, 1] == fan[:, 1:, 2]).all(axis=(1, 2)) & (k > 1)
        fan[backward] = fan[backward][:, ::-1]
        is_fan = (fan[:, :, 0] == fan[:, :1, 0]).all(axis=(1, 2)) & (fan[:, :-1, 2] == fan[:, 1:, 1]).all(axis=(1, 2))
        rings.append((patch[of_k][is_fan], np.concatenate([fan[:, 0, :2], fan[:, :, 2]], axis=1)[is_fan]))
    return rings


def _with_pieces(core, rings):
    pieces = assemble_patches(rings)
    whole = np.ones(len(core), bool)
    whole[pieces.faces] = False
    kept = np.flatnonzero(whole)
    of = np.concatenate([kept, pieces.faces])
    order = np.argsort(of, kind="stable")
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    # Each has its share of what its patch had.
    sums = np.bincount(pieces.faces, pieces.areas, len(core))
    areas = None
    if core.areas is not None:
        areas = np.concatenate([core.areas[kept], core.areas[pieces.faces] * pieces.areas / sums[pieces.faces]])[order]
    new_place = np.full(len(core), -1)
    new_place[kept] = np.arange(len(kept))
    stays = whole[core.triangle_surfel]
    owner = np.concatenate([new_place[core.triangle_surfel[stays]], len(kept) + pieces.triangle_patch])
    triangles = np.concatenate([core.triangles[stays], pieces.triangles])
    by_owner = np.argsort(place[owner], kind="stable")
    of = of[order]
    cut = make_core(
        np.concatenate([core.positions[kept], pieces.centroids])[order],
        core.normals[of],
        np.concatenate([core.radii[kept], pieces.radii])[order],
        areas,
        core.reflectance[of],
        core.emission[of],
        triangles[by_owner],
        place[owner][by_owner].astype(np.uint32),
        **gloss_at(core, of),
    )
    return cut, of
