"""A dim room beside a bright one, and errors by local light: what an eye sees that has grown used to the dark.

Two rooms, a lamp in one, a door 3 cm ajar (data/door.toml). Errors are those of truth.local_errors, at surfels of the
other room drawn by area.
"""

import sys
from dataclasses import dataclass
from time import process_time

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.solvers import by_scene_surfel
from surflux.bench.truth import even_squares, local_errors, places_on, with_areas

PLACES = 8
WALL = 0.1  # m
DENSITY = 1.0  # patches of 5 cm
MEASURED = 400  # surfels
PATHS = 131_072  # at each of them
SOLVERS = {"`solve`": sf.solve, "`solve_meshless`": sf.solve_meshless}


@dataclass
class Row:
    """One solver; lists have an entry for each seed. Errors are shares of 1."""

    by: str
    surfels: int
    seconds: list  # of the processor, on all cores
    medians: list
    percentiles_90: list
    means: list  # of the light of all measured surfels together


def door_ajar(density=DENSITY):
    """data/door.toml; at density 1 with patches of 5 cm."""
    return scenes.build("door ajar", density).scene


def in_the_dark(scene):
    """Whether each surfel (n,) is in the dim room: not on the wall's or the door's other side, nor beneath them."""
    s = scene.surfels
    leaf = np.repeat(np.arange(len(scene.objects)), [len(o) for o in scene.objects]) == 4
    face = (s.normals[:, 0] > 0.9) & (s.points[:, 0] > WALL - 1e-3)  # of the wall
    return (face | (s.points[:, 0] > WALL + 1e-3)) & ~(leaf & (s.normals[:, 0] < -0.5))


def drawn_in_the_dark(scene, count, seed):
    """Rows (count,) of surfels of the dim room, each with probability proportional to its area."""
    chance = with_areas(scene).areas * in_the_dark(scene)
    return np.random.default_rng(seed).choice(len(chance), count, p=chance / chance.sum())


class Reference:
    """Irradiance (m, 3) of surfels of a scene by path tracing, means over patches, with its standard error."""

    def __init__(self, scene, rows, paths, rounds=8, seed=0, threads=None):
        self.scene, self.rows = scene, rows
        found = []
        for k in range(rounds):
            squares = even_squares(rows, [seed, k], PLACES)
            points, normals = places_on(scene.surfels, np.repeat(rows, PLACES), squares)
            samples = max(16, paths // (rounds * PLACES))
            options = {"samples": samples, "seed": 1000 * seed + k, "threads": threads}
            values, _ = sf.reference_irradiance(scene, points, normals, **options)
            found.append(values.reshape(len(rows), PLACES, 3).mean(axis=1))
        self.mean = np.mean(found, axis=0)
        self.error = np.std(found, axis=0, ddof=1) / np.sqrt(rounds)

    @property
    def noise(self):
        """The standard error of the sum over all surfels, relative to it."""
        return float(np.sqrt((self.error**2).sum()) / self.mean.sum())

    def of(self, solution):
        """What a solution has at these surfels: means, by area, over those inserted below each."""
        return by_scene_surfel(solution, solution.irradiance, len(self.scene.surfels))[self.rows]


def measure(seeds, threads=None):
    """Rows of both solvers."""
    scene = door_ajar(DENSITY)
    print("bench: door ajar, reference", file=sys.stderr)
    reference = Reference(scene, drawn_in_the_dark(scene, MEASURED, 3), PATHS, threads=threads)
    rows = []
    for by, solve in SOLVERS.items():
        row = Row(by, len(scene.surfels), [], [], [], [])
        for seed in range(seeds):
            print(f"bench: door ajar, {by}, seed {seed}", file=sys.stderr)
            begun = process_time()
            solution = solve(door_ajar(DENSITY), seed=seed, threads=threads)
            row.seconds.append(process_time() - begun)
            found = reference.of(solution)
            errors = local_errors(found, reference.mean, reference.error, _rms_of(solution))
            row.medians.append(float(np.median(errors)))
            row.percentiles_90.append(float(np.quantile(errors, 0.9)))
            row.means.append(float(found.sum() / reference.mean.sum() - 1.0))
        rows.append(row)
    return rows


def _rms_of(solution):
    return np.sqrt(np.average((solution.irradiance**2).sum(axis=1), weights=solution.surfels.areas))


def table(rows):
    """Markdown: a line for each solver, in its cells one number for each seed."""
    lines = ["| by | processor seconds | median, % | 90th percentile, % | mean, % |", "|---|---|---|---|---|"]
    for row in rows:
        cells = [" ".join(f"{seconds:.2g}" for seconds in row.seconds)]
        cells += [" ".join(f"{100 * error:.2g}" for error in of) for of in (row.medians, row.percentiles_90)]
        cells += [" ".join(f"{100 * error:+.1f}" for error in row.means)]
        lines.append(f"| {' | '.join([row.by, *cells])} |")
    return "\n".join(lines)
