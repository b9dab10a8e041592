"""What commands that draw have in common: single pictures, Gaussians, and the camera of the command line."""

from pathlib import Path

import surflux as sf
from surflux._base.files import require_place
from surflux.pictures.framing import own_or_framing


def check_images(images):
    """Refuses what is no name of a single picture."""
    for image in map(Path, images):
        if image.suffix.lower() not in (".exr", ".png", ".hdr"):
            raise ValueError(f"--image: wanted a name ending in .exr, .png or .hdr, got {str(image)!r}")
        require_place(image)


def write_images(solution, camera, options, images, **settings):
    """Each picture of a solution in the format of its name."""
    write_layers(
        lambda layers: solution.render(camera, options.size, layers=layers, progress=True, **settings), options, images
    )


def write_layers(drawn, options, images):
    """Each picture in the format of its name; only EXR has room for what the light is made of.

    drawn: function of `layers`, as of Solution.render.
    """
    all_of_it = any(Path(image).suffix.lower() == ".exr" for image in images)
    layers = drawn(all_of_it or ["radiance"])
    for image in images:
        tone = {"exposure": options.exposure, "stops": options.stops, "filmic": not options.linear}
        sf.write_image(image, layers, **(tone if Path(image).suffix.lower() == ".png" else {}))


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


def camera_of(options, surfels, default):
    """The camera of the command line; what it leaves open comes from the scene, or frames the surfels."""
    default = own_or_framing(default, surfels, options.size, (0.0, 0.0, 1.0) if options.up is None else options.up)
    chosen = {name: getattr(options, name) for name in ("eye", "target", "up", "fov")}
    height = default.height if options.fov is None else None
    found = {name: getattr(default, name) if value is None else value for name, value in chosen.items()}
    return sf.Camera(**found, height=height)
