"""The cases of `surflux bench`, one row of its table each: seconds and errors of one pass.

Each runs once and returns a Row without its name.
"""

import os
import sys
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import clouds, factors, images, scenes, sky
from surflux.points.reading import read_with_faces
from surflux.scenes import shapes


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


def measure(name, run, repeats, threads):
    """The case's row: medians over `repeats` runs after one that is not counted."""
    runs = [run(threads) for _ in range(repeats + 1)][1:]
    stages = {stage: median(r.stages[stage] for r in runs) for stage in runs[0].stages}
    last = runs[-1]
    return Row(name, last.surfels, median(r.seconds for r in runs), last.error, last.against, stages, repeats)


def table(rows):
    """The rows as a Markdown table."""
    lines = ["| case | surfels | seconds | error | against | stages, seconds |", "|---|--:|--:|--:|---|---|"]
    for r in rows:
        stages = ", ".join(f"{stage} {seconds:.3f}" for stage, seconds in r.stages.items() if seconds >= 0.0005)
        lines.append(f"| {r.case} | {r.surfels} | {r.seconds:.3f} | {r.error:.2g} | {r.against} | {stages} |")
    return "\n".join(lines)


def _run(surfels, seconds, error, against, stages=None):
    return Row("", surfels, seconds, float(error), against, stages or {})


def _solved(scene, threads, error, against):
    start = perf_counter()
    # A scene remembers areas that it has computed; a new one has to compute them again.
    solution = sf.solve(sf.Scene(scene.objects, scene.lights, solve_options=scene.solve_options), threads=threads)
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
        s, _ = read_with_faces(_statue_path("bunny_34834"))
        start = perf_counter()
        areas = sf.effective_areas(s, method=method, threads=threads)
        return _run(len(s), perf_counter() - start, abs(areas.sum() / area - 1), "area of its mesh")

    return run


def _normals(points, truth, threads):
    from surflux._base.passes import thread_limit

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
        normals = clouds.vertex_normals(vertices, faces)
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
    from surflux.meshes.reading import read_mesh

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
        scene = sf.load_scene(scenes.data_folder() / f"{name}.toml", surfels=surfels)
        loading = perf_counter() - start
        row = _solved(scene, threads, lambda s: s.error, "own estimate, RMS")
        row.stages = {"load": loading, **row.stages}
        row.seconds += loading
        return row

    return run


def measure_all(names, repeats, threads):
    """Rows of those of the cases that can run here; what is left out, and why, is said."""
    rows = []
    for name in names:
        needs_data, run = CASES[name]
        reason = scenes.why_not(name)
        if needs_data and not scenes.has_scans():
            reason = scenes.NO_SCANS
        if name == factors.NAME:
            reason = factors.why_not()
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
            continue
        print(f"bench: {name}", file=sys.stderr)
        rows.append(measure(name, run, repeats, threads))
    return rows


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
    images.NAME: (False, lambda threads: _run(*images.picture(threads))),
    factors.NAME: (False, lambda threads: _run(*factors.beside_peer(threads))),
    sky.NAME: (True, lambda threads: _run(*sky.tile(threads))),
    **{name: (False, _scene_file(file)) for name, file in scenes.FILES.items()},
    # Whole ones are a row of --scale.
    "two bunnies": (False, _scene_file("two_bunnies", 10_400)),
}
