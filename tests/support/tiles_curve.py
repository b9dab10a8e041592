"""Error of `solve_tiles` against the untiled solution, with processor seconds and peak memory, over halo and thinning.

`python tests/support/tiles_curve.py town --runs 150:4 50:4` makes towns of three seeds, ground, houses and trees, in
3 x 3 tiles, and solves them by these halos and thinnings; `... tile.laz --cut 2` cuts a file of its own; `... --row`
measures memory of 1, 2, 4 and 8 tiles in a row instead.

Errors are differences from the untiled solution in % of the RMS irradiance: of all points, of those by an inner border
of tiles, and of those inside. Each is solved by two seeds; `chance` is what follows from how these two differ: of tiles
and untiled, half of both squares. `left` is what chance does not explain: of all points, and by borders.
"""

import argparse
import json
import resource
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import laspy
import numpy as np

import surflux as sf
from surflux.bench.scale import peak_gigabytes
from surflux.scenes.studio import clear_day

SIDE, SPACING, LOT = 600.0, 2.2, 30.0  # of a town, of its points, of the square of a house: metres
BORDER = 0.03  # of the side of a tile: points nearer to an inner border than that are by it
CUT, COUNTS, DENSE = 3, (1, 2, 4, 8), 1.2  # in a row: so many tiles, and their spacing
SEEDS = {"untiled": (0, 1), "tiles": (2, 3)}
PARTS = ("all", "border", "inside")


def town(seed, size=(SIDE, SIDE), spacing=SPACING):
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


def lights_of(name):
    """The lights of a run, W/m2."""
    sun = sf.Sky.from_sun(40.0, 150.0, direct_normal=800.0, diffuse=0.0)
    sky = sf.Sky.from_sun(40.0, 150.0, direct_normal=0.0, diffuse=100.0)
    return [{"sun": sun, "sky": sky, "both": clear_day(150.0)}[name]]


def solved(paths, folder, light, options):
    """What _solved says, in a process of its own."""
    with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
        return fresh.submit(_solved, paths, folder, light, options).result()


def _solved(paths, folder, light, options):
    """Processor seconds, peak of memory, the most surfels of a tile, and the largest estimate of one, %."""
    found = sf.solve_tiles(paths, folder, lights=lights_of(light), **options)
    used = resource.getrusage(resource.RUSAGE_SELF)
    most, error = max(tile.surfels for tile in found), max(tile.error for tile in found)
    return {
        "seconds": used.ru_utime + used.ru_stime,
        "gigabytes": peak_gigabytes(),
        "surfels": most,
        "estimate": 100.0 * error,
    }


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
    return np.array([np.mean((a - b)[of] ** 2) / mean for of in (known, known & border, known & ~border)])


def figures(found, untiled, border):
    """What a row says of errors: mean squares by PARTS, and those of chance."""
    chance = 0.5 * (squares(*found, border) + squares(*untiled, border))
    between = np.mean([squares(a, b, border) for a in found for b in untiled], axis=0)
    named = {name: float(value) for name, value in zip(PARTS, between, strict=True)}
    return named | {f"chance, {name}": float(value) for name, value in zip(PARTS, chance, strict=True)}


def curve(path, folder, options, kept):
    """Rows of one survey: the untiled solution, and tiles for each halo and thinning; each by two seeds."""
    points = sf.read_scan(path).points
    paths, rows = cut(path, folder, options.cut, options.cut)
    border, whole, everything = by_borders(points, options.cut, options.cut), [np.arange(len(points))], []

    def both(of, rows, light, seeds, **given):
        outs = [folder / f"{light} {seed} {given}" for seed in seeds]
        more = {"solve_options": {"insert": options.insert}, **given}
        runs = [solved(of, out, light, {"seed": seed} | more) for seed, out in zip(seeds, outs, strict=True)]
        found = [irradiance([out / one.name for one in of], rows, len(points)) for out in outs]
        return {name: float(np.mean([run[name] for run in runs])) for name in runs[0]}, found

    for light in options.lights:
        run, untiled = both([path], whole, light, SEEDS["untiled"])
        mean = {name: float(value) for name, value in zip(PARTS, squares(*untiled, border), strict=True)}
        chance = {f"chance, {name}": value for name, value in mean.items()}
        everything.append(kept({"light": light, "run": "untiled", "points": len(points)} | run | mean | chance))
        for halo, far in (map(float, run.split(":")) for run in options.runs):
            run, found = both(paths, rows, light, SEEDS["tiles"], halo=halo, far=far)
            row = {"light": light, "run": f"halo {halo:g}, far {far:g}", "points": len(points)}
            everything.append(kept(row | run | figures(found, untiled, border)))
    return everything


