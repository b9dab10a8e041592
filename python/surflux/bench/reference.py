"""`surflux bench --reference`: reference_irradiance against Mitsuba 3, at 200 points of two scenes of polygons.

Two path tracers that share no code, on the same triangles: each value has its standard error, so that z-scores of the
differences are those of a normal distribution if neither is biased. A scene passes with a chi-square p above 1e-3 in
each colour and no |z| above 4.5.
"""

import os
import sys
import xml.etree.ElementTree as ET
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import mitsuba_renderer, scenes
from surflux.bench.truth import area_sample, even_squares, places_on
from surflux.meshes.reading import read_mesh
from surflux.scenes import shapes

POINTS = 200
BATCHES = 64  # of Mitsuba's paths
CORNELL = "scenes/cornell_mitsuba/cbox-rgb.xml"


@dataclass
class Row:
    """One scene: how far two path tracers are from each other."""

    scene: str
    points: int
    paths: int  # of each at each point
    reference: float  # mean standard error over mean irradiance
    mitsuba: float
    chi_square_p: float  # the least of three colours
    largest_z: float
    mean_z: float
    seconds: float | None = None  # of the reference
    seconds_mitsuba: float | None = None

    @property
    def passes(self):
        return self.chi_square_p > 1e-3 and self.largest_z <= 4.5


def measure(threads=None, paths=4096):
    """Rows of both scenes, or of the one that needs no scans; none without Mitsuba."""
    mitsuba = mitsuba_renderer.load(threads)
    if mitsuba is None:
        return []
    rows = []
    for name, build in SCENES.items():
        if build is cornell and not scenes.scans_for(name):
            continue
        print(f"bench: {name}", file=sys.stderr)
        scene, renderer = build(mitsuba)
        rows.append(compare(name, scene, renderer, paths, threads))
    return rows


def compare(name, scene, renderer, paths, threads=None, seed=0):
    """The Row of a scene of polygons and of a Renderer of the same ones."""
    from scipy import stats

    surfels = scene.surfels
    index = area_sample(surfels.areas, 2 * POINTS, seed)
    points, normals = places_on(surfels, index, even_squares(index, seed, 1))
    # Left out: places where surfaces coincide, so that chance decides which one a ray meets.
    kept = np.nonzero(renderer.meets(points, normals))[0][:POINTS]
    index, points, normals = index[kept], points[kept], normals[kept]

    start = perf_counter()
    ours, error = sf.reference_irradiance(scene, points, normals, samples=paths, seed=seed, threads=threads)
    seconds = perf_counter() - start
    places = np.repeat(points[:, None], paths, axis=1)
    rho, emission = surfels.reflectance[index], surfels.emission[index]
    start = perf_counter()
    batches = renderer.irradiance(places, normals, rho, emission, seed, BATCHES, "independent")
    seconds_mitsuba = perf_counter() - start
    theirs, their_error = batches.mean(axis=1), batches.std(axis=1, ddof=1) / np.sqrt(BATCHES)

    # Welch 1947: the difference over its standard error follows Student's t, here with 63 degrees of freedom and more.
    squares = error**2 + their_error**2
    lit = squares > 0.0
    if not np.array_equal(ours[~lit], theirs[~lit]):
        raise ValueError(f"{name}: where no path brings light, the two do not agree")
    own = round(paths**0.5) - 1
    freedom = squares[lit] ** 2 / (error[lit] ** 4 / own + their_error[lit] ** 4 / (BATCHES - 1))
    t = (ours - theirs)[lit] / np.sqrt(squares[lit])
    z = np.full(ours.shape, np.nan)
    z[lit] = stats.norm.isf(stats.t.sf(t, freedom))
    p = [stats.chi2.sf(np.nansum(z[:, c] ** 2), np.sum(lit[:, c])) for c in range(3)]
    return Row(
        name,
        len(points),
        paths,
        float(np.sqrt(np.mean(error**2)) / ours.mean()),
        float(np.sqrt(np.mean(their_error**2)) / ours.mean()),
        float(min(p)),
        float(np.nanmax(np.abs(z))),
        float(np.nanmean(z)),
        seconds,
        seconds_mitsuba,
    )


