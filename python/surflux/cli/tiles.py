"""`surflux solve TILES --tiles`: a survey tile by tile, into a folder, and a map of it."""

import contextlib
import re
from pathlib import Path

import surflux as sf
from surflux._base import check
from surflux._base.passes import LOG
from surflux.cli.pictures import check_images
from surflux.scenes.lights import Environment

_OWN = ("halo", "far", "unit")  # options that go with --tiles alone
_SHARED = ("points", "viewpoint", "normals", "albedo", "keep_outliers", "raw_colors", "strict", "seed", "threads")
_SOLVE = ("error", "seconds", "tolerance", "zeta", "rays", "transport", "insert")
# Options of solve that do not go with --tiles, and why.
_REFUSED = {
    "thin": "; --points thins all tiles alike",
    "solution": "; each tile is written with its light alone",
    "ground": "",
    "mesh": "; tiles hold points",
    **dict.fromkeys(("mpi", "cluster"), "; tiles are solved by one process"),
    "checkpoint": "; a run that was stopped goes on with the tile that it had not finished",
    **dict.fromkeys(("background", "direct"), "; --image is a map, black where no point is"),
    **dict.fromkeys(("size", "eye", "target", "up", "fov"), "; --image is a map from above, of all tiles"),
}
_FLAGS = {"folder": "-o", "paths": "tiles", "viewpoint": "--viewpoint"}  # of arguments that only solve_tiles can check
_HINT = re.compile(r"(?<=\()(unit|points|viewpoint|raw_colors)(?=\)|: | keeps)")  # as in "(viewpoint: elsewhere)"


def check_options(options):
    """Refuses options of `solve` that do not go together with --tiles, or without it."""
    if not options.tiles:
        for name in _OWN:
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: goes with --tiles")
        if len(options.inputs) > 1:
            text = f"wanted one file, or tiles of one survey by --tiles; got {len(options.inputs)} files"
            raise ValueError(f"SCENE|CLOUD: {text}")
        return
    for name, why in _REFUSED.items():
        if getattr(options, name) is not getattr(options.usual, name):
            raise ValueError(f"--{name}: does not go with --tiles{why}")
    if options.solver == "meshless":
        raise ValueError("--solver: wanted radiosity with --tiles, got 'meshless'")
    if options.light == "studio":
        raise ValueError("--light: wanted sun or sky with --tiles, got 'studio', whose lamp goes by a camera")
    bounds = {"halo": (0.0, 1e9, True), "far": (1.0, 1e6, False), "unit": (0.0, 1e9, True)}
    for name, (low, high, is_open) in bounds.items():
        if getattr(options, name) is not None:
            check.number(f"--{name}", getattr(options, name), low, high, low_open=is_open)


def run(options):
    """What is found: a dict for programs, and lines of text. Writes the tiles, and the map."""
    images, folder = options.image or [], Path(options.output or "tiles_solved")
    check_images(images, folder)
    given = {name: getattr(options, name) for name in _OWN + _SHARED}
    given = {name: value for name, value in given.items() if value is not None}
    settings = {name: getattr(options, name) for name in _SOLVE if getattr(options, name) is not None}
    if options.light is None:
        LOG.info("tiles have no light: they get the sun and sky of a clear day, in W/m2 (--light sky)")
    lights = [Environment(1.0)] if options.light == "sky" else None
    with _named_by_flags():
        found = sf.solve_tiles(options.inputs, folder, lights=lights, **given, solve_options=settings, progress=True)
    if images:
        picture = found.map(progress=True)
        tone = {"exposure": options.exposure, "stops": options.stops, "filmic": not options.linear}
        for image in images:
            sf.write_image(image, picture, **(tone if Path(image).suffix.lower() == ".png" else {}))
    result = {"input": options.inputs, "output": str(folder), "images": [str(image) for image in images]}
    result["tiles"] = [vars(tile) for tile in found]
    return result, _lines(found, folder, images)


@contextlib.contextmanager
def _named_by_flags():
    """What solve_tiles logs and refuses while the block runs names options of the command, not arguments."""

    def renamed(record):
        record.msg, record.args = _HINT.sub(lambda hint: f"--{hint[0].replace('_', '-')}", record.getMessage()), ()
        return True

    LOG.addFilter(renamed)
    try:
        yield
    except ValueError as error:
        name, colon, rest = str(error).partition(": ")
        if colon and name in _FLAGS:
            raise ValueError(f"{_FLAGS[name]}: {rest}") from error
        raise
    finally:
        LOG.removeFilter(renamed)


def _lines(found, folder, images):
    lines = []
    for tile in found:
        how = "kept" if tile.kept else f"{tile.seconds:.1f} s"
        points = check.counted(tile.points, "point")
        lines.append(f"{tile.output}: {points}, estimated error {100 * tile.error:.2g} %, {how}")
    count, kept = sum(tile.points for tile in found), sum(tile.kept for tile in found)
    some = f", {kept} of them solved before" if kept else ""
    tiles, points = check.counted(len(found), "tile"), check.counted(count, "point")
    lines.append(f"{tiles}{some}: {points}, as read, with their light, in {folder}")
    return lines + [f"map: {image}" for image in images]
