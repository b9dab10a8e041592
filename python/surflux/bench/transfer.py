"""`surflux bench --transfer`: precomputed light transport, each scene in a process of its own.

Seconds of precompute_transfer with the scene compiled in them, bytes of the operator, memory at its peak, errors beside
path tracing, milliseconds of a relighting and frames a second. Lamps are at places where none was before. The limits
are those that surflux set itself beside Lehtinen and others 2007 (L07), table 2, on two cores of 2007.

Errors are RMS over the surface (of the Buddha, over the picture), without the variance of the path tracer: of indirect
irradiance, relative to the RMS of all irradiance and to its own.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.pictures import unproject
from surflux.bench.scale import peak_gigabytes
from surflux.bench.truth import Truth
from surflux.scenes import shapes
from surflux.scenes.transform import make_transform

MEASURED = 800  # surfels, drawn by area
ROUNDS = 4  # of the reference
PIXELS = 3000  # of a picture
PATHS = 1024  # of each
RELIT = 9  # times that seconds are medians of
FRAMES, SIZE = 12, (960, 720)

BUDDHA_SIZE, BUDDHA_CAMERA = (172, 400), sf.Camera([0, -6, 0.3], [-0.05, -0.08, 0], fov=20.5)
AZIMUTHS = (0, 180)
DRAGONS = (6, 4)  # of 100 000 triangles each, in rows


@dataclass(frozen=True)
class Target:
    """What a scene has to reach, and where L07 was; None for what neither says."""

    seconds: float
    megabytes: float | None  # of the operator
    gigabytes: float | None  # at its peak
    error: float  # of all irradiance, or of the picture
    relight_ms: float | None = None
    bounce_ms: float | None = None
    frames: float | None = None
    l07: str = ""


TARGETS = {
    "Buddha": Target(40, 40, None, 0.08, l07="498 s, 116 MB"),
    "Sponza": Target(150, 103, None, 0.08, 20, 10, 10, l07="1892 s, 103 MB, 97 to 139 ms, 7.2 frames/s (GPU)"),
    "statue": Target(40, None, None, 0.05, l07="492 s, 30 MB"),
    "dragons": Target(600, None, 4.0, 0.08, l07="2.3 M triangles: under 30 min (Lehtinen and others 2008)"),
}
LAMPS = {
    "Sponza": [(0, 0, 2), (-9, 0.2, 3), (8, -4.5, 2), (-6, 4.5, 6), (4, 0, 8)],
    "statue": [(1.2, 1.0, 2.6), (3.6, 3.2, 1.6), (2.2, 0.6, 2.9)],
    "dragons": [(3.0, 2.0, 3.2), (8.5, 6.0, 2.5)],
}


@dataclass
class Row:
    """One scene. Errors are [least, most] over lamps or turns and seeds; `of_indirect` is None of pictures."""

    scene: str
    surfels: int
    receivers: int
    links: int
    seconds: list = field(default_factory=list)  # of each seed
    megabytes: float = 0.0
    gigabytes: float | None = None
    error: tuple = ()
    of_indirect: tuple | None = None
    relight_ms: float | None = None
    bounce_ms: float | None = None
    frames: float | None = None

    @property
    def passes(self):
        return not self.missed()

    def missed(self):
        """Names of what is beyond the scene's Target."""
        target, out = TARGETS[self.scene], []
        found = asdict(self) | {"seconds": max(self.seconds), "error": self.error[1]}
        for name, most in asdict(target).items():
            value = found.get(name)
            if name == "l07" or most is None or value is None:
                continue
            if value < most if name == "frames" else value > most:
                out.append(name)
        return out


def measure(names, repeats, threads):
    """Rows of the scenes; `repeats`: seeds of each but the dragons, which have one."""
    rows = []
    for name in names:
        if not os.environ.get("SURFLUX_DATA"):
            print(f"bench: {name} left out: {scenes.NO_SCANS}", file=sys.stderr)
            continue
        print(f"bench: {name}", file=sys.stderr)
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            run = of_buddha if name == "Buddha" else of_lamps
            rows.append(fresh.submit(run, name, 1 if name == "dragons" else repeats, threads).result())
    return rows


