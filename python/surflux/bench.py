"""`surflux bench`: seconds and errors of every pass on the machine at hand, in one table.

Each case is run once to warm up and then several times; seconds are medians, all stages counted. An error is measured
against a closed form where there is one; "own estimate" is Solution.error. With --quick or --full it measures instead
what each knob of each solver does (bench_solvers), with --scale both from 2500 surfels to a million (bench_scale),
with --areas effective areas (bench_areas), with --reference the path tracer against Mitsuba (bench_reference).
"""

import argparse
import json
import math
import os
import sys
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import surflux as sf
from surflux import _check, bench_clouds, bench_factors, bench_images, bench_scenes, shapes


@dataclass
class Row:
    """One line of the table."""

    case: str
    surfels: int
    seconds: float
    error: float
    against: str
    stages: dict = field(default_factory=dict)
    repeats: int = 1


def main(arguments=None):
    """Measures what is asked for, prints the table, and returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="surflux bench",
        description="Seconds and errors on this machine: of every pass, one case after another; or, with one of the "
        "options below, one thing in detail.",
    )
    parser.add_argument("--quick", action="store_true", help="error against seconds: scenes x solvers x knobs, minutes")
    parser.add_argument("--full", action="store_true", help="the same on more surfels, with more paths and settings")
    parser.add_argument("--scale", action="store_true", help="from 4000 surfels to a million: seconds, memory, errors")
    parser.add_argument("--reference", action="store_true", help="reference_irradiance against Mitsuba 3")
    parser.add_argument("--areas", action="store_true", help="effective areas alone")
    parser.add_argument("--case", action="append", metavar="NAME", help="of the cases only this one; again for more")
    parser.add_argument("--scene", action="append", metavar="NAME", help="with --quick, --full or --scale: only this")
    parser.add_argument(
        "--paths",
        type=int,
        metavar="N",
        help="of the path tracer: at each point with --reference (default: 4096), at most at each surfel with --quick "
        "(default: 8192), --full (default: 65536) and --scale (default: 16384)",
    )
    parser.add_argument("--cache", metavar="FOLDER", help="with --scale: keep reference values there")
    parser.add_argument("--list", action="store_true", help="print the names of the cases, or of the scenes")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="timed runs of each (default: 3)")
    parser.add_argument("--threads", type=int, metavar="N", help="at most N threads (default: all)")
    parser.add_argument("--markdown", metavar="OUT.md", help="write the table there too")
    parser.add_argument("--json", metavar="OUT.json", help="write the rows there, for programs")
    parser.add_argument("--plot", metavar="OUT.png", help="with --quick, --full, --scale or --areas: the curves")
    options = parser.parse_args(arguments)
    kind = _kind(options)
    _check_options(options, kind)
    if options.list:
        print("\n".join(_scenes(kind) or CASES))
        return 0
    if kind == "areas":
        from surflux import bench_areas

        bench_areas.main(options.repeats, options.threads, options.markdown, options.json, options.plot, heading())
        return 0
    run = {"quick": _solvers, "full": _solvers, "scale": _scale, "reference": _reference, "cases": _cases}[kind]
    rows, text = run(options)
    text = heading() + text
    print(text)
    if options.markdown:
        Path(options.markdown).write_text(text + "\n")
    if options.json:
        found = {"machine": dict(sf.info()), "rows": [asdict(row) for row in rows]}
        Path(options.json).write_text(json.dumps(found, indent=2) + "\n")
    return 0 if all(getattr(row, "passes", True) for row in rows) else 1


def _kind(options):
    """What is asked for: "quick", "full", "scale", "reference", "areas", or "cases" where none of these is."""
    chosen = [kind for kind in ("quick", "full", "scale", "reference", "areas") if getattr(options, kind)]
    if len(chosen) > 1:
        raise ValueError(f"--{chosen[1]}: does not go with --{chosen[0]}")
    return chosen[0] if chosen else "cases"


def _check_options(options, kind):
    if options.repeats < 1:
        raise ValueError(f"--repeats: wanted at least 1, got {options.repeats}")
    if options.plot and kind not in ("quick", "full", "scale", "areas"):
        raise ValueError("--plot: goes with --quick, --full, --scale or --areas")
    if options.case and kind != "cases":
        raise ValueError(f"--case: does not go with --{kind}, which has tables of its own")
    if options.paths is not None:
        if kind not in ("quick", "full", "scale", "reference"):
            raise ValueError("--paths: goes with --quick, --full, --scale or --reference")
        _check.count("--paths", options.paths, 1024)
    if options.cache and kind != "scale":
        raise ValueError("--cache: goes with --scale")
    if options.scene and not _scenes(kind):
        raise ValueError("--scene: goes with --quick, --full or --scale")
    for option, names in (("case", CASES), ("scene", _scenes(kind))):
        for name in getattr(options, option) or ():
            if name not in names:
                raise ValueError(f"--{option}: there is no {name!r}; --list names them all")


def _scenes(kind):
    """The names of the scenes of a kind of table that has scenes."""
    if kind == "scale":
        from surflux import bench_scale

        return tuple(bench_scale.SCENES)
    return bench_scenes.NAMES if kind in ("quick", "full") else ()


def _cases(options):
    rows = []
    for name in options.case or CASES:
        needs_data, run = CASES[name]
        reason = bench_scenes.why_not(name)
        if needs_data and not os.environ.get("SURFLUX_DATA"):
            reason = bench_scenes.NO_SCANS
        if name == bench_factors.NAME:
            reason = bench_factors.why_not()
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
            continue
        print(f"bench: {name}", file=sys.stderr)
        rows.append(measure(name, run, options.repeats, options.threads))
    return rows, table(rows)


def _solvers(options):
    """Scenes x solvers x knobs."""
    from surflux import bench_solvers
    from surflux.bench_truth import PATHS_A_ROUND

    names = []
    for name in options.scene or bench_scenes.NAMES:
        reason = bench_scenes.why_not(name)
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
        else:
            names.append(name)
    mode = bench_solvers.QUICK if options.quick else bench_solvers.FULL
    if options.paths is not None:
        mode = replace(mode, rounds=math.ceil(options.paths / PATHS_A_ROUND))
    rows = bench_solvers.measure(mode, names, options.repeats, options.threads)
    if options.plot:
        from surflux import bench_plot

        bench_plot.draw(rows, options.plot)
    return rows, bench_solvers.table(rows)


def _scale(options):
    from surflux import bench_plot, bench_scale

    names = options.scene or bench_scale.SCENES
    rows = bench_scale.measure(names, options.repeats, options.threads, options.cache, options.paths)
    if options.plot:
        bench_plot.draw_growth(rows, options.plot)
    return rows, bench_scale.table(rows)


def _reference(options):
    from surflux import bench_reference

    rows = bench_reference.measure(options.threads, options.paths or 4096)
    return rows, bench_reference.table(rows)


def measure(name, run, repeats, threads):
    """The case's row: medians over `repeats` runs after one that is not counted."""
    runs = [run(threads) for _ in range(repeats + 1)][1:]
    stages = {stage: median(r.stages[stage] for r in runs) for stage in runs[0].stages}
    last = runs[-1]
    return Row(name, last.surfels, median(r.seconds for r in runs), last.error, last.against, stages, repeats)