def row_of_tiles(folder, kept):
    """Rows of memory: towns of one tile's width, and of more in a row."""
    everything = []
    for count in COUNTS:
        path = folder / f"row{count}.laz"
        town(0, (count * SIDE / CUT, SIDE / CUT), DENSE).save(path)
        paths, _ = cut(path, folder, count, 1)
        run = solved(paths, folder / f"of {count}", "both", {"halo": 50.0, "solve_options": {"insert": False}})
        everything.append(kept({"light": "both", "run": f"{count} in a row", "points": len(sf.read_scan(path))} | run))
    return everything


def table(rows):
    """Markdown: means over surveys of what was measured under one name, of squares where they are errors."""
    columns = ("points", "surfels", "seconds", "gigabytes", "estimate")
    squared = (*PARTS, *(f"chance, {name}" for name in PARTS))
    heads = (*columns, *squared, "left, all", "left, border")
    lines = ["| light | run | " + " | ".join(heads) + " |", "|---|---|" + "--:|" * len(heads)]
    for light, run in dict.fromkeys((row["light"], row["run"]) for row in rows):
        same = [row for row in rows if (row["light"], row["run"]) == (light, run)]
        mean = {name: np.mean([row[name] for row in same]) for name in (*columns, *squared) if name in same[0]}
        values = [f"{mean[name]:.3g}" if name in mean else "" for name in columns]
        if PARTS[0] in mean:
            left = [max(0.0, mean[name] - mean[f"chance, {name}"]) for name in PARTS[:2]]
            values += [f"{100.0 * np.sqrt(value):.2f}" for value in [*(mean[name] for name in squared), *left]]
        lines.append(f"| {light} | {run} | " + " | ".join(values) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("survey", nargs="?", default="town", help='"town", or a LAS file')
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="of towns")
    parser.add_argument("--side", type=float, default=SIDE, help="of towns, metres")
    parser.add_argument("--cut", type=int, default=CUT, help="so many tiles a side")
    parser.add_argument("--runs", nargs="+", default=["150:4"], metavar="HALO:FAR")
    parser.add_argument(
        "--insert", action="store_true", help="surfels at the borders of shadows, as solve has by itself"
    )
    parser.add_argument("--lights", nargs="+", default=["both"], choices=("sun", "sky", "both"))
    parser.add_argument("--row", action="store_true", help="memory of tiles in a row instead")
    parser.add_argument("--rows", type=Path, help="JSON lines, to which each run is added; the table has all of them")
    options = parser.parse_args()

    def kept(row):
        print(row, flush=True)
        if options.rows:
            with options.rows.open("a") as file:
                file.write(json.dumps(row) + "\n")
        return row

    rows = []
    for seed in [0] if options.row or options.survey != "town" else options.seeds:
        with tempfile.TemporaryDirectory() as name:
            folder, path = Path(name), Path(options.survey)
            if options.row:
                rows += row_of_tiles(folder, kept)
                continue
            if options.survey == "town":
                path = folder / "town.laz"
                town(seed, (options.side, options.side)).save(path)
            rows += curve(path, folder, options, kept)
    if options.rows:
        rows = [json.loads(line) for line in options.rows.read_text().splitlines()]
    print(table(rows))


if __name__ == "__main__":
    main()
