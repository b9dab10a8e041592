"""The share of points whose normals have the right sign, once a cloud is read and turned to the side it is seen from.

`python tests/support/facing.py [NAME ...] [--points N] [--seeds N]`. Meshes are sampled, so that their normals are
known: they are left out and estimated (row "estimated"), given as they are ("given"), turned over whole ("turned"),
or piece by piece at random ("pieces"). Of scans the truth is their own normals, where they have some, or the side from
which they were seen.
"""

import argparse
import os
import sys
import tempfile
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
import surflux as sf
from surflux.scenes import shapes

PIECES = 40  # Voronoi cells of as many points, half of which are turned over
DATA = Path(os.environ["SURFLUX_DATA"])


@dataclass
class Case:
    """Points with what is known of their normals: (n, 3) vectors, of which the sign of the product counts."""

    points: np.ndarray
    truth: np.ndarray
    file: Path | None = None  # read as it is, with what it says
    known: bool = True  # truth are unit normals, which can be given, and not only a side


def sampled(name):
    def make(count):
        cloud = sf.Surfels.sample_mesh(DATA / name, count)
        return Case(cloud.points, cloud.normals)

    return make


def own_normals(name):
    def make(_):
        scan = sf.read_scan(DATA / name)
        return Case(scan.points, scan.normals)

    return make


def towards(name, place=(0.0, 0.0, 0.0)):
    def make(_):
        points = sf.read_scan(DATA / name).points
        return Case(points, np.asarray(place) - points, DATA / name, known=False)

    return make


def upwards(name):
    def make(_):
        points = sf.read_scan(DATA / name).points
        return Case(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), DATA / name, known=False)

    return make


def room(furnished):
    """A closed room, with three balls in the air or nothing in it."""

    def make(count):
        vertices, faces, _ = shapes.box(size=[5, 4, 3], inward=True)
        parts = [sf.Surfels.sample_mesh((vertices, faces), count)]
        if furnished:
            for x in (1.0, 2.5, 4.0):
                ball = shapes.sphere(count // 20)
                parts.append(sf.Surfels(0.5 * ball.points + [x, 2.0, 1.0], ball.normals))
        return Case(np.vstack([p.points for p in parts]), np.vstack([p.normals for p in parts]))

    return make


def plate(count):
    """Both sides of a plate, 40 by 30 by 1."""
    vertices, faces, _ = shapes.box(size=[4, 3, 0.1])
    cloud = sf.Surfels.sample_mesh((vertices, faces), count)
    return Case(cloud.points, cloud.normals)


CASES = {
    "bunny": sampled("statues/bunny_34834.ply"),
    "armadillo": sampled("statues/armadillo_43k.ply"),
    "buddha": sampled("statues/buddha_50k.ply"),
    "dragon": sampled("statues/dragon_50k.ply"),
    "sofa": sampled("hard/sofa.ply"),
    "sponza": sampled("scenes/crytek_sponza.ply"),
    "room": room(furnished=True),
    "empty room": room(furnished=False),
    "plate": plate,
    "lion": own_normals("statues/lion_takanawa_342k_surfels.ply"),
    "redwood": own_normals("scans/redwood_livingroom_fragment.pcd"),
    "autzen": upwards("scans/autzen_trim.laz"),
    "simple": upwards("scans/simple.las"),
    "office": towards("scans/office1.pcd"),
    "floor": towards("scans/region_growing_rgb_tutorial.pcd"),
    "mug": towards("scans/table_scene_mug_stereo_textured.pcd"),
    "milk": towards("scans/milk_color.pcd"),
    "rops": towards("hard/rops_cloud.pcd"),
    "corridor": towards("scans/region_growing_tutorial.pcd"),
    "lidar room": towards("scans/room_scan1.pcd"),
}


def right(normals, truth):
    return float(np.mean(np.sum(normals * truth, axis=1) > 0.0))


def pieces(points, seed):
    """Which points are in Voronoi cells that are turned over."""
    rng = np.random.default_rng(seed)
    seeds = points[rng.choice(len(points), PIECES, replace=False)]
    nearest = np.argmin([np.sum((points - s) ** 2, axis=1) for s in seeds], axis=0)
    return rng.permutation(np.arange(PIECES) % 2 == 0)[nearest]


def faced(points, normals):
    began = time.perf_counter()
    turned = sf.facing(points, normals).turned
    return np.where(turned[:, None], -normals, normals), time.perf_counter() - began


def read(case):
    with tempfile.TemporaryDirectory() as folder:
        path = case.file
        if path is None:
            path = Path(folder) / "cloud.npz"
            np.savez(path, points=case.points)
        began = time.perf_counter()
        normals = sf.read(path).normals
        return normals, time.perf_counter() - began


def rows(name, case, seeds):
    """(what, share right, seconds) of each row."""
    normals, seconds = read(case)
    yield "estimated", right(normals, case.truth), seconds
    truth = case.truth if case.known else normals * np.sign(np.sum(normals * case.truth, axis=1))[:, None]
    for what, turned in [("given", np.zeros(len(truth), bool)), ("turned", np.ones(len(truth), bool))] + [
        (f"pieces {seed}", pieces(case.points, seed)) for seed in range(seeds)
    ]:
        given = np.where(turned[:, None], -truth, truth)
        after, seconds = faced(case.points, given)
        yield what, right(after, case.truth), seconds


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*")
    parser.add_argument("--points", type=int, default=60_000)
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    for name in options.names or CASES:
        case = CASES[name](options.points)
        print(f"{name}: {len(case.points)} points", flush=True)
        for what, share, seconds in rows(name, case, options.seeds):
            print(f"  {what:<12} {100 * share:7.2f} %  {seconds:6.2f} s", flush=True)


if __name__ == "__main__":
    main()
