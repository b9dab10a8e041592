"""The scenes of `surflux bench --transfer`, where their lamps are, and what is wanted of each."""

import os
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.scenes import shapes
from surflux.scenes.transform import make_transform


@dataclass(frozen=True)
class Case:
    """One scene, and the most that fields of its Row may be; of frames the least."""

    build: object  # () -> Scene
    lamps: tuple
    power: float  # W/sr
    wanted: dict
    l07: str
    most_seeds: int | None = None
    options: dict = field(default_factory=dict)  # of precompute_transfer, beside the default ones
    about: str = ""  # what stands behind the name in the guide's table


def _statue(name, rotate=(90, 0, 0), **looks):
    """A scan of 100 000 triangles, y up in the file, as patches."""
    path = Path(os.environ["SURFLUX_DATA"]) / "statues" / f"{name}.ply"
    return make_transform(rotate=rotate).surfels(sf.Surfels.from_mesh(path, **looks))


def buddha():
    return sf.Scene([_statue("buddha_50k", reflectance=0.2, specular=[0.5, 0.42, 0.3], exponent=20.0)])


def dragons(across=6, along=4):
    """24 dragons of 100 000 triangles, each turned and tinted otherwise, in a hall of 12 x 8 x 4 m."""
    rng, bodies = np.random.default_rng(0), []
    for k in range(across * along):
        place = 2 * (k % across) + 1.0, 2 * (k // across) + 1.0, 0.004
        looks = {"reflectance": rng.uniform(0.3, 0.8, 3)}
        dragon = _statue("dragon_50k", (90, 0, float(rng.uniform(0, 360))), **looks)
        bodies.append(make_transform(scale=0.11, translate=place).surfels(dragon))
    size = 2 * across, 2 * along, 4
    vertices, faces, _ = shapes.box(size, [5 * side for side in size], inward=True)
    hall = sf.Surfels.from_mesh((vertices, faces), reflectance=0.7)
    return sf.Scene([hall, *bodies], camera=sf.Camera([6, -6, 3], [6, 4, 1]))


def _scene_file(stem):
    return lambda: sf.load_scene(scenes.data_folder() / f"{stem}.toml")


def grace_probe():
    """Debevec's Grace cathedral as it stands: the file has its rows from below, which no turn would mend unmirrored."""
    image = sf.read_image(Path(os.environ["SURFLUX_DATA"]) / "probes" / "grace_latlong.exr")
    return sf.Environment(image[::-1], azimuth=180)


STATUE_LAMPS = (1.2, 1.0, 2.6), (3.6, 3.2, 1.6), (2.2, 0.6, 2.9)

CASES = {
    "Buddha": Case(
        buddha,
        (),
        0.0,
        {"seconds": 40, "megabytes": 40, "worst": 0.08},
        "498 s, 116 MB",
        about=", glossy, in the Grace probe, two turns",
    ),
    "Sponza": Case(
        _scene_file("sponza"),
        ((0, 0, 2), (-9, 0.2, 3), (8, -4.5, 2), (-6, 4.5, 6), (4, 0, 8)),
        100.0,
        {"seconds": 150, "megabytes": 103, "worst": 0.08, "relight_ms": 20, "bounce_ms": 10, "frames": 10},
        "1892 s, 103 MB, 97 to 139 ms, 7.2 frames/s",
        about=", five lamps",
    ),
    "statue": Case(
        _scene_file("statue"),
        STATUE_LAMPS,
        10.0,
        {"seconds": 40, "worst_of_indirect": 0.05},
        "492 s, 30 MB",
        options={"epsilon_t": 0.1, "rays": 256},
        about=" of 100 000 triangles in a room, three lamps, `epsilon_t=.1, rays=256`",
    ),
    "statue by default": Case(
        _scene_file("statue"),
        STATUE_LAMPS,
        10.0,
        {"seconds": 40},
        "492 s, 30 MB",
    ),
    "dragons": Case(
        dragons,
        ((3.0, 2.0, 3.2), (8.5, 6.0, 2.5)),
        20.0,
        {"seconds": 600, "gigabytes": 4.0},
        "2.3 M triangles: under 30 min (Lehtinen and others 2008)",
        most_seeds=1,
        about=", 24 in a hall, two lamps",
    ),
}
