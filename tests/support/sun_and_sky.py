"""Seconds, memory and errors of `sky_view_factor` and `solar_irradiation` on an aerial LiDAR tile of any size.

    python tests/support/sun_and_sky.py view 1e6 --rays 64 128 256 512
    python tests/support/sun_and_sky.py year 5e5 --seeds 3

The tile is scans/autzen_trim.laz of SURFLUX_DATA, 110 000 points, mirrored side by side until there are as many as
wanted, in metres. `view` compares with 4096 other rays at some of the points. `year` compares the sums of all hours
with path tracing under the sum of all their skies and suns, as one image.
"""

import argparse
import os
import resource
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

import surflux as sf
from surflux.bench import sky
from surflux.scenes.sky import _dome
from surflux.solving.sky_view import SightLines

PLACE, YEAR = (44.05, -123.07), 2025  # where the tile is
FEET = 0.3048
SKY_ROWS, FINER = 128, 4  # of the image, and of the suns in it for each
HOURS_AT_ONCE = 256


def tile(count):
    """Surfels of the first `count` points along x of so many copies of the tile."""
    one = sf.read(Path(os.environ["SURFLUX_DATA"]) / "scans" / "autzen_trim.laz")
    points, normals = FEET * (one.points - one.points.min(axis=0)), one.normals
    size = points.max(axis=0)
    rows = 1 if count <= len(one) else 2
    parts = []
    for column in range(-(-count // (rows * len(one)))):
        for row in range(rows):
            turn = np.array([1.0 - 2.0 * (column % 2), 1.0 - 2.0 * (row % 2), 1.0])
            shift = np.array([(column + column % 2) * size[0], (row + row % 2) * size[1], 0.0])
            parts.append((points * turn + shift, normals * turn, one.reflectance))
    points, normals, reflectance = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    chosen = np.sort(np.argsort(points[:, 0], kind="stable")[:count])
    return sf.Surfels(points[chosen], normals[chosen], reflectance=reflectance[chosen])


def measured(work):
    """(what work gives, text: seconds and memory)."""
    start, busy = perf_counter(), process_time()
    found = work()
    seconds, busy = perf_counter() - start, process_time() - busy
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    return found, f"{seconds:.1f} s ({busy:.1f} s of processors), {peak:.2f} GB at most so far"


def view(options):
    surfels = tile(options.points)
    scene = sf.Scene([surfels])
    lines, told = measured(lambda: SightLines(scene))
    print(f"{len(surfels)} surfels; areas and ends of disks: {told}")
    _, told = measured(lambda: lines.free(np.array([[0.0, 0.0, 1.0]]), ""))
    print(f"tracer, and the zenith alone: {told}")
    true = {weighting: sky.compared(scene, options.compared, weighting) for weighting in options.weightings}
    for rays in options.rays:
        for weighting, (some, right) in true.items():
            errors = []
            for seed in range(options.seeds):
                found, told = measured(lambda w=weighting, r=rays, s=seed: sf.sky_view_factor(scene, w, rays=r, seed=s))
                errors.append(np.sqrt(np.mean((found[some] - right) ** 2)))
            each = ", ".join(f"{100.0 * e:.2f}" for e in errors)
            relative = 100.0 * np.mean(errors) / np.sqrt(np.mean(right**2))
            print(f"{weighting}, {rays} rays: RMSE {each} % of the whole sky, {relative:.2f} % of the RMS; {told}")


def year_image(found):
    """(rows, columns, 3) kWh/m2 sr of all hours: what an Environment takes."""
    skies, scale = found._found.skies, found._found.hours / 1000.0
    places, level = _dome(SKY_ROWS)
    upper = np.zeros(places.shape[:2])
    bright = np.flatnonzero(skies.diffuse > 0.0)
    for first in range(0, len(bright), HOURS_AT_ONCE):
        some = skies.of(bright[first : first + HOURS_AT_ONCE])
        relative = some.relative(places.reshape(-1, 3)).reshape(-1, *places.shape[:2])
        upper += np.tensordot(some.diffuse / (relative.sum(axis=2) @ level), relative, axes=1)
    image = np.full((SKY_ROWS, 2 * SKY_ROWS), skies.ground.sum())
    image[: SKY_ROWS // 2] = upper
    image = scale * np.repeat(np.repeat(image, FINER, axis=0), FINER, axis=1)
    paths = found._rays[0]
    power = (paths.shares * (skies.beams * scale)[:, None]).ravel()
    x, y, z = paths.suns.reshape(-1, 3)[power > 0.0].T
    height = len(image)
    row = np.minimum((np.arccos(z) / np.pi * height).astype(int), height // 2 - 1)
    column = (np.arctan2(y, -x) % (2.0 * np.pi) / np.pi * height).astype(int) % (2 * height)
    angle = np.pi / height * (np.cos(np.pi * row / height) - np.cos(np.pi * (row + 1) / height))
    np.add.at(image, (row, column), power[power > 0.0] / angle)
    return np.repeat(image[..., None], 3, axis=2)


def year(options):
    surfels = tile(options.points)
    scene = sf.Scene([surfels])
    true = None
    for seed in range(options.seeds):
        found, told = measured(lambda s=seed: sf.solar_irradiation(scene, PLACE, YEAR, bounces=2, seed=s))
        stages = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in found.timings.items())
        print(f"{found}\nseed {seed}: {told}; {stages}")
        if true is None:
            chosen = np.sort(np.random.default_rng(0).choice(len(surfels), options.compared, replace=False))
            lit = sf.Scene([surfels], lights=[sf.Environment(year_image(found))])
            values = sf.reference_irradiance(lit, surfels.points[chosen], surfels.normals[chosen], options.samples)
            true, error = (value.mean(axis=1) for value in values)
            of_truth = np.sqrt(np.mean(error**2) / np.mean(true**2))
        off = found.total[chosen] - true
        rms = np.sqrt(np.mean(off**2) / np.mean(true**2))
        print(
            f"at {len(chosen)} points: RMS {100.0 * rms:.2f} % (path tracing {100.0 * of_truth:.2f} %),"
            f" mean {100.0 * off.mean() / true.mean():+.2f} %"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    for name, run, compared in (("view", view, 2000), ("year", year, 50)):
        command = commands.add_parser(name)
        command.set_defaults(run=run)
        command.add_argument("points", type=lambda text: int(float(text)))
        command.add_argument("--seeds", type=int, default=3)
        command.add_argument("--compared", type=int, default=compared, help="points")
        if name == "view":
            command.add_argument("--rays", type=int, nargs="+", default=[256])
            command.add_argument("--weightings", nargs="+", default=["cosine"])
        else:
            command.add_argument("--samples", type=int, default=16384, help="paths of a point of the reference")
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
