"""glTF 2.0 files of points, written: .glb, and .gltf with its buffer inside."""

import base64
import json
import struct

import numpy as np

from surflux._base.files import whole_file, write_whole
from surflux._base.installation import VERSION

POINTS, ARRAY_BUFFER, FLOAT = 0, 34962, 5126
# A .glb file: magic, version and length of all; then chunks, each with its length and type in front.
GLB_START, GLB_CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
GLB_MAGIC, GLB_VERSION, GLB_JSON, GLB_BIN = b"glTF", 2, b"JSON", b"BIN\0"
GLB_MOST = 2**32 - 1  # bytes
DATA_URI = "data:application/octet-stream;base64,"


def write_gltf_points(path, arrays, matrix=None, extensions=None):
    """Writes points as one primitive, as .glb or .gltf by the name.

    Args:
        path: Path.
        arrays: {semantic: (n, width) or (n,)}, "POSITION" among them; written as float32.
        matrix: (4, 4) of the node; None for the unit matrix.
        extensions: {name: object} of the primitive.

    Raises:
        ValueError: a .glb file of more than 4 GiB.
        FileError: the file cannot be written.
    """
    data = {name: np.ascontiguousarray(array, "<f4") for name, array in arrays.items()}
    size = sum(array.nbytes for array in data.values())
    header = _header(data, np.eye(4) if matrix is None else matrix, extensions or {})
    if path.suffix.lower() == ".gltf":
        packed = base64.b64encode(b"".join(array.tobytes() for array in data.values())).decode("ascii")
        header["buffers"] = [{"byteLength": size, "uri": DATA_URI + packed}]
        write_whole(path, _text(header))
        return
    header["buffers"] = [{"byteLength": size}]
    text = _text(header)
    text += b" " * (-len(text) % 4)
    whole = GLB_START.size + 2 * GLB_CHUNK.size + len(text) + size
    if whole > GLB_MOST:
        raise ValueError(f"path: a .glb file has up to 4 GiB, got {whole / 2**30:.1f}; .gltf and .ply hold more")
    with whole_file(path) as file:
        file.write(GLB_START.pack(GLB_MAGIC, GLB_VERSION, whole))
        file.write(GLB_CHUNK.pack(len(text), GLB_JSON) + text)
        file.write(GLB_CHUNK.pack(size, GLB_BIN))  # floats alone, so that it is a multiple of 4
        for array in data.values():
            file.write(array.data)


def up_to_y(up):
    """The shortest rotation (3, 3) that takes a unit vector to +y, which is up in glTF; exact for the axes."""
    x, y, z = up
    if y < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.array([-z, 0.0, x])  # up cross +y, of length sine; Rodrigues' formula, free of the sine's division
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + cross + cross @ cross / (1.0 + y)


def _header(arrays, matrix, extensions):
    accessors, views, begin = [], [], 0
    for name, array in arrays.items():
        kind = "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}"
        accessor = {"bufferView": len(views), "componentType": FLOAT, "count": len(array), "type": kind}
        if name == "POSITION":
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors.append(accessor)
        views.append({"buffer": 0, "byteOffset": begin, "byteLength": array.nbytes, "target": ARRAY_BUFFER})
        begin += array.nbytes
    primitive = {"mode": POINTS, "attributes": {name: k for k, name in enumerate(arrays)}}
    node = {"mesh": 0}
    if not np.array_equal(matrix, np.eye(4)):
        node["matrix"] = (matrix.T + 0.0).ravel().tolist()  # columns first; -0 becomes 0
    return {
        "asset": {"version": "2.0", "generator": f"surflux {VERSION}"},
        **({"extensionsUsed": list(extensions)} if extensions else {}),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"primitives": [primitive | ({"extensions": extensions} if extensions else {})]}],
        "accessors": accessors,
        "bufferViews": views,
    }


def _text(header):
    return json.dumps(header, separators=(",", ":"), allow_nan=False).encode("ascii")
