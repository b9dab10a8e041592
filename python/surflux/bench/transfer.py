"""`surflux bench --transfer`: precomputed light transport beside what it is to reach.

Each scene has a process of its own. Seconds are of all stages of precompute_transfer, compiling included; beside them
are those of all cores, for others may use the machine. Memory is the operator's, and the most the process had until the
first lamp was lit. Errors are those of `transfer_truth`, of all reflections, at lamps where none was while transfer was
precomputed; those with 3 bounces, as milliseconds and frames are measured with, stand beside them. Of the Buddha they
are of the picture, beside that of surfels that are path traced, glossy at the last reflection, as transfer has it, and
diffuse before; in place of 3 bounces stands the error beside paths that are glossy throughout.

L07 is Lehtinen and others 2007 on two cores of their time, pictures on its graphics card.
"""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.scale import peak_gigabytes
from surflux.bench.transfer_truth import SUBPIXELS, errors_of, picture_error, traced, traced_pictures
from surflux.scenes import shapes
from surflux.scenes.transform import make_transform

RELIT = 5  # times for each lamp
BOUNCES = 3  # of what is timed
FRAMES, SIZE = 20, (960, 720)
BUDDHA_CAMERA, BUDDHA_SIZE = sf.Camera([0, -6, 0.3], [-0.05, -0.08, 0], fov=20.5), (172, 400)
AZIMUTHS = (0, 180)  # of the probe


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


@dataclass
class Row:
    """One scene. Pairs are the least and the most over seeds, of errors over the worst lamp of each seed or the RMS."""

    scene: str
    triangles: int
    surfels: int
    links: int = 0
    seeds: int = 0
    seconds: tuple = ()
    core_seconds: tuple = ()  # of all cores
    megabytes: float = 0.0  # of the operator
    gigabytes: float | None = None
    worst: tuple = ()  # relative to all light, or of the picture
    rms: tuple = ()
    uncertainty: float = 0.0  # standard error of the worst
    worst_of_indirect: tuple | None = None  # relative to indirect light alone
    uncertainty_of_indirect: float | None = None
    worst_of_three: tuple | None = None  # as `worst`, of 3 bounces; of the Buddha beside paths glossy throughout
    relight_ms: float | None = None
    bounce_ms: float | None = None
    frames: float | None = None
    wanted: dict = field(default_factory=dict)
    kept: dict = field(default_factory=dict)  # whether each of those is

    @property
    def passes(self):
        return all(self.kept.values())

    def judge(self, wanted):
        """Fills `wanted` and `kept`. What was not found does not pass."""
        self.wanted = dict(wanted)
        for name, limit in wanted.items():
            value = getattr(self, name)
            value = max(value) if isinstance(value, tuple) else value
            self.kept[name] = value is not None and (value >= limit if name == "frames" else value <= limit)


def why_not():
    """Why scenes cannot be had here, or None."""
    if not os.environ.get("SURFLUX_DATA"):
        return scenes.NO_SCANS
    return None if scenes.data_folder() else "its scene file is missing in this installation"


def measure(names, repeats, threads):
    """Rows of the scenes that can be had; `repeats`: seeds, where a Case does not have fewer."""
    rows = []
    for name in names:
        reason = why_not()
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
            continue
        print(f"bench: {name}", file=sys.stderr)
        seeds = min(repeats, CASES[name].most_seeds or repeats)
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:
            rows.append(fresh.submit(of_lamps if CASES[name].lamps else of_buddha, name, seeds, threads).result())
        rows[-1].judge(CASES[name].wanted)
    return rows


def of_lamps(name, seeds, threads):
    """The Row of a scene under lamps."""
    case = CASES[name]
    scene = case.build()
    lamps = [sf.PointLight(place, case.power) for place in case.lamps]
    row, off, off_three, speeds, truths = _row(name, scene), [], [], [], None
    for seed in range(seeds):
        transfer = _precomputed(row, scene, "local", seed, threads)
        if truths is None:
            surfels = transfer.relight([], threads=threads).surfels
            transfer.indirect(lamps[0], threads=threads)
            row.gigabytes = peak_gigabytes()
            truths = [traced(scene, lamp, surfels, threads=threads) for lamp in lamps]
        for bounces, found in ((None, off), (BOUNCES, off_three)):
            light = (transfer.indirect(lamp, bounces=bounces, threads=threads) for lamp in lamps)
            found.append([errors_of(*pair) for pair in zip(light, truths, strict=True)])
        speeds.append([*_relighting(transfer, lamps, threads), _frames(transfer, lamps, threads)])
    of_all, of_indirect, doubt, doubt_of_indirect = np.moveaxis(off, -1, 0)  # (seeds, lamps) each
    row.worst, row.rms, row.uncertainty = _over_seeds(of_all, doubt)
    row.worst_of_indirect, _, row.uncertainty_of_indirect = _over_seeds(of_indirect, doubt_of_indirect)
    row.worst_of_three = _range(np.max(off_three, axis=1)[:, 0])
    row.relight_ms, row.bounce_ms, row.frames = (float(speed) for speed in np.median(speeds, axis=0))
    return row


