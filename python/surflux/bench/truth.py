"""What the irradiance of surfels ought to be: a closed form, or path tracing with its standard error.

A surfel that is a patch of a mesh stands for the patch: its truth is the mean over it, from places spread evenly
over its triangles. One that is a disk stands for a point of a surface that nobody knows: its truth is the irradiance
at its centre. Surfels are drawn with probability proportional to their areas, so that means over them are area means.
"""

import numpy as np

import surflux as sf
from surflux.bench.scenes import without_light_between

PATHS_A_PLACE = 64
PLACES = 16
# Paths of one surfel in one round; the mean of a round is one independent estimate.
PATHS_A_ROUND = PATHS_A_PLACE * PLACES
LEAST_ROUNDS = 4
LEAST_PATHS = 16  # that reference_irradiance takes


class Truth:
    """Irradiance of area-sampled surfels.

    With direct_places, direct light, which changes abruptly on a patch, comes from that many places on it for each
    round instead of PLACES; paths that end at the first surface are cheap.

    Attributes:
        index: (m,) rows of the surfels, some perhaps more than once.
        total, indirect: (m, 3) irradiance, and the part that comes from surfels.
        total_error, indirect_error: (m, 3) standard errors; 0 for a closed form.
        rounds, paths: traced so far; paths without those of direct_places.
    """

    def __init__(self, scene, surfels, count, *, exact=None, seed=0, direct_places=0, threads=None, state=None):
        self.scene, self.surfels, self.seed, self.threads = scene, surfels, seed, threads
        self.index = area_sample(surfels.areas, count, seed) if state is None else state["index"]
        self.paths = self.rounds = 0
        self._sums = np.zeros((4, count, 3))  # of total and of indirect, and of their squares
        self._dark = without_light_between(scene) if scene.lights else None
        self._direct_places = direct_places
        self._exact = None if exact is None else exact[self.index]
        if state is not None:
            self._sums, self.rounds, self.paths = state["sums"].copy(), int(state["rounds"]), int(state["paths"])
        while self.rounds < LEAST_ROUNDS and self._exact is None:
            self.refine()

    @property
    def state(self):
        """What has been traced, for another Truth of the same surfels to go on from."""
        return {"index": self.index, "sums": self._sums, "rounds": self.rounds, "paths": self.paths}

    def refine(self):
        """Another round of paths for each surfel; nothing to do for a closed form."""
        if self._exact is not None:
            return
        places, normals = self._places(PLACES, [self.seed, self.rounds])

        def traced(scene, places, normals, samples, seed):
            found, _ = sf.reference_irradiance(scene, places, normals, samples=samples, seed=seed, threads=self.threads)
            return found.reshape(len(self.index), -1, 3).mean(axis=1)

        seed = 1000 * self.seed + self.rounds
        total = indirect = traced(self.scene, places, normals, PATHS_A_PLACE, seed)
        if self._dark is not None:
            # The same seed draws the same first rays: what lights bring cancels path by path.
            indirect = total - traced(self._dark, places, normals, PATHS_A_PLACE, seed)
            if self._direct_places:
                more = self._places(self._direct_places, [self.seed, self.rounds, 1])
                total = indirect + traced(self._dark, *more, LEAST_PATHS, seed + 500)
        for k, values in enumerate((total, indirect, total**2, indirect**2)):
            self._sums[k] += values
        self.rounds += 1
        self.paths += len(places) * PATHS_A_PLACE

    def _places(self, count, seed):
        """Where paths start: count places and normals for each row."""
        return places_on(self.surfels, np.repeat(self.index, count), even_squares(self.index, seed, count))

    @property
    def total(self):
        return self._exact if self._exact is not None else self._sums[0] / self.rounds

    @property
    def indirect(self):
        return self._exact if self._exact is not None else self._sums[1] / self.rounds

    @property
    def total_error(self):
        return self._standard_error(0)

    @property
    def indirect_error(self):
        return self._standard_error(1)

    def _standard_error(self, k):
        if self._exact is not None:
            return np.zeros_like(self._exact)
        mean = self._sums[k] / self.rounds
        return np.sqrt(np.maximum(0.0, self._sums[k + 2] / self.rounds - mean**2) / (self.rounds - 1))


class PointTruth(Truth):
    """Irradiance at random points of the surface: each on one of the area-sampled surfels, anywhere on its patch, or
    its centre where it is a disk.

    Attributes, beside Truth's:
        points, normals: (m, 3).
    """

    def __init__(self, scene, surfels, count, *, seed=0, threads=None, state=None):
        rows = area_sample(surfels.areas, count, seed) if state is None else state["index"]
        squares = np.random.default_rng([seed, count]).random((count, 2))
        self.points, self.normals = places_on(surfels, rows, squares)
        super().__init__(scene, surfels, count, seed=seed, threads=threads, state=state)

    def _places(self, count, seed):
        return np.repeat(self.points, count, axis=0), np.repeat(self.normals, count, axis=0)


