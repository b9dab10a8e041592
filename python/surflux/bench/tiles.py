"""`surflux bench --site FOLDER --only tiles` and `--only tile_memory`: errors of `solve_tiles` against the untiled
solution, by halo, and peak memory of tiles in a row.

A made town, ground, houses and trees, is cut into CUT x CUT tiles. Errors are differences from the untiled solution,
in % of the RMS irradiance, of all points and of those by an inner border of tiles. Each is solved by two seeds: chance
is what follows from how these two differ, of tiles and untiled half of both squares, and left what it does not explain.
Needs laspy.
"""

import tempfile
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench.areas import percent
from surflux.bench.scale import in_fresh_process, peak_gigabytes
from surflux.scenes.studio import clear_day

SIDE, SPACING, LOT = 360.0, 2.2, 30.0  # of a town, of its points, of the square of a house: metres
BORDER = 0.03  # of the side of a tile: points nearer to an inner border than that are by it
CUT = 3  # tiles a side
HALOS = 20.0, 50.0, 150.0  # metres; 150 is the default
COUNTS, DENSE = (2, 4, 8), 0.7  # in a row: so many tiles, and the spacing of their points
SEEDS = {"untiled": (0, 1), "tiles": (2, 3)}
PARTS = ("all", "border")


def town(seed, size, spacing=SPACING):
    """A Scan of rolling ground with a house or trees on most lots, as airborne LiDAR has it: few points on walls."""
    random = np.random.default_rng(seed)
    size, area = np.asarray(size), float(np.prod(size))
    xy = random.uniform(0.0, size, (int(area / spacing**2), 2))
    points = np.column_stack([xy, _ground(xy)])
    colors = np.tile([0.25, 0.35, 0.15], (len(xy), 1))
    parts = []
    for corner in np.stack(np.meshgrid(*(np.arange(0.0, side, LOT) for side in size)), -1).reshape(-1, 2):
        kind, middle = random.random(), corner + random.uniform(0.4, 0.6, 2) * LOT
        if kind < 0.6:
            half, height = random.uniform([5.0, 4.0], [10.0, 8.0]), random.uniform(4.0, 15.0)
            points, colors, house = _house(random, points, colors, middle, half, height, spacing)
            parts.append(house)
        elif kind < 0.9:
            parts += [_tree(random, middle + random.uniform(-9.0, 9.0, 2), spacing) for _ in range(4)]
    points = np.concatenate([points, *(part[0] for part in parts)])
    colors = np.concatenate([colors, *(part[1] for part in parts)])
    points[:, 2] += random.normal(0.0, 0.03, len(points))
    mixed = random.permutation(len(points))
    return sf.Scan(points[mixed], reflectance=colors[mixed])


def _ground(xy):
    return 4.0 * np.sin(xy[:, 0] / 70.0) * np.cos(xy[:, 1] / 90.0)


def _house(random, points, colors, middle, half, height, spacing):
    """(points and colours with the ground under a gabled roof lifted up to it; the points of its walls)."""
    base = float(_ground(middle[None])[0])
    at = points[:, :2] - middle
    under = np.all(np.abs(at) < half, axis=1)
    points[under, 2] = base + height + 0.5 * (half[1] - np.abs(at[under, 1]))
    colors[under] = random.choice([[0.5, 0.2, 0.15], [0.35, 0.35, 0.35], [0.6, 0.55, 0.5]])
    count = int(0.15 * 4.0 * half.sum() * height / spacing**2)  # seen at a slant
    along, side = random.uniform(-1.0, 1.0, count), random.integers(0, 4, count)
    sign = np.where(side % 2, 1.0, -1.0)
    place = np.where((side < 2)[:, None], np.column_stack([along, sign]), np.column_stack([sign, along]))
    walls = np.column_stack([middle + place * half, base + random.uniform(0.0, height, count)])
    return points, colors, (walls, np.tile([0.7, 0.68, 0.6], (count, 1)))


def _tree(random, middle, spacing):
    """The upper half of a crown."""
    radius, height = random.uniform(2.0, 4.0), random.uniform(6.0, 14.0)
    direction = random.normal(size=(int(2.0 * np.pi * radius**2 / spacing**2), 3))
    direction *= np.sign(direction[:, 2:]) / np.linalg.norm(direction, axis=1)[:, None]
    crown = [*middle, _ground(middle[None])[0] + height] + direction * [radius, radius, 1.3 * radius]
    return crown, np.tile([0.12, 0.25, 0.08], (len(crown), 1))


