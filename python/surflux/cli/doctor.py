"""`surflux doctor`: what a file holds, what `surflux solve` would take for granted, and what to type next."""

import contextlib
import logging
import shlex
import warnings
from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.passes import LOG
from surflux._base.summary import box_text
from surflux.cli.cloud import camera_of_cloud
from surflux.cli.doctor_points import facts_of_points, lines_of_points, up_text
from surflux.cli.mesh import PATCHES, is_mesh, patches_of_mesh, take_up
from surflux.cli.saying import error_lines
from surflux.meshes.reading import MESHES_ALONE, read_mesh
from surflux.scans.formats import format_of
from surflux.solutions.solution_file import holds_solution

_PICTURES = (".exr", ".hdr", ".png")
# Measured on scans of 110 000 to 340 000 points: seconds of one core for 100 000 surfels, all stages and the picture;
# bytes of the process without any, and for a surfel more.
_CORE_SECONDS = (12.0, 40.0)
_BYTES, _BYTES_EACH = 0.4e9, 2.0e3
_FEW = 2000  # surfels that exchange light in pairs, within a second or two


def examined(options, limit, solve_options):
    """One `surflux doctor`: a dict for programs, and lines of text.

    limit, solve_options: see facts_of_points.
    """
    path = Path(options.input)
    suffix = path.suffix.lower()
    with _said() as said:
        if suffix == ".toml":
            result, lines = _scene(options)
        elif suffix == ".transfer":
            result, lines = _transfer(options)
        elif suffix in _PICTURES and path.is_file():
            result, lines = _picture(options)
        elif suffix in MESHES_ALONE or (suffix == ".obj" and _has_faces(path)):
            result, lines = _mesh(options, solve_options)
        elif format_of(path) == "ply" and holds_solution(path):
            result, lines = _solution(options)
        elif options.points is None and options.viewpoint is None and is_mesh(solve_options(["--", options.input])):
            result, lines = _mesh(options, solve_options)
        else:
            result = {"kind": "points"} | facts_of_points(options, limit, solve_options)
            result["solve"] |= _expense(options, result["solve"]["surfels"])
            lines = [*lines_of_points(result), *_expense_lines(result["solve"])]
    notes = [note for note in dict.fromkeys(said) if not any(note in line for line in lines)]
    notes = [note for note in notes if "has no light: it gets" not in note]  # a line of its own
    lines += [f"note: {note}" for note in notes]
    if "next" in result:
        lines.append(f"next: {result['next']}")
    return {"input": options.input, **result, "notes": notes}, lines


class _Kept(logging.Handler):
    """Keeps what is logged, but for progress, which goes to the handlers before."""

    def __init__(self, said, before):
        super().__init__()
        self.said, self.before = said, before

    def emit(self, record):
        if not getattr(record, "of_progress", False):
            self.said.append(record.getMessage())
            return
        for handler in self.before:
            handler.handle(record)


@contextlib.contextmanager
def _said():
    """What the library warns of and logs while the block runs, but for its progress, in place of saying it."""
    said, before, level = [], list(LOG.handlers), LOG.level
    LOG.handlers[:] = [_Kept(said, before)]
    LOG.setLevel(min(level, logging.INFO))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = lambda message, *_, **__: said.append(str(message))
            yield said
    finally:
        LOG.handlers[:] = before
        LOG.setLevel(level)


def _has_faces(path):
    from surflux import _core

    return path.is_file() and len(_core.read_obj(path)[1]) > 1


def _quoted(options):
    return shlex.quote(options.input)


def _expense(options, surfels):
    """What `surflux solve` is likely to take for so many surfels."""
    cores = sf.info()["threads"]
    cores = min(cores, options.threads or cores)
    seconds = [per * surfels / 1e5 / cores for per in _CORE_SECONDS] if surfels > _FEW else [0.0, 3.0]
    return {"seconds": seconds, "bytes": _BYTES + _BYTES_EACH * surfels, "threads": cores}


def _expense_lines(expected):
    low, high = expected["seconds"]
    some = "a few seconds" if high <= 3.0 else f"about {_time(low)} to {_time(high)}"
    on = check.counted(expected["threads"], "thread")
    return [f"expected of solve: {some} on {on}, {expected['bytes'] / 1e9:.1f} GB of memory"]


def _time(seconds):
    return f"{seconds:.2g} s" if seconds < 99.5 else f"{seconds / 60:.2g} min"


def _scene(options):
    scene = sf.load_scene(options.input, progress=True)
    surfels = scene.surfels
    kinds = {}
    for light in scene.lights:
        kinds[type(light).__name__] = kinds.get(type(light).__name__, 0) + 1
    shining = int(np.count_nonzero(surfels.emission.any(axis=1)))
    result = {
        "kind": "scene",
        "objects": len(scene.objects),
        "surfels": len(surfels),
        "patches": len(np.unique(surfels.triangle_surfel)),
        "emissive": shining,
        "bounds": surfels.bounds,
        "lights": kinds,
        "camera": None if scene.camera is None else scene.camera.to_dict(),
        "solve_options": scene.solve_options,
        "solve": _expense(options, len(surfels)),
        "next": f"surflux solve {_quoted(options)}",
    }
    lamps = ", ".join(f"{n} {kind}" for kind, n in kinds.items()) or "none"
    dark = "" if kinds or shining else ": it stays black until its file has a [[light]] or an emission"
    if dark:
        result["next"] = f"add a [[light]] to {options.input} (see help(surflux.load_scene)), then {result['next']}"
    objects = check.counted(result["objects"], "object")
    count = f"{check.counted(len(surfels), 'surfel')}, {result['patches']} of them patches of meshes"
    return result, [
        f"{options.input}: a scene of {objects}",
        f"surfels: {count}, {shining} emissive",
        f"bounds: {box_text(surfels.bounds)}",
        f"lights: {lamps}{dark}",
        f"camera: {scene.camera or 'none; pictures are seen from where most fronts show'}",
        *([f"its [solve] asks for: {scene.solve_options}"] if scene.solve_options else []),
        *_expense_lines(result["solve"]),
    ]