def heading():
    found = sf.info()
    return f"{found['threads']} threads, {found['instruction set']}, Embree {found['Embree']}, GL: {found['GL']}\n\n"


def table(rows):
    """The rows as a Markdown table."""
    lines = ["| case | surfels | seconds | error | against | stages, seconds |", "|---|--:|--:|--:|---|---|"]
    for r in rows:
        stages = ", ".join(f"{stage} {seconds:.3f}" for stage, seconds in r.stages.items() if seconds >= 0.0005)
        lines.append(f"| {r.case} | {r.surfels} | {r.seconds:.3f} | {r.error:.2g} | {r.against} | {stages} |")
    return "\n".join(lines)


# --- cases: each runs once and returns a Row without its name --------------------------------------------------------


def _run(surfels, seconds, error, against, stages=None):
    return Row("", surfels, seconds, float(error), against, stages or {})


def _solved(scene, threads, error, against):
    start = perf_counter()
    # A scene remembers areas that it has computed; a new one has to compute them again.
    solution = sf.solve(sf.Scene(scene.objects, scene.lights), threads=threads, **scene.solve_options)
    seconds = perf_counter() - start
    return _run(len(solution.surfels), seconds, error(solution), against, solution.timings)


def _cube(n, rho, emission):
    vertices, faces, _ = shapes.box(patches=n, inward=True)
    return sf.Surfels.from_mesh((vertices, faces), reflectance=rho, emission=emission)


