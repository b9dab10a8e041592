"""Materials of OBJ files (MTL): what each reflects diffusely, and what it sends by itself."""

import os
import re
from pathlib import Path

import numpy as np

from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn
from surflux.geometry.textures import read_image

_USUAL = 0.5  # what is reflected where a file says nothing
_NAMED = 3  # so many names in a warning
_COMMENT = re.compile(rb"\s#.*")
_NUMBER = re.compile(rb"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_MAP_OPTIONS = {b"-" + name: 1 for name in (b"blendu", b"blendv", b"bm", b"boost", b"cc", b"clamp", b"imfchan")}
_MAP_OPTIONS |= {b"-texres": 1, b"-type": 1, b"-mm": 2, b"-o": 3, b"-s": 3, b"-t": 3}
_NUMBERED = (b"-o", b"-s", b"-t")
_WORD = re.compile(rb'"([^"]+)"|(\S+)')


def looks_of_faces(path, libraries, names, of_face, textured=None):
    """(reflectance, exitance), (f, 3) each, of the faces of an OBJ file, by its materials; (None, None) without any.

    Kd is linear reflectance, at most .98; Ke radiance, so that a face sends pi times as much. Their textures, map_Kd
    and map_Ke, are times these, or by themselves where they are 0; a face has the mean of its own. What is not there,
    no colour or no image is warned of.

    Args:
        path: of the OBJ file, in whose folder its libraries are looked for.
        libraries: what stands in each of its lines mtllib, in bytes.
        names: of its materials, in bytes.
        of_face: (f,) index into names; larger where a face has none.
        textured: its TexturedFaces; None where no corner has a place on a texture.
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
    which = np.minimum(of_face, len(names))
    rho, glow = (_colors([*used, None], *how)[which] for how in ((b"kd", _USUAL), (b"ke", 0.0)))
    images = _Images(path)
    for keyword, looks, most in ((b"kd", rho, WHITE), (b"ke", glow, 1.0)):
        for k, material in enumerate(used):
            if material and b"map_" + keyword in material:
                _paint(np.flatnonzero(which == k), looks, most, material, keyword, textured, images)
    images.warn()
    off = np.count_nonzero(((rho < 0.0) | (rho > WHITE)).any(axis=1))
    if off:
        warn(f"{path}: Kd of {counted(off, 'face')} is not in 0 to {WHITE:g}, the most that counts, and is cut off")
    return np.clip(rho, 0.0, WHITE), np.pi * np.maximum(0.0, glow)


def _paint(faces, looks, most, material, keyword, textured, images):
    """Puts a texture, of which white is `most`, on some faces, times what they have."""
    place, words = material[b"map_" + keyword]
    name, scale, shift = _map_options(words)
    image = images.of(Path(place[0]).parent, name)
    if image is None:
        return
    tints = looks[faces]
    tints[~tints.any(axis=1) | (keyword not in material)] = 1.0
    means = np.full((len(faces), 3), np.nan) if textured is None else textured.means(faces, image, scale, shift)
    known = np.isfinite(means[:, 0])
    images.unplaced += np.count_nonzero(~known)
    looks[faces[known]] = most * tints[known] * means[known]


class _Images:
    """The images of an OBJ file's materials, each read once, and what there is to say of them."""

    def __init__(self, path):
        self.path, self.known, self.lost, self.unplaced = path, {}, [], 0

    def of(self, folder, name):
        """The image, or None where it cannot be had."""
        if (folder, name) in self.known:
            return self.known[folder, name]
        file, image = _file(folder, name) or _beside(folder, name), None
        if file is None:
            self.lost.append(f"{_listed([name])!r} is not there")
        else:
            try:
                image = read_image(file)
            except Exception as error:  # of Pillow, which raises many kinds
                self.lost.append(f"{str(file)!r} is not read ({type(error).__name__}: {error})")
        self.known[folder, name] = image
        return image

    def warn(self):
        if self.lost:
            more = f" (and {len(self.lost) - 1} more)" if len(self.lost) > 1 else ""
            warn(f"{self.path}: texture {self.lost[0]}{more}; Kd and Ke alone count there")
        if self.unplaced:
            what = "has a texture and no place on it" if self.unplaced == 1 else "have a texture and no place on it"
            warn(f"{self.path}: {counted(self.unplaced, 'face')} {what} (vt); Kd and Ke alone count there")


def _map_options(words):
    """(file name, (scale of u, v), (shift of u, v)) of the words of map_Kd: options, and a name, maybe with spaces."""
    scale, shift = [1.0, 1.0], [0.0, 0.0]
    while words and words[0].lower() in _MAP_OPTIONS and len(words) > 1:
        option, words = words[0].lower(), words[1:]
        most, count = _MAP_OPTIONS[option], 0
        # Of -s, -o and -t one to three numbers, of all others always so many words.
        while count < most and len(words) > 1 and (option not in _NUMBERED or _NUMBER.fullmatch(words[0])):
            if option == b"-s" and count < 2:
                scale[count] = float(words[0])
            elif option == b"-o" and count < 2:
                shift[count] = float(words[0])
            count, words = count + 1, words[1:]
    return b" ".join(words).strip(b'"'), scale, shift


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
            rest = rest if keyword.lower().startswith(b"map_") else rest.split(b"#")[0]
            material[keyword.lower()] = (path, number), rest.split()
    return found


def _colors(materials, keyword, usual):
    """(m, 3): of three numbers, or one for all; the usual one where there are none, which is told of the first one."""
    out, bad = np.full((len(materials), 3), usual), []
    for k, material in enumerate(materials):
        if not material or keyword not in material:
            continue
        (path, line), words = material[keyword]
        try:
            values = np.array([float(word) for word in words])
        except ValueError:
            values = np.zeros(0)
        if len(values) in (1, 3) and np.all(np.isfinite(values)):
            out[k] = values
        else:
            bad.append(f"{path} (line {line}): a colour is {_listed([b' '.join(words)])!r}, wanted three numbers")
    if bad:
        more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
        warn(f"{bad[0]}; taken for {usual:g}{more}")
    return out