def cut(path, folder, columns, rows):
    """(paths of the tiles of a file, columns x rows of them, from the lower left; the rows of each)."""
    import laspy

    las = laspy.read(path)
    xy = np.column_stack([las.x, las.y])
    cells = np.array([columns, rows])
    cell = np.clip(np.floor((xy - xy.min(axis=0)) / np.ptp(xy, axis=0) * cells), 0, cells - 1).astype(int)
    paths, of = [], []
    for k in range(columns * rows):
        of.append(np.flatnonzero(cell[:, 1] * columns + cell[:, 0] == k))
        tile = laspy.LasData(las.header)
        tile.points = las.points[of[-1]]
        paths.append(folder / f"tile{k}.laz")
        tile.write(paths[-1])
    return paths, of


def solved(paths, folder, options):
    """Peak of memory of a process that solves them under a clear day's sun and sky, gigabytes."""
    sf.solve_tiles(paths, folder, lights=[clear_day(150.0)], solve_options={"insert": False}, **options)
    return peak_gigabytes()


def irradiance(paths, rows, count):
    """(n, 3) of the outputs of tiles, in the order of the whole."""
    found = np.empty((count, 3))
    for path, of in zip(paths, rows, strict=True):
        columns = sf.read_scan(path).attributes
        found[of] = np.stack([columns[f"irradiance_{c}"] for c in "rgb"], axis=-1)
    return found


def by_borders(points, columns, rows):
    """Which points are by a border between tiles."""
    low, size = points[:, :2].min(axis=0), np.ptp(points[:, :2], axis=0)
    cells = np.array([columns, rows])
    at = (points[:, :2] - low) / size * cells
    nearest = np.round(at)
    return np.any((np.abs(at - nearest) < BORDER) & (nearest > 0) & (nearest < cells), axis=1)


def squares(a, b, border):
    """Mean squares of how two solutions differ, of PARTS, in those of the second."""
    known = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
    mean = np.mean(b[known] ** 2)
    return np.array([np.mean((a - b)[of] ** 2) / mean for of in (known, known & border)])


def rows(threads=None):
    """The untiled town, and tiles for each of HALOS: peak memory, errors and chance, %."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        town(0, (SIDE, SIDE)).save(folder / "town.laz")
        points = sf.read_scan(folder / "town.laz").points
        paths, of = cut(folder / "town.laz", folder, CUT, CUT)
        border = by_borders(points, CUT, CUT)

        def both(paths, of, seeds, **options):
            outs = [folder / f"{len(paths)} {seed} {options}" for seed in seeds]
            peaks = [
                in_fresh_process(solved, paths, out, {"seed": seed, "threads": threads, **options})
                for seed, out in zip(seeds, outs, strict=True)
            ]
            return np.mean(peaks), [irradiance([out / p.name for p in paths], of, len(points)) for out in outs]

        peak, whole = both([folder / "town.laz"], [np.arange(len(points))], SEEDS["untiled"])
        found = [_row("untiled", len(points), peak, None, squares(*whole, border))]
        for halo in HALOS:
            peak, tiled = both(paths, of, SEEDS["tiles"], halo=halo)
            error = np.mean([squares(a, b, border) for a in tiled for b in whole], axis=0)
            chance = 0.5 * (squares(*tiled, border) + squares(*whole, border))
            found.append(_row(f"halo {halo:g} m", len(points), peak, error, chance))
    return found


def _row(run, points, peak, error, chance):
    row = {"run": run, "points": points, "GB": float(f"{peak:.2g}")}
    left = None if error is None else np.maximum(0.0, error - chance)
    for name, values in (("error", error), ("chance", chance), ("left", left)):
        roots = [None] * len(PARTS) if values is None else [percent(root) for root in np.sqrt(values)]
        row |= {f"{name}, %": roots[0], f"{name} by borders, %": roots[1]}
    return row


def memory(threads=None):
    """Peak memory of COUNTS tiles in a row, each of a town as wide as a tile."""
    found = []
    for count in COUNTS:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            town(0, (count * SIDE / CUT, SIDE / CUT), DENSE).save(folder / "row.laz")
            paths, of = cut(folder / "row.laz", folder, count, 1)
            peak = in_fresh_process(solved, paths, folder / "lit", {"halo": 50.0, "threads": threads})
        found.append({"tiles in a row": count, "points": sum(map(len, of)), "GB": float(f"{peak:.2g}")})
    return found