def cornell(mitsuba):
    """Mitsuba's own Cornell box: read by Mitsuba, and by us from the same files."""
    path = Path(os.environ["SURFLUX_DATA"]) / CORNELL
    return read_mitsuba(path), mitsuba_renderer.Renderer(mitsuba, mitsuba.load_file(str(path)))


def read_mitsuba(path):
    """A Scene of a Mitsuba file of OBJ shapes that are diffuse, some of them lamps, with colours in RGB."""
    path = Path(path)

    def elements(file):
        for element in ET.parse(file).getroot():
            if element.tag == "include":
                yield from elements(path.parent / element.get("filename"))
            else:
                yield element

    def color(element):
        return [float(c) for c in element.find("rgb").get("value").split(",")]

    found = list(elements(path))
    known = {e.get("id"): (e.tag, color(e)) for e in found if e.tag in ("bsdf", "emitter")}
    objects = []
    for shape in (e for e in found if e.tag == "shape"):
        looks = dict(known[reference.get("id")] for reference in shape.findall("ref"))
        vertices, offsets, indices = read_mesh(path.parent / shape.find("string").get("value"))[:3]
        moved = shape.find("transform/translate")
        if moved is not None:
            vertices = vertices + [float(moved.get(axis)) for axis in "xyz"]
        # Fans, as Mitsuba cuts polygons: one wall of the box is not flat.
        fans = [
            (indices[first], indices[k], indices[k + 1])
            for first, last in pairwise(offsets)
            for k in range(first + 1, last - 1)
        ]
        glow = np.pi * np.array(looks.get("emitter", (0.0, 0.0, 0.0)))
        objects.append(sf.Surfels.from_mesh((vertices, np.array(fans)), None, looks["bsdf"], glow))
    return sf.Scene(objects)


def room_of_spheres(mitsuba):
    """Three spheres of triangles under a lamp in a closed room, all of different colours."""
    room, faces, side = shapes.box((3.0, 4.0, 2.5), 1, inward=True)
    walls = np.array([[0.7, 0.2, 0.1], [0.2, 0.6, 0.3], [0.6, 0.6, 0.6], [0.5, 0.5, 0.7], [0.4, 0.3, 0.3], [0.8] * 3])
    objects = [sf.Surfels.from_mesh((room, faces), None, walls[side])]
    ball, triangles = shapes.icosphere(3)
    for center, radius, rho in (
        ((0.9, 1.2, 0.6), 0.6, (0.8, 0.5, 0.3)),
        ((2.1, 1.9, 0.45), 0.45, (0.3, 0.7, 0.8)),
        ((1.2, 2.9, 1.4), 0.5, (0.6, 0.6, 0.2)),
    ):
        objects.append(sf.Surfels.from_mesh((radius * ball + np.array(center), triangles), None, rho))
    lamp, faces = shapes.rectangle((1.0, 1.5, 2.3), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    objects.append(sf.Surfels.from_mesh((lamp, faces), None, 0.3, (12.0, 10.0, 7.0)))
    scene = sf.Scene(objects)
    return scene, mitsuba_renderer.Renderer.of_surfels(mitsuba, scene)


SCENES = {"Cornell box of Mitsuba": cornell, "room of spheres": room_of_spheres}


def shown(row):
    """What the guide has of a row: all but seconds."""
    return {name: value for name, value in asdict(row).items() if not name.startswith("seconds")}


def table(rows):
    """The rows as a Markdown table, with seconds where they have them."""
    timed = any(r.seconds is not None for r in rows)
    lines = [
        "| scene | points | paths at each | reference's error, % | Mitsuba's, % | chi-square p | largest z "
        "| mean z | agree |" + timed * " seconds | Mitsuba's |",
        "|---|" + "--:|" * (8 + 2 * timed),
    ]
    for r in rows:
        lines.append(
            f"| {r.scene} | {r.points} | {r.paths} | {100 * r.reference:.2g} | {100 * r.mitsuba:.2g} "
            f"| {r.chi_square_p:.2g} | {r.largest_z:.2f} | {r.mean_z:.2f} | {'yes' if r.passes else 'NO'} |"
            + (f" {r.seconds:.2f} | {r.seconds_mitsuba:.2f} |" if timed else "")
        )
    return "\n".join(lines)
