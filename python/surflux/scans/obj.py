"""OBJ files that hold points and no faces."""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.files import file_error
from surflux.scans.columns import PointFile
from surflux.scans.tables import text_rows

MESH_HINT = 'surflux.Surfels.from_mesh reads it as a mesh (kind = "mesh" in a scene file)'


def open_obj(path):
    """A PointFile of the vertices, their colours, and their normals where there are as many of them."""
    vertices, offsets, _, colors, *_ = _core.read_obj(path)
    if len(offsets) > 1:
        raise file_error(path, f"has {check.counted(len(offsets) - 1, 'face')}; {MESH_HINT}")
    if len(vertices) == 0:
        raise file_error(path, "no points: it has no vertices")
    chunk = {"points": vertices}
    normals = _normals(path)
    if len(normals) == len(vertices):
        chunk["normals"] = normals
    if colors is not None:
        chunk["colors"] = colors
    return PointFile(len(vertices), iter([chunk]))


def _normals(path):
    with open(path, "rb") as file:
        lines = [(k, line[3:].decode("latin-1").strip()) for k, line in enumerate(file, 1) if line.startswith(b"vn ")]
    return np.concatenate([np.zeros((0, 3)), *text_rows(path, 3, delimiter="", lines=lines)])
