"""`surflux bench --site FOLDER --only facing`: the share of points whose normals have the right sign, once a cloud is
read and turned to the side it is seen from.

Meshes are sampled, so that their normals are known: they are left out and estimated ("estimated"), given as they are
("given"), turned over whole ("turned over"), or piece by piece at random ("in pieces", the least of SEEDS). Of scans
the truth is their own normals, where they have some, or the side from which they were seen.
"""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.areas import percent
from surflux.scenes import shapes

POINTS = 40_000
SEEDS = 0, 1, 2
PIECES = 40  # Voronoi cells of as many points, half of which are turned over


@dataclass(eq=False)
class Cloud:
    """Points with what is known of their normals: (n, 3) vectors, of which the sign of the product counts."""

    points: np.ndarray
    truth: np.ndarray
    file: Path | None = None  # read as it is, with what it says
    known: bool = True  # truth are unit normals, which can be given, and not only a side


def sampled(name):
    def make(count):
        cloud = sf.Surfels.sample_mesh(_data() / name, count)
        return Cloud(cloud.points, cloud.normals)

    return make


def own_normals(name):
    def make(_):
        scan = sf.read_scan(_data() / name)
        return Cloud(scan.points, scan.normals)

    return make


def towards_the_scanner(name):
    def make(_):
        points = sf.read_scan(_data() / name).points
        return Cloud(points, -points, _data() / name, known=False)

    return make


def upwards(name):
    def make(_):
        points = sf.read_scan(_data() / name).points
        return Cloud(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), _data() / name, known=False)

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
        return Cloud(np.vstack([p.points for p in parts]), np.vstack([p.normals for p in parts]))

    return make


def plate(count):
    """Both sides of a plate, 40 by 30 by 1."""
    vertices, faces, _ = shapes.box(size=[4, 3, 0.1])
    cloud = sf.Surfels.sample_mesh((vertices, faces), count)
    return Cloud(cloud.points, cloud.normals)


def _data():
    return Path(os.environ["SURFLUX_DATA"])


# Name -> (whether it needs scans, count -> Cloud).
CLOUDS = {
    "room with balls in it": (False, room(furnished=True)),
    "empty room": (False, room(furnished=False)),
    "both sides of a plate": (False, plate),
    "bunny": (True, sampled("statues/bunny_34834.ply")),
    "armadillo": (True, sampled("statues/armadillo_43k.ply")),
    "Buddha": (True, sampled("statues/buddha_50k.ply")),
    "dragon": (True, sampled("statues/dragon_50k.ply")),
    "scan of a lion, open below": (True, own_normals("statues/lion_takanawa_342k_surfels.ply")),
    "fragment of a living room": (True, own_normals("scans/redwood_livingroom_fragment.pcd")),
    "airborne LiDAR": (True, upwards("scans/autzen_trim.laz")),
    "depth camera, an office": (True, towards_the_scanner("scans/office1.pcd")),
    "turning scanner, a room": (True, towards_the_scanner("scans/room_scan1.pcd")),
}


def rows(threads=None):
    """For each of CLOUDS the shares that are right, %."""
    found = []
    for name, (needs_scans, make) in CLOUDS.items():
        if needs_scans and not scenes.scans_for(name):
            continue
        cloud = make(POINTS)
        normals = _estimated(cloud)
        signs = np.sign(np.sum(normals * cloud.truth, axis=1))[:, None]
        true = cloud.truth if cloud.known else normals * signs
        pieces = [_pieces(cloud.points, seed) for seed in SEEDS]
        row = {"cloud": name, "points": len(true), "estimated, %": percent(_right(normals, cloud.truth))}
        row["given, %"] = percent(_right_after(cloud, true))
        row["turned over, %"] = percent(_right_after(cloud, -true))
        row["in pieces, %"] = percent(min(_right_after(cloud, np.where(p[:, None], -true, true)) for p in pieces))
        found.append(row)
    return found


def _right(normals, truth):
    return float(np.mean(np.sum(normals * truth, axis=1) > 0.0))


def _right_after(cloud, given):
    """The share that is right of given normals, once they are turned to the side that is seen."""
    turned = sf.facing(cloud.points, given).turned
    return _right(np.where(turned[:, None], -given, given), cloud.truth)


def _pieces(points, seed):
    """Which points are in Voronoi cells that are turned over."""
    rng = np.random.default_rng(seed)
    seeds = points[rng.choice(len(points), PIECES, replace=False)]
    nearest = np.argmin([np.sum((points - s) ** 2, axis=1) for s in seeds], axis=0)
    return rng.permutation(np.arange(PIECES) % 2 == 0)[nearest]


def _estimated(cloud):
    """Normals that reading its file makes."""
    if cloud.file is not None:
        return sf.read(cloud.file).normals
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cloud.npz"
        np.savez(path, points=cloud.points)
        return sf.read(path).normals
