"""Which format a file of points has: by its content, then by its suffix, or as the caller says."""

import os
from pathlib import Path

from surflux._base.files import file_error, require_file
from surflux.scans.obj import MESH_HINT

FORMATS = ("ply", "pcd", "las", "laz", "e57", "npz", "xyz", "pts", "csv", "obj")
_TEXT = ("xyz", "xyzn", "xyzrgb", "pts", "csv")
_SUFFIXES = {name: name for name in (*FORMATS, "xyzn", "xyzrgb")} | {
    "txt": "xyz",
    "asc": "xyz",
    "laz": "las",
    "copc": "las",
}
_BOTH = ("glb", "gltf", "vtp", "vtk")  # which may have points alone, as Scan.save writes them
MESHES = ("stl", "off", *_BOTH)
_BEGINNINGS = {b"LASF": "las", b"ASTM-E57": "e57", b"PK\x03\x04": "npz", b"ply\n": "ply", b"ply\r": "ply"}
_BEGINNINGS |= {b"# .PCD": "pcd", b"#.PCD": "pcd", b"VERSION": "pcd"}
_POINTS_HINT = "; points without faces have to be written as .ply or .npz instead"
_LFS = b"version https://git-lfs"
_OTHERS = {
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"%PDF": "a PDF",
    b"\x1f\x8b": "a gzip archive",
}
_NPY = b"\x93NUMPY"
_OTHERS |= {b"glTF": "glTF", b"<!DOCTYPE": "a web page", b"<html": "a web page"}


def format_of(path, format=None):
    """One of "ply", "pcd", "las", "e57", "npz", "obj" and, for text, "xyz", "xyzn", "xyzrgb", "pts", "csv".

    Args:
        format: a name of FORMATS or a suffix; None to go by what the file begins with, then by its suffix.

    Raises:
        FileError: no such file, or one of another kind; says what reads or converts it.
    """
    require_file(path)
    if format is not None:
        name = str(format).lower().lstrip(".")
        if name in _SUFFIXES:
            return _SUFFIXES[name]
        raise file_error(path, _refusal(path, f"format {str(format)!r}", name))
    head = _head(path)
    if head.startswith(_NPY):
        raise file_error(path, _refusal(path, "one array of numpy, without a name,", "npy"))
    suffix = Path(os.fsdecode(path)).suffix.lower().lstrip(".")
    for beginning, name in _BEGINNINGS.items():
        if head.startswith(beginning):
            return name
    if head.startswith(_LFS):
        raise file_error(path, "a pointer of git-lfs, not the file itself; 'git lfs pull' fetches that", "line 1")
    for beginning, what in _OTHERS.items():
        if head.startswith(beginning):
            hint = MESH_HINT + _POINTS_HINT if what == "glTF" else "wanted points"
            raise file_error(path, f"is {what}; {hint}")
    if suffix in _SUFFIXES:
        name = _SUFFIXES[suffix]
        if not head:
            raise file_error(path, "the file is empty")
        if name in _TEXT and b"\0" in head:
            raise file_error(path, "is no text, though its name says so, and of no format of points that is known")
        return name
    raise file_error(path, _refusal(path, f"format {suffix!r}" if suffix else "a name without a suffix", suffix))


def _head(path):
    try:
        with open(path, "rb") as file:
            return file.read(1024)
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault


# Texts, pages, programs and pictures that lie beside scans.
_NO_POINTS = {"bmp", "doc", "docx", "gif", "htm", "html", "ipynb", "jpeg", "jpg", "log", "md", "mp4", "odt"}
_NO_POINTS |= {"pdf", "py", "rst", "sh", "tif", "tiff", "webp", "xls", "xlsx", "xml", "yaml", "yml"}


def _refusal(path, what, name):
    shown = os.fsdecode(path)
    if name in MESHES:
        hint = MESH_HINT + (_POINTS_HINT if name in _BOTH else "")
    elif name == "npy":
        named = f"{Path(shown).stem}.npz"
        hint = (
            f"numpy.savez({named!r}, points=array[:, :3]) writes one with names, normals and colors too, that is read"
        )
    elif name == "mtl":
        hint = "It is the materials of an OBJ file, which is read with them"
    elif name == "toml":
        hint = "surflux.load_scene reads it as a scene"
    elif name == "epw":
        hint = "It is the weather of a place, which `surflux solar --epw` and surflux.Sky.from_epw read"
    elif name in ("ies", "ldt"):
        hint = "It is the photometry of a luminaire, which surflux.read_photometry reads"
    elif name in _NO_POINTS:
        hint = "It is no scan"
    else:
        hint = f"PDAL (pdal translate {shown} {Path(shown).stem}.laz) and CloudCompare turn most others into these"
    return f"{what} cannot be read as points; supported now: {', '.join(FORMATS)}. {hint}"
