"""Materials of OBJ files (MTL): what each reflects diffusely, and what it sends by itself."""

import os
from pathlib import Path

import numpy as np

from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn

_USUAL = 0.5  # what is reflected where a file says nothing
_NAMED = 3  # so many names in a warning


def looks_of_faces(path, libraries, names, of_face):
    """(reflectance, exitance), (f, 3) each, of the faces of an OBJ file, by its materials; (None, None) without any.

    Kd is linear reflectance, at most .98; Ke radiance, so that a face sends pi times as much. What is not there, no
    colour or a texture is warned of.

    Args:
        path: of the OBJ file, in whose folder its libraries are looked for.
        libraries: what stands in each of its lines mtllib, in bytes.
        names: of its materials, in bytes.
        of_face: (f,) index into names; larger where a face has none.
    """
    if not any(names):
        return None, None
    known, missing = {}, []
    for line in dict.fromkeys(libraries):
        found, lost = _files(Path(path).parent, line)
        missing += lost
        for file in found:
            known.update(_read(file))
    used = [known.get(name, known.get(_before_comment(name))) for name in names]
    unknown = [name for name, material in zip(names, used, strict=True) if name and material is None]
    if unknown:
        lost = f"not there: {_listed(missing)}" if missing else "in no library of it" if libraries else "without mtllib"
        faces = "faces that have it reflect" if len(unknown) == 1 else "faces that have them reflect"
        warn(f"{path}: {counted(len(unknown), 'material')} ({_listed(unknown)}) {lost}; {faces} {_USUAL:g}")
    if all(material is None for material in used):
        return None, None
    textured = sum(b"map_kd" in material or b"map_ke" in material for material in used if material is not None)
    if textured:
        have = "material has a texture" if textured == 1 else "materials have textures"
        warn(f"{path}: {textured} {have} (map_Kd, map_Ke), not read from OBJ files: Kd and Ke count")
    rho = [_color(material, b"kd", _USUAL) for material in (*used, None)]
    glow = [_color(material, b"ke", 0.0) for material in (*used, None)]
    which = np.minimum(of_face, len(names))
    return np.clip(rho, 0.0, WHITE)[which], np.pi * np.maximum(0.0, glow)[which]


def _listed(names):
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(name.decode("utf-8", "replace") for name in names[:_NAMED]) + more


def _before_comment(name):
    return name.split(b" #")[0].rstrip()


def _files(folder, line):
    """([path of each file of a line that is there], [names of the others]); names may have spaces in them."""
    for whole in (line, _before_comment(line)):
        file = _file(folder, whole.strip(b'"'))
        if file is not None:
            return [file], []
    words = _before_comment(line).split()
    files = {word: _file(folder, word) for word in words}
    return [file for file in files.values() if file], [word for word, file in files.items() if file is None]


def _file(folder, name):
    name = os.fsdecode(name)
    upright = name.replace("\\", "/")
    places = (folder / place for place in (name, upright, upright.rsplit("/", 1)[-1]))
    return next((place for place in places if os.path.isfile(place)), None)


def _read(path):
    """The materials of a library, by name: of each the words of its lines, by keyword, with the place of the line."""
    found, material = {}, {}
    for number, line in enumerate(path.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        keyword, _, rest = line.strip().replace(b"\t", b" ").partition(b" ")
        if keyword.lower() == b"newmtl":
            material = {}
            found[rest.strip()] = found[_before_comment(rest.strip())] = material
        elif keyword:
            material[keyword.lower()] = f"{path} (line {number})", rest.split(b"#")[0].split()
    return found


def _color(material, keyword, usual):
    """(3,): of three numbers, or one for all; the usual one where there are none."""
    if material is None or keyword not in material:
        return np.full(3, usual)
    place, words = material[keyword]
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        values = np.zeros(0)
    if len(values) not in (1, 3) or not np.all(np.isfinite(values)):
        said = b" ".join(words).decode("utf-8", "replace")
        warn(f"{place}: a colour is {said!r}, wanted three numbers; it is taken for {usual:g}")
        return np.full(3, usual)
    return np.broadcast_to(values, 3)
