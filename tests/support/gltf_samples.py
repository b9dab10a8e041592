"""glTF files as other programs write them: a .glb of any header and arrays, without surflux."""

import copy
import json
import struct

import numpy as np

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
SPLAT = "KHR_gaussian_splatting"


def header_and_bytes(parts, nodes=({"mesh": 0},), **more):
    """(header, bytes of its one buffer) of meshes with a primitive each.

    parts: dicts of arrays by the semantics of glTF, without the extension's name: ROTATION, SH_DEGREE_0_COEF_0.
    """
    accessors, views, meshes, data = [], [], [], b""
    for part in parts:
        attributes = {}
        for name, array in part.items():
            array = np.ascontiguousarray(array)
            array = array[:, None] if array.ndim == 1 else array
            width = array.shape[1] * array.itemsize
            stride = width + -width % 4
            rows = np.zeros((len(array), stride), np.uint8)
            rows[:, :width] = array.view(np.uint8).reshape(len(array), width)
            accessor = {"bufferView": len(views), "count": len(array), "type": KINDS[array.shape[1]]}
            accessor["componentType"] = COMPONENTS[array.dtype.str[1:]]
            if array.dtype.kind in "iu":
                accessor["normalized"] = True
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": rows.nbytes, "byteStride": stride})
            attributes[name if name in ("POSITION", "COLOR_0") else f"{SPLAT}:{name}"] = len(accessors)
            accessors.append(accessor)
            data += rows.tobytes()
        extension = {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}
        meshes.append({"primitives": [{"mode": 0, "attributes": attributes, "extensions": {SPLAT: extension}}]})
    header = {"asset": {"version": "2.0"}, "extensionsUsed": [SPLAT], "scene": 0}
    header |= {
        "scenes": [{"nodes": [0]}],
        "nodes": copy.deepcopy(list(nodes)),
        "meshes": meshes,
        "accessors": accessors,
    }
    return header | {"bufferViews": views, "buffers": [{"byteLength": len(data)}]} | more, data


def glb(header, data):
    """Bytes of a .glb file."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    length = 12 + 8 + len(text) + 8 + len(data)
    start = struct.pack("<4sII", b"glTF", 2, length)
    return start + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data


def glb_parts(data):
    """(header, bytes of the BIN chunk) of a .glb file whose structure is what glTF 2.0 section 4 asks for."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    assert size % 4 == 0
    header = json.loads(data[20 : 20 + size])
    more, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    assert more % 4 == 0
    assert 28 + size + more == length
    return header, data[28 + size :]