def of_buddha(name, seeds, threads):
    """The Row of a glossy statue in an environment that turns, from pictures beside path traced ones of its light."""
    scene = CASES[name].build()
    probe = grace_probe()
    turns = [make_transform(rotate=[0, 0, azimuth]).rotation for azimuth in AZIMUTHS]
    row, off, speeds, truths = _row(name, scene), [], [], {}
    for seed in range(seeds):
        transfer = _precomputed(row, scene, "distant", seed, threads)
        for turn, rotation in enumerate(turns):
            solution = transfer.relight(probe, rotation=rotation, threads=threads)
            row.gigabytes = row.gigabytes or peak_gigabytes()
            drawn = solution.render(BUDDHA_CAMERA, BUDDHA_SIZE, samples=SUBPIXELS)
            if turn not in truths:
                light = sf.Environment.from_harmonics(sf.rotate_harmonics(probe.harmonics(5), rotation))
                lit = sf.Scene(scene.objects, lights=[light])
                view = solution, lit, BUDDHA_CAMERA, BUDDHA_SIZE
                truths[turn] = [traced_pictures(*view, glossy_bounces=last, threads=threads) for last in (False, True)]
            off.append([picture_error(drawn, truth) for truth in truths[turn]])
        speeds.append(1e3 * _median(lambda of=transfer: of.relight(probe, threads=threads), RELIT))
    found = np.reshape(off, (seeds, len(turns), 2, 2))  # ..., (glossy at last, throughout), (error, its own)
    row.worst, row.rms, row.uncertainty = _over_seeds(found[:, :, 0, 0], found[:, :, 0, 1])
    row.worst_of_three = _range(found[:, :, 1, 0].max(axis=1))
    row.relight_ms = median(speeds)
    return row


def grace_probe():
    """Debevec's Grace cathedral as it stands: the file has its rows from below, which no turn would mend unmirrored."""
    image = sf.read_image(Path(os.environ["SURFLUX_DATA"]) / "probes" / "grace_latlong.exr")
    return sf.Environment(image[::-1], azimuth=180)


def _row(name, scene):
    return Row(name, sum(len(s.triangles) for s in scene.objects), sum(len(s) for s in scene.objects))


def _precomputed(row, scene, lighting, seed, threads):
    """The transfer of a seed; its seconds, bytes and links go into the row."""
    fresh = sf.Scene(scene.objects, camera=scene.camera)  # not compiled yet
    start, busy = perf_counter(), process_time()
    bounces = None if lighting == "local" else BOUNCES
    options = CASES[row.scene].options
    transfer = sf.precompute_transfer(fresh, lighting, bounces=bounces, seed=seed, threads=threads, **options)
    seconds, busy = perf_counter() - start, process_time() - busy
    row.seconds, row.core_seconds = _range([*row.seconds, seconds]), _range([*row.core_seconds, busy])
    row.megabytes, row.links = max(row.megabytes, transfer.nbytes / 1e6), max(row.links, transfer.links)
    row.seeds += 1
    return transfer


def _over_seeds(off, doubt):
    """Of errors (seeds, lamps) and standard errors: ranges of the worst and the RMS; the worst's standard error."""
    rms = np.sqrt((off**2).mean(axis=1))
    return _range(off.max(axis=1)), _range(rms), float(doubt.flat[off.argmax()])


def _relighting(transfer, lamps, threads):
    """Milliseconds of 3 bounces everywhere, and of one of them."""

    def taken(bounces):
        return 1e3 * median(
            _median(lambda of=lamp: transfer.indirect(of, bounces=bounces, threads=threads), RELIT) for lamp in lamps
        )

    three, one = taken(BOUNCES), taken(1)
    return three, (three - one) / (BOUNCES - 1)


