"""glTF files as JSON and bytes: .glb, and .gltf with its buffers inside or beside it."""

import base64
import binascii
import json
import os
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from surflux.scans.gltf import GLB_BIN, GLB_CHUNK, GLB_JSON, GLB_MAGIC, GLB_START, GLB_VERSION
from surflux.splats import gltf_format as gltf

DAMAGED = (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError, RecursionError)


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

    def array(self, index, wanted):
        """An accessor as (count, width) float64, or (count,) of scalars; normalized integers as what they stand for."""
        accessor = self.entry("accessors", index)
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError("an accessor is sparse, or has no bufferView, which is not read here")
        kind, component = accessor["type"], gltf.COMPONENTS[accessor["componentType"]]
        if kind != wanted:
            raise ValueError(f"an accessor is {kind!r}; wanted {wanted}")
        dtype, width, count = np.dtype(component), gltf.WIDTHS[kind], self.count(index)
        view = self.entry("bufferViews", accessor["bufferView"])
        if view.get("extensions"):
            raise ValueError(f"a bufferView has {', '.join(view['extensions'])}, which is not read here")
        data = self._buffer(view["buffer"])
        begin, length = (whole(name, view.get(name, 0)) for name in ("byteOffset", "byteLength"))
        stride = whole("byteStride", view.get("byteStride", width * dtype.itemsize), 252)
        offset = whole("byteOffset", accessor.get("byteOffset", 0))
        last = offset + (count - 1) * stride + width * dtype.itemsize
        if stride < width * dtype.itemsize or count < 1 or last > length or begin + length > len(data):
            raise ValueError(f"{count} elements of an accessor are not in its buffer")
        values = np.ndarray((count, width), dtype, data, begin + offset, (stride, dtype.itemsize)).astype(np.float64)
        if accessor.get("normalized", False) and dtype.kind in "iu":
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values[:, 0] if width == 1 else values

    def _buffer(self, index):
        if index not in self._buffers:
            buffer = self.entry("buffers", index)
            length = whole("byteLength", buffer["byteLength"])
            data = self._binary if "uri" not in buffer else _of_uri(self._folder, buffer["uri"], length)
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


def _of_uri(folder, uri, length):
    """The bytes of a data URI, or the first `length` of a file beside the .gltf."""
    if uri.startswith("data:"):
        kind, _, packed = uri.partition(",")
        if not kind.endswith(";base64"):
            raise ValueError("a data URI is not base64")
        try:
            return base64.b64decode(packed, validate=True)
        except binascii.Error as fault:
            raise ValueError(f"a data URI is damaged ({fault})") from fault
    name = unquote(uri)
    if "://" in name or os.path.isabs(name) or "\0" in name:
        raise ValueError(f"wanted buffers beside the file, got {uri[:60]!r}")
    path = folder / name
    if not path.is_file():
        raise ValueError(f"its buffer {name[:60]!r} is not there")
    with open(path, "rb") as file:
        return file.read(length)


def _no_constant(name):
    raise ValueError(f"{name} is no JSON")
