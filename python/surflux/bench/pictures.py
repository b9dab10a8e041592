"""`python -m surflux.bench.pictures SCENE.toml OUT.png`: what insertion does to a picture (D04 fig. 6).

From left to right: solved on the scene's own surfels, with insertion, and path traced; below the first two their
differences from the third, ten times as bright, about grey. Seconds and RMS differences go to stdout. The traced
picture has the geometry of the splatted one, and at each pixel the irradiance of reference_irradiance.
"""

import argparse

import numpy as np

import surflux as sf
from surflux.pictures.framing import own_or_framing

AMPLIFIED = 10.0


def main(arguments=None):
    """Writes the picture; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m surflux.bench.pictures", description=__doc__.split("\n\n")[0])
    parser.add_argument("scene", metavar="SCENE.toml")
    parser.add_argument("output", metavar="OUT.png")
    parser.add_argument("--size", type=int, default=400, metavar="PIXELS", help="of one picture (default: 400)")
    parser.add_argument("--paths", type=int, default=256, metavar="N", help="of the path tracer at each pixel")
    options = parser.parse_args(arguments)
    scene = sf.load_scene(options.scene)
    size = (options.size, options.size)
    pictures = []
    for insert in (False, True):
        solution = sf.solve(scene, insert=insert)
        seconds = sum(solution.timings.values())
        print(f"insert={insert}: {len(solution.surfels)} surfels, {seconds:.2f} s, own error {solution.error:.2%}")
        pictures.append(solution.render(size=size, samples=1))
    truth = traced(scene, solution, size, options.paths)
    level = np.sqrt(np.mean(truth**2))
    gray = 0.5 * np.quantile(truth, 0.9)
    rows = []
    for insert, picture in zip((False, True), pictures, strict=True):
        off = np.sqrt(np.mean((picture - truth) ** 2)) / level
        print(f"insert={insert}: RMS difference of the pictures {off:.2%}")
        rows.append(np.maximum(0.0, gray + AMPLIFIED * (picture - truth)))
    upper = np.concatenate([*pictures, truth], axis=1)
    lower = np.concatenate([*rows, np.zeros_like(truth)], axis=1)
    sf.write_image(options.output, np.concatenate([upper, lower]).astype(np.float32))
    return 0


def traced(scene, solution, size, paths, seed=0):
    """The picture that solution.render(size=size, samples=1) would be if its irradiance were exact: (h, w, 3)."""
    layers = solution.render(size=size, samples=1, layers=True)
    seen = layers["index"] >= 0
    camera = own_or_framing(solution.camera, solution.surfels, size)
    points = unproject(camera, layers["depth"], size)[seen]
    normals = layers["normal"][seen]
    irradiance, _ = sf.reference_irradiance(scene, points, normals, samples=paths, seed=seed)
    surfel = layers["index"][seen]
    out = layers["radiance"].copy()  # lamps and what is behind the scene
    rho, emission = solution.surfels.reflectance[surfel], solution.surfels.emission[surfel]
    out[seen] = (emission + rho * irradiance) / np.pi
    return out


def unproject(camera, depth, size):
    """The points (h, w, 3) in the middle of the pixels at these depths along the view axis; infinite where they are."""
    width, height = size
    right, down, forward = camera._axes()
    parallel = camera.height is not None
    scale = height / camera.height if parallel else 0.5 * height / np.tan(np.radians(camera.fov) / 2.0)
    column, row = np.meshgrid(np.arange(width) + 0.5 - 0.5 * width, np.arange(height) + 0.5 - 0.5 * height)
    across = (column[..., None] * right + row[..., None] * down) / scale
    if parallel:
        return camera.eye + across + depth[..., None] * forward
    way = forward + across
    return camera.eye + depth[..., None] * way


if __name__ == "__main__":
    raise SystemExit(main())
