"""Files of named arrays: versioned, checksummed, and read by mapping them into memory.

A file begins with 32 bytes, little-endian like all of it: 16 of its kind (ASCII, filled up with blanks), and four
unsigned numbers of 4 bytes, the version, the bytes of the header, the CRC-32 of the header, and 0. The header is JSON,
filled up with blanks: "about", what the writer says; "bytes", the length of the whole file; and "arrays", each with its
name, type (as numpy has it: "<f4", or pairs of a field and its type), shape, offset in the file and CRC-32. Every array
begins at a multiple of 64 bytes.
"""

import json
import os
import struct
import zlib

import numpy as np

from surflux._base.check import counted
from surflux._base.files import file_error, require_file, whole_file
from surflux._core import FileError

_START = struct.Struct("<16s4I")
_ALIGNED = 64
_MOST_HEADER = 1 << 26
_BLOCK = 1 << 24  # bytes that a checksum is taken of at once


def write_arrays(path, kind, version, about, arrays):
    """Writes the file whole or not at all.

    Args:
        path: str or path.
        kind: ASCII text of at most 16 characters, by which readers know the file.
        version: int of what `about` and `arrays` mean.
        about: what JSON takes.
        arrays: dict of numpy arrays of numbers, or of structures of numbers without gaps.

    Raises:
        FileError: the file cannot be written.
    """
    arrays = {name: np.ascontiguousarray(values) for name, values in arrays.items()}
    entries = [
        {"name": name, "type": _type_to_json(values.dtype), "shape": values.shape, "crc": _checksum(_bytes_of(values))}
        for name, values in arrays.items()
    ]
    sizes = [values.nbytes for values in arrays.values()]
    header = _header(about, entries, sizes)
    with whole_file(path) as file:
        file.write(_START.pack(kind.encode("ascii").ljust(16), version, len(header), zlib.crc32(header), 0))
        file.write(header)
        for values in arrays.values():
            file.write(bytes(-file.tell() % _ALIGNED))
            file.write(_bytes_of(values))


def read_arrays(path, kind, version, what):
    """(about, arrays) of a file that write_arrays wrote; the arrays are mapped from it, and cannot be written to.

    Args:
        path: str or path.
        kind, version: as they were written.
        what: the kind in words, for messages.

    Raises:
        FileError: names the path and what is wrong: a file of another kind or version, one that is cut off or was
            changed, and where.
    """
    require_file(path)
    try:
        with open(path, "rb") as file:
            start, length = file.read(_START.size), os.fstat(file.fileno()).st_size
            if len(start) < _START.size or start[:16] != kind.encode("ascii").ljust(16):
                raise file_error(path, f"holds no {what}")
            _, found, size, checksum, _ = _START.unpack(start)
            if found != version:
                said = f"holds a {what} of version {found}, and this surflux reads version {version}"
                raise file_error(path, said)
            header = file.read(min(size, _MOST_HEADER))
        if len(header) < size:
            raise file_error(path, f"is cut off: its header has {len(header)} of {counted(size, 'byte')}")
        if zlib.crc32(header) != checksum:
            raise file_error(path, "its header was changed: the checksum is another one")
        mapped = np.memmap(path, np.uint8, "r")
    except FileError:
        raise
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault
    try:
        about, entries, whole = _parsed(header)
    except (ValueError, TypeError, KeyError, RecursionError, OverflowError) as fault:
        raise file_error(path, f"its header is damaged ({fault})") from fault
    if length < whole:
        raise file_error(path, f"is cut off: it has {length} of {counted(whole, 'byte')}")
    if length > whole:
        raise file_error(path, f"has {counted(length - whole, 'byte')} behind its end")
    return about, {entry["name"]: _mapped(path, mapped, entry) for entry in entries}


def _bytes_of(values):
    return memoryview(values.reshape(-1).view(np.uint8)) if values.size else b""


def _checksum(data):
    checksum = 0
    for begin in range(0, len(data), _BLOCK):
        checksum = zlib.crc32(data[begin : begin + _BLOCK], checksum)
    return checksum


def _header(about, entries, sizes):
    """JSON that says where all arrays are, which depends on how long it is itself."""
    room = 0
    while True:
        at = _START.size + room
        for entry, size in zip(entries, sizes, strict=True):
            entry["offset"] = at = at + -at % _ALIGNED
            at += size
        text = json.dumps({"about": about, "bytes": at, "arrays": entries}, separators=(",", ":")).encode()
        if len(text) <= room:
            return text.ljust(room)
        room = len(text) + -(len(text) + _START.size) % _ALIGNED + _ALIGNED


def _type_to_json(dtype):
    little = dtype.newbyteorder("<")
    return little.str if little.names is None else [list(field) for field in little.descr]


def _type_of_json(given):
    fields = [tuple(field) for field in given] if isinstance(given, list) else [("", given)]
    for field in fields:  # nothing but numbers: other types are of objects, or run code
        if len(field) != 2 or not all(isinstance(part, str) for part in field) or np.dtype(field[1]).kind not in "iuf":
            raise ValueError(f"{given!r} is no type of numbers")
    return np.dtype(given if isinstance(given, str) else fields)


def _parsed(header):
    data = json.loads(header)
    whole, entries = data["bytes"], []
    for given in data["arrays"]:
        name, shape, offset = given["name"], tuple(given["shape"]), given["offset"]
        dtype = _type_of_json(given["type"])
        sizes = (*shape, offset, given["crc"])
        if not isinstance(name, str) or not all(type(n) is int and 0 <= n < 2**62 for n in sizes) or len(shape) > 3:
            raise ValueError(f"of the array {name!r}")
        count = 1
        for n in shape:
            count *= n
        if offset % _ALIGNED or offset + count * dtype.itemsize > whole:
            raise ValueError(f"the array {name!r} is not in the file")
        entries.append({"name": name, "dtype": dtype, "shape": shape, "offset": offset, "crc": given["crc"]})
    if type(whole) is not int:
        raise ValueError("of the length of the file")
    return data["about"], entries, whole


def _mapped(path, mapped, entry):
    size = int(np.prod(entry["shape"], dtype=object)) * entry["dtype"].itemsize
    raw = mapped[entry["offset"] : entry["offset"] + size].view(np.ndarray)
    if _checksum(memoryview(raw)) != entry["crc"]:
        raise file_error(path, f"its array {entry['name']!r} was changed: the checksum is another one")
    return raw.view(entry["dtype"]).reshape(entry["shape"])
