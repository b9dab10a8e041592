"""Pictures of precomputed transfer for the guide (L07 figs. 7 and 8), beside path tracing, and a film.

`python tests/support/transfer_pictures.py buddha|sponza|film OUT`, with SURFLUX_DATA naming the folder of statues,
probes and scenes. "buddha" is glossy and stands in the Grace probe, turned twice, each beside path tracing under the
same 25 harmonics, and with the points at which visibility is kept; "sponza" has a lamp in three places, above by
LampRenderer, below path traced; "film" is a lamp that flies through Sponza. RMS differences, relative to the RMS of the
path traced picture and without its variance, go to stdout.
"""

import argparse
import os
import time
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench.pictures import unproject
from surflux.bench.transfer import grace_probe
from surflux.bench.transfer_truth import SUBPIXELS, traced_pictures
from surflux.scenes.transform import make_transform

DATA = Path(os.environ.get("SURFLUX_DATA", "."))
SPONZA = Path(__file__).parents[2] / "data" / "sponza.toml"
FINER = SUBPIXELS  # each way
GAP = 4  # pixels between pictures

BUDDHA_SIZE, BUDDHA_CAMERA = (172, 400), sf.Camera([0, -6, 0.3], [-0.05, -0.08, 0], fov=20.5)
BRONZE = {"specular": [0.5, 0.42, 0.3], "exponent": 20.0}
AZIMUTHS = (0, 180)

SPONZA_SIZE = (256, 192)
WARM = np.array([100.0, 88.0, 70.0])
# Before the camera, behind a curtain, farther down the nave.
LAMPS = [sf.PointLight(*lamp) for lamp in (([-6, -1, 4.5], WARM), ([-3, 4.5, 2], 4 * WARM), ([0, 0, 1.5], WARM))]
EXPOSURE = 0.6
FILM_SIZE = (208, 156)


def finer(size):
    return tuple(FINER * side for side in size)


