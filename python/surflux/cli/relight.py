"""What `surflux relight` does."""

from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux._base.warn import warn
from surflux.cli.pictures import camera_of, check_images, write_images
from surflux.drawing.plots import picture_path
from surflux.pictures.animation import FILMS, NUMBER, check_target

TRANSFER = ".transfer"  # the suffix of what Transfer.save writes


def run(options):
    """One `surflux relight`: a dict for programs and lines of text."""
    off_screen = bool(options.image or options.output)
    frames = None if options.path is None else sf.load_lamps(options.path)
    _refuse_options(options, off_screen, 1 if frames is None else len(frames))
    transfer = transfer_of(options)
    scene = transfer.scene
    frames = [_own_lamps(options.input, scene)] if frames is None else frames
    camera = camera_of(options, scene.surfels, scene.camera)
    result = {
        "input": options.input,
        "surfels": len(scene.surfels),
        "receivers": len(transfer.receivers[0]),
        "links": transfer.links,
        "bytes": transfer.nbytes,
        "timings": transfer.timings,
        "frames": len(frames),
    }
    lines = [f"{check.counted(result['surfels'], 'surfel')}, {transfer}"]
    if not off_screen:
        path = sf.move_lamps(
            transfer, frames[0], camera=camera, stops=options.stops, size=options.size, screenshot=options.screenshot
        )
        return result | {"picture": path}, lines + ([] if path is None else [f"picture: {path}"])
    if not any(frames) and not np.any(scene.surfels.emission):
        raise ValueError(f"{options.input}: has no lamps; --path LIGHTS.toml gives it some")
    outputs = _saved(transfer, frames, options)
    images = _drawn(transfer, frames, camera, options)
    result |= {"outputs": outputs, "images": images}
    lines += [f"relit surfels: {path}" for path in outputs] + [f"picture: {path}" for path in images]
    return result, lines


def transfer_of(options):
    """The Transfer of a file of one, or of a scene, for which it is found first."""
    path = Path(options.input)
    settings = {name: getattr(options, name) for name in ("epsilon_t", "rays", "seed")}
    settings = {name: value for name, value in settings.items() if value is not None}
    if path.suffix.lower() == TRANSFER:
        if set(settings) - {"seed"}:
            raise ValueError(f"--{min(settings).replace('_', '-')}: is for a scene; {path} is precomputed")
        transfer = sf.load_transfer(path)
    else:
        scene = sf.load_scene(path, threads=options.threads, progress=True)
        transfer = sf.precompute_transfer(scene, **settings, progress=True)
    if options.bounces is not None:
        transfer.bounces = None if options.bounces == "all" else options.bounces
    return transfer


def _own_lamps(name, scene):
    """The scene's lamps; what is no lamp is left out, and told."""
    lamps = [light for light in scene.lights if not isinstance(light, sf.Environment)]
    if len(lamps) < len(scene.lights):
        warn(f"{name}: its environment is left out, for transfer is that of lamps")
    return lamps


def _refuse_options(options, off_screen, frames):
    """Refuses, before any work, what would only be found out after it."""
    if off_screen and options.screenshot is not None:
        raise ValueError("--screenshot: is the window's; wanted without --image and -o")
    if options.screenshot is not None:
        picture_path("--screenshot", options.screenshot)
    for image in options.image or []:
        if _is_series(image):
            check_target(image, "--image")
        elif frames > 1:
            what = f"a film (.mp4, .gif) or a pattern, such as frames/%04d.png, for {frames} frames"
            raise ValueError(f"--image: wanted {what}, got {image!r}")
        else:
            check_images([image])
    if options.output is not None and frames > 1 and len(NUMBER.findall(options.output)) != 1:
        what = f"a pattern, such as frames/%04d.ply, for {frames} frames"
        raise ValueError(f"-o: wanted {what}, got {options.output!r}")


def _is_series(image):
    return Path(image).suffix.lower() in FILMS or "%" in image


def _seed(options):
    return 0 if options.seed is None else options.seed


def _saved(transfer, frames, options):
    if options.output is None:
        return []
    paths = []
    for k, lights in enumerate(frames, start=1):
        path = options.output % k if len(NUMBER.findall(options.output)) == 1 else options.output
        require_place(path)
        transfer.relight(lights, seed=_seed(options)).save(path)
        paths.append(path)
    return paths


def _drawn(transfer, frames, camera, options):
    """Paths of the films and pictures written."""
    settings = {
        "samples": options.samples,
        "background": options.background,
        "culling": not options.both_sides,
    }
    paths = []
    single = [image for image in options.image or [] if not _is_series(image)]
    if single:
        solution = transfer.relight(frames[0], seed=_seed(options), progress=True)
        write_images(solution, camera, options, single, **settings)
        paths += single
    for image in options.image or []:
        if _is_series(image):
            tone = {"exposure": options.exposure, "stops": options.stops, "filmic": not options.linear}
            paths += sf.animate_lamps(
                transfer,
                frames,
                image,
                options.size,
                camera=camera,
                seed=_seed(options),
                fps=options.fps,
                progress=True,
                **tone,
                **settings,
            )
    return [str(path) for path in paths]
