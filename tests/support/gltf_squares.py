"""glTF files of one textured square, whose headers tests change before they are written."""

import base64
import io
import json

import numpy as np

from gltf_samples import COMPONENTS

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
UPRIGHT = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4")  # v goes down
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def data_uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def png(pixels):
    """Bytes of a PNG file of (h, w, 3)."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(out, "PNG")
    return out.getvalue()


class Square:
    """A square of two triangles in material m; `header` is what is written."""

    def __init__(self, pixels=None, position=SQUARE, places=UPRIGHT, indices=(0, 1, 2, 0, 2, 3), mode=4, **material):
        lists = ("buffers", "bufferViews", "accessors", "materials", "meshes")
        self.header = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]}
        self.header |= {name: [] for name in lists}
        self.header["materials"] = [{"name": "m", **material}]
        if pixels is not None:
            self.header |= {"images": [{"uri": data_uri(png(pixels), "image/png")}], "textures": [{"source": 0}]}
            self.material.setdefault("pbrMetallicRoughness", {})["baseColorTexture"] = {"index": 0}
        self.primitive = {"attributes": {"POSITION": self.array(position)}, "material": 0, "mode": mode}
        if places is not None:
            self.primitive["attributes"]["TEXCOORD_0"] = self.array(places)
        if indices is not None:
            self.primitive["indices"] = self.array(np.array(indices, "<u2"))
        self.header["meshes"] = [{"primitives": [self.primitive]}]

    @property
    def material(self):
        return self.header["materials"][0]

    def view(self, array):
        """The index of a bufferView of its own buffer."""
        data = np.ascontiguousarray(array).tobytes()
        self.header["buffers"].append({"uri": data_uri(data), "byteLength": len(data)})
        self.header["bufferViews"].append({"buffer": len(self.header["buffers"]) - 1, "byteLength": len(data)})
        return len(self.header["bufferViews"]) - 1

    def array(self, array):
        """The index of an accessor; integers of vectors are normalized."""
        array = np.asarray(array)
        accessor = {"bufferView": self.view(array), "count": len(array), "type": KINDS[array[:1].size]}
        accessor["componentType"] = COMPONENTS[array.dtype.str[1:]]
        if array.ndim == 2 and array.dtype.kind in "iu":
            accessor["normalized"] = True
        self.header["accessors"].append(accessor)
        return len(self.header["accessors"]) - 1

    def save(self, path):
        path.write_text(json.dumps(self.header))
        return path