def _sphere_points(n):
    return shapes.sphere(n).points  # not an icosphere's number: a Fibonacci lattice


def _relative_rms(surfels, found, expected):
    weight = surfels.areas[:, None]
    return np.sqrt(np.sum(weight * (found - expected) ** 2) / np.sum(weight * expected**2 * np.ones_like(found)))


def _areas_icosphere(method):
    def run(threads):
        s = shapes.sphere(642, 0.8)
        start = perf_counter()
        areas = sf.effective_areas(s, method=method, threads=threads)
        return _run(len(s), perf_counter() - start, abs(areas.sum() / (4 * np.pi * 0.64) - 1), "total area 4 pi r^2")

    return run


def _areas_bunny(method):
    def run(threads):
        _, corners, _ = _statue("bunny_34834")
        area = 0.5 * np.linalg.norm(_cross(corners), axis=1).sum()
        s = sf.read(_statue_path("bunny_34834"))
        start = perf_counter()
        areas = sf.effective_areas(s, method=method, threads=threads)
        return _run(len(s), perf_counter() - start, abs(areas.sum() / area - 1), "area of its mesh")

    return run


def _normals(points, truth, threads):
    from surflux._passes import thread_limit

    with thread_limit(threads):
        start = perf_counter()
        found = sf.Surfels(points)
        seconds = perf_counter() - start
    wrong = np.mean(np.sum(found.normals * truth, axis=1) < np.cos(np.radians(20.0)))
    return _run(len(points), seconds, wrong, "share of normals more than 20 degrees off the mesh's")


def _normals_of_vertices(name):
    """Normals and radii from the vertices of a statue, against the area-weighted mean of the faces around each."""

    def run(threads):
        vertices, _, faces = _statue(name)
        normals = bench_clouds.vertex_normals(vertices, faces)
        used = normals.any(axis=1)
        return _normals(vertices[used], normals[used], threads)

    return run


def _normals_of_samples(name):
    """The same of 300 000 points, uniformly random on its faces, against the normals of the faces."""

    def run(threads):
        _, corners, _ = _statue(name)
        points, triangle = sf._core.sample_triangles(corners, 300_000, 0)
        cross = _cross(corners)[triangle]
        return _normals(points, cross / np.linalg.norm(cross, axis=1, keepdims=True), threads)

    return run


def _statue(name):
    from surflux.meshes import read_mesh

    mesh = read_mesh(_statue_path(name))
    faces = np.asarray(mesh.indices).reshape(-1, 3)
    return mesh.vertices, mesh.vertices[faces], faces


def _statue_path(name):
    return Path(os.environ["SURFLUX_DATA"]) / "statues" / f"{name}.ply"