def of_lamps(name, seeds, threads):
    """The Row of a scene under lamps."""
    scene, power = BUILDERS[name]()
    lamps = [sf.PointLight(place, power) for place in LAMPS[name]]
    row, truths, errors = None, None, []
    for seed in range(seeds):
        start = perf_counter()
        transfer = sf.precompute_transfer(sf.Scene(scene.objects, camera=scene.camera), seed=seed, threads=threads)
        seconds = perf_counter() - start
        if row is None:
            row = _row(name, transfer, peak_gigabytes())
            surfels = transfer.relight([]).surfels
            truths = [_truth(scene, lamp, surfels, threads) for lamp in lamps]
            row.relight_ms, row.bounce_ms = _relighting(transfer, lamps, threads)
            row.frames = _frames(transfer, lamps, threads) if TARGETS[name].frames else None
        row.seconds.append(seconds)
        for lamp, truth in zip(lamps, truths, strict=True):
            found = transfer.indirect(lamp, bounces=20, threads=threads)  # as many as paths have
            errors.append(errors_of(found, truth))
    least, most = np.min(errors, axis=0), np.max(errors, axis=0)
    row.error, row.of_indirect = (float(least[0]), float(most[0])), (float(least[1]), float(most[1]))
    return row


def errors_of(found, truth):
    """Of indirect irradiance, relative to (all, its own) RMS, without the variance of the truth."""
    noise = _squared(truth.indirect_error)
    off = max(0.0, _squared(found[truth.index] - truth.indirect) - noise)
    return np.sqrt(off / _squared(truth.total)), np.sqrt(off / (_squared(truth.indirect) - noise))


def of_buddha(name, seeds, threads):
    """The Row of a glossy Buddha in the Grace probe, from pictures beside path traced ones of the same light."""
    data = Path(os.environ["SURFLUX_DATA"])
    bronze = {"specular": [0.5, 0.42, 0.3], "exponent": 20.0}
    body = sf.Surfels.from_mesh(data / "statues" / "buddha_50k.ply", reflectance=0.2, **bronze)
    body = make_transform(rotate=[90, 0, 0]).surfels(body)  # y is up in the file
    probe = sf.Environment(data / "probes" / "grace_latlong.exr", up=(0, 0, -1))
    row, truths, errors = None, {}, []
    for seed in range(seeds):
        start = perf_counter()
        transfer = sf.precompute_transfer(sf.Scene([body]), "distant", seed=seed, threads=threads)
        seconds = perf_counter() - start
        row = row or _row(name, transfer, peak_gigabytes())
        row.seconds.append(seconds)
        for azimuth in AZIMUTHS:
            rotation = make_transform(rotate=[0, 0, azimuth]).rotation
            solution = transfer.relight(probe, rotation=rotation, threads=threads)
            drawn = solution.render(
                BUDDHA_CAMERA, BUDDHA_SIZE, samples=1, layers=["radiance", "normal", "depth", "index"]
            )
            if azimuth not in truths:
                light = sf.Environment.from_harmonics(sf.rotate_harmonics(probe.harmonics(5), rotation))
                truths[azimuth] = _traced_gloss(sf.Scene([body], lights=[light]), drawn, threads)
            at, radiance, error = truths[azimuth]
            noise = _squared(error)
            off = max(0.0, _squared(drawn["radiance"][at] - radiance) - noise)
            errors.append(np.sqrt(off / (_squared(radiance) - noise)))
    row.relight_ms = 1e3 * _median(lambda: transfer.relight(probe, threads=threads), 3)
    row.error = float(min(errors)), float(max(errors))
    return row


def _traced_gloss(scene, drawn, threads):
    """(pixels, radiance, standard error) of pixels drawn at random, at the places that their middles see."""
    rows, columns = np.nonzero(drawn["index"] >= 0)
    chosen = np.random.default_rng(0).choice(len(rows), min(PIXELS, len(rows)), replace=False)
    at = rows[chosen], columns[chosen]
    points = unproject(BUDDHA_CAMERA, drawn["depth"], BUDDHA_SIZE)[at]
    own, index = scene.surfels, drawn["index"][at]
    found, error = sf.reference_radiance(
        scene,
        points,
        drawn["normal"][at],
        BUDDHA_CAMERA.eye - points,
        reflectance=own.reflectance[index],
        specular=own.specular[index],
        exponent=own.exponent[index],
        glossy_bounces=False,  # as transfer has it, and says
        samples=PATHS,
        threads=threads,
    )
    return at, found, error


def _row(name, transfer, gigabytes):
    count = sum(len(surfels) for surfels in transfer.scene.objects)
    return Row(name, count, len(transfer.receivers[0]), transfer.links, [], transfer.nbytes / 1e6, gigabytes)


