"""glTF files as JSON and bytes: .glb, and .gltf with its buffers inside or beside it."""

import base64
import binascii
import json
import os
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from surflux.meshes.gltf_format import (
    COMPONENTS,
    GLB_BIN,
    GLB_CHUNK,
    GLB_JSON,
    GLB_MAGIC,
    GLB_START,
    GLB_VERSION,
    WIDTHS,
)

DAMAGED = (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError, RecursionError)
_MOST_ZEROS = 1 << 28  # elements that no byte of a file stands for


class Container:
    """The header of a glTF file, and its accessors as arrays.

    Everything that does not fit raises one of DAMAGED, or OSError; the numbers of a header may be anything.
    """

    def __init__(self, path):
        self._folder = Path(path).parent
        data = Path(path).read_bytes()
        text, self._binary = _glb(data) if data[:4] == GLB_MAGIC else (data, None)
        self.header = json.loads(text.decode("utf-8-sig"), parse_constant=_no_constant)
        if not isinstance(self.header, dict) or str(self.header["asset"]["version"])[:2] != "2.":
            raise ValueError("wanted glTF 2.0")
        self._buffers = {}

    def entry(self, kind, index):
        """An entry of a list of the header, such as ("nodes", 0)."""
        found = self.header[kind][whole(f"the index of {kind}", index, len(self.header[kind]) - 1)]
        if not isinstance(found, dict):
            raise ValueError(f"{kind} {index} is no object")
        return found

    def size(self):
        """Bytes of all buffers that were read so far."""
        return sum(len(data) for data in self._buffers.values())

    def count(self, index):
        """How many elements an accessor says it has."""
        return whole("count", self.entry("accessors", index)["count"])

    def array(self, index, *wanted, normalized=False):
        """An accessor of a type that is wanted, as "VEC3": (count, width) float64, or (count,) of scalars.

        Normalized integers are what they stand for. normalized: also where the file does not say that they are.
        """
        accessor = self.entry("accessors", index)
        if "sparse" not in accessor and "bufferView" not in accessor:
            raise ValueError("an accessor has no bufferView")
        kind, dtype = accessor["type"], np.dtype(COMPONENTS[accessor["componentType"]])
        if kind not in wanted:
            raise ValueError(f"an accessor is {kind!r}; wanted {' or '.join(wanted)}")
        width, count = WIDTHS[kind], self.count(index)
        if "sparse" in accessor:
            values = self._with_sparse(accessor, dtype, width, count)
        else:
            values = self._elements(accessor, dtype, width, count)
        if (normalized or accessor.get("normalized", False)) and dtype.kind in "iu":
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values[:, 0] if width == 1 else values

    def _elements(self, of, dtype, width, count):
        """(count, width) float64 in the bufferView of an accessor, or of a part of a sparse one."""
        view = self.entry("bufferViews", of["bufferView"])
        if view.get("extensions"):
            raise ValueError(f"a bufferView has {', '.join(view['extensions'])}, which is not read here")
        data = self._buffer(view["buffer"])
        begin, length = (whole(name, view.get(name, 0)) for name in ("byteOffset", "byteLength"))
        stride = whole("byteStride", view.get("byteStride", width * dtype.itemsize), 252)
        offset = whole("byteOffset", of.get("byteOffset", 0))
        last = offset + (count - 1) * stride + width * dtype.itemsize
        if stride < width * dtype.itemsize or count < 1 or last > length or begin + length > len(data):
            raise ValueError(f"{count} elements of an accessor are not in its buffer")
        return np.ndarray((count, width), dtype, data, begin + offset, (stride, dtype.itemsize)).astype(np.float64)

    def _with_sparse(self, accessor, dtype, width, count):
        """(count, width) float64: of the accessor's bufferView, 0 without one, but for the elements that it lists."""
        sparse = accessor["sparse"]
        number, of_indices = whole("count of sparse", sparse["count"], count), sparse["indices"]
        rows = self._elements(of_indices, np.dtype(COMPONENTS[of_indices["componentType"]]), 1, number)[:, 0]
        if not ((rows >= 0) & (rows < count)).all():
            raise ValueError(f"a sparse accessor has an element {rows.max():g} of {count}")
        if "bufferView" in accessor:
            values = self._elements(accessor, dtype, width, count)
        elif count > _MOST_ZEROS:
            raise ValueError(f"a sparse accessor has {count} elements; wanted up to {_MOST_ZEROS} without a bufferView")
        else:
            values = np.zeros((count, width))
        values[rows.astype(np.int64)] = self._elements(sparse["values"], dtype, width, number)
        return values

    def view(self, index):
        """The bytes of a bufferView."""
        view = self.entry("bufferViews", index)
        data = self._buffer(view["buffer"])
        begin, length = (whole(name, view.get(name, 0)) for name in ("byteOffset", "byteLength"))
        if begin + length > len(data):
            raise ValueError(f"bufferView {index} is not in its buffer")
        return data[begin : begin + length]

    def data(self, uri, length=None):
        """The bytes of a data URI, or the first `length` of a file beside the .gltf; FileNotFoundError of none."""
        if uri.startswith("data:"):
            return _decoded(uri)
        name = unquote(uri)
        if "://" in name or os.path.isabs(name) or "\0" in name:
            raise ValueError(f"wanted a file beside it, got {uri[:60]!r}")
        places = (self._folder / one for one in (name, uri, name.replace("\\", "/")))
        with open(next((place for place in places if place.is_file()), self._folder / name), "rb") as file:
            return file.read(length)

    def _buffer(self, index):
        if index not in self._buffers:
            buffer = self.entry("buffers", index)
            length = whole("byteLength", buffer["byteLength"])
            try:
                data = self._binary if "uri" not in buffer else self.data(buffer["uri"], length)
            except FileNotFoundError as fault:
                raise ValueError(f"its buffer {unquote(buffer['uri'])[:60]!r} is not there") from fault
            if data is None or len(data) < length:
                raise ValueError(f"is cut off: buffer {index} has {len(data or b'')} of {length} bytes")
            self._buffers[index] = data[:length]
        return self._buffers[index]


