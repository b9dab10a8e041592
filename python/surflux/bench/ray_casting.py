"""Pictures of solutions by ray casting: what splatted ones are judged by. Nothing of this knows OpenGL.

How far the two agree is a peak signal to noise ratio, white being the 99th percentile of what surfaces show.
"""

import sys
from dataclasses import dataclass

import numpy as np

import surflux as sf
from surflux import _core
from surflux.bench import scenes

SCENES = ("three spheres", "statues", "Cornell box")
SIZE, SUBPIXELS = (400, 300), 2


@dataclass
class Row:
    """One scene, drawn at so many subpixels each way."""

    scene: str
    width: int
    height: int
    subpixels: int
    decibels: float


def ray_cast(solution, camera, size, samples):
    """(h, w, 3) linear radiance, and white: the 99th percentile of what surfels, and not lamps, show. A ray
    through each subpixel, and the solution's light where it meets a front.

    The surfaces are the disks and triangles of the scene as Embree has them. The light there is interpolated between
    surfels by the fit that irradiance_at uses, of radiosity.
    """
    width, height = size
    right, down, forward = camera._axes()
    tan = np.tan(np.radians(camera.fov) / 2.0)
    fine = width * samples, height * samples
    x = (2.0 * (np.arange(fine[0]) + 0.5) / fine[0] - 1.0) * tan * width / height
    y = (2.0 * (np.arange(fine[1]) + 0.5) / fine[1] - 1.0) * tan
    x, y = (v.reshape(-1, 1) for v in np.meshgrid(x, y))
    ways = forward + x * right + y * down
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    eyes = np.tile(camera.eye, (len(ways), 1))

    scene = solution._scene._to_core()
    surfel, distance = _core.seen_fronts(scene, eyes, ways)
    distance = np.where(surfel >= 0, distance, np.inf)
    radiance = np.zeros((len(ways), 3))
    for lamp in solution._lamps:
        normal = np.cross(lamp.edge_u, lamp.edge_v)
        facing = ways @ normal < 0
        away = np.where(facing, (lamp.corner - camera.eye) @ normal / np.where(facing, ways @ normal, 1.0), np.inf)
        at = camera.eye + np.where(np.isfinite(away), away, 0.0)[:, None] * ways - lamp.corner
        u, v = (at @ edge / (edge @ edge) for edge in (np.asarray(lamp.edge_u), np.asarray(lamp.edge_v)))
        hit = (away > 0) & (away < distance) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        radiance[hit] = np.divide(lamp.exitance, np.pi)
        distance[hit] = away[hit]
        surfel[hit] = -1
    seen = surfel >= 0
    places = camera.eye + distance[seen, None] * ways[seen]
    normals = scene.surfels.normals[surfel[seen]]
    buried = (solution.radiosity == 0).all(axis=1)
    groups = (2 * solution.objects + buried).astype(np.uint32)
    field = _core.Field(solution.surfels._core, groups, [solution.radiosity], scene, None)
    radiance[seen] = np.maximum(field.at(0, places, normals, None), 0.0) / np.pi
    white = np.percentile(radiance[seen].max(axis=1), 99)
    return radiance.reshape(height, samples, width, samples, 3).mean(axis=(1, 3)), white


def psnr(picture, exact, white):
    """Decibels: both linear, cut off at white."""
    difference = np.minimum(picture, white) - np.minimum(exact, white)
    return 10 * np.log10(white**2 / np.mean(difference**2))


def measure(names, threads=None):
    """A Row for each scene."""
    rows = []
    for name in names:
        print(f"bench: {name}, ray casting", file=sys.stderr)
        scene = scenes.build(name).scene
        solution = sf.solve(scene, **scene.solve_options, threads=threads)
        exact, white = ray_cast(solution, scene.camera, SIZE, SUBPIXELS)
        drawn = solution.render(size=SIZE, samples=SUBPIXELS)
        rows.append(Row(name, *SIZE, SUBPIXELS, float(psnr(drawn, exact, white))))
    return rows


def table(rows):
    """Markdown: a line for each scene."""
    lines = ["| scene | pixels | agreement, dB |", "|---|--:|--:|"]
    return "\n".join([*lines, *(f"| {r.scene} | {r.width} x {r.height} | {r.decibels:.1f} |" for r in rows)])