def _truth(scene, lamp, surfels, threads):
    truth = Truth(sf.Scene(scene.objects, lights=[lamp]), surfels, MEASURED, threads=threads)
    while truth.rounds < ROUNDS:
        truth.refine()
    return truth


def _relighting(transfer, lamps, threads):
    """Milliseconds of three bounces everywhere, and of one of them: medians over lamps and repeats."""

    def taken(bounces):
        seconds = [_median(partial(transfer.indirect, lamp, bounces=bounces, threads=threads), RELIT) for lamp in lamps]
        return 1e3 * np.median(seconds)

    three, one = taken(3), taken(1)
    return float(three), float((three - one) / 2)


def _frames(transfer, lamps, threads):
    """Frames a second, while a lamp moves from the first place to the second."""
    renderer = sf.LampRenderer(transfer, None, SIZE, threads=threads)
    first, second = (np.array(lamp.position) for lamp in lamps[:2])
    seconds = []
    for t in np.linspace(0.0, 1.0, FRAMES + 1):
        lamp = sf.PointLight(first + t * (second - first), lamps[0].intensity)
        start = perf_counter()
        renderer.frame(lamp, threads=threads)
        seconds.append(perf_counter() - start)
    return float(1.0 / np.median(seconds[1:]))


def _median(call, repeats):
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        seconds.append(perf_counter() - start)
    return float(np.median(seconds))


def _squared(values):
    return float((np.asarray(values, float) ** 2).sum(axis=-1).mean())


def sponza():
    return sf.load_scene(scenes.data_folder() / "sponza.toml"), 100.0


def statue():
    return sf.load_scene(scenes.data_folder() / "statue.toml"), 10.0


def dragons():
    """24 dragons, each turned and tinted otherwise, in a hall of 12 x 8 x 4 m: 2.4 M triangles."""
    path = Path(os.environ["SURFLUX_DATA"]) / "statues" / "dragon_50k.ply"
    across, along = DRAGONS
    rng = np.random.default_rng(0)
    bodies = []
    for k in range(across * along):
        place = 2.0 * (k % across) + 1.0, 2.0 * (k // across) + 1.0, 0.004
        turned = make_transform(scale=0.11, rotate=[90, 0, float(rng.uniform(0, 360))], translate=place)
        bodies.append(turned.surfels(sf.Surfels.from_mesh(path, reflectance=rng.uniform(0.3, 0.8, 3))))
    size = 2 * across, 2 * along, 4
    vertices, faces, _ = shapes.box(size, [5 * side for side in size], inward=True)
    hall = sf.Surfels.from_mesh((vertices, faces), reflectance=0.7)
    return sf.Scene([hall, *bodies], camera=sf.Camera([6, -6, 3], [6, 4, 1])), 20.0


BUILDERS = {"Sponza": sponza, "statue": statue, "dragons": dragons}
NAMES = tuple(TARGETS)


def table(rows):
    """Markdown: a line for each scene; what is beyond its limit is marked."""
    lines = [
        "| scene | surfels | links | precomputed in, s | MB | peak, GB | error of all light, % | of indirect light, % "
        "| relit, ms | a bounce, ms | frames/s | L07 |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|",
    ]
    for row in rows:
        target, missed = TARGETS[row.scene], row.missed()

        def cell(name, text, row=row, target=target, missed=missed):
            value, limit = getattr(row, name), getattr(target, name, None)
            if value is None:
                return ""
            said = text(value)
            if limit is None:
                return said
            least = ">=" if name == "frames" else "<="
            limit = f"{100 * limit:.0f}" if name == "error" else f"{limit:g}"
            return f"{said} ({'**' if name in missed else ''}{least} {limit}{'**' if name in missed else ''})"

        cells = [
            row.scene,
            str(row.surfels),
            str(row.links),
            cell("seconds", lambda all_seeds: _range(all_seeds, 1.0, 0)),
            cell("megabytes", lambda value: f"{value:.0f}"),
            cell("gigabytes", lambda value: f"{value:.1f}"),
            cell("error", lambda values: _range(values, 100.0, 1)),
            cell("of_indirect", lambda values: _range(values, 100.0, 0)),
            cell("relight_ms", lambda value: f"{value:.0f}"),
            cell("bounce_ms", lambda value: f"{value:.1f}"),
            cell("frames", lambda value: f"{value:.1f}"),
            target.l07,
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _range(values, factor, digits):
    least, most = (f"{factor * value:.{digits}f}" for value in (min(values), max(values)))
    return least if least == most else f"{least} to {most}"
