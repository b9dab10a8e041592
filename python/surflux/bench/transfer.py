"""`surflux bench --transfer`: precomputed light transport beside what it is to reach.

Each scene has a process of its own. Seconds are of all stages of precompute_transfer, compiling included; beside them
are those of all cores, for others may use the machine. Memory is the operator's, and the most the process had until the
first lamp was lit. Errors are those of `transfer_truth`, of all reflections, at lamps where none was while transfer was
precomputed; those with 3 bounces, as milliseconds and frames are measured with, stand beside them. Of the Buddha they
are of the picture, beside that of surfels that are path traced, glossy at the last reflection, as transfer has it, and
diffuse before; in place of 3 bounces stands the error beside paths that are glossy throughout.

L07 is Lehtinen and others 2007 on two cores of their time, pictures on its graphics card.
"""

import sys
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter, process_time

import numpy as np

import surflux as sf
from surflux.bench import scenes
from surflux.bench.scale import in_fresh_process, peak_gigabytes
from surflux.bench.transfer_cases import CASES, grace_probe
from surflux.bench.transfer_truth import SUBPIXELS, errors_of, picture_error, traced, traced_pictures
from surflux.scenes.transform import make_transform

RELIT = 5  # times for each lamp
BOUNCES = 3  # of what is timed
FRAMES, SIZE = 20, (960, 720)
BUDDHA_CAMERA, BUDDHA_SIZE = sf.Camera([0, -6, 0.3], [-0.05, -0.08, 0], fov=20.5), (172, 400)
AZIMUTHS = (0, 180)  # of the probe


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
    estimate: tuple | None = None  # of Solution.estimate_error, of all light, of the lamp of which it is most
    worst_of_three: tuple | None = None  # as `worst`, of 3 bounces; of the Buddha beside paths glossy throughout
    relight_ms: float | None = None
    bounce_ms: float | None = None
    frames: float | None = None
    frame_ms: dict | None = None  # of the parts of a frame, of one from a new camera, and of a new LampRenderer
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
    if not scenes.has_scans():
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
        of_case = of_lamps if CASES[name].lamps else of_buddha
        rows.append(in_fresh_process(of_case, name, seeds, threads))
        rows[-1].judge(CASES[name].wanted)
    return rows


def of_lamps(name, seeds, threads):
    """The Row of a scene under lamps."""
    case = CASES[name]
    scene = case.build()
    lamps = [sf.PointLight(place, case.power) for place in case.lamps]
    row, off, off_three, speeds, truths, estimates = _row(name, scene), [], [], [], None, []
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
        relit = (transfer.relight(lamp, threads=threads) for lamp in lamps)
        estimates.append(max(solution.estimate_error(seed=seed, threads=threads) for solution in relit))
        speeds.append([*_relighting(transfer, lamps, threads), *_frames(transfer, lamps, threads)])
    of_all, of_indirect, doubt, doubt_of_indirect = np.moveaxis(off, -1, 0)  # (seeds, lamps) each
    row.worst, row.rms, row.uncertainty = _over_seeds(of_all, doubt)
    row.worst_of_indirect, _, row.uncertainty_of_indirect = _over_seeds(of_indirect, doubt_of_indirect)
    row.estimate = _range(estimates)
    row.worst_of_three = _range(np.max(off_three, axis=1)[:, 0])
    *found, frames, parts = zip(*speeds, strict=True)
    row.relight_ms, row.bounce_ms, row.frames = (median(of) for of in (*found, frames))
    row.frame_ms = {name: median(part[name] for part in parts) for name in parts[0]}
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
    """Frames a second, while a lamp moves from the first place to the second, and milliseconds as Row.frame_ms."""
    start = perf_counter()
    renderer = sf.LampRenderer(transfer, None, SIZE, threads=threads)
    first, second = (np.array(lamp.position) for lamp in lamps[:2])
    moved = [sf.PointLight(first + t * (second - first), lamps[0].intensity) for t in np.linspace(0, 1, FRAMES)]
    parts = {"new renderer": [_timed_frame(renderer, moved[0], threads, start)]}
    seconds = []
    for lamp in moved:
        seconds.append(_timed_frame(renderer, lamp, threads))
        for name, taken in renderer.frame_timings.items():
            parts.setdefault(name, []).append(taken)
    look = renderer.camera
    for _ in range(RELIT):
        renderer.camera = sf.Camera(look.eye, look.target, look.up, look.fov)  # what depends on it is made anew
        parts.setdefault("new camera", []).append(_timed_frame(renderer, moved[-1], threads))
    return 1.0 / median(seconds), {name: 1e3 * median(taken) for name, taken in parts.items()}


