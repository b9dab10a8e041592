"""Textures that files of meshes name, as materials of OBJ files do (map_Kd, map_Ke), on the faces that have them."""

import os
import re
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from surflux._base.check import counted
from surflux._base.warn import warn
from surflux.meshes.textures import TextureUse, read_texture
from surflux.meshes.transparency import warn_of_transparency

COMMENT = re.compile(rb"\s#.*")
_NUMBER = re.compile(rb"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
# Words that each option has behind it; of the last three up to so many numbers.
_OPTIONS = {b"-" + name: 1 for name in (b"blendu", b"blendv", b"bm", b"boost", b"cc", b"clamp", b"imfchan")}
_OPTIONS |= {b"-texres": 1, b"-type": 1, b"-mm": 2, b"-o": 3, b"-s": 3, b"-t": 3}
_NUMBERED = (b"-o", b"-s", b"-t")


def file_in(folder, name):
    """The file of that name, by either kind of slash, or None."""
    places = (folder / os.fsdecode(one) for one in (name, name.replace(b"\\", b"/")))
    return next((place for place in places if os.path.isfile(place)), None)


def file_beside(folder, name):
    """The file of that name in that very folder, whichever folder the name has, or None."""
    return file_in(folder, name.replace(b"\\", b"/").rsplit(b"/", 1)[-1])


class Words(NamedTuple):
    """What warnings say."""

    without: str  # of what is there where a texture is not
    place: str  # on a texture, of corners
    image: str  # whose alpha it is


def paint(path, materials, which, looks, textured, words):
    """Puts the textures of materials on the faces that have them, in place, times what these have there; [TextureUse].

    Where that is 0, or nothing, the texture counts by itself. What cannot be had is warned of.

    Args:
        path: of the file of the mesh.
        materials: of each its lines, by keyword: ((library, line), words); None of one that is not known.
        which: (f,) material of each face; larger where it has none.
        looks: by keyword, as b"kd": (f, 3) float, and what white is.
        textured: TexturedFaces, or None where no corner has a place on a texture.
        words: Words of warnings.
    """
    painted, lost, unplaced, clear = {}, [], 0, []  # by file, for one texture at a time is in memory
    uses = []
    for k, material in enumerate(materials):
        for keyword in looks:
            if material and b"map_" + keyword in material:
                (library, _), line = material[b"map_" + keyword]
                name, scale, shift = _options(line)
                file = _file(Path(library).parent, name)
                if file is None:
                    lost.append(f"{name.decode('utf-8', 'replace')!r} is not there")
                else:
                    painted.setdefault(file, []).append((k, keyword, scale, shift))
    if painted:
        order = np.argsort(which, kind="stable")
        begin = np.searchsorted(which[order], np.arange(len(materials) + 1))
    for file, of_file in painted.items():
        try:
            texture = read_texture(file)
        except ImportError:
            lost.append(f"{str(file)!r} needs Pillow to be read (pip install pillow)")
            continue
        except Exception as error:  # of Pillow, which raises many kinds
            lost.append(f"{str(file)!r} is not read ({type(error).__name__}: {error})")
            continue
        read = partial(read_texture, file)
        for k, keyword, scale, shift in of_file:
            faces, (values, most) = order[begin[k] : begin[k + 1]], looks[keyword]
            if textured is None:
                unplaced += len(faces)
                continue
            means = textured.means(faces, texture, scale, shift)
            known = np.isfinite(means[:, 0])
            unplaced += np.count_nonzero(~known)
            tints = values[faces]
            tints[~tints.any(axis=1) | (keyword not in materials[k])] = 1.0
            faces, tints = faces[known], most * tints[known]
            values[faces] = tints * means[known]
            if texture.cover is not None and keyword == b"kd":
                clear.append((materials[k][b"newmtl"].decode("utf-8", "replace"), len(faces)))
            uses.append(TextureUse(faces, tints, read, scale, shift, keyword == b"ke"))
    if lost:
        more = f" (and {len(set(lost)) - 1} more)" if len(set(lost)) > 1 else ""
        warn(f"{path}: texture {lost[0]}{more}; {words.without} there")
    warn_of_transparency(path, f"alpha of {words.image}", clear)
    if unplaced:
        what = "has a texture and no place on it" if unplaced == 1 else "have a texture and no place on it"
        warn(f"{path}: {counted(unplaced, 'face')} {what} ({words.place}); {words.without} there")
    return uses


def _file(folder, name):
    """Of a name that may have a comment or an option behind it, or an unknown one before it."""
    short = COMMENT.sub(b"", name)
    last = short.split()[-1:]
    for one in (name, short, *last):
        file = file_in(folder, one.strip(b'"')) or file_beside(folder, one.strip(b'"'))
        if file is not None:
            return file
    return None


def _options(words):
    """(name of the file, (scale of u, v), (shift of u, v)) of the words of map_Kd: options, and a name with blanks."""
    numbers = {b"-s": np.ones(2), b"-o": np.zeros(2)}
    while len(words) > 1 and words[0].lower() in _OPTIONS:
        option, words = words[0].lower(), words[1:]
        for count in range(_OPTIONS[option]):
            if len(words) == 1 or (option in _NUMBERED and not _NUMBER.fullmatch(words[0])):
                break
            if option in numbers and count < 2 and np.isfinite(float(words[0])):
                numbers[option][count] = float(words[0])
            words = words[1:]
    return b" ".join(words), numbers[b"-s"], numbers[b"-o"]