def whole(name, value, most=2**53):
    """value, if it is a whole number from 0 to `most`."""
    if type(value) is not int or not 0 <= value <= most:
        raise ValueError(f"{name} is {value!r:.40}; wanted a whole number from 0 to {most}")
    return value


def numbers(name, values, count):
    """`count` finite numbers of the header, as an array."""
    found = np.array(values)
    if found.shape != (count,) or found.dtype.kind not in "iuf" or not np.isfinite(found).all():
        raise ValueError(f"{name}: wanted {count} finite numbers")
    return found.astype(np.float64)


def _glb(data):
    """(JSON, bytes of the BIN chunk or None) of a .glb file."""
    if len(data) < GLB_START.size:
        raise ValueError("is cut off")
    _, version, length = GLB_START.unpack_from(data)
    if version != GLB_VERSION:
        raise ValueError(f"is of version {version} of GLB; wanted {GLB_VERSION}")
    if length > len(data):
        raise ValueError(f"is cut off: it has {len(data)} of {length} bytes")
    chunks, at = {}, GLB_START.size
    while at + GLB_CHUNK.size <= length:
        size, kind = GLB_CHUNK.unpack_from(data, at)
        at += GLB_CHUNK.size
        if at + size > length:
            raise ValueError(f"is cut off: a chunk of {size} bytes ends beyond the file")
        chunks.setdefault(kind, data[at : at + size])
        at += size
    if GLB_JSON not in chunks:
        raise ValueError("has no JSON chunk")
    return chunks[GLB_JSON], chunks.get(GLB_BIN)


def _decoded(uri):
    """The bytes of a data URI."""
    kind, _, packed = uri.partition(",")
    if not kind.endswith(";base64"):
        raise ValueError("a data URI is not base64")
    try:
        return base64.b64decode(packed, validate=True)
    except binascii.Error as fault:
        raise ValueError(f"a data URI is damaged ({fault})") from fault


def _no_constant(name):
    raise ValueError(f"{name} is no JSON")