def _timed_frame(renderer, lamp, threads, start=None):
    start = perf_counter() if start is None else start
    renderer.frame(lamp, bounces=BOUNCES, threads=threads)
    return perf_counter() - start


def _median(call, repeats):
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        seconds.append(perf_counter() - start)
    return median(seconds)


def _range(values):
    return float(min(values)), float(max(values))


# Fields of a Row that the guide's table and its sentences have.
SHOWN = (
    "scene",
    "surfels",
    "seeds",
    "seconds",
    "megabytes",
    "gigabytes",
    "relight_ms",
    "bounce_ms",
    "frames",
    "frame_ms",
)
SHOWN += ("worst", "uncertainty", "estimate", "worst_of_three", "worst_of_indirect", "uncertainty_of_indirect")


def shown(row):
    """What the guide has of a row, as JSON keeps it."""
    found = {name: getattr(row, name) for name in SHOWN}
    return {name: list(value) if isinstance(value, tuple) else value for name, value in found.items()}


def short_table(rows):
    """The guide's table, of what `shown` gives."""
    lines = [
        "| scene | surfels | seeds | precomputed in, s | MB | at the peak, GB | one lamp, ms | a bounce, ms | frames/s "
        "| error of all light, % | its own estimate, % | of indirect light, % |",
        "|---|" + "--:|" * 11,
    ]
    for row in (Row(triangles=0, **row) for row in rows):
        about = CASES[row.scene].about if row.scene in CASES else ""
        cells = [row.scene + about, str(row.surfels), str(row.seeds), _said(row, "seconds", 1, 0)]
        cells += [_said(row, "megabytes", 1, 0), _said(row, "gigabytes", 1, 1), _said(row, "relight_ms", 1, 0)]
        cells += [_said(row, "bounce_ms", 1, 1), _said(row, "frames", 1, 0)]
        cells += [_said(row, "worst", 100, 1, row.uncertainty), _said(row, "estimate", 100, 1)]
        cells += [_said(row, "worst_of_indirect", 100, 1, row.uncertainty_of_indirect)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def table(rows):
    """Markdown: a line for each scene, with what is wanted of a cell and whether it is kept beside it."""
    lines = [
        "| scene | triangles | surfels | links | seeds | precomputed in, s | of all cores, s | MB | peak, GB "
        "| error of worst lamp, % | RMS over lamps, % | of indirect light, worst lamp, % | own estimate, % "
        "| with 3 bounces, % "
        "| relit, ms | a bounce, ms | frames/s | L07 |",
        "|---|" + "--:|" * 16 + "---|",
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
            _said(row, "estimate", 100, 1),
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
    ends = [f"{factor * end:.{digits}f}" for end in (value if isinstance(value, (tuple, list)) else (value,))]
    text = " to ".join(dict.fromkeys(ends))
    if doubt is not None:
        text += f" ± {factor * doubt:.{digits}f}"
    if name not in row.wanted:
        return text
    wanted = f"{'>=' if name == 'frames' else '<='} {factor * row.wanted[name]:g}"
    return f"{text} ({wanted}: {'yes' if row.kept[name] else 'NO'})"
