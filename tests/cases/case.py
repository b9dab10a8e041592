"""What a case is, and how a field of irradiance is held against it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

import surflux as sf

# Gauss and Legendre on the square, mapped to a triangle. Where patches meet at an edge, the factor from one to the
# other is not smooth in the corner: 4 x 4 points are off by 2e-5 there, 8 x 8 by 1e-6.
_AT, _WEIGHT = np.polynomial.legendre.leggauss(8)
_S, _T = (x.ravel() for x in np.meshgrid(0.5 + 0.5 * _AT, 0.5 + 0.5 * _AT, indexing="ij"))
_TRIANGLE = np.stack([1 - _S, _S * (1 - _T), _S * _T], axis=1)
_TRIANGLE_WEIGHT = (np.outer(_WEIGHT, _WEIGHT).ravel() / 4) * 2 * _S


@dataclass(frozen=True)
class Wanted:
    """Irradiance that is known on some surfels of a scene.

    Attributes:
        surfels: slice into scene.surfels.
        irradiance: number or RGB; or a function (points (m, 3), normals (m, 3)) -> (m,) or (m, 3).
        mean: True where only the mean over these surfels, by area, is known; irradiance is then a number.
    """

    surfels: slice
    irradiance: object
    mean: bool = False

    def at(self, points, normals):
        """(m, 3) of points of the surface; of the mean, the mean."""
        value = self.irradiance(points, normals) if callable(self.irradiance) else self.irradiance
        value = np.asarray(value, dtype=float)
        if value.ndim == 1 and len(value) == len(points) and callable(self.irradiance):
            value = value[:, None]
        return np.broadcast_to(value, (len(points), 3))

    def of(self, surfels):
        """(k, 3) for the surfels it is known on: the mean over a patch, the value at a point's place."""
        index = np.arange(len(surfels))[self.surfels]
        out = np.array(self.at(surfels.points[index], surfels.normals[index]))
        if not callable(self.irradiance):
            return out
        keep = np.isin(surfels.triangle_surfel, index)
        if not keep.any():
            return out
        corners, owner = surfels.triangles[keep], surfels.triangle_surfel[keep]
        area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        points = np.einsum("qk,tkd->tqd", _TRIANGLE, corners)
        normals = np.repeat(surfels.normals[owner], len(_TRIANGLE), axis=0)
        values = self.at(points.reshape(-1, 3), normals).reshape(len(corners), len(_TRIANGLE), 3)
        of_triangle = np.einsum("q,tqc->tc", _TRIANGLE_WEIGHT, values)
        sums, total = np.zeros((len(surfels), 3)), np.zeros(len(surfels))
        np.add.at(sums, owner, area[:, None] * of_triangle)
        np.add.at(total, owner, area)
        patches = total[index] > 0
        out[patches] = sums[index][patches] / total[index][patches, None]
        return out


def knobs(rays=64):
    """Knobs by the names that solvers know them by: rays, per surfel, for what is found by chance. 64 where all of it
    is closed and none matter; where light escapes, a share of what they find is an error of its own."""
    return {"rays": rays}


