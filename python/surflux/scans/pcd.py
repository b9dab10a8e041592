"""PCD, the point files of PCL and Open3D: ascii, binary and binary_compressed."""

import os
import struct
from typing import NamedTuple

import numpy as np

from surflux._base.files import file_error
from surflux.scans.columns import CHUNK, TRIPLES, PointFile, require_xyz, sorted_out
from surflux.scans.lzf import decompressed
from surflux.scans.tables import as_text, byte_rows, text_rows

_KEYS = ("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
_MOST_HEADER = 1 << 16
_TYPES = {
    f"{kind}{size}" for kind, sizes in (("F", (4, 8)), ("U", (1, 2, 4, 8)), ("I", (1, 2, 4, 8))) for size in sizes
}
_SINGLE = {name for choices in TRIPLES.values() for choice in choices for name in choice}
_MOST_VALUES = 4096  # of one field of a point


class _Header(NamedTuple):
    row: np.dtype  # packed, little-endian, fields without a use ("_") included
    count: int
    data: str
    viewpoint: list | None
    begin: int  # of the points, in bytes
    lines: int  # before them


def open_pcd(path):
    """A PointFile.

    `rgb` and `rgba`, packed into four bytes, become colors. The viewpoint is that of the header; the default of an
    unorganized cloud (0 0 0 and no turn), which says nothing, is none.
    """
    header = _read_header(path)
    names = header.row.names
    require_xyz(path, names)
    chunks = {"ascii": _ascii, "binary": _binary, "binary_compressed": _compressed}[header.data](path, header)
    return PointFile(header.count, map(_chunk, chunks), lambda: [] if header.viewpoint is None else [header.viewpoint])


def _chunk(columns):
    columns = {name: values for name, values in columns.items() if not name.startswith("_")}
    packed = next((name for name in columns if name.lower() in ("rgb", "rgba")), None)
    if packed is not None and columns[packed].ndim == 1 and columns[packed].dtype.itemsize == 4:
        bits = np.ascontiguousarray(columns.pop(packed)).view(np.uint32)
        columns["red"], columns["green"], columns["blue"] = ((bits >> k & 255).astype(np.uint8) for k in (16, 8, 0))
    return sorted_out(columns)


def _read_header(path):
    found, at, line = {}, 0, 0
    with open(path, "rb") as file:
        head = file.read(_MOST_HEADER)
    while "DATA" not in found:
        end = head.find(b"\n", at)
        words = as_text(head[at : end if end >= 0 else len(head)]).split()
        at, line = end + 1, line + 1
        if words and not words[0].startswith("#"):
            key = words[0].upper()
            if key not in _KEYS:
                what = "not a PCD file: its header begins" if not found else "its header has a line that begins"
                raise file_error(path, f"{what} with {words[0][:40]!r}; wanted {', '.join(_KEYS)}", f"line {line}")
            if key in found:
                raise file_error(path, f"a second {key}", f"line {line}")
            found[key] = words[1:], line
        if end < 0 and "DATA" not in found:
            raise file_error(path, "the header ends before its DATA line", f"line {line}")
    return _parsed(path, found, at, line)


def _parsed(path, found, begin, lines):
    def words(key, default=None):
        if key not in found and default is None:
            raise file_error(path, f"the header has no {key}")
        return found.get(key, (default, lines))[0]

    def fail(key, reason):
        return file_error(path, reason, f"line {found[key][1] if key in found else lines}")

    def numbers(key, default=None):
        try:
            values = [int(word) for word in words(key, default)]
        except ValueError:
            values = [-1]
        if min(values, default=-1) < 0:
            raise fail(key, f"{key} is {' '.join(words(key, default))[:40]!r}; wanted whole numbers from 0")
        return values

    key = "FIELDS" if "FIELDS" in found else "COLUMNS"
    fields = words(key if key in found else "FIELDS")
    sizes, kinds, counts = numbers("SIZE"), words("TYPE"), numbers("COUNT", ["1"] * len(fields))
    for name, values in (("SIZE", sizes), ("TYPE", kinds), ("COUNT", counts)):
        if len(values) != len(fields):
            raise fail(name, f"{name} has {len(values)} values for {len(fields)} fields")
    row = []
    for k, (field, size, kind, count) in enumerate(zip(fields, sizes, kinds, counts, strict=True)):
        if f"{kind}{size}" not in _TYPES:
            raise fail(
                "TYPE", f"field {field!r} is of type {kind[:8]!r} and size {size}; wanted F, U or I of a usual size"
            )
        if count > _MOST_VALUES:
            raise fail("COUNT", f"field {field!r} has {count} values; wanted at most {_MOST_VALUES}")
        if count != 1 and field.lower() in _SINGLE:
            raise fail("COUNT", f"field {field!r} has {count} values; wanted 1")
        name = f"_{k}" if field == "_" else field
        if any(name == there[0] for there in row):
            raise fail(key, f"a second field {field!r}")
        if count:
            row.append((name, f"<{kind.lower()}{size}", *(((count,),) if count > 1 else ())))
    width, height = (numbers(key, ["1"])[0] for key in ("WIDTH", "HEIGHT"))
    points = numbers("POINTS", [str(width * height)])[0]
    if "WIDTH" in found and width * height != points:
        raise fail("POINTS", f"POINTS is {points}, but WIDTH and HEIGHT make {width * height}")
    data = (words("DATA") or [""])[0].lower()
    if data not in ("ascii", "binary", "binary_compressed"):
        raise fail("DATA", f"DATA is {data[:40]!r}; wanted ascii, binary or binary_compressed")
    return _Header(np.dtype(row), points, data, _viewpoint(words("VIEWPOINT", []), height, fail), begin, lines)


def _viewpoint(words, height, fail):
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = [np.nan]
    if values and (len(values) != 7 or not np.all(np.isfinite(values))):
        raise fail("VIEWPOINT", f"VIEWPOINT is {' '.join(words)[:60]!r}; wanted a position and a quaternion")
    # All writers set the default, also of clouds in survey coordinates; a depth camera's frame begins at the camera.
    said = bool(values) and (values != [0, 0, 0, 1, 0, 0, 0] or height > 1)
    return values[:3] if said else None


def _ascii(path, header):
    kinds = [header.row[name].base for name in header.row.names]
    widths = [int(np.prod(header.row[name].shape)) for name in header.row.names]
    count = 0
    for table in text_rows(path, sum(widths), begin=header.begin, line=header.lines, most=header.count):
        columns, at = {}, 0
        for name, kind, width in zip(header.row.names, kinds, widths, strict=True):
            values = table[:, at] if width == 1 else table[:, at : at + width]
            at += width
            with np.errstate(invalid="ignore", over="ignore"):
                # Coordinates as exact as they are written; others of the type that they have in binary files.
                exact = name.lower() in ("x", "y", "z")
                columns[name] = values if exact else values.astype(kind)
        count += len(table)
        yield columns
    if count < header.count:
        raise file_error(path, f"truncated: the header promises {header.count} points, and {count} are there")


def _binary(path, header):
    for rows in byte_rows(path, header.row, header.count, header.begin):
        yield {name: rows[name] for name in header.row.names}


def _compressed(path, header):
    """Column after column, so that all of them have to be unpacked before the first row is whole."""
    left = os.path.getsize(path) - header.begin
    place = f"byte {header.begin}"
    wanted = header.row.itemsize * header.count
    with open(path, "rb") as file:
        file.seek(header.begin)
        sizes = file.read(8)
        if len(sizes) < 8:
            raise file_error(path, "truncated: the sizes of the compressed points are missing", place)
        packed, unpacked = struct.unpack("<II", sizes)
        if packed > left - 8:
            raise file_error(path, f"truncated: {packed} bytes of points are promised, and {left - 8} are there", place)
        if unpacked != wanted:
            raise file_error(path, f"unpacks to {unpacked} bytes; the header makes {wanted} of its points", place)
        data = file.read(packed)
    try:
        data = decompressed(data, wanted)
    except ValueError as fault:
        raise file_error(path, f"its compressed points are damaged: the stream {fault}", place) from None
    columns, at = {}, 0
    for name in header.row.names:
        kind = header.row[name]
        columns[name] = np.frombuffer(data, kind, header.count, at)
        at += kind.itemsize * header.count
    for begin in range(0, header.count, CHUNK):
        yield {name: values[begin : begin + CHUNK] for name, values in columns.items()}