def _frames(transfer, lamps, threads):
    """Frames a second, while a lamp moves from the first place to the second."""
    renderer = sf.LampRenderer(transfer, None, SIZE, threads=threads)
    first, second = (np.array(lamp.position) for lamp in lamps[:2])
    moved = [sf.PointLight(first + t * (second - first), lamps[0].intensity) for t in np.linspace(0, 1, FRAMES)]
    renderer.frame(moved[0], bounces=BOUNCES, threads=threads)
    seconds = []
    for lamp in moved:
        start = perf_counter()
        renderer.frame(lamp, bounces=BOUNCES, threads=threads)
        seconds.append(perf_counter() - start)
    return 1.0 / median(seconds)


def _median(call, repeats):
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        seconds.append(perf_counter() - start)
    return median(seconds)


def _range(values):
    return float(min(values)), float(max(values))


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


CASES = {
    "Buddha": Case(buddha, (), 0.0, {"seconds": 40, "megabytes": 40, "worst": 0.08}, "498 s, 116 MB"),
    "Sponza": Case(
        _scene_file("sponza"),
        ((0, 0, 2), (-9, 0.2, 3), (8, -4.5, 2), (-6, 4.5, 6), (4, 0, 8)),
        100.0,
        {"seconds": 150, "megabytes": 103, "worst": 0.08, "relight_ms": 20, "bounce_ms": 10, "frames": 10},
        "1892 s, 103 MB, 97 to 139 ms, 7.2 frames/s",
    ),
    "statue": Case(
        _scene_file("statue"),
        ((1.2, 1.0, 2.6), (3.6, 3.2, 1.6), (2.2, 0.6, 2.9)),
        10.0,
        {"seconds": 40, "worst_of_indirect": 0.05},
        "492 s, 30 MB",
        options={"epsilon_t": 0.1, "rays": 256},
    ),
    "dragons": Case(
        dragons,
        ((3.0, 2.0, 3.2), (8.5, 6.0, 2.5)),
        20.0,
        {"seconds": 600, "gigabytes": 4.0},
        "2.3 M triangles: under 30 min (Lehtinen and others 2008)",
        most_seeds=1,
    ),
}


def table(rows):
    """Markdown: a line for each scene, with what is wanted of a cell and whether it is kept beside it."""
    lines = [
        "| scene | triangles | surfels | links | seeds | precomputed in, s | of all cores, s | MB | peak, GB "
        "| error of worst lamp, % | RMS over lamps, % | of indirect light, worst lamp, % | with 3 bounces, % "
        "| relit, ms | a bounce, ms | frames/s | L07 |",
        "|---|" + "--:|" * 15 + "---|",
    ]
    for row in rows:
        cells = [
            _said(row, "seconds", 1, 0),
            _said(row, "core_seconds", 1, 0),
            _said(row, "megabytes", 1, 0),
            _said(row, "gigabytes", 1, 1),
            _said(row, "worst", 100, 1, row.uncertainty),
            _said(row, "rms", 100, 1),
            _said(row, "worst_of_indirect", 100, 1, row.uncertainty_of_indirect),
            _said(row, "worst_of_three", 100, 1),
            _said(row, "relight_ms", 1, 0),
            _said(row, "bounce_ms", 1, 1),
            _said(row, "frames", 1, 1),
            CASES[row.scene].l07 if row.scene in CASES else "",
        ]
        counts = [str(count) for count in (row.triangles, row.surfels, row.links, row.seeds)]
        lines.append(f"| {' | '.join([row.scene, *counts, *cells])} |")
    for row in rows:
        if row.scene in CASES and CASES[row.scene].options:
            options = ", ".join(f"{name}={value}" for name, value in CASES[row.scene].options.items())
            lines.append(f"\n{row.scene}: precomputed with {options}.")
    return "\n".join(lines)


def _said(row, name, factor, digits, doubt=None):
    """A cell: the value or its range over seeds, its standard error, and what is wanted."""
    value = getattr(row, name)
    if value is None:
        return ""
    ends = [f"{factor * end:.{digits}f}" for end in (value if isinstance(value, tuple) else (value,))]
    text = " to ".join(dict.fromkeys(ends))
    if doubt is not None:
        text += f" ± {factor * doubt:.{digits}f}"
    if name not in row.wanted:
        return text
    wanted = f"{'>=' if name == 'frames' else '<='} {factor * row.wanted[name]:g}"
    return f"{text} ({wanted}: {'yes' if row.kept[name] else 'NO'})"