@dataclass(frozen=True)
class Problem:
    """A case at one density.

    Attributes:
        scene: Scene.
        wanted: list of Wanted.
        spacing: h of its surfels in some unit that is the same for all densities; None for surfels^(-1/2).
        quality: knobs that a solver may know by these names; every solver is given them.
    """

    scene: sf.Scene
    wanted: list
    spacing: float | None = None
    quality: dict = field(default_factory=knobs)

    @property
    def h(self):
        return self.spacing or sum(len(s) for s in self.scene.objects) ** -0.5

    @cached_property
    def areas(self):
        """Those given, or those that a solver would compute; (n,)."""
        return np.concatenate([sf.effective_areas(s) if s.areas is None else s.areas for s in self.scene.objects])

    @cached_property
    def expected(self):
        """(k, 3) for each of wanted."""
        surfels = self.scene.surfels
        return [wanted.of(surfels) for wanted in self.wanted]

    def error(self, irradiance):
        """Of a field (n, 3) at scene.surfels: relative RMS by area over all that is known; of means, the largest."""
        squared, size, worst = 0.0, 0.0, 0.0
        for wanted, expected in zip(self.wanted, self.expected, strict=True):
            weight, found = self.areas[wanted.surfels, None], irradiance[wanted.surfels]
            if wanted.mean:
                mean = (weight * found).sum(axis=0) / weight.sum()
                worst = max(worst, np.abs(mean - expected[0]).max() / expected[0].max())
            else:
                squared += (weight * (found - expected) ** 2).sum()
                size += (weight * expected**2).sum()
        return max(worst, np.sqrt(squared / size) if size > 0 else 0.0)

    def reference_points(self, count):
        """Places of surfels where H is known, evenly chosen: points, normals (m, 3) and H (m, 3)."""
        surfels, parts = self.scene.surfels, []
        for wanted in self.wanted:
            if wanted.mean:
                continue
            index = np.arange(len(surfels))[wanted.surfels]
            points, normals = surfels.points[index], surfels.normals[index]
            parts.append((points, normals, wanted.at(points, normals)))
        points, normals, expected = (np.concatenate(part) for part in zip(*parts, strict=True))
        kept = np.unique(np.linspace(0, len(points) - 1, count).round().astype(int))
        return points[kept], normals[kept], expected[kept]


@dataclass(frozen=True)
class Case:
    """A scene whose irradiance is known.

    Attributes:
        name: words, for tables and for the names of tests.
        build: density -> Problem.
        densities: three or more, rising.
        derivation: where the expected value is from; and where the tolerance is looser than theory, why.
        tolerance: largest error at the last density; with a floor, at every density.
        order: least order of the error against h, by least squares over all densities; None where there is a floor.
            Not asked of a solver whose errors are a tenth of the tolerance or less at every density.
        floor: why the error does not fall with h: it is rounding, or the noise of a fixed number of rays.
        factors: largest error, at every density, of solvers of form factors: where they find out by themselves how many
            rays a pair needs, neither the tolerance nor the order of the others says anything of them. None where it
            does.
        off: by how much of it the expected value may be off for the very disks and triangles of the scene at the last
            density, which are all that the path tracer knows. None where these are another geometry altogether, or
            its paths too long to be followed here.
    """

    name: str
    build: Callable
    densities: tuple
    derivation: str
    tolerance: float
    order: float | None = None
    floor: str = ""
    factors: float | None = None
    off: float | None = 0.0

    def __post_init__(self):
        assert len(self.densities) >= 3, self.name
        assert (self.order is None) == bool(self.floor), self.name

    def judged(self, solver):
        """(tolerance, order) that a solver is held to; no order where there is a floor."""
        if solver.factors and self.factors is not None:
            return self.factors, None
        return max(self.tolerance, solver.error_of(self)), self.order


@dataclass(frozen=True)
class Convergence:
    """What a solver made of a case: surfels, spacing and error at each density."""

    surfels: list
    spacings: list
    errors: list

    @property
    def order(self):
        """Slope of log error against log h, by least squares."""
        return np.polyfit(np.log(self.spacings), np.log(np.maximum(self.errors, 1e-300)), 1)[0]


@lru_cache(maxsize=16)
def problem_of(case, density):
    """The case at a density, built once for all solvers."""
    return case.build(density)


def converge(case, solver):
    """Runs a case at all its densities."""
    surfels, spacings, errors = [], [], []
    for density in case.densities:
        problem = problem_of(case, density)
        field_found = solver(problem.scene, **problem.quality)
        surfels.append(len(field_found))
        spacings.append(problem.h)
        errors.append(float(problem.error(field_found)))
    return Convergence(surfels, spacings, errors)
