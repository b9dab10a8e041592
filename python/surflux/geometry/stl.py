"""STL files that are not whole: trimesh finds no faces in them and does not say why."""

import os

from surflux._base.check import counted
from surflux._base.files import file_error

_HEADER, _TRIANGLE = 84, 50  # bytes: a comment of 80 and the number of triangles, and each of them
_END = 1000  # bytes at the end of a text, among which endsolid is


def require_whole_stl(path):
    """Refuses an STL file, binary or text, that is cut off, or none, with what it has of what it promises."""
    size, head, end = _ends(path)
    if size == 0:
        raise file_error(path, "the file is empty")
    if b"\0" not in head:  # which the number of up to 16 million triangles has
        if b"solid" not in head.lower():
            raise file_error(path, "is no STL file, by what it begins with")
        if b"endsolid" not in end and b"facet" in end:
            raise file_error(path, "is cut off: its text ends without endsolid")
        return
    if size < _HEADER:
        raise file_error(path, f"is cut off: it has {size} of the {_HEADER} bytes before its triangles")
    promised = int.from_bytes(head[80:], "little")
    there, wanted = (size - _HEADER) // _TRIANGLE, _HEADER + _TRIANGLE * promised
    if there < promised:
        raise file_error(path, f"is cut off: it has {there} of its {counted(promised, 'triangle')}")
    if size > wanted:
        raise file_error(
            path, f"is damaged: it has {size} bytes, and its {counted(promised, 'triangle')} take {wanted}"
        )


def _ends(path):
    """(bytes of a file, the header that a binary one has, the last of them in lower case)."""
    try:
        size = os.path.getsize(path)
        with open(path, "rb") as file:
            head = file.read(_HEADER)
            file.seek(max(0, size - _END))
            return size, head, file.read().lower()
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault
