"""Materials of OBJ files (MTL): what each reflects diffusely, and what it sends by itself."""

from pathlib import Path, PureWindowsPath
from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn

_USUAL = 0.5  # what is reflected where a file says nothing
_NAMED = 3  # so many names in a warning


class _Material(NamedTuple):
    reflectance: np.ndarray  # (3,)
    exitance: np.ndarray  # (3,)
    has_texture: bool


def looks_of_faces(path, libraries, names, of_face):
    """(reflectance, exitance), (f, 3) each, of the faces of an OBJ file, by its materials; (None, None) without any.

    Kd is linear reflectance, at most .98; Ke radiance, so that a face sends pi times as much. Textures are not read.

    Args:
        path: of the OBJ file, in whose folder its libraries are looked for.
        libraries: what each of its lines mtllib names.
        names: of its materials.
        of_face: (f,) index into names; larger where a face has none.

    Raises:
        FileError: a number in a library that is none, with its line.
    """
    if not libraries or not names:
        return None, None
    known, missing = {}, []
    for line in libraries:
        for file, name in _files(Path(path).parent, line):
            if file is None:
                missing.append(name)
            else:
                known.update(_read(file))
    if missing:
        warn(f"{path}: materials are not there: {', '.join(missing)}; faces that have them reflect {_USUAL:g}")
    if not known:
        return None, None
    unknown = [name for name in names if name not in known]
    if unknown and not missing:
        more = f" and {len(unknown) - _NAMED} more" if len(unknown) > _NAMED else ""
        listed = ", ".join(map(repr, unknown[:_NAMED])) + more
        warn(f"{path}: no library has its material {listed}; faces that have it reflect {_USUAL:g}")
    textured = sum(known[name].has_texture for name in names if name in known)
    if textured:
        warn(
            f"{path}: {counted(textured, 'material has a texture', 'materials have textures')} (map_Kd), "
            "not read from OBJ files: what is reflected is Kd"
        )
    grey = _Material(np.full(3, _USUAL), np.zeros(3), False)
    looks = [*(known.get(name, grey) for name in names), grey]
    which = np.minimum(of_face, len(names))
    return tuple(np.stack([getattr(m, what) for m in looks])[which] for what in ("reflectance", "exitance"))


def _files(folder, line):
    """(path or None where it is not there, name) of each file of a line, in which names may have spaces."""
    whole = _file(folder, line)
    return [(whole, line)] if whole else [(_file(folder, word), word) for word in line.split()]


def _file(folder, name):
    parts = PureWindowsPath(name)  # which knows both kinds of slashes
    places = folder / Path(*parts.parts), folder / parts.name
    return next((place for place in places if place.is_file()), None)


def _read(path):
    """The materials of a library, by name."""
    found, name, texts = {}, None, {}

    def close():
        if name is None:
            return
        reflectance = np.clip(_color(path, *texts.get("kd", (0, [str(_USUAL)]))), 0.0, WHITE)
        exitance = np.pi * np.maximum(0.0, _color(path, *texts.get("ke", (0, ["0"]))))
        found[name] = _Material(reflectance, exitance, "map_kd" in texts)

    lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    for number, line in enumerate(lines, 1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0].lower() == "newmtl":
            close()
            name, texts = " ".join(words[1:]), {}
        else:
            texts[words[0].lower()] = number, words[1:]
    close()
    return found


def _color(path, line, words):
    """(3,): of three numbers, or one for all."""
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.zeros(0)
    if len(values) not in (1, 3) or not np.all(np.isfinite(values)):
        raise _core.FileError(f"{path} (line {line}): a colour is {' '.join(words)!r}; wanted three numbers")
    return np.broadcast_to(values, 3)
