"""Where the light of a surfel comes from: rays into the hemisphere over it, added up by groups of what they meet."""

from dataclasses import dataclass

import numpy as np

from surflux import _core
from surflux._base import check
from surflux.drawing.colors import LUMINANCE
from surflux.points.surfels import Surfels
from surflux.scenes.scene import Scene
from surflux.solutions.leaves import inserted_among
from surflux.solutions.rendering import drawn_surfels

RAYS = 4096
_MOST_GROUPS = 1000


@dataclass(frozen=True, eq=False)
class Links:
    """What a surfel receives from other surfels, strongest first.

    Attributes:
        index: of the surfel that receives.
        start: (3,) its place.
        senders: (m,) for each link its strongest surfel.
        ends: (m, 3) the mean of the places that light comes from.
        light: (m, 3) irradiance at the surfel, in W/m2.
        shares: (m,) its luminance over that of all irradiance at the surfel.
        by_object: (k, 3) irradiance from each object.
        escaped: the part of the rays that left the scene.
        into_backs: the part of them that met backs, which are black.
    """

    index: int
    start: np.ndarray
    senders: np.ndarray
    ends: np.ndarray
    light: np.ndarray
    shares: np.ndarray
    by_object: np.ndarray
    escaped: float
    into_backs: float


class LinkFinder:
    """Finds links in a solution: holds the scene to trace in, and the groups, both made when first asked for.

    Rays trace the surfels of the solution as they are drawn, inserted ones with them, so that a solution from a file
    will do. Light is added up by the finest groups of their hierarchy (D04 section 6) that are at most 1000, or by
    surfels where these are.
    """

    def __init__(self, subject):
        self._subject = subject
        self._scene = self._groups = None

    def __call__(self, index, rays=RAYS, seed=0):
        """Links of surfel `index`. Rays start all over a patch, and at the centre of a disk.

        Their standard error is about 1 / sqrt(rays) of the light, less where it comes from all around.
        """
        subject = self._subject
        if subject.solution is None:
            raise ValueError("thing: wanted a Solution, for without light there are no links")
        index = check.count("index", index, 0, len(subject) - 1)
        if self._scene is None:
            self._prepare()
        start, along = self._rays(index, check.count("rays", rays), check.seed("seed", seed))
        met, front, distance = _core.closest_hits(self._scene, np.full(rays, index, np.uint32), start, along)
        lit = np.flatnonzero((met >= 0) & front.astype(bool))
        sender, place = met[lit], start[lit] + distance[lit, None] * along[lit]
        light = subject.solution.radiosity[sender] / rays  # cosine-weighted rays: irradiance is the mean of B
        group, inverse = np.unique(self._groups[sender], return_inverse=True)
        total = _added(light, inverse, len(group))
        weight = light @ LUMINANCE
        strength = np.bincount(inverse, weight, len(group))
        ends = _added(place * weight[:, None], inverse, len(group)) / np.maximum(strength, 1e-300)[:, None]
        best = np.zeros(len(group), np.int64)
        ascending = np.argsort(weight, kind="stable")
        best[inverse[ascending]] = sender[ascending]  # the last one written is the strongest
        order = np.argsort(-strength, kind="stable")
        order = order[strength[order] > 0]
        of_all = subject.solution.irradiance[index] @ LUMINANCE
        return Links(
            index,
            subject.surfels.points[index],
            best[order],
            ends[order],
            total[order],
            strength[order] / of_all if of_all > 0 else np.zeros(len(order)),
            _added(light, subject.objects[sender], int(subject.objects.max()) + 1),
            float(np.mean(met < 0)),
            float(np.mean((met >= 0) & ~front.astype(bool))),
        )

    def _prepare(self):
        subject = self._subject
        drawn = Surfels._from_core(drawn_surfels(subject.solution))
        if len(drawn) <= _MOST_GROUPS:
            self._groups = np.arange(len(drawn))
        else:
            tree = subject.tree()
            fitting = [level for level, count in zip(tree.levels, tree.counts, strict=True) if count <= _MOST_GROUPS]
            self._groups = fitting[0] if fitting else tree.levels[-1]
        parts = [drawn[subject.objects == k] for k in np.unique(subject.objects)]
        # In one scene surfels go object by object.
        self._place = np.concatenate([np.flatnonzero(subject.objects == k) for k in np.unique(subject.objects)])
        if not np.array_equal(self._place, np.arange(len(drawn))):
            raise ValueError("objects: wanted the surfels of one object after those of another")
        own = subject.scene
        # With inserted surfels the leaves are another scene than was solved.
        self._scene = (
            Scene(parts) if own is None or inserted_among(subject.solution.parents).any() else own
        )._to_core()

    def _rays(self, index, count, seed):
        """Starts and directions, cosine-weighted, of a shifted lattice (Roberts' R2 and R4)."""
        s = self._subject.surfels
        rng = np.random.default_rng(seed)
        base = 1.1673039782614187 if np.any(s.triangle_surfel == index) else 1.324717957244746
        steps = base ** -np.arange(1.0, 5.0) if base < 1.2 else base ** -np.arange(1.0, 3.0)
        x = (rng.random(len(steps)) + np.arange(1, count + 1)[:, None] * steps) % 1.0
        n = s.normals[index]
        u = np.cross(n, [1.0, 0.0, 0.0] if abs(n[0]) < 0.6 else [0.0, 1.0, 0.0])
        u /= np.linalg.norm(u)
        angle, radius = 2 * np.pi * x[:, 0], np.sqrt(x[:, 1])
        height = np.sqrt(1 - x[:, 1])
        along = radius[:, None] * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * np.cross(n, u))
        along += height[:, None] * n
        mine = s.triangles[s.triangle_surfel == index]
        if not len(mine):
            return np.tile(s.points[index], (count, 1)), along
        a, b, c = mine[:, 0], mine[:, 1], mine[:, 2]
        sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1).cumsum()
        which = np.minimum(np.searchsorted(sizes, x[:, 2] * sizes[-1], side="right"), len(mine) - 1)
        before = np.where(which > 0, sizes[which - 1], 0.0)
        p, q = np.sqrt((x[:, 2] * sizes[-1] - before) / (sizes[which] - before)), x[:, 3]
        p, q = p[:, None], q[:, None]
        return (1 - p) * a[which] + p * ((1 - q) * b[which] + q * c[which]), along


def _added(values, place, count):
    return np.stack([np.bincount(place, column, count) for column in values.T], axis=1)
