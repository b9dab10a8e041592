"""Materials of OBJ files (MTL): what each reflects diffusely, and what it sends by itself."""

import re
from pathlib import Path

import numpy as np

from surflux._base.check import counted
from surflux._base.color import WHITE
from surflux._base.warn import warn
from surflux.meshes.obj_textures import COMMENT, Words, file_beside, file_in, paint
from surflux.meshes.transparency import warn_of_transparency

USUAL = 0.5  # what is reflected where a file says nothing
_NAMED = 3  # so many names in a warning
_WORD = re.compile(rb'"([^"]+)"|(\S+)')


def looks_of_faces(path, libraries, names, of_face, textured=None, colored=None):
    """(reflectance, exitance), (f, 3) each, of the faces of an OBJ file, by its materials, None without any; and the
    TextureUse of each of their textures.

    Kd is linear reflectance, at most .98; Ke radiance, so that a face sends pi times as much. Their textures, map_Kd
    and map_Ke, are times these, or by themselves where they are 0; a face has the mean of its own. What is not there,
    no colour or no image is warned of.

    Args:
        path: of the OBJ file, in whose folder its libraries are looked for.
        libraries: what stands in each of its lines mtllib, in bytes.
        names: of its materials, in bytes.
        of_face: (f,) index into names; larger where a face has none.
        textured: its TexturedFaces; None where no corner has a place on a texture.
        colored: (f,) faces whose vertices have colours, which count in place of Kd, but not of map_Kd.
    """
    has_face = np.bincount(np.minimum(of_face, len(names)), minlength=len(names) + 1)[:-1] > 0
    names = [_spaced(name) if used else b"" for name, used in zip(names, has_face, strict=True)]
    if not any(names):
        return None, None, ()
    colored = np.zeros(len(of_face), bool) if colored is None else colored
    known, missing = {}, []
    for line in filter(None, dict.fromkeys(libraries)):
        found, lost = _files(Path(path).parent, line)
        missing += lost
        for file in found:
            known.update(_read(file))
    commented = {COMMENT.sub(b"", name): material for name, material in known.items()}
    # A name may have a comment behind it, in either file, or a # in it.
    used = [known.get(name) or known.get(COMMENT.sub(b"", name)) or commented.get(name) for name in names]
    unknown = [name for name, material in zip(names, used, strict=True) if name and material is None]
    if unknown:
        lost = f"not there: {_listed(missing)}" if missing else "in no library of it" if libraries else "without mtllib"
        faces = "faces that have it" if len(unknown) == 1 else "faces that have them"
        instead = f"reflect {USUAL:g}" if not colored.any() else f"have the colours of their vertices, else {USUAL:g}"
        warn(f"{path}: {counted(len(unknown), 'material')} ({_listed(unknown)}) {lost}; {faces} {instead}")
    if not any(used):
        return None, None, ()
    which = np.minimum(of_face, len(names))
    faces_of = np.bincount(which, minlength=len(names) + 1).tolist()
    named = ((name.decode("utf-8", "replace"), number) for name, number in zip(names, faces_of, strict=False))
    clear = [one for one, material in zip(named, used, strict=True) if material and _is_clear(material)]
    warn_of_transparency(path, "d, Tr or map_d", clear)
    rho, glow = (_colors([*used, None], *how)[which] for how in ((b"kd", USUAL), (b"ke", 0.0)))
    kd, looks = rho.copy(), {b"kd": (rho, WHITE), b"ke": (glow, 1.0)}
    without = "colours of vertices, Kd and Ke alone count" if colored.any() else "Kd and Ke alone count"
    uses = paint(path, used, which, looks, textured, Words(without, "vt", "map_Kd"))
    by_vertices = colored.copy()
    for use in uses:
        by_vertices[use.faces] &= use.shines
    if by_vertices.any() and np.ptp(kd[by_vertices], axis=0).any():
        many = counted(np.count_nonzero(by_vertices), "face")
        warn(f"{path}: Kd of {many} is left out: the colours of their vertices count in its place")
    off = ((rho < 0.0) | (rho > WHITE)).any(axis=1) & ~by_vertices
    if off.any():
        whose = f"{counted(np.count_nonzero(off), 'face')} ({_listed([names[k] for k in np.unique(which[off])])})"
        bytes_are = "; 8-bit values are to be divided by 255" if rho[off].max() >= 2.0 else ""
        warn(f"{path}: Kd of {whose} is not in 0 to {WHITE:g}, the most that counts, and is cut off{bytes_are}")
    uses = [use._replace(tint=np.pi * use.tint, most=np.inf) if use.shines else use for use in uses]
    return np.clip(rho, 0.0, WHITE), np.pi * np.maximum(0.0, glow), tuple(uses)


def _spaced(text):
    """With one space for any blanks."""
    return b" ".join(text.split())


def _listed(names):
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(name.decode("utf-8", "replace") for name in names[:_NAMED]) + more


def _files(folder, line):
    """([path of each file of a line that is there], [names of the others]); names may have spaces in them."""
    short = COMMENT.sub(b"", line).strip()
    is_one = short.lower().count(b".mtl") <= 1
    for whole in (line.strip(b'"'), short.strip(b'"')):
        file = file_in(folder, whole) or (file_beside(folder, whole) if is_one else None)
        if file is not None:
            return [file], []
    words = [quoted or word for quoted, word in _WORD.findall(short)]
    files = [file_in(folder, word) or file_beside(folder, word) for word in words]
    if not any(files):
        return [], [short]
    return [file for file in files if file], [word for word, file in zip(words, files, strict=True) if file is None]


def _read(path):
    """The materials of a library, by name: of each the words of its lines, by keyword, with the place of the line."""
    found, material = {}, {}
    for number, line in enumerate(path.read_bytes().removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        keyword, _, rest = _spaced(line).partition(b" ")
        if keyword.lower() == b"newmtl":
            found[rest] = material = {b"newmtl": rest}  # not empty, even without a line of its own
        elif keyword and (rest or not keyword.lower().startswith(b"map_")):
            rest = rest if keyword.lower().startswith(b"map_") else rest.split(b"#")[0]
            material[keyword.lower()] = (path, number), rest.split()
    return found


def _is_clear(material):
    """Whether a material is not opaque: by map_d, else d, else Tr, which is 1 - d (but some write 1 beside d 1)."""
    if b"map_d" in material:
        return True
    _, words = material.get(b"d") or material.get(b"tr") or (None, ())
    try:
        value = float(words[-1])  # -halo may stand before it
    except (IndexError, ValueError):
        return False
    return value < 1.0 if b"d" in material else value > 0.0


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
