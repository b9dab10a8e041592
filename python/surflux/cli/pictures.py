"""What commands that draw have in common: single pictures, Gaussians, and the camera of the command line."""

from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base.files import require_place
from surflux._base.passes import LOG
from surflux.cli.saying import say
from surflux.pictures.animation import check_series, check_target
from surflux.pictures.backdrop import radiance_shown_as
from surflux.pictures.framing import own_or_framing
from surflux.pictures.images import resolved_exposure
from surflux.solutions.background import add_background, environments_behind


def check_images(images, made=None):
    """Refuses what is no name of a single picture. made: a folder that may be made until then."""
    for image in map(Path, images):
        if image.suffix.lower() not in (".exr", ".png", ".hdr"):
            raise ValueError(f"--image: wanted a name ending in .exr, .png or .hdr, got {str(image)!r}")
        if made is None or image.parent.exists() or image.parent.resolve() != made.resolve():
            require_place(image)


def check_film(image, options):
    """Refuses what is no name of a film or of numbered pictures, and options that they do not take."""
    check_target(image, "--image")
    try:
        check_series(Path(image).suffix.lower(), options.size, options.exposure, options.stops, not options.linear)
    except ValueError as error:
        name, _, said = str(error).partition(": ")
        raise ValueError(f"--{'linear' if name == 'filmic' else name}: {said}") from None


def write_images(solution, camera, options, images, *, background, samples=2, **settings):
    """Each picture of a solution in the format of its name; background: as of write_layers."""

    def drawn(layers):
        return solution.render(camera, options.size, layers=layers, samples=samples, progress=True, **settings)

    write_layers(drawn, camera, samples, options, images, background, solution._environments)


def draw_if_possible(solution, camera, options, images, **settings):
    """write_images; where there is no OpenGL, says so and returns why."""
    try:
        if images:
            write_images(solution, camera, options, images, **settings)
    except sf.DeviceError as error:
        say(f"warning: no picture, for {error} (--no-image asks for none)")
        return error
    return None


def write_layers(drawn, camera, samples, options, images, background, environments=()):
    """Each picture in the format of its name; only EXR has room for what the light is made of.

    Args:
        drawn: function of the names of layers, or True for all, that draws them before black.
        camera, samples: by which it draws.
        background: True for the environments; or the display value, from 0 to 1, of what is seen behind, or three of
            them. Files of radiance have what the exposure would show so.
        environments: list of Environment.
    """
    all_of_it = any(Path(image).suffix.lower() == ".exr" for image in images)
    layers = drawn(all_of_it or ["radiance", "alpha"])
    tone, behind = exposed(lambda: layers["radiance"], options, background)
    layers = add_background(layers, environments_behind(behind, environments), camera, samples)
    for image in images:
        sf.write_image(image, layers, **(tone if Path(image).suffix.lower() == ".png" else {}))


def animations(solution, camera, options, images, background, settings):
    """Paths of films and numbered pictures from around what a camera looks at, a list for each; settings: of
    Solution.render.
    """
    tone, behind = exposed(lambda: solution.render(camera, options.size, **settings), options, background)
    cameras, paths = sf.turntable(camera, options.turntable), []
    for image in images:
        given = {"fps": options.fps, "background": behind, "progress": True, **settings}
        given |= tone_of_series(image, tone, options)
        paths.append(solution.animate(cameras, image, options.size, **given))
    return paths


def exposed(first, options, background):
    """(exposure, stops and filmic of pictures; the radiance that they show as the background, or True for True).

    first: function that draws a picture without background, by which the exposure is found where none is given: a sky
    and a sun in it have no say.
    """
    tone = {"exposure": options.exposure, "stops": options.stops, "filmic": not options.linear}
    if not np.any(background):
        return tone, 0.0
    factor = options.exposure if options.exposure is not None else resolved_exposure(None, first())
    tone["exposure"] = factor
    if background is True:
        return tone, True
    color = np.broadcast_to(background, (3,))
    return tone, radiance_shown_as(color, factor * 2.0**options.stops, tone["filmic"])


def tone_of_series(path, tone, options):
    """The tone of a film or of numbered pictures; of files of radiance what was asked for alone, which they refuse."""
    return tone | {"exposure": options.exposure} if Path(path).suffix.lower() in (".exr", ".hdr") else tone


def background_of(options, default=True):
    """What is to be seen behind, as write_layers takes it: of --background, which has "sky" for True."""
    return {None: default, "sky": True}.get(options.background, options.background)


def check_gaussians(path):
    """Refuses what is no name of a file of Gaussians."""
    if Path(path).suffix.lower() not in (".ply", ".glb", ".gltf"):
        raise ValueError(f"--gaussians: wanted a name ending in .ply, .glb or .gltf, got {str(path)!r}")
    require_place(path)


def write_gaussians(solution, options):
    """Exposed as the options say; in glTF, what is up in pictures is up."""
    gaussians = sf.Gaussians.of(solution, exposure=options.exposure, stops=options.stops, progress=True)
    up = None if Path(options.gaussians).suffix.lower() == ".ply" else options.up
    gaussians.save(options.gaussians, up=up)


def _is_vertical(options):
    """Whether the camera looks straight up or down."""
    return bool(options.eye and options.target) and tuple(options.eye[:2]) == tuple(options.target[:2])


def camera_of(options, surfels, default):
    """The camera of the command line; what it leaves open comes from the scene, or frames the surfels."""
    up = options.up
    if default is None and up is None and (options.eye or options.target) and not _is_vertical(options):
        up = (0.0, 0.0, 1.0)  # also where the picture would be taken from straight above, with another side up
    default = own_or_framing(default, surfels, options.size, up)
    chosen = {name: getattr(options, name) for name in ("eye", "target", "up", "fov")}
    height = default.height if options.fov is None else None
    found = {name: getattr(default, name) if value is None else value for name, value in chosen.items()}
    camera = sf.Camera(**found, height=height)
    LOG.debug("camera: %r", camera)
    return camera
