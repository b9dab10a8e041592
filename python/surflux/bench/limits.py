"""`surflux bench --site FOLDER --only limits`: how far surflux is off where it is weakest, and with what instead.

Errors of areas are signed: above 0 there is too much. All are means, or RMS, over SEEDS.
"""

import os
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench import clouds, scenes
from surflux.bench.areas import percent
from surflux.scenes import shapes

SEEDS = 0, 1, 2


def rows(threads=None):
    """Rows of all LIMITS that can be measured here: what, where, "error, %", what is better, and "error then, %"."""
    found = []
    for (what, where), (better, measure) in LIMITS.items():
        if measure in NEED_SCANS and not scenes.scans_for(f"{what}, {where},"):
            continue
        errors = np.atleast_1d(measure())
        row = {"what": what, "where": where, "error, %": percent(errors[0]), "better": better}
        found.append(row | {"error then, %": percent(errors[1]) if len(errors) > 1 else None})
    return found


def over_seeds(error):
    """The mean over SEEDS of what a function of a seed gives."""
    return np.mean([error(seed) for seed in SEEDS], axis=0)


def flat(points):
    """Surfels of points (n, 2) in z = 0."""
    return sf.Surfels(np.insert(points, 2, 0.0, axis=1), np.tile([0.0, 0.0, 1.0], (len(points), 1)))


def blue_square():
    def error(seed):
        return [sf.effective_areas(clouds.open_square(n, seed).surfels()).sum() - 1.0 for n in (1000, 4000)]

    return over_seeds(error)


def random_square():
    def error(seed):
        points = np.random.default_rng(seed).uniform(size=(4000, 2))
        return [sf.effective_areas(flat(points[:n])).sum() - 1.0 for n in (1000, 4000)]

    return over_seeds(error)


def grid_square():
    """Points in the middles of n x n cells."""

    def error(n):
        at = (np.arange(n) + 0.5) / n
        return sf.effective_areas(flat(np.stack(np.meshgrid(at, at), -1).reshape(-1, 2))).sum() - 1.0

    return [error(20), error(40)]


def hole_in_a_square(counts=(2000, 8000), radius=0.29):
    """Of the unit square a disk is missing."""

    def error(seed):
        found = []
        for count in counts:
            points = clouds.open_square(count, seed).points[:, :2]
            points = points[np.linalg.norm(points - 0.5, axis=1) > radius]
            found.append(sf.effective_areas(flat(points)).sum() / (1.0 - np.pi * radius**2) - 1.0)
        return found

    return over_seeds(error)


def open_bowls(counts=(1000, 12_000)):
    """What the inside of half a sphere sees of the sky, of which it hides half from itself."""

    def error(seed):
        random = np.random.default_rng(seed)
        found = []
        for count in counts:
            unit = random.normal(size=(count, 3))
            unit /= np.linalg.norm(unit, axis=1, keepdims=True)
            unit[:, 2] = -np.abs(unit[:, 2])
            bowl = sf.Surfels(unit, normals=-unit)
            seen = sf.sky_view_factor(bowl)
            found.append(np.average(seen, weights=sf.effective_areas(bowl)) / 0.5 - 1.0)
        return found

    return over_seeds(error)


def thinned_statue():
    path = Path(os.environ["SURFLUX_DATA"]) / "statues" / "armadillo_43k.ply"
    whole = sf.read(path)
    area = sf.Surfels.from_mesh(path).areas.sum()

    def error(seed):
        return [sf.effective_areas(whole.thinned(n, seed=seed)).sum() / area - 1.0 for n in (3000, 12_000)]

    return over_seeds(error)


def cube_without_normals():
    def error(seed):
        cloud = clouds.cube(400, seed)
        return [sf.effective_areas(s).sum() / cloud.area - 1.0 for s in (sf.Surfels(cloud.points), cloud.surfels())]

    return over_seeds(error)


def noisy_ball(noises=(0.01, 0.003)):
    """What backs of its disks take of what it reflects, as a share of the sky's light that meets it."""

    def error(seed):
        unit = shapes.sphere(4000).points
        random = np.random.default_rng(seed).normal(size=(len(unit), 1))
        return [backs(unit * (1.0 + noise * random), unit, seed) for noise in noises]

    return over_seeds(error)