def averaged(subpixels):
    """Of FINER x FINER subpixels each."""
    height, width = (side // FINER for side in subpixels.shape[:2])
    return subpixels.reshape(height, FINER, width, FINER, -1).mean(axis=(1, 3)).astype(np.float32)


def difference(picture, traced, variance=0.0):
    """Relative RMS difference, without what the noise of the path tracer has of it."""
    off = np.mean((picture - traced) ** 2) - np.mean(variance)
    return np.sqrt(max(off, 0.0) / np.mean(traced**2))


def row(pictures):
    height = len(pictures[0])
    gap = np.zeros((height, GAP, 3), np.float32)
    return np.concatenate([part for picture in pictures for part in (gap, picture)][1:], axis=1)


def bronze_buddha():
    body = sf.Surfels.from_mesh(DATA / "statues" / "buddha_50k.ply", reflectance=0.2, **BRONZE)
    upright = make_transform(rotate=[90, 0, 0])  # y is up in the file
    return sf.Scene([upright.surfels(body)], camera=BUDDHA_CAMERA)


def traced_gloss(solution, scene, samples):
    """(picture, variance) that the solution's picture has where radiance of each subpixel is path traced."""
    size = finer(BUDDHA_SIZE)
    layers = solution.render(BUDDHA_CAMERA, size, samples=1, layers=["normal", "depth", "index"])
    seen = layers["index"] >= 0
    points = unproject(BUDDHA_CAMERA, layers["depth"], size)[seen]
    own, at = scene.surfels, layers["index"][seen]
    found, error = sf.reference_radiance(
        scene,
        points,
        layers["normal"][seen],
        BUDDHA_CAMERA.eye - points,
        reflectance=own.reflectance[at],
        specular=own.specular[at],
        exponent=own.exponent[at],
        glossy_bounces=False,
        samples=samples,
    )
    picture, variance = np.zeros((2, *layers["normal"].shape))
    picture[seen], variance[seen] = found, error**2
    return averaged(picture), averaged(variance) / FINER**2


def dotted(transfer):
    """The points at which visibility is kept, where the camera sees them, on a plain statue."""
    size = finer(BUDDHA_SIZE)
    plain = transfer.relight(sf.Environment(1.0), reflectance=0.8, specular=0.0)
    layers = plain.render(BUDDHA_CAMERA, size, samples=1, layers=True)
    picture = 0.9 * layers["radiance"]
    points, normals = transfer.receivers
    column, line, depth = BUDDHA_CAMERA.project(points, size).T
    facing = ((BUDDHA_CAMERA.eye - points) * normals).sum(axis=1) > 0
    column, line = column.astype(int), line.astype(int)
    inside = (column > 0) & (column < size[0] - 1) & (line > 0) & (line < size[1] - 1) & facing
    column, line, depth = column[inside], line[inside], depth[inside]
    visible = depth < layers["depth"][line, column] + 0.01
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            picture[line[visible] + down, column[visible] + right] = 0.0
    return averaged(picture)


def buddha(out, transfer, samples):
    began = time.perf_counter()
    transfer = transfer or sf.precompute_transfer(bronze_buddha(), "distant")
    print(f"{transfer}, {len(transfer.scene.surfels)} surfels, {time.perf_counter() - began:.1f} s")
    probe = grace_probe()
    pictures = []
    for azimuth in AZIMUTHS:
        rotation = make_transform(rotate=[0, 0, azimuth]).rotation
        began = time.perf_counter()
        solution = transfer.relight(probe, rotation=rotation, **BRONZE)
        seconds = time.perf_counter() - began
        drawn = solution.render(BUDDHA_CAMERA, BUDDHA_SIZE, samples=FINER)
        light = sf.Environment.from_harmonics(sf.rotate_harmonics(probe.harmonics(5), rotation))
        lit = sf.Scene(transfer.scene.objects, lights=[light])
        traced, variance = traced_gloss(solution, lit, samples)
        off, noise = difference(drawn, traced, variance), np.sqrt(variance.mean() / np.mean(traced**2))
        print(f"turned by {azimuth}: relit in {seconds:.2f} s, off by {off:.1%} RMS (noise of the traced {noise:.1%})")
        view = solution, lit, BUDDHA_CAMERA, BUDDHA_SIZE
        known = traced_pictures(*view, glossy_bounces=False, paths=2 * samples).mean(axis=0)
        print(f"    beside surfels that are path traced and drawn alike: {difference(drawn, known):.1%}")
        print(f"    these beside each pixel path traced: {difference(known, traced, variance):.1%}")
        pictures += [drawn, traced]
    exposure = 0.5 / np.quantile(pictures[0].max(axis=-1)[pictures[0].max(axis=-1) > 0], 0.75)
    shown = [sf.tone_map(picture, exposure=exposure) for picture in pictures]
    save(out, row([*shown, sf.tone_map(dotted(transfer), exposure=1.0)]))


def sponza_transfer(transfer):
    began = time.perf_counter()
    transfer = transfer or sf.precompute_transfer(sf.load_scene(SPONZA))
    print(f"{transfer}, {time.perf_counter() - began:.1f} s")
    return transfer


def traced_light(transfer, renderer, lamp, samples):
    """(picture, variance) that renderer.frame(lamp) has where irradiance of each subpixel is path traced."""
    layers = renderer.frame(lamp, layers=["albedo", "normal", "depth", "index"])
    seen = layers["index"] >= 0
    points = unproject(renderer.camera, layers["depth"], renderer.size)[seen]
    scene = sf.Scene(transfer.scene.objects, lights=[lamp])
    found, error = sf.reference_irradiance(scene, points, layers["normal"][seen], samples=samples)
    picture, variance = np.zeros((2, *layers["albedo"].shape))
    albedo = layers["albedo"][seen] / np.pi
    picture[seen], variance[seen] = albedo * found, (albedo * error) ** 2
    return averaged(picture), averaged(variance) / FINER**2


def sponza(out, transfer, samples):
    transfer = sponza_transfer(transfer)
    renderer = sf.LampRenderer(transfer, None, SPONZA_SIZE, samples=FINER)
    each = sf.LampRenderer(transfer, None, finer(SPONZA_SIZE), samples=1)  # subpixel by subpixel
    drawn, traced = [], []
    for lamp in LAMPS:
        drawn.append(renderer.frame(lamp))
        truth, variance = traced_light(transfer, each, lamp, samples)
        traced.append(truth)
        off, noise = difference(drawn[-1], truth, variance), np.sqrt(variance.mean() / np.mean(truth**2))
        print(f"lamp at {lamp.position}: off by {off:.1%} RMS (noise of the traced {noise:.1%})")
    rows = [sf.tone_map(row(pictures), exposure=EXPOSURE) for pictures in (drawn, traced)]
    save(out, np.concatenate([rows[0], np.zeros((GAP, *rows[0].shape[1:])), rows[1]]))


def film(out, transfer, samples):
    frames = sf.load_lamps(Path(__file__).with_name("sponza_lamp.toml"))
    transfer = sponza_transfer(transfer)
    began = time.perf_counter()
    sf.animate_lamps(transfer, frames, out, FILM_SIZE, direct="traced", exposure=EXPOSURE, fps=20, samples=FINER)
    print(
        f"{out}: {Path(out).stat().st_size / 1e3:.0f} kB, {len(frames)} frames in {time.perf_counter() - began:.1f} s"
    )


def save(out, shown):
    """What tone_map gave, in 128 levels: three quarters of the bytes of 256, and the eye misses none."""
    from PIL import Image

    levels = np.minimum(2 * np.rint(127.5 * shown), 255).astype(np.uint8)
    Image.fromarray(levels).save(out, optimize=True)
    print(f"{out}: {Path(out).stat().st_size / 1e3:.0f} kB")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("picture", choices=["buddha", "sponza", "film"])
    parser.add_argument("out")
    parser.add_argument("--transfer", help="FILE.transfer, made before, in place of a new one")
    parser.add_argument("--samples", type=int, default=64, help="paths of each of the path tracer's subpixels")
    given = parser.parse_args()
    transfer = sf.load_transfer(given.transfer) if given.transfer else None
    {"buddha": buddha, "sponza": sponza, "film": film}[given.picture](given.out, transfer, given.samples)


if __name__ == "__main__":
    main()