def _transfer(options):
    transfer = sf.load_transfer(options.input)
    result = {
        "kind": "transfer",
        "lighting": transfer.lighting,
        "surfels": len(transfer.scene.surfels),
        "bytes": transfer.nbytes,
    }
    file = _quoted(options)
    result["next"] = {
        "local": f"surflux relight {file} --path LAMPS.toml --image lamps.gif",
        "distant": f"surflux relight {file} --environment IMAGE.hdr",
    }.get(transfer.lighting, f"sf.load_transfer({options.input!r}).relight(...) in Python: skies have no command")
    of = {"local": "of lamps that move", "distant": "of distant light that turns"}.get(transfer.lighting, "of skies")
    return result, [f"{options.input}: a transfer {of}", f"{check.counted(result['surfels'], 'surfel')}, {transfer}"]


def _solution(options):
    solution = sf.load_solution(options.input)
    surfels, file = solution.surfels, _quoted(options)
    result = {
        "kind": "solution",
        "surfels": len(surfels),
        "bounds": surfels.bounds,
        "error": solution.error,
        "camera": None if solution.camera is None else solution.camera.to_dict(),
        "timings": solution.timings,
        "next": f"surflux view {file}, or surflux render {file} --image picture.png",
    }
    return result, [
        f"{options.input}: a solution of {check.counted(len(surfels), 'surfel')}",
        f"bounds: {box_text(surfels.bounds)}",
        *error_lines(solution),
        f"camera: {solution.camera or 'none'}",
        "solved already: lights are not in the file, so `surflux solve` refuses it",
    ]


def _picture(options):
    image = sf.read_image(options.input)
    height, width = image.shape[:2]
    brightest = float(np.max(image))
    result = {"kind": "picture", "size": [width, height], "mean": image.mean(axis=(0, 1)), "largest": brightest}
    mean = ", ".join(f"{v:.3g}" for v in result["mean"])
    lines = [
        f"{options.input}: a picture, {width} x {height} pixels, no points",
        f"mean {mean}; largest {brightest:.3g}",
    ]
    if width != 2 * height:
        lines.append("no latitude-longitude image by its shape: these are twice as wide as high")
    else:
        result["next"] = f"surflux relight SCENE.toml --environment {_quoted(options)}"
        lines.append(
            'taken for a latitude-longitude image, it lights scenes: [[light]] type = "environment", image = ...'
        )
    return result, lines


def _mesh(options, solve_options):
    mesh = read_mesh(options.input)
    given = solve_options(["--", options.input])
    take_up(given)
    camera_of_cloud(given, patches_of_mesh(given, mesh=mesh))
    up = given.up or (0.0, 0.0, 1.0)
    faces, file = len(mesh.offsets) - 1, _quoted(options)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    colors = "given" if mesh.reflectance is not None or mesh.of_faces is not None else "none: solve takes grey, .5"
    shines = mesh.exitance is not None and np.any(mesh.exitance)
    lit = "adds no light, for it shines by itself" if shines else "lights it by a lamp and a sky"
    result = {
        "kind": "mesh",
        "format": Path(options.input).suffix.lower().lstrip("."),
        "vertices": len(mesh.vertices),
        "faces": faces,
        "bounds": np.array([low, high]),
        "colors": mesh.reflectance is not None or mesh.of_faces is not None,
        "up": up,
        "solve": _expense(options, max(faces, PATCHES)),
        "next": f"surflux solve {file}, or surflux view {file}",
    }
    return result, [
        f"{options.input}: a mesh of {check.counted(len(mesh.vertices), 'vertex', 'vertices')}"
        f" and {check.counted(faces, 'face')}",
        f"bounds: {box_text(result['bounds'])}, in the unit of the file",
        f"colours: {colors}",
        f"up: {up_text(up)}, as `surflux solve` takes it (--up)",
        f"`surflux solve` {lit}; large faces are cut until there are about {PATCHES} patches",
        *lines_of_mesh_scene(options.input, float(np.max(high - low)), up, shines),
        *_expense_lines(result["solve"]),
    ]


def lines_of_mesh_scene(path, extent, up, shines):
    """How to give a mesh lights of its own: the scene file that names it. up: (3,). shines: needs no other light."""
    cell = (extent / 50.0) ** 2
    keys = "" if up[2] > 0 else f"\n  up = [{', '.join(f'{v:g}' for v in up)}]"
    lines = [
        "lights and patches of your own go into a scene file, such as scene.toml with these lines:",
        f'  [[object]]\n  file = "{path}"\n  kind = "mesh"{keys}\n  patch_area = {cell:.3g}',
    ]
    return lines if shines else [*lines, '  [[light]]\n  type = "environment"\n  radiance = 1.0']