def backs(points, normals, seed):
    ball = sf.Surfels(points, normals, reflectance=0.5)
    solution = sf.solve(sf.Scene([ball], [sf.Environment(1.0)]), transport="rays", seed=seed)
    last = solution.history[-1]
    return last["power_into_backs"] / last["power_in"]


def small_plates(count=8, lamp=1.0, floor=2.0):
    """Plates a millimetre wide, alone above a floor, under a lamp over a quarter of it, which is too large a part of
    the scene to be aimed at."""
    square = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])

    def placed(side, at, faces, patches, **what):
        return sf.Surfels.from_mesh((side * square + at, faces), (side / patches) ** 2, **what)

    angle = 2.0 * np.pi * np.arange(count) / count
    places = 0.1 * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    shining = placed(lamp, [0, 0, 1.0], [[3, 2, 1, 0]], 10, reflectance=0.0, emission=1.0)
    plates = [placed(1e-3, at, [[0, 1, 2, 3]], 1, reflectance=0.0) for at in places]
    scene = sf.Scene([shining, *plates, placed(floor, [0, 0, -0.01], [[0, 1, 2, 3]], 20, reflectance=0.3)])
    of_plates = slice(len(shining), len(shining) + count)
    true = sf.form_factors(scene)[of_plates, : len(shining)].sum(axis=1)

    def error(seed, transport):
        found = sf.solve(scene, transport=transport, insert=False, seed=seed).irradiance[of_plates, 0]
        return np.mean((found / true - 1.0) ** 2)

    return [np.sqrt(over_seeds(lambda seed, t=t: error(seed, t))) for t in ("rays", "pairs")]


def noise_of_rays(example, **options):
    """Standard deviation of the indirect light over seeds, RMS, as a share of its RMS."""

    def measure():
        scene = example()

        def spread(rays):
            solutions = [
                sf.solve(scene, transport="rays", rays=rays, insert=False, seed=seed, **options) for seed in range(4)
            ]
            light = np.array([solution.irradiance - solution.direct for solution in solutions])
            areas = solutions[0].surfels.areas[:, None]
            return np.sqrt((areas * light.var(axis=0, ddof=1)).sum() / (areas * light.mean(axis=0) ** 2).sum())

        return [spread(256), spread(1024)]

    return measure


def ball_on_patches():
    """The ball of .2 m on patches of .175 m: RMS of its light over path tracing."""
    scene = sf.examples.three_spheres()
    surfels = scene.surfels
    ball = np.flatnonzero(np.linalg.norm(surfels.points - [1.85, 0.95, 0.2], axis=1) < 0.21)
    true, doubt = sf.reference_irradiance(scene, surfels.points[ball], surfels.normals[ball], samples=1024)

    def error(seed, transport):
        found = sf.solve(scene, transport=transport, seed=seed).per_surfel("irradiance")[ball]
        return ((found - true) ** 2 - doubt**2).sum() / (true**2 - doubt**2).sum()

    return [np.sqrt(max(0.0, over_seeds(lambda seed, t=t: error(seed, t)))) for t in ("pairs", "rays")]


def shadow_borders(count=300):
    """Interpolated light within .1 m of the borders of shadows of three spheres under a point light."""
    room = sf.examples.three_spheres()
    scene = sf.Scene(room.objects, [sf.PointLight([1.8, 1.1, 2.5], 10.0)])
    black = scenes.without_light_between(scene)
    random = np.random.default_rng(0)
    at = np.column_stack([random.uniform(0.1, 3.4, (2000, 2)), np.zeros(2000)])
    angle = np.arange(8) * np.pi / 4
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    around = np.concatenate([at[:, None], at[:, None] + 0.05 * ring, at[:, None] + 0.1 * ring], axis=1).reshape(-1, 3)

    def reference(scene, points, samples):
        return sf.reference_irradiance(scene, points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), samples=samples)

    lit = (reference(black, around, 16)[0][:, 0] > 0).reshape(len(at), -1)
    at = at[lit.any(axis=1) & ~lit.all(axis=1)][:count]
    true, doubt = reference(scene, at, 4096)

    def error(seed, insert):
        solution = sf.solve(scene, insert=insert, seed=seed)
        found = solution.irradiance_at(at, np.tile([0.0, 0.0, 1.0], (len(at), 1)), direct="interpolated")
        return ((found - true) ** 2 - doubt**2).sum() / (true**2 - doubt**2).sum()

    return [np.sqrt(over_seeds(lambda seed, i=insert: error(seed, i))) for insert in (False, True)]


def rooms_of_clouds(count=20, gap=1e-3):
    """Light of one closed room of clouds in another, beyond a wall that thick: of what the first has."""

    at = (np.arange(count) + 0.5) / count
    cells = np.stack(np.meshgrid(at, at), -1).reshape(-1, 2)

    def wall(axis, side, x, emission):
        points = np.insert(cells, axis, side, axis=1) + np.array([x, 0.0, 0.0])
        normals = np.tile((1.0 - 2.0 * side) * np.eye(3)[axis], (len(points), 1))
        return sf.Surfels(points, normals, reflectance=0.5, emission=emission)

    def room(x, emission):
        return [wall(axis, side, x, emission) for axis in range(3) for side in (0, 1)]

    scene = sf.Scene([*room(0.0, 1.0), *room(1.0 + gap, 0.0)])
    bright = np.arange(len(scene.surfels)) < 6 * count**2

    def error(seed, transport):
        solution = sf.solve(scene, transport=transport, insert=False, seed=seed)
        light, areas = solution.irradiance[:, 0], solution.surfels.areas
        return np.average(light[~bright], weights=areas[~bright]) / np.average(light[bright], weights=areas[bright])

    return [over_seeds(lambda seed, t=t: error(seed, t)) for t in ("rays", "pairs")]


def heap_of_disks(count=200):
    """Power that is absorbed or escapes, and was not emitted."""

    def error(seed):
        random = np.random.default_rng(seed)
        points, normals = random.uniform(-1.0, 1.0, (count, 3)), random.normal(size=(count, 3))
        heap = sf.Surfels(points, normals, radii=0.3, areas=np.pi * 0.09, reflectance=0.5, emission=1.0)
        last = sf.solve(sf.Scene([heap]), rays=1024, seed=seed, transport="rays").history[-1]
        return -last["power_lost"] / last["power_in"]

    return over_seeds(error)


# (what, where) -> (what is better, measure): shares, then those with what is better.
LIMITS = {
    ("area, open border", "square, 1000 points of blue noise"): ("4000 points", blue_square),
    ("area, open border", "square, 1000 points at random"): ("4000 points", random_square),
    ("area, open border", "square, middles of 20 x 20 cells"): ("40 x 40", grid_square),
    ("area, round hole", "square, 2000 points of blue noise"): ("8000 points", hole_in_a_square),
    ("light, open border", "half a sphere of 1000 points, the sky seen from inside"): ("12 000 points", open_bowls),
    ("area, too few points", "armadillo, 3000 points"): ("12 000 points", thinned_statue),
    ("area, sharp edges", "cube, 2400 points without normals"): ("normals given", cube_without_normals),
    ("light on backs", "ball of 4000 points, noise of 1 % of its radius"): ("noise of .3 %", noisy_ball),
    ("shadows", "within .1 m of their borders, three spheres, nothing inserted"): ("as by default", shadow_borders),
    ("noise", "indirect light of three spheres, 256 rays"): ("1024 rays", noise_of_rays(sf.examples.three_spheres)),
    ("noise", "indirect light of a Cornell box, 256 rays"): ("1024 rays", noise_of_rays(sf.examples.cornell_box)),
    ("noise", "three spheres, 256 rays of every surfel"): (
        "1024 rays",
        noise_of_rays(sf.examples.three_spheres, zeta=1e-9),
    ),
    ("small receivers", "plates under a lamp as large as a quarter of the floor, by rays"): ("pairs", small_plates),
    ("up close", "a ball of .2 m on patches of .175 m, by pairs"): ("rays", ball_on_patches),
    ("walls of points", "two rooms .001 apart: light of one in the other, by rays"): ("pairs", rooms_of_clouds),
    ("heaps", "200 disks across each other: power made, by rays"): ("", heap_of_disks),
}
NEED_SCANS = {thinned_statue}
