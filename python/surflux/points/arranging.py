"""Surfels made of Surfels: methods that turn them round, move or thin them or change materials; putting together."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage, watched
from surflux._base.types import Progress, SomeSurfels
from surflux.geometry.areas import surface_area
from surflux.geometry.cores import gloss_at, make_core, moved, replaced
from surflux.geometry.estimates import estimated_radii
from surflux.geometry.gloss import NO_GLOSS, gloss_arrays, require_energy
from surflux.meshes.divided import cut_at_walls
from surflux.meshes.mesh_surfels import with_colors_of_pieces

_ASLANT = np.array([0.577, 0.618, 0.533])  # to no usual normal at right angles


def flipped(self: SomeSurfels, mask: ArrayLike | None = None) -> SomeSurfels:
    """All surfels, with those of a boolean mask (n,) facing the other way; their triangles turn with them.

    For the inward patches of a scan: `s.flipped(sf.inward_patches(s) > 0)`. Without a mask all of them turn.

    Raises:
        ValueError: not a mask of that shape.

    >>> import surflux as sf
    >>> sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.5).flipped().normals
    array([[-0., -0., -1.]])
    """
    mask = np.ones(len(self), bool) if mask is None else np.asarray(mask)
    if mask.dtype != bool or mask.shape != (len(self),):
        raise ValueError(f"mask: wanted booleans of shape ({len(self)},), got {mask.dtype} of shape {mask.shape}")
    normals = np.where(mask[:, None], -self.normals, self.normals)
    of_turned = mask[self.triangle_surfel]
    triangles = np.where(of_turned[:, None, None], self.triangles[:, ::-1], self.triangles)
    return self._from_core(replaced(self._core, normals=normals, triangles=triangles), self._faces)


def with_other_sides(s):
    """All surfels, then a copy of each that faces the other way."""
    faces = None if s._faces is None else s._faces.taken(np.tile(np.arange(len(s)), 2))
    return s._from_core(s._core.two_sided(), faces)


def replace(
    self: SomeSurfels,
    *,
    radii: ArrayLike | None = None,
    areas: ArrayLike | None = None,
    reflectance: ArrayLike | None = None,
    emission: ArrayLike | None = None,
    specular: ArrayLike | None = None,
    exponent: ArrayLike | None = None,
) -> SomeSurfels:
    """The same surfels with other radii, areas or materials, as Surfels takes them; None keeps them.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> s = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, 1]], radii=0.6)
    >>> s.replace(reflectance=[0.8, 0.4, 0.4]).reflectance
    array([[0.8, 0.4, 0.4],
           [0.8, 0.4, 0.4]])
    """
    n, given = len(self), {}
    if radii is not None:
        given["radii"] = check.per_surfel("radii", radii, n, low_open=True)
    if areas is not None:
        given["areas"] = check.per_surfel("areas", areas, n)
    if reflectance is not None:
        given["reflectance"] = check.per_surfel_rgb("reflectance", reflectance, n, high=1.0, high_open=True)
    if emission is not None:
        given["emission"] = check.per_surfel_rgb("emission", emission, n)
    core = self._core
    if specular is not None or exponent is not None:
        specular = core.specular if specular is None else specular
        given |= gloss_arrays(specular, core.exponent if exponent is None else exponent, n) or NO_GLOSS
    if core.has_specular or "specular" in given:
        gloss = {"specular": given.get("specular", core.specular)}
        require_energy(given.get("reflectance", core.reflectance), gloss if gloss["specular"] is not None else {})
    faces = self._faces
    if faces is not None:
        colors = ("reflectance", "emission")
        faces = faces.without_colors(
            [n for n in colors if n in given and not np.array_equal(given[n], getattr(core, n))]
        )
    return self._from_core(replaced(self._core, **given), faces)


def transformed(self: SomeSurfels, matrix: ArrayLike) -> SomeSurfels:
    """The surfels by p -> A p + t: normals turn, radii grow with the scale, areas with its square.

    Args:
        matrix: (4, 4), [[A, t], [0, 1]], where A turns, mirrors and scales alike along all axes: under any other
            disks would not stay round.

    Raises:
        ValueError: another shape, or an A that shears or scales by different factors.

    >>> import surflux as sf
    >>> s = sf.Surfels([[1, 0, 0]], [[1, 0, 0]], radii=0.5)
    >>> moved = s.transformed([[0, -2, 0, 0], [2, 0, 0, 0], [0, 0, 2, 3], [0, 0, 0, 1]])
    >>> moved.points, moved.normals, moved.radii
    (array([[0., 2., 3.]]), array([[0., 1., 0.]]), array([1.]))
    """
    matrix = check.finite_array("matrix", matrix, (4, 4))
    linear = matrix[:3, :3]
    scale = float(np.cbrt(abs(np.linalg.det(linear))))
    if not np.array_equal(matrix[3], [0, 0, 0, 1]):
        raise ValueError(f"matrix: wanted a last row of 0, 0, 0, 1, got {matrix[3]}")
    if scale == 0.0 or not np.allclose(linear.T @ linear, scale**2 * np.eye(3), rtol=0.0, atol=1e-6 * scale**2):
        raise ValueError("matrix: wanted one that turns, mirrors and scales alike along all axes")
    faces = None if self._faces is None else self._faces.transformed(linear, matrix[:3, 3])
    return self._from_core(moved(self._core, scale, linear / scale, matrix[:3, 3]), faces)


def thinned(
    self: SomeSurfels, n: int, seed: int = 0, *, threads: int | None = None, progress: Progress = False
) -> SomeSurfels:
    """A blue-noise subset of n surfels, by weighted sample elimination (Yuksel 2015).

    Positions, normals and materials are kept; areas are left open. Radii are estimated anew, but where
    a surfel stands alone (outliers of a scan survive any thinning) its disk grows no further than it was, or
    than four times the packing radius sqrt(area / (2 sqrt(3) n)) of that blue noise (1.6 of them are usual).
    Patches of a mesh lose their triangles and become disks. The two sides of a sheet (`two_sided`) stay together.

    Args:
        n: number of surfels to keep, from 2 to len(self); where all have two sides and it is odd, one less is kept.
        seed: the same seed gives the same subset.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Raises:
        ValueError: n out of range; areas that are 0 of all surfels.
        Cancelled: the callback returned False.
    """
    return thinned_with_rows(self, n, seed, threads=threads, progress=progress)[0]


def thinned_with_rows(self, n, seed=0, *, threads=None, progress=False):
    """What thinned gives, and the rows of self that were kept, ascending."""
    n = check.count("n", n, 2, 2**63 - 1)
    seed = check.seed("seed", seed)
    if n > len(self):
        raise ValueError(f"n: {only_so_many(len(self), n)}")
    with watched(threads, progress):
        area, back_of = surface_area(self), _backs(self.points, self.normals)
        kept = np.arange(n) if n == len(self) else _thinned_rows(self.points, back_of, n, area, seed)
        largest = np.maximum(self.radii[kept], 4.0 * np.sqrt(area / (2.0 * np.sqrt(3.0) * n)))
        of = np.arange(len(self))
        of[back_of[back_of >= 0]] = np.flatnonzero(back_of >= 0)  # of the back of a sheet its front, else itself
        fronts, of = np.unique(of[kept], return_inverse=True)
        points, normals = (np.ascontiguousarray(values[fronts]) for values in (self.points, self.normals))
        radii = largest  # of the two sides of one point, which has no neighbours
        if len(fronts) > 1:
            radii = np.minimum(estimated_radii(points, normals)[of], largest)
        points, normals = (np.ascontiguousarray(values[kept]) for values in (self.points, self.normals))
    gloss = gloss_at(self._core, kept)
    core = make_core(points, normals, radii, None, self.reflectance[kept], self.emission[kept], **gloss)
    return self._from_core(core), kept


def _backs(points, normals):
    """(n,): for the first side of each two-sided sheet the row of the other, at its place; -1 for all others."""
    back_of = np.full(len(points), -1)
    rows = _sharing(points)
    if len(rows) == 0:
        return back_of
    points, normals = points[rows], normals[rows]
    side = np.where(normals @ _ASLANT > 0.0, 1.0, -1.0)
    _, sheet = np.unique(np.hstack([points, side[:, None] * normals]), axis=0, return_inverse=True)
    sheet = sheet.ravel()
    # The k-th of one side of a sheet belongs to the k-th of the other.
    front, back = (np.flatnonzero(side == of) for of in (1.0, -1.0))
    keys = (sheet[of] * len(points) + _numbered(sheet[of]) for of in (front, back))
    _, of_front, of_back = np.intersect1d(*keys, assume_unique=True, return_indices=True)
    back_of[rows[front[of_front]]] = rows[back[of_back]]
    return back_of


def _sharing(points):
    """Rows, ascending, of points whose place others have, too; and hardly any more."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64)  # -0 is 0
    mixed = (bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)).sum(axis=1)
    ordered = np.sort(mixed)
    return np.flatnonzero(np.isin(mixed, ordered[1:][ordered[1:] == ordered[:-1]]))


