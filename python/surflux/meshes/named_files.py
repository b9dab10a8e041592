"""Files that a file of a mesh names: libraries of materials, textures, buffers."""

import os
import re
from pathlib import Path
from urllib.parse import unquote

from surflux.meshes.gltf_container import Container

_KEY_LINES = re.compile(rb"^[ \t]*(mtllib|map_\w+|refl|bump|disp|decal|norm)[ \t]+(.*?)[ \t\r]*$", re.MULTILINE)
_TEXTURES = re.compile(rb"^comment TextureFile[ \t]+(.*?)[ \t\r]*$", re.MULTILINE)
_TOP = 1 << 20  # bytes of a file that names are looked for in: they stand ahead of what is long


def files_of_mesh(path):
    """Paths of the existing files that a mesh file names; of one that cannot be read none, which is told elsewhere."""
    path = Path(os.fsdecode(path))
    try:
        names = _NAMED.get(path.suffix.lower(), lambda _: ())(path)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []
    return [path.parent / name for name in names if os.path.isfile(path.parent / name)]


def _of_obj(path):
    """Names in its lines mtllib, and in those libraries: all ends of a line, for options precede names."""
    found = []
    for line in _KEY_LINES.finditer(_top_of(path)):
        found += _words(line[2])
    for library in found.copy():
        if os.path.isfile(path.parent / library):
            for line in _KEY_LINES.finditer((path.parent / library).read_bytes()):
                found += _words(line[2])
    return found


def _top_of(path):
    with open(path, "rb") as file:
        return file.read(_TOP)


def _words(text):
    words = os.fsdecode(text.replace(b"\\", b"/")).split()
    return [" ".join(words[k:]) for k in range(len(words))] + words


def _of_ply(path):
    header = _top_of(path).split(b"end_header")[0]
    return [os.fsdecode(found[1]) for found in _TEXTURES.finditer(header)]


def _of_gltf(path):
    header = Container(path).header
    entries = [*header.get("buffers", ()), *header.get("images", ())]
    uris = [one["uri"] for one in entries if not one.get("uri", "data:").startswith("data:")]
    return [*uris, *map(unquote, uris)]


_NAMED = {".obj": _of_obj, ".ply": _of_ply, ".gltf": _of_gltf, ".glb": _of_gltf}
