"""PLY, a chunk of vertices at a time; surflux._core reads whole files of it, and those with lists of vertices."""

from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux._base.files import file_error
from surflux.scans.columns import PointFile, require_xyz, sorted_out
from surflux.scans.tables import as_text, byte_rows, text_rows
from surflux.scans.viewpoints import viewpoints_of

TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"}
TYPES |= {"float": "f4", "double": "f8"}
_OTHER_NAMES = {f"int{8 * size}": f"i{size}" for size in (1, 2, 4)} | {
    f"uint{8 * size}": f"u{size}" for size in (1, 2, 4)
}
_OTHER_NAMES |= {"float32": "f4", "float64": "f8"}
_ORDERS = {b"binary_little_endian": "<", b"binary_big_endian": ">", b"ascii": ""}
_MOST_HEADER = 1 << 20


class _Vertices(NamedTuple):
    row: np.dtype
    count: int
    faces: int
    begin: int  # of the vertices, in bytes
    lines: int  # before them
    ascii: bool
    viewpoints: list


def open_ply(path):
    """A PointFile of the element vertex; its other properties are attributes."""
    layout = _vertices(path)
    if layout is None:
        return _read_whole(path)
    if layout.count == 0:
        raise file_error(path, "no points: it has no element 'vertex', or an empty one")
    require_xyz(path, layout.row.names)
    chunks = (_ascii if layout.ascii else _binary)(path, layout)
    return PointFile(layout.count, map(sorted_out, chunks), lambda: layout.viewpoints, faces=layout.faces)


def _binary(path, layout):
    for rows in byte_rows(path, layout.row, layout.count, layout.begin):
        yield {name: rows[name].astype(layout.row[name].newbyteorder("=")) for name in layout.row.names}


def _ascii(path, layout):
    names, count = layout.row.names, 0
    for table in text_rows(path, len(names), layout.begin, layout.lines, delimiter="", most=layout.count):
        count += len(table)
        with np.errstate(invalid="ignore", over="ignore"):
            columns = {
                name: values if layout.row[name].kind == "f" else values.astype(layout.row[name])
                for name, values in zip(names, table.T, strict=True)
            }
        yield columns
    if count < layout.count:
        raise file_error(path, f"truncated: the header promises {layout.count} of element 'vertex', {count} are there")


def _read_whole(path):
    ply = _core.read_ply(path, ["vertex"])
    columns, types = ply["columns"].get("vertex", {}), ply["types"].get("vertex", {})
    count = ply["elements"].get("vertex", 0)
    if count == 0:
        raise file_error(path, "no points: it has no element 'vertex', or an empty one")
    require_xyz(path, columns)
    columns = {name: values.astype(TYPES[types[name]]) for name, values in columns.items()}
    places = viewpoints_of(ply["comments"])
    return PointFile(count, iter([sorted_out(columns)]), lambda: places, faces=ply["elements"].get("face", 0))


def header_of(path):
    """(lines of the header before its last, what ends them, the byte behind it); None of a file without one."""
    with open(path, "rb") as file:
        head = file.read(_MOST_HEADER)
    first = head.find(b"\n")
    lone = head.find(b"\r")
    newline = b"\r" if lone >= 0 and (first < 0 or lone + 1 < first) else b"\n"
    end = head.find(newline + b"end_header")
    stop = head.find(newline, end + 1) if end >= 0 else -1
    if stop < 0 or head[:3] != b"ply":
        return None
    return head[:end].split(newline), newline, stop + 1


def _vertices(path):
    """The vertices of a file that begins with them, and has no lists in them; None of any other, or a damaged one."""
    header = header_of(path)
    if header is None:
        return None
    lines, _, begin = header
    order, elements, row = None, [], []
    for words in (line.split() for line in lines[1:]):
        if not words or words[0] in (b"comment", b"obj_info"):
            continue
        if words[0] == b"format" and len(words) == 3 and order is None and words[1] in _ORDERS:
            order = _ORDERS[words[1]]
        elif words[0] == b"element" and len(words) == 3 and words[2].isdigit() and len(words[2]) < 19:
            elements.append((words[1], int(words[2])))
        elif words[0] == b"property" and elements:
            if len(elements) > 1:
                continue
            kind = words[1].decode("latin-1") if len(words) == 3 else ""
            kind = TYPES.get(kind) or _OTHER_NAMES.get(kind)
            if kind is None:
                return None
            row.append((as_text(words[2]), (order or "<") + kind))
        else:
            return None
    names = [name for name, _ in row]
    if order is None or not elements or elements[0][0] != b"vertex" or not row or len(set(names)) < len(names):
        return None
    faces = dict(elements).get(b"face", 0)
    texts = [as_text(line).strip() for line in lines]
    places = viewpoints_of(line.partition(" ")[2] for line in texts if line.startswith("comment "))
    return _Vertices(np.dtype(row), elements[0][1], faces, begin, len(lines) + 1, order == "", places)
