"""glTF files of Gaussians, written."""

import base64
import json

import numpy as np

from surflux._base.color import srgb_to_linear
from surflux._base.files import whole_file, write_whole
from surflux._base.installation import VERSION
from surflux.splats import gltf_format as gltf
from surflux.splats.origins import to_origin
from surflux.splats.turning import up_to_y
from surflux.splats.view_colors import even_color


def write_gltf(path, gaussians, up):
    """Writes Gaussians, .glb or .gltf by the name; `up` (3,), a unit vector, becomes +y by the matrix of the node.

    The arrays are those of the Gaussians, harmonics included: what is written does not depend on up, and comes back as
    it was. Raises FileError.
    """
    positions, origin = to_origin(gaussians.positions, gaussians.scales)
    arrays = _attributes(gaussians, positions)
    header = _header(gaussians, arrays, up, origin)
    data = [np.ascontiguousarray(array, "<f4") for array in arrays.values()]
    size = sum(array.nbytes for array in data)
    if path.suffix.lower() == ".gltf":
        packed = base64.b64encode(b"".join(array.tobytes() for array in data)).decode("ascii")
        header["buffers"] = [{"byteLength": size, "uri": gltf.DATA_URI + packed}]
        write_whole(path, _text(header))
        return
    header["buffers"] = [{"byteLength": size}]
    text = _text(header)
    text += b" " * (-len(text) % 4)
    whole = gltf.GLB_START.size + 2 * gltf.GLB_CHUNK.size + len(text) + size
    if whole > gltf.GLB_MOST:
        raise ValueError(f"path: a .glb file has up to 4 GiB, got {whole / 2**30:.1f}; .gltf and .ply hold more")
    with whole_file(path) as file:
        file.write(gltf.GLB_START.pack(gltf.GLB_MAGIC, gltf.GLB_VERSION, whole))
        file.write(gltf.GLB_CHUNK.pack(len(text), gltf.GLB_JSON) + text)
        file.write(gltf.GLB_CHUNK.pack(size, gltf.GLB_BIN))  # floats alone, so that it is a multiple of 4
        for array in data:
            file.write(array.data)


def _attributes(g, positions):
    """{semantic: (n, width) or (n,)} of all that a Gaussian has."""
    color = np.clip(even_color(g.harmonics.astype(np.float32).astype(np.float64)), 0.0, 1.0)
    color = srgb_to_linear(color) if g.color_space == "srgb" else color
    return {
        "POSITION": positions,
        "COLOR_0": np.concatenate([color, g.opacities[:, None]], axis=1),  # linear, whatever the Gaussians are
        gltf.ROTATION: np.roll(g.rotations, -1, axis=1),  # (x, y, z, w)
        gltf.SCALE: g.scales,
        gltf.OPACITY: g.opacities,
        **{name: g.harmonics[:, k] for k, name in enumerate(gltf.harmonics(g.degree))},
    }


def _header(g, arrays, up, origin):
    accessors, views, begin = [], [], 0
    for name, array in arrays.items():
        size = array.size * 4
        kind = "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}"
        accessor = {"bufferView": len(views), "componentType": gltf.FLOAT, "count": len(g), "type": kind}
        if name == "POSITION":
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors.append(accessor)
        views.append({"buffer": 0, "byteOffset": begin, "byteLength": size, "target": gltf.ARRAY_BUFFER})
        begin += size
    primitive = {
        "mode": gltf.POINTS,
        "attributes": {name: k for k, name in enumerate(arrays)},
        "extensions": {gltf.EXTENSION: {"kernel": "ellipse", "colorSpace": gltf.COLOR_SPACES[g.color_space]}},
    }
    node = {"mesh": 0}
    turn = up_to_y(up)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn, turn @ origin
    if not np.array_equal(matrix, np.eye(4)):
        node["matrix"] = (matrix.T + 0.0).ravel().tolist()  # columns first; -0 becomes 0
    return {
        "asset": {"version": "2.0", "generator": f"surflux {VERSION}"},
        "extensionsUsed": [gltf.EXTENSION],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [node],
        "meshes": [{"primitives": [primitive]}],
        "accessors": accessors,
        "bufferViews": views,
    }


def _text(header):
    return json.dumps(header, separators=(",", ":"), allow_nan=False).encode("ascii")
