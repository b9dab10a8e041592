"""glTF 2.0 files of points and triangles, written: .glb, and .gltf with its buffer inside."""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surflux._base.files import whole_file, write_whole
from surflux._base.installation import VERSION
from surflux.meshes.gltf_format import (
    ARRAY_BUFFER,
    FLOAT,
    GLB_BIN,
    GLB_CHUNK,
    GLB_JSON,
    GLB_MAGIC,
    GLB_START,
    GLB_VERSION,
    INDEX_BUFFER,
    POINTS,
    TRIANGLES,
    UNSIGNED_INT,
)

UNLIT = "KHR_materials_unlit"
GLB_MOST = 2**32 - 1  # bytes
DATA_URI = "data:application/octet-stream;base64,"


@dataclass(frozen=True, eq=False)
class Primitive:
    """Points or triangles of a mesh.

    Attributes:
        arrays: {semantic: (n, width) or (n,)}, "POSITION" among them; written as float32.
        indices: (m, 3) of the corners of triangles; None of points.
        extensions: {name: object}.
        unlit: whether viewers show COLOR_0 as it is, not in lights of their own.
    """

    arrays: Mapping[str, np.ndarray]
    indices: np.ndarray | None = None
    extensions: Mapping[str, Any] = field(default_factory=dict)
    unlit: bool = False


def write_primitives(path, primitives, matrix=None):
    """Writes primitives as one mesh, as .glb or .gltf by the name.

    Args:
        path: Path.
        primitives: list of Primitive.
        matrix: (4, 4) of the node; None for the unit matrix.

    Raises:
        ValueError: a .glb file of more than 4 GiB.
        FileError: the file cannot be written.
    """
    file = _File()
    header = _header([_primitive(file, p) for p in primitives], np.eye(4) if matrix is None else matrix, file)
    if path.suffix.lower() == ".gltf":
        packed = base64.b64encode(b"".join(array.tobytes() for array in file.data)).decode("ascii")
        header["buffers"] = [{"byteLength": file.size, "uri": DATA_URI + packed}]
        write_whole(path, _text(header))
        return
    header["buffers"] = [{"byteLength": file.size}]
    text = _text(header)
    text += b" " * (-len(text) % 4)
    whole = GLB_START.size + 2 * GLB_CHUNK.size + len(text) + file.size
    if whole > GLB_MOST:
        raise ValueError(f"path: a .glb file has up to 4 GiB, got {whole / 2**30:.1f}; .gltf and .ply hold more")
    with whole_file(path) as out:
        out.write(GLB_START.pack(GLB_MAGIC, GLB_VERSION, whole))
        out.write(GLB_CHUNK.pack(len(text), GLB_JSON) + text)
        out.write(GLB_CHUNK.pack(file.size, GLB_BIN))  # numbers of 4 bytes alone, so that it is a multiple of 4
        for array in file.data:
            out.write(array.data)


def placed(origin, up):
    """The matrix (4, 4) of a node whose points stand around an origin (3,); `up` (3,), a unit vector, becomes +y."""
    turn, matrix = up_to_y(up), np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, turn @ origin
    return matrix


def up_to_y(up):
    """The shortest rotation (3, 3) that takes a unit vector to +y, which is up in glTF; exact for the axes."""
    x, y, z = up
    if y < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    axis = np.array([-z, 0.0, x])  # up cross +y, of length sine; Rodrigues' formula, free of the sine's division
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + cross + cross @ cross / (1.0 + y)


class _File:
    """The arrays of a file, one after another, and what its header says of them."""

    def __init__(self):
        self.data, self.accessors, self.views, self.size = [], [], [], 0

    def add(self, array, component, target, **more):
        """The index of the accessor of an array (n, width) or (n,)."""
        kind = "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}"
        accessor = {"bufferView": len(self.views), "componentType": component, "count": len(array), "type": kind}
        self.accessors.append(accessor | more)
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": array.nbytes, "target": target})
        self.data.append(array)
        self.size += array.nbytes
        return len(self.accessors) - 1


def _primitive(file, of):
    attributes = {}
    for name, values in of.arrays.items():
        array = np.ascontiguousarray(values, "<f4")
        bounds = {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()} if name == "POSITION" else {}
        attributes[name] = file.add(array, FLOAT, ARRAY_BUFFER, **bounds)
    out = {"mode": POINTS if of.indices is None else TRIANGLES, "attributes": attributes}
    if of.indices is not None:
        out["indices"] = file.add(np.ascontiguousarray(of.indices, "<u4").ravel(), UNSIGNED_INT, INDEX_BUFFER)
    if of.unlit:
        out["material"] = 0
    return out | ({"extensions": dict(of.extensions)} if of.extensions else {})


def _header(primitives, matrix, file):
    node = {"mesh": 0}
    if not np.array_equal(matrix, np.eye(4)):
        node["matrix"] = (matrix.T + 0.0).ravel().tolist()  # columns first; -0 becomes 0
    used = [name for primitive in primitives for name in primitive.get("extensions", ())]
    materials = {}
    if any("material" in primitive for primitive in primitives):
        used.append(UNLIT)
        white = {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0}
        materials = {"materials": [{"pbrMetallicRoughness": white, "extensions": {UNLIT: {}}}]}
    return {
        "asset": {"version": "2.0", "generator": f"surflux {VERSION}"},
        **({"extensionsUsed": list(dict.fromkeys(used))} if used else {}),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"primitives": primitives}],
        **materials,
        "accessors": file.accessors,
        "bufferViews": file.views,
    }


def _text(header):
    return json.dumps(header, separators=(",", ":"), allow_nan=False).encode("ascii")
