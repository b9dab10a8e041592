"""What `surflux relight` does."""

import shlex
from pathlib import Path

import surflux as sf
from surflux._base import check
from surflux._base.files import file_error, require_file, require_place
from surflux.cli.pictures import (
    background_of,
    camera_of,
    check_film,
    check_gaussians,
    check_images,
    exposed,
    tone_of_series,
    write_gaussians,
)
from surflux.cli.relight_lights import MovingLamps, TurningEnvironment
from surflux.cli.saying import error_lines, lines_of_files
from surflux.drawing.plots import picture_path
from surflux.pictures.animation import FILMS, NUMBER
from surflux.viewing.page import page_path

TRANSFER = ".transfer"  # the suffix of what Transfer.save writes


def run(options):
    """One `surflux relight`: a dict for programs and lines of text."""
    _require_input(options.input)
    settings = _settings(options)
    transfer = sf.load_transfer(options.input) if _is_transfer(options) else None
    lights = _lights_of(options, transfer)
    relights = bool(options.image or options.output or options.export or options.gaussians)
    off_screen = relights or options.save is not None
    _refuse_options(options, off_screen, lights.count)
    scene = transfer.scene if transfer else sf.load_scene(options.input, threads=options.threads, progress=True)
    camera = camera_of(options, scene.surfels, scene.camera)
    lights.take(scene, relights)
    if options.export is not None and camera.height is not None:
        raise ValueError("--export: wanted a camera without height, for a page is drawn in perspective alone")
    if transfer is None:
        transfer = sf.precompute_transfer(scene, lights.lighting, **settings, progress=True)
    if options.bounces is not None:
        transfer.bounces = None if options.bounces == "all" else options.bounces
    result = {
        "input": options.input,
        "surfels": len(scene.surfels),
        "receivers": len(transfer.receivers[0]),
        "links": transfer.links,
        "bytes": transfer.nbytes,
        "timings": transfer.timings,
        "frames": lights.count,
    }
    lines = [f"{check.counted(result['surfels'], 'surfel')}, {transfer}"]
    if options.save is not None:
        result["transfer"] = saved = transfer.save(options.save)
        lines.append(f"transfer: {saved} ({saved.stat().st_size / 1e6:.1f} MB)")
    if not off_screen:
        look = {"stops": options.stops, "size": options.size, "screenshot": options.screenshot}
        path = lights.window(transfer, camera=camera, **look)
        return result | {"picture": path}, lines + ([] if path is None else [f"picture: {path}"])
    first = lights.checked(transfer) if relights else None
    outputs = _saved(transfer, lights, options)
    images = _drawn(transfer, lights, camera, options)
    lights.say()
    result |= {"outputs": outputs, "images": [path for series in images for path in series]}
    if first is not None:  # it stands for all frames
        result["error"], result["history"] = first.error, first.history
        lines += error_lines(first, lights.what(transfer))
    lines += lines_of_files("relit surfels", outputs)
    lines += [line for series in images for line in lines_of_files("picture", series)]
    if options.gaussians is not None:
        write_gaussians(lights.relit(transfer, 0), options)
        result["gaussians"] = options.gaussians
        lines.append(f"Gaussians: {options.gaussians}")
    if options.export is not None:
        page = lights.page(transfer, camera, scene.name or Path(options.input).stem).save(options.export)
        result["page"] = page
        lines.append(f"page: {page} ({page.stat().st_size / 1e6:.1f} MB)")
    return result, lines


def _require_input(name):
    """Refuses files of another kind, and says what they would have to become."""
    suffix = Path(name).suffix.lower()
    if suffix in (".toml", TRANSFER):
        return
    require_file(name)
    made = (
        f'[[object]] with file = "{Path(name).name}" in a scene file makes one of points (kind = "mesh": of a mesh); '
        f"`surflux doctor {shlex.quote(name)}` says what the file holds"
    )
    raise file_error(name, f"wanted a scene (.toml), or what --save wrote of one ({TRANSFER}): {made}")


def _is_transfer(options):
    return Path(options.input).suffix.lower() == TRANSFER


def _settings(options):
    """What precompute_transfer is given; refused of what is precomputed."""
    settings = {name: getattr(options, name) for name in ("epsilon_t", "rays", "seed")}
    settings = {name: value for name, value in settings.items() if value is not None}
    if _is_transfer(options) and set(settings) - {"seed"}:
        name = min(set(settings) - {"seed"}).replace("_", "-")
        raise ValueError(f"--{name}: is for a scene; {options.input} is precomputed")
    return settings


def _lights_of(options, transfer):
    """What is asked to change: lamps, or an environment."""
    if isinstance(transfer, sf.SkyTransfer):
        wanted = "wanted one of lamps or of distant light"
        raise ValueError(f"{options.input}: is a transfer of skies, which `SkyTransfer.relight` takes; {wanted}")
    if isinstance(transfer, sf.DistantTransfer) or options.environment is not None:
        return TurningEnvironment(options, transfer)
    return MovingLamps(options)


def _refuse_options(options, off_screen, frames):
    """Refuses, before any work, what would only be found out after it."""
    if options.direct is not None and not options.image:
        raise ValueError("--direct: is of pictures; wanted with --image")
    if off_screen and options.screenshot is not None:
        raise ValueError("--screenshot: is the window's; wanted without --image, -o, --export, --gaussians and --save")
    if options.save is not None:
        if _is_transfer(options):
            raise ValueError(f"--save: is for a scene; {options.input} is precomputed")
        if Path(options.save).suffix.lower() != TRANSFER:
            raise ValueError(f"--save: wanted a name ending in {TRANSFER}, got {options.save!r}")
        require_place(options.save)
    if options.gaussians is not None:
        if frames > 1:
            raise ValueError(f"--gaussians: is of one frame; there are {frames}")
        check_gaussians(options.gaussians)
    if options.screenshot is not None:
        picture_path("--screenshot", options.screenshot)
    if options.export is not None:
        require_place(page_path("--export", options.export))
    if frames > 1 and not (options.image or options.output):
        wanted = "wanted --image with a film (.mp4, .gif) or a pattern, such as frames/%04d.png, or -o frames/%04d.ply"
        raise ValueError(f"--path: {options.path} has {frames} frames; {wanted}")
    for image in options.image or []:
        if _is_series(image):
            check_film(image, options)
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


def _saved(transfer, lights, options):
    if options.output is None:
        return []
    paths = []
    for k in range(lights.count):
        path = options.output % (k + 1) if len(NUMBER.findall(options.output)) == 1 else options.output
        require_place(path)
        lights.relit(transfer, k).save(path)
        paths.append(path)
    return paths


def _drawn(transfer, lights, camera, options):
    """Paths of the pictures and films written: a list for each name that was asked for."""
    settings = {"samples": options.samples, "culling": not options.both_sides}
    background = background_of(options)
    paths = []
    single = [image for image in options.image or [] if not _is_series(image)]
    series = [image for image in options.image or [] if _is_series(image)]
    if single:
        lights.write_images(transfer, camera, options, single, background=background, **settings)
        paths += [[image] for image in single]
    if series:

        def first():
            return lights.relit(transfer, 0).render(camera, options.size, **settings)

        tone, behind = exposed(first, options, background)
        for image in series:
            film = {"camera": camera, "fps": options.fps, "background": behind, "progress": True, **settings}
            film |= tone_of_series(image, tone, options)
            paths.append(lights.film(transfer, image, options.size, **film))
    return [[str(path) for path in series] for series in paths]
