"""STL files, of bytes or of text, with the colours that VisCAM and Magics put into their attributes."""

import re

import numpy as np

from surflux._base.check import counted
from surflux._base.color import reflectance_of_colors
from surflux._base.files import bytes_of, file_error
from surflux.meshes.foreign_meshes import Mesh

_HEADER = 84  # bytes: a comment of 80 and the number of triangles
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_FLAG = 0x8000  # of an attribute: VisCAM has a colour there, Magics that of the object
_END = 1000  # bytes at the end of a text, among which endsolid is
# solid and endsolid with names, which go on to the end of the line, or to a facet in it.
_NAMES = re.compile(rb"(?i)\b(?:end)?solid\b(?:(?!\bfacet\s+normal(?:\s+\S+){3}\s+outer\b).)*")
_FACET = re.compile(rb"(?i)\bfacet\b")
_CORNER = re.compile(rb"(?i)\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl_mesh(path):
    """The Mesh of an STL file; corners at one place are one vertex.

    Raises:
        FileError: it is cut off, or none, or a corner is not finite.
    """
    data = bytes_of(path)
    _require_whole(path, data)
    if _is_text(data):
        corners, of_faces = _corners_of_text(path, data), None
    else:
        triangles = np.frombuffer(data, _TRIANGLE, offset=_HEADER)
        corners = triangles["corners"].astype(np.float64)
        of_faces = _colors(data[: _HEADER - 4], triangles["attribute"])
    finite = np.isfinite(corners).all(axis=2)
    if not finite.all():
        row, corner = np.argwhere(~finite)[0]
        got = ", ".join(f"{value:g}" for value in corners[row, corner])
        raise file_error(path, f"a corner is ({got}); wanted finite numbers", f"triangle {row}")
    vertices, indices = _joined(corners.reshape(-1, 3))
    return Mesh(vertices, 3 * np.arange(len(corners) + 1), indices, None, of_faces)


def _is_text(data):
    return b"\0" not in data[:_HEADER]  # which the number of up to 16 million triangles has


def _require_whole(path, data):
    """Refuses a file that is cut off, or none, with what it has of what it promises."""
    size = len(data)
    if size == 0:
        raise file_error(path, "the file is empty")
    if _is_text(data):
        if b"solid" not in data[:_HEADER].lower():
            raise file_error(path, "is no STL file, by what it begins with")
        end = data[-_END:].lower()
        if b"endsolid" not in end and b"facet" in end:
            raise file_error(path, "is cut off: its text ends without endsolid")
        return
    if size < _HEADER:
        raise file_error(path, f"is cut off: it has {size} of the {_HEADER} bytes before its triangles")
    promised = int.from_bytes(data[_HEADER - 4 : _HEADER], "little")
    there, wanted = (size - _HEADER) // _TRIANGLE.itemsize, _HEADER + _TRIANGLE.itemsize * promised
    if there < promised:
        raise file_error(path, f"is cut off: it has {there} of its {counted(promised, 'triangle')}")
    if size > wanted:
        raise file_error(
            path, f"is damaged: it has {size} bytes, and its {counted(promised, 'triangle')} take {wanted}"
        )


def _corners_of_text(path, data):
    """(t, 3, 3)."""
    text = _NAMES.sub(b"", data.replace(b"\r", b"\n"))
    corners, facets = _CORNER.findall(text), len(_FACET.findall(text))
    if len(corners) != 3 * facets:
        raise file_error(path, f"has {counted(facets, 'facet')} with {len(corners)} corners; wanted 3 of each")
    try:
        return np.array([float(word) for corner in corners for word in corner]).reshape(-1, 3, 3)
    except ValueError as fault:
        raise file_error(path, f"a coordinate is no number ({fault})") from None


def _colors(header, attributes):
    """(t, 3) linear reflectance of triangles, .5 where one has no colour; None where none has one."""
    bits = np.stack([attributes >> shift & 31 for shift in (0, 5, 10)], axis=1)
    flagged = (attributes & _FLAG) > 0
    if b"COLOR=" not in header:  # of VisCAM: blue, green, red
        return np.where(flagged[:, None], reflectance_of_colors(bits[:, ::-1], 31.0), 0.5) if flagged.any() else None
    at = header.index(b"COLOR=") + len(b"COLOR=")
    of_object = reflectance_of_colors(np.frombuffer(header[at : at + 3].ljust(3, b"\0"), np.uint8), 255.0)
    own = ~flagged & bool(attributes.any())  # 0 throughout is what programs write that know of no colours
    return np.where(own[:, None], reflectance_of_colors(bits, 31.0), of_object)


def _joined(points):
    """(vertices (v, 3) in the order in which they come, index (n,) of each point)."""
    order = np.lexsort(points.T)
    starts = np.append(True, np.any(np.diff(points[order], axis=0) != 0.0, axis=1))[: len(points)]
    first = order[starts]  # of each vertex, for the order is stable
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    indices = np.empty(len(points), np.int64)
    indices[order] = rank[np.cumsum(starts) - 1]
    return points[np.sort(first)], indices
