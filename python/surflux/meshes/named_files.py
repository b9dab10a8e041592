"""Files that a file of a mesh names: libraries of materials, textures, buffers."""

import os
import re
from pathlib import Path
from urllib.parse import unquote

from surflux.meshes.gltf_container import Container
from surflux.meshes.obj_textures import file_beside, file_in

_KEY_LINES = re.compile(rb"^[ \t]*(mtllib|map_\w+|refl|bump|disp|decal|norm)[ \t]+(.*?)[ \t\r]*$", re.MULTILINE)
_TEXTURES = re.compile(rb"^comment TextureFile[ \t]+(.*?)[ \t\r]*$", re.MULTILINE)
_TOP = 1 << 20  # bytes of a file that names are looked for in: they stand ahead of what is long


def files_of_mesh(path):
    """Paths of the existing files that a mesh file names; of one that cannot be read none, which is told elsewhere."""
    path = Path(os.fsdecode(path))
    try:
        return _NAMED.get(path.suffix.lower(), lambda _: [])(path)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []


def _of_obj(path):
    """Those in its lines mtllib, and in these libraries."""
    libraries = _in_lines(path.parent, _top_of(path))
    return libraries + [file for one in libraries for file in _in_lines(one.parent, one.read_bytes())]


def _in_lines(folder, text):
    """Files that lines of keys name: all ends of a line are asked for, as options precede names, and all words."""
    words = (line[2].split() for line in _KEY_LINES.finditer(text))
    return _there(folder, (name for of in words for name in (*of, *(b" ".join(of[k:]) for k in range(len(of))))))


def _there(folder, names):
    found = (file_in(folder, name) or file_beside(folder, name) for name in names)
    return [file for file in dict.fromkeys(found) if file is not None]


def _top_of(path):
    with open(path, "rb") as file:
        return file.read(_TOP)


def _of_ply(path):
    header = _top_of(path).split(b"end_header")[0]
    return _there(path.parent, (found[1] for found in _TEXTURES.finditer(header)))


def _of_gltf(path):
    header = Container(path).header
    entries = [*header.get("buffers", ()), *header.get("images", ())]
    uris = [one["uri"] for one in entries if not one.get("uri", "data:").startswith("data:")]
    return _there(path.parent, map(os.fsencode, [*uris, *map(unquote, uris)]))


_NAMED = {".obj": _of_obj, ".ply": _of_ply, ".gltf": _of_gltf, ".glb": _of_gltf}
