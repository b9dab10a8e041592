"""Frames a second and errors of LampRenderer under a lamp that moves, beside path tracing of single pixels.

`python tests/support/lamp_frames.py SCENE.toml|FILE.transfer FROM TO`, where places are x,y,z, moves a light from one
to the other, in steps: a point light, or with `--side` a square area light of that side that shines downwards. Errors
are RMS over pixels drawn at random, relative to the RMS of the truth there.
"""

import argparse
import time

import numpy as np

import surflux as sf
from surflux.bench.pictures import unproject

LAYERS = ["radiance", "direct", "indirect"]


def rms(values):
    return np.sqrt((values**2).sum(axis=-1).mean())


def errors(transfer, renderer, lamp, count, samples, seed=0):
    """{name: relative RMS error of the picture, of direct and of indirect light} of frames and of Solution.render."""
    frame = renderer.frame(lamp, layers=True)
    index = frame["index"]
    places = unproject(renderer.camera, frame["depth"], renderer.size)
    rng = np.random.default_rng(seed)
    rows, columns = np.nonzero(index >= 0)
    chosen = rng.choice(len(rows), min(count, len(rows)), replace=False)
    at = rows[chosen], columns[chosen]
    normals = transfer.scene.surfels.normals[index[at]]
    scene = sf.Scene(transfer.scene.objects, lights=[lamp])
    found, noise = sf.reference_irradiance(scene, places[at], normals, samples)
    dark = sf.Scene([s.replace(reflectance=0.0) for s in transfer.scene.objects], lights=[lamp])
    direct, _ = sf.reference_irradiance(dark, places[at], normals, samples)
    albedo = frame["albedo"][at].astype(float) / np.pi
    truth = {"radiance": albedo * found, "direct": albedo * direct, "indirect": albedo * (found - direct)}
    variance = (albedo * noise) ** 2
    drawn = transfer.relight(lamp).render(renderer.camera, renderer.size, samples=1, layers=LAYERS)
    out = {}
    for name, picture in {"frame": frame, "render": drawn}.items():
        off = {}
        for layer in LAYERS:
            squared = ((picture[layer][at] - truth[layer]) ** 2).sum(axis=-1).mean()
            if layer != "direct":
                squared -= variance.sum(axis=-1).mean()
            off[layer] = np.sqrt(max(squared, 0.0)) / rms(truth[layer])
        out[name] = off
    return out


def lamp_at(place, side):
    if not side:
        return sf.PointLight(place, 100.0)
    corner = place - [side / 2, side / 2, 0]
    return sf.AreaLight(corner, [0, side, 0], [side, 0, 0], 400.0 / side**2)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("start")
    parser.add_argument("end")
    parser.add_argument("--side", type=float, default=0.0)
    parser.add_argument("--size", default="960x720")
    parser.add_argument("--subpixels", type=int, default=1, help="of a pixel each way")
    parser.add_argument("--bounces", default=3, type=lambda text: None if text == "all" else int(text))
    parser.add_argument("--frames", type=int, default=40)
    parser.add_argument("--pixels", type=int, default=0, help="that are path traced for three of the frames")
    parser.add_argument("--samples", type=int, default=4096)
    given = parser.parse_args()
    if given.scene.endswith(".transfer"):
        transfer = sf.load_transfer(given.scene)
    else:
        transfer = sf.precompute_transfer(sf.load_scene(given.scene))
    transfer.bounces = given.bounces
    size = tuple(int(side) for side in given.size.split("x"))
    start, end = (np.array([float(x) for x in text.split(",")]) for text in (given.start, given.end))
    lamps = [lamp_at(start + t * (end - start), given.side) for t in np.linspace(0, 1, given.frames)]
    renderer = sf.LampRenderer(transfer, None, size, samples=given.subpixels)
    every = sf.LampRenderer(transfer, None, size, samples=given.subpixels, shadow_cell=1)
    renderer.frame(lamps[0])
    seconds, wrong = [], []
    for lamp in lamps:
        began = time.perf_counter()
        picture = renderer.frame(lamp)
        seconds.append([time.perf_counter() - began, *renderer.frame_timings.values()])
    for lamp in lamps[:: max(1, given.frames // 8)]:
        picture, all_rays = renderer.frame(lamp), every.frame(lamp)
        off = np.abs(picture - all_rays).max(axis=-1) > 1e-4 * all_rays.max(axis=-1)
        wrong.append((off.mean(), rms(picture - all_rays) / rms(all_rays)))
    best = np.median(seconds, axis=0)
    stages = ", ".join(f"{n} {1e3 * s:.0f}" for n, s in zip(renderer.frame_timings, best[1:], strict=True))
    print(
        f"{1 / best[0]:.1f} frames/s: {1e3 * best[0]:.0f} ms ({stages}), fastest {1e3 * np.min(seconds, axis=0)[0]:.0f}"
    )
    print(f"ready in s: {dict((k, round(v, 3)) for k, v in renderer.timings.items())}, {renderer.nbytes / 1e6:.0f} MB")
    print("beside a ray for every pixel: {:.1e} of pixels, {:.2f} % RMS".format(*(np.mean(wrong, axis=0) * [1, 100])))
    if given.pixels:
        for lamp in (lamps[0], lamps[len(lamps) // 2], lamps[-1]):
            found = errors(transfer, renderer, lamp, given.pixels, given.samples)
            for name, off in found.items():
                print(lamp, name, {layer: f"{100 * e:.1f} %" for layer, e in off.items()})


if __name__ == "__main__":
    main()