def _cross(corners):
    """Of triangles (f, 3, 3): along their normals, twice as long as their areas (f, 3)."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _furnace(surfels, threads):
    def error(solution):
        return np.abs(solution.radiosity * (1.0 - 0.9) - 1.0).max()

    return _solved(sf.Scene([surfels]), threads, error, "B = E/(1-rho), largest")


def _furnace_cube(threads):
    return _furnace(_cube(13, 0.9, 1.0), threads)


def _furnace_sphere(threads):
    p = _sphere_points(1000)
    return _furnace(sf.Surfels(p, normals=-p, reflectance=0.9, emission=1.0), threads)


def _sphere_inside(threads):
    p = _sphere_points(2000)
    s = sf.Surfels(p, normals=-p, reflectance=0.5 + 0.4 * p[:, 0], emission=np.where(p[:, 2] > 0.5, 10.0, 0.0))

    def error(solution):
        # H = mean(E) / (1 - mean(rho)), means over the sphere: a cap of height 1/2 has 1/4 of it.
        return _relative_rms(solution.surfels, solution.irradiance, np.array(2.5 / 0.5))

    return _solved(sf.Scene([s]), threads, error, "H = mean(E)/(1-mean(rho)), RMS")


def _concentric(threads):
    inner, outer = _sphere_points(1000), _sphere_points(4000)
    scene = sf.Scene(
        [
            sf.Surfels(0.5 * inner, normals=inner, reflectance=0.0, emission=1.0),
            sf.Surfels(outer, normals=-outer, reflectance=0.5),
        ]
    )

    def error(solution):
        return _relative_rms(solution.surfels[1000:], solution.radiosity[1000:], np.array(0.2))

    return _solved(scene, threads, error, "B = .2 on the outer sphere, RMS")


def _cube_factors(threads):
    scene = sf.Scene([_cube(20, 0.5, 0.0)])
    start = perf_counter()
    f = sf.form_factors(scene, threads=threads)
    seconds = perf_counter() - start
    faces = f.reshape(6, 400, 6, 400).sum(axis=3).mean(axis=1)
    expected = np.full((6, 6), 0.2000437761)
    expected[[0, 1, 2, 3, 4, 5], [1, 0, 3, 2, 5, 4]] = 0.1998248957
    np.fill_diagonal(expected, 0.0)
    off = np.abs(faces - expected).max() / 0.2
    return _run(2400, seconds, off, "factors between faces, largest")


def _scene_file(name, surfels=None):
    def run(threads):
        start = perf_counter()
        scene = sf.load_scene(bench_scenes.data_folder() / f"{name}.toml", surfels=surfels)
        loading = perf_counter() - start
        row = _solved(scene, threads, lambda s: s.error, "own estimate, RMS")
        row.stages = {"load": loading, **row.stages}
        row.seconds += loading
        return row

    return run


# Name -> (needs SURFLUX_DATA, run).
CASES = {
    "areas of an icosphere": (False, _areas_icosphere("curved")),
    "areas of an icosphere, paper's": (False, _areas_icosphere("paper")),
    "areas of the bunny": (True, _areas_bunny("curved")),
    "areas of the bunny, paper's": (True, _areas_bunny("paper")),
    "normals and radii of the bunny": (True, _normals_of_vertices("bunny_34834")),
    "normals and radii of the armadillo": (True, _normals_of_vertices("armadillo_43k")),
    "normals and radii, bunny sampled": (True, _normals_of_samples("bunny_34834")),
    "normals and radii, armadillo sampled": (True, _normals_of_samples("armadillo_43k")),
    "normals and radii, buddha sampled": (True, _normals_of_samples("buddha_50k")),
    "normals and radii, dragon sampled": (True, _normals_of_samples("dragon_50k")),
    "furnace in a cube": (False, _furnace_cube),
    "furnace in a sphere": (False, _furnace_sphere),
    "sphere inside": (False, _sphere_inside),
    "concentric spheres": (False, _concentric),
    "form factors in a cube": (False, _cube_factors),
    bench_images.NAME: (False, lambda threads: _run(*bench_images.picture(threads))),
    bench_factors.NAME: (False, lambda threads: _run(*bench_factors.beside_peer(threads))),
    **{name: (False, _scene_file(file)) for name, file in bench_scenes.FILES.items()},
    # Whole ones are a row of --scale.
    "two bunnies": (False, _scene_file("two_bunnies", 10_400)),
}
