"""What a command writes: names that nobody gives, and none in place of what it reads or of another output."""

import os
import re
from pathlib import Path

from surflux._core import FileError
from surflux.meshes.named_files import files_of_mesh
from surflux.pictures.animation import NUMBER
from surflux.scenes.scene_file import named_files

_FLAGS = {"solution": "--solution", "gaussians": "--gaussians", "save": "--save", "export": "--export"}
_FLAGS |= {"screenshot": "--screenshot"}
_READ = "inputs", "path", "environment", "epw"  # beside `input`


def output_of(options):
    """The Path of `-o`, or the usual one, of `solve` and `solar`; None of other commands without it."""
    given = getattr(options, "table", None) or getattr(options, "output", None)
    if given is not None:
        return Path(given)
    ending = {"solve": "_solved", "solar": "_solar"}.get(options.command)
    return None if ending is None else Path(f"{Path(os.fsdecode(options.input)).stem}{ending}.ply")


def images_of(options):
    """The names of --image, or the usual one; none where no picture is drawn."""
    given = getattr(options, "image", None)
    if given:
        return [given] if isinstance(given, str) else given
    if getattr(options, "no_image", False) or getattr(options, "tiles", False):
        return []
    if options.command in ("solve", "solar"):
        return [output_of(options).with_suffix(".png")]
    if options.command == "render" and not options.gaussians:
        of_solve = Path(options.input).with_suffix(".png")  # which stays
        return [of_solve.with_stem(f"{of_solve.stem}_render")]
    return []


def check_outputs(options):
    """Refuses, before any work, an output in place of a file that the command reads, or of another output."""
    read, outputs = _files_read(options), _outputs(options)
    for k, (flag, path) in enumerate(outputs):
        for file, what in read:
            if _is_same(path, file):
                raise ValueError(f"{flag}: is {what}, {str(path)!r}; wanted another name")
        for other, taken in outputs[:k]:
            if _is_same(path, taken) or _is_same(taken, path):
                raise ValueError(f"{flag}: is what {other} writes, {str(path)!r}; wanted another name")


def _outputs(options):
    """(flag, Path) of each file that is written; of numbered ones their pattern."""
    output = None if getattr(options, "tiles", False) else output_of(options)
    found = [] if output is None else [("-o", output)]
    given = {flag: getattr(options, name, None) for name, flag in _FLAGS.items()}
    found += [(flag, Path(path)) for flag, path in given.items() if path is not None]
    return found + [("--image", Path(image)) for image in images_of(options)]


def _files_read(options):
    """(path, what it is in words) of each existing file that is read."""
    found = [(options.input, "the input itself")]
    for name in _READ:
        given = getattr(options, name, None)
        paths = given if isinstance(given, list) else [] if given is None else [given]
        found += [(path, "an input, too" if name == "inputs" else f"the file of --{name}") for path in paths]
    for path, _ in found.copy():
        if Path(path).suffix.lower() == ".toml":
            found += [(file, f"a file that {path} names") for file in _named_in(path)]
    found += [(file, f"a file that {path} names") for path, _ in found.copy() for file in files_of_mesh(path)]
    return [(path, what) for path, what in found if os.path.isfile(path)]


def _named_in(path):
    try:
        return named_files(path)
    except FileError:  # which is told where the file is read
        return []


def _is_same(output, file):
    """Whether an output, perhaps a pattern of numbered ones, is a file."""
    if os.path.exists(output) and os.path.exists(file) and os.path.samefile(output, file):
        return True
    pattern = r"\d+".join(map(re.escape, NUMBER.split(os.path.realpath(output))))
    return re.fullmatch(pattern, os.path.realpath(file)) is not None