def area_sample(areas, count, seed=0):
    """Rows (count,), each with probability proportional to its area; spread evenly over the list."""
    up_to = np.cumsum(areas)
    at = (np.arange(count) + np.random.default_rng(seed).random()) * (up_to[-1] / count)
    return np.minimum(np.searchsorted(up_to, at, side="right"), len(areas) - 1)


def even_squares(rows, seed, count=PLACES):
    """count points (len(rows) * count, 2) of the unit square for each row, even by the R2 sequence (Roberts 2018).

    Each row's are moved by a random vector of its own.
    """
    sequence = np.arange(count)[:, None] * [0.7548776662466927, 0.5698402909980532]
    moved = sequence + np.random.default_rng(seed).random((len(rows), 1, 2))
    return (moved % 1.0).reshape(-1, 2)


def places_on(surfels, rows, squares):
    """A place and normal for each row: on its triangles, by area, where it has some, else its centre.

    squares: (len(rows), 2), points of the unit square that choose the place.
    """
    points, normals = surfels.points[rows].copy(), surfels.normals[rows]
    owner, corners = surfels.triangle_surfel, surfels.triangles
    if not len(owner):
        return points, normals
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    up_to = np.concatenate([[0.0], np.cumsum(area)])
    first, last = np.searchsorted(owner, rows, side="left"), np.searchsorted(owner, rows, side="right")
    of_patch = first < last
    low, high = up_to[first[of_patch]], up_to[last[of_patch]]
    x, y = squares[of_patch].T
    chosen = low + x * (high - low)
    triangle = np.clip(np.searchsorted(up_to, chosen, side="right") - 1, first[of_patch], last[of_patch] - 1)
    u = np.clip((chosen - up_to[triangle]) / area[triangle], 0.0, 1.0)
    # The unit square onto the triangle, by area: strips parallel to the side b c.
    u, v = np.sqrt(u)[:, None], y[:, None]
    a, b, c = np.moveaxis(corners[triangle], 1, 0)
    points[of_patch] = a + u * (1.0 - v) * (b - a) + u * v * (c - a)
    return points, normals


def errors_against(truth, total, indirect):
    """The errors of irradiance at the surfels of a Truth: total and indirect (m, 3), indirect perhaps None.

    Returns a dict. "error" and "indirect": sqrt(sum A |H - Href|^2 / sum A |Href|^2) with the squares of the standard
    errors taken off; "uncertainty": the standard error of "error" from the choice of surfels; "percentile_99": of
    |H - Href| / |Href| at single surfels, where those darker than a hundredth of the RMS count as that bright;
    "reference": the standard error of the reference, as an RMS and relative, and "reference_indirect".
    """
    found = {}
    for name, value, true, spread in (
        ("error", total, truth.total, truth.total_error),
        ("indirect", indirect, truth.indirect, truth.indirect_error),
    ):
        noise = (spread**2).sum(axis=1)
        bright = np.mean((true**2).sum(axis=1) - noise)
        reference = float(np.sqrt(noise.mean() / bright))
        found["reference" if name == "error" else "reference_indirect"] = reference
        if value is None:
            found[name] = None
            continue
        off = ((value - true) ** 2).sum(axis=1)
        square = np.mean(off - noise) / bright
        found[name] = float(np.sqrt(max(0.0, square)))
        floor = 0.01 * np.sqrt(bright)
        single = np.sqrt(np.maximum(0.0, off - noise)) / np.maximum(np.linalg.norm(true, axis=1), floor)
        found["percentile_99" if name == "error" else "percentile_99_indirect"] = float(np.quantile(single, 0.99))
        if name == "error":
            doubt = np.std(off - noise, ddof=1) / np.sqrt(len(off)) / bright
            found["uncertainty"] = float(doubt / (2.0 * max(found[name], np.sqrt(doubt), np.finfo(float).tiny)))
    return found


def local_errors(found, true, noise, rms, dimmest=1e-3):
    """|H - Href| / |Href| (k,) of the surfels where |Href| is above that share of the RMS of H.

    The square of the reference's standard error is taken off.
    """
    bright = np.linalg.norm(true, axis=1)
    known = bright > dimmest * rms
    off = ((found - true) ** 2 - noise**2).sum(axis=1)
    return np.sqrt(np.maximum(0.0, off[known])) / bright[known]


def local_errors_against(truth, total):
    """Errors of irradiance by the light that is there, as an eye sees that has grown used to the dark (local_errors).

    Returns a dict: "local", the median, "local_90", the 90th percentile, and "reference_local", that of the standard
    errors of the reference.
    """
    true, noise = truth.total, truth.total_error
    rms = np.sqrt(np.mean((true**2 - noise**2).sum(axis=1)))
    single = local_errors(total, true, noise, rms)
    return {
        "local": float(np.median(single)),
        "local_90": float(np.quantile(single, 0.9)),
        "reference_local": float(np.quantile(local_errors(true + noise, true, 0.0, rms), 0.9)),
    }


def with_areas(scene):
    """scene.surfels, with the areas that solve would compute."""
    surfels = scene.surfels
    if surfels.areas is None:
        areas = [sf.effective_areas(s) if s.areas is None else s.areas for s in scene.objects]
        surfels.areas = np.concatenate(areas)
    return surfels