def _numbered(values):
    """Of each of some values, how many before it are the same."""
    order = np.argsort(values, kind="stable")
    run = np.flatnonzero(np.diff(values[order], prepend=-1))
    out = np.empty(len(values), np.int64)
    out[order] = np.arange(len(values)) - np.repeat(run, np.diff(run, append=len(values)))
    return out


def _thinned_rows(points, back_of, n, area, seed):
    """Rows, ascending, by sample elimination: of sheets with both sides, and of all else, as much as there is of it."""
    fronts = np.flatnonzero(back_of >= 0)
    alone = np.setdiff1d(np.arange(len(points)), np.concatenate([fronts, back_of[fronts]]))
    of_fronts = min(len(fronts), round(n * len(fronts) / len(points)), n // 2)
    parts = []
    for rows, wanted in ((fronts, of_fronts), (alone, min(n - 2 * of_fronts, len(alone)))):
        kept = rows[:wanted]
        if 2 <= wanted < len(rows):
            share = area * len(rows) / len(points)
            own = np.ascontiguousarray(points[rows])
            kept = rows[_core.eliminate_samples(own, wanted, share, seed, progress=stage("samples"))]
        parts.append(kept)
    return np.sort(np.concatenate([*parts, back_of[parts[0]]]))


def concatenate(surfels: list[SomeSurfels] | tuple[SomeSurfels, ...]) -> SomeSurfels:
    """One Surfels of several, one after another; its areas are those given, None where they are open for any of them.

    Faces of meshes and their textures do not go with them: objects of a Scene keep theirs.

    Args:
        surfels: list of Surfels, at least one.

    Raises:
        ValueError: not such a list.

    >>> import surflux as sf
    >>> s = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=0.5, areas=1.0)
    >>> sf.concatenate([s, s, s])
    Surfels(3 surfels, area 3)
    """
    if not isinstance(surfels, (list, tuple)) or not surfels:
        raise ValueError("surfels: wanted a list of at least one Surfels")
    cores = [check.surfels("surfels", s)._core for s in surfels]
    cores = [core for core in cores if len(core)] or cores[:1]
    if any(core.areas is None for core in cores):
        cores = [core.with_areas(np.zeros(0)) for core in cores]
    return surfels[0]._from_core(_core.Scene(cores, []).surfels if len(cores) > 1 else cores[0])


def divide_patches(
    objects: list[SomeSurfels] | tuple[SomeSurfels, ...], *, threads: int | None = None, progress: Progress = False
) -> list[SomeSurfels]:
    """Surfels of several objects, their patches cut where faces of another object stand on them.

    A patch has one value. With both sides of a wall in it, each side has light of the other: beneath a wall light leaks
    into the dark, and a dark rim runs around a box in the sun. Surfels.from_mesh cuts the patches of one mesh so;
    scene files are cut as they are loaded. Pieces have what of a texture, or of colours of vertices, is there.

    Args:
        objects: list of Surfels.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        list of Surfels: those that nothing stands on as they are, others with more patches and the same area in all.

    Raises:
        ValueError: not such a list; a piece whose reflectance and specular are 1 or more together.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]], [[0, 1, 2, 3]]))
    >>> wall = sf.Surfels.from_mesh(([[1, 0, 0], [1, 3, 0], [1, 3, 2], [1, 0, 2]], [[0, 1, 2, 3]]))
    >>> floor, wall = sf.divide_patches([floor, wall])
    >>> floor.areas
    array([3., 9.])
    """
    if not isinstance(objects, (list, tuple)) or not objects:
        got = "an empty one" if isinstance(objects, (list, tuple)) else type(objects).__name__
        hint = "; a Scene has one, its objects" if got == "Scene" else ""
        raise ValueError(f"objects: wanted a list of at least one Surfels, got {got}{hint}")
    cores = [check.surfels("objects", s)._core for s in objects]
    with watched(threads, progress):
        found = cut_at_walls(cores)
    return [s if cut is None else _cut(s, *cut) for s, cut in zip(objects, found, strict=True)]


def _cut(s, core, of):
    if s._faces is None:
        return s._from_core(core)
    faces = s._faces.divided(of, core.positions)
    return s._from_core(with_colors_of_pieces(core, of, faces), faces)


def only_so_many(there, n):
    """Why n surfels cannot be kept of those that are there."""
    verb = "is" if there == 1 else "are"
    return f"wanted at most {there}, for there {verb} only {check.counted(there, 'surfel')}; got {n}"
