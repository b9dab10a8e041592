"""Numbers of glTF 2.0 and of its binary container, .glb."""

import struct

POINTS, TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN = 0, 4, 5, 6  # modes of primitives
ARRAY_BUFFER, INDEX_BUFFER = 34962, 34963
UNSIGNED_INT, FLOAT = 5125, 5126
NEAREST = 9728  # a filter of samplers
COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", UNSIGNED_INT: "<u4", FLOAT: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
# A .glb file: magic, version and length of all; then chunks, each with its length and type in front.
GLB_START, GLB_CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
GLB_MAGIC, GLB_VERSION, GLB_JSON, GLB_BIN = b"glTF", 2, b"JSON", b"BIN\0"
