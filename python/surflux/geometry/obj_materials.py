"""Materials of OBJ files (MTL): what each reflects diffusely, and what it sends by itself."""

import os
import re
from pathlib import Path

import numpy as np

from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn

_USUAL = 0.5  # what is reflected where a file says nothing
_NAMED = 3  # so many names in a warning
_COMMENT = re.compile(rb"\s#.*")
_WORD = re.compile(rb'"([^"]+)"|(\S+)')


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
    has_face = np.bincount(np.minimum(of_face, len(names)), minlength=len(names) + 1)[:-1] > 0
    names = [_spaced(name) if used else b"" for name, used in zip(names, has_face, strict=True)]
    if not any(names):
        return None, None
    known, missing = {}, []
    for line in filter(None, dict.fromkeys(libraries)):
        found, lost = _files(Path(path).parent, line)
        missing += lost
        for file in found:
            known.update(_read(file))
    commented = {_COMMENT.sub(b"", name): material for name, material in known.items()}
    # A name may have a comment behind it, in either file, or a # in it.
    used = [known.get(name) or known.get(_COMMENT.sub(b"", name)) or commented.get(name) for name in names]
    unknown = [name for name, material in zip(names, used, strict=True) if name and material is None]
    if unknown:
        lost = f"not there: {_listed(missing)}" if missing else "in no library of it" if libraries else "without mtllib"
        faces = "faces that have it reflect" if len(unknown) == 1 else "faces that have them reflect"
        warn(f"{path}: {counted(len(unknown), 'material')} ({_listed(unknown)}) {lost}; {faces} {_USUAL:g}")
    if not any(used):
        return None, None
    textured = sum(b"map_kd" in material or b"map_ke" in material for material in used if material)
    if textured:
        have = "material has a texture" if textured == 1 else "materials have textures"
        warn(f"{path}: {textured} {have} (map_Kd, map_Ke), not read from OBJ files: Kd and Ke count")
    which = np.minimum(of_face, len(names))
    rho, glow = (_colors([*used, None], *how)[which] for how in ((b"kd", _USUAL), (b"ke", 0.0)))
    off = np.count_nonzero(((rho < 0.0) | (rho > WHITE)).any(axis=1))
    if off:
        warn(f"{path}: Kd of {counted(off, 'face')} is not in 0 to {WHITE:g}, the most that counts, and is cut off")
    return np.clip(rho, 0.0, WHITE), np.pi * np.maximum(0.0, glow)


def _spaced(text):
    """With one space for any blanks."""
    return b" ".join(text.split())


def _listed(names):
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(name.decode("utf-8", "replace") for name in names[:_NAMED]) + more


def _files(folder, line):
    """([path of each file of a line that is there], [names of the others]); names may have spaces in them."""
    short = _COMMENT.sub(b"", line).strip()
    is_one = short.lower().count(b".mtl") <= 1
    for whole in (line.strip(b'"'), short.strip(b'"')):
        file = _file(folder, whole) or (_beside(folder, whole) if is_one else None)
        if file is not None:
            return [file], []
    words = [quoted or word for quoted, word in _WORD.findall(short)]
    files = [_file(folder, word) or _beside(folder, word) for word in words]
    if not any(files):
        return [], [short]
    return [file for file in files if file], [word for word, file in zip(words, files, strict=True) if file is None]


def _file(folder, name):
    places = (folder / os.fsdecode(one) for one in (name, name.replace(b"\\", b"/")))
    return next((place for place in places if os.path.isfile(place)), None)


def _beside(folder, name):
    """The file of that name in the OBJ file's own folder, whichever folder it names, or None."""
    return _file(folder, name.replace(b"\\", b"/").rsplit(b"/", 1)[-1])


def _read(path):
    """The materials of a library, by name: of each the words of its lines, by keyword, with the place of the line."""
    found, material = {}, {}
    for number, line in enumerate(path.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        keyword, _, rest = _spaced(line).partition(b" ")
        if keyword.lower() == b"newmtl":
            found[rest] = material = {b"newmtl": rest}  # not empty, even without a line of its own
        elif keyword:
            material[keyword.lower()] = f"{path} (line {number})", rest.split(b"#")[0].split()
    return found


def _colors(materials, keyword, usual):
    """(m, 3): of three numbers, or one for all; the usual one where there are none, which is told of the first one."""
    out, bad = np.full((len(materials), 3), usual), []
    for k, material in enumerate(materials):
        if not material or keyword not in material:
            continue
        place, words = material[keyword]
        try:
            values = np.array([float(word) for word in words])
        except ValueError:
            values = np.zeros(0)
        if len(values) in (1, 3) and np.all(np.isfinite(values)):
            out[k] = values
        else:
            bad.append(f"{place}: a colour is {_listed([b' '.join(words)])!r}, wanted three numbers")
    if bad:
        more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
        warn(f"{bad[0]}; taken for {usual:g}{more}")
    return out
