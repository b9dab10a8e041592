"""Files of points, written: the formats that are read, and those of viewers."""

import os
import zipfile
from pathlib import Path

import numpy as np

from surflux._base.color import srgb_to_linear
from surflux._base.files import whole_file
from surflux._base.warn import warn
from surflux.scans.gltf import Primitive, placed, write_primitives
from surflux.scans.las_writing import write_las
from surflux.scans.names import OWN, Names, scalars
from surflux.scans.viewpoints import NAME, comments_of, warn_of_lost
from surflux.scans.vtp import write_polydata

_BLOCK = 100_000  # rows formatted or interleaved at once
_COARSE = 0.1  # of the spacing of points: rounding of more than that is said
_PLY_TYPES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint"}
_PLY_TYPES |= {"f4": "float", "f8": "double"}


def write_points(path, columns, frame=None, comments=(), up=(0.0, 0.0, 1.0), pixels=None, viewpoints=()):
    """Writes columns of points, in the format of the name; a file that is there is replaced whole or not at all.

    Args:
        path: Path, its suffix one of WRITTEN.
        columns: dict of "points" (n, 3), and of "normals" (n, 3), "colors" (n, 3) uint8 and attributes (n,) or (n, k),
            whatever there is of these. NaN says that a value is not known.
        frame: of a LAS file that the points come from, as open_las has it; None of others.
        comments: lines of text, of PLY files.
        up: (3,), a unit vector, which becomes y in glTF.
        pixels: (k, 3) of what is seen behind, in PLY files an element `environment`; None for none.
        viewpoints: (k, 3) where the points were seen from, NaN where that is not known; a warning says where the format
            loses them, and the points have no normals that tell.

    Raises:
        ValueError: a name that says no format of these; what the format has no room for.
        FileError: the file cannot be written; what it takes is not installed.
    """
    writer = WRITTEN[written_suffix(path)]
    if not isinstance(comments, tuple | list) or not all(isinstance(line, str) for line in comments):
        raise ValueError("comments: wanted a list of lines of text")
    if any("\n" in line or "\r" in line for line in comments):
        raise ValueError("comments: wanted lines of text, got one with a line break")
    if "normals" not in columns and writer not in (_write_ply, _write_npz):
        warn_of_lost(path, viewpoints)
    if writer is write_las:
        writer(path, columns, frame)
    elif writer is _write_ply:
        writer(path, columns, [*comments, *comments_of(viewpoints)], pixels)
    elif writer is _write_npz:
        writer(path, columns | ({NAME: viewpoints} if len(viewpoints) and NAME not in columns else {}))
    elif writer is _write_gltf:
        writer(path, columns, up)
    else:
        writer(path, columns)


def written_suffix(path, name="path"):
    """The suffix of a path, if points are written under it."""
    suffix = Path(os.fsdecode(path)).suffix.lower()
    if suffix not in WRITTEN:
        raise ValueError(f"{name}: wanted a name ending in {', '.join(WRITTEN)}, got {os.fsdecode(path)!r}")
    return suffix


def _write_ply(path, columns, comments, pixels):
    """Binary little-endian PLY. Coordinates are doubles where floats do not hold them."""
    parts = scalars(path, columns, _tidy)
    types = {name: _ply_type(name, values) for name, values in parts.items()}
    row = np.dtype([(name, "<" + kind) for name, kind in types.items()])
    count = len(columns["points"])
    lines = ["ply", "format binary_little_endian 1.0", *(f"comment {line}" for line in comments)]
    lines += [f"element vertex {count}", *(f"property {_PLY_TYPES[kind]} {name}" for name, kind in types.items())]
    if pixels is not None:
        lines += [f"element environment {len(pixels)}", *(f"property float {channel}" for channel in "rgb")]
    with whole_file(path) as file:
        file.write(("\n".join([*lines, "end_header"]) + "\n").encode("utf-8", "backslashreplace"))
        for begin in range(0, count, _BLOCK):
            rows = np.empty(min(_BLOCK, count - begin), row)
            for name, values in parts.items():
                rows[name] = values[begin : begin + _BLOCK]
            file.write(rows.data)
        if pixels is not None:
            file.write(np.ascontiguousarray(pixels, "<f4").data)


def _ply_type(name, values):
    if values.dtype == bool:
        return "u1"
    kind = values.dtype.str[1:]
    if kind in ("f2", "f4"):
        return "f4"
    if kind in _PLY_TYPES and kind != "f8":
        return kind
    if values.dtype.kind in "iu":  # of 8 bytes
        for small in ("i4", "u4"):
            limits = np.iinfo(small)
            if len(values) == 0 or (values.min() >= limits.min and values.max() <= limits.max):
                return small
        return "f8"
    if name in OWN["points"]:
        with np.errstate(over="ignore"):
            exact = np.array_equal(values.astype(np.float32).astype(np.float64), values)
        return "f4" if exact else "f8"
    return "f8" if name not in OWN["normals"] else "f4"


def _write_csv(path, columns):
    """Lines of numbers between commas, behind one with the names; of floats as many digits as bring them back."""
    parts = scalars(path, columns, _tidy)
    with whole_file(path) as file:
        file.write((",".join(parts) + "\n").encode("utf-8", "backslashreplace"))
        for begin in range(0, len(columns["points"]), _BLOCK):
            texts = [_texts(values[begin : begin + _BLOCK]) for values in parts.values()]
            file.write(("\n".join(map(",".join, zip(*texts, strict=True))) + "\n").encode())


def _tidy(name):
    """A name without what ends one in a line."""
    return "".join("_" if c in ',;"' or c.isspace() else c for c in name) or "_"


def _texts(values):
    if values.dtype.kind in "iub":
        return list(map(str, values.astype(np.int64 if values.dtype.kind != "u" else np.uint64).tolist()))
    if values.dtype == np.float32:
        return [f"{value:.9g}" for value in values.tolist()]
    return list(map(repr, values.astype(np.float64).tolist()))


def _write_npz(path, columns):
    """Arrays by their names."""
    with whole_file(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
        for name, values in columns.items():  # np.savez takes no array of the name "file"
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.ascontiguousarray(values), allow_pickle=False)


def _write_vtp(path, columns):
    """VTK PolyData, for ParaView: "RGB" are the colours, "Normals" the normals."""
    import pyvista

    own = {"normals": "Normals", "colors": "RGB"}
    names = Names(path, (name for column, name in own.items() if column in columns))
    data = pyvista.PolyData(np.ascontiguousarray(columns["points"], dtype=np.float64))
    for name, values in columns.items():
        if name != "points":
            data.point_data[own[name] if name in own else names.free(name)] = values
    names.warn_of_others()
    write_polydata(path, data)


def _write_gltf(path, columns, up):
    """Points of glTF 2.0, turned to y up; colours linear, as glTF has them, attributes as _NAME."""
    points = columns["points"]
    middle = np.median(points, axis=0)  # where floats are finest
    arrays = {"POSITION": points - middle}
    _warn_of_rounding(path, arrays["POSITION"])
    if "normals" in columns:  # which glTF wants of length 1: up, where none is known
        known = np.isfinite(columns["normals"]).all(axis=1, keepdims=True)
        arrays["NORMAL"] = np.where(known, columns["normals"], [0.0, 0.0, 1.0])
    if "colors" in columns:
        arrays["COLOR_0"] = srgb_to_linear(columns["colors"] / 255.0)
    names = Names(path, ())
    for name, values in columns.items():
        if name not in OWN and (values.ndim == 1 or values.shape[1] in (2, 3, 4)):
            arrays["_" + names.free(str(name).upper())] = values
    names.warn_of_others()
    write_primitives(path, [Primitive(arrays)], placed(middle, up))


def _warn_of_rounding(path, positions):
    """Warns where floats of 32 bits move points by more than a tenth of the spacing of 98 % of them."""
    if len(positions) < 2:
        return
    extent = np.max(np.ptp(np.percentile(positions, [1, 99], axis=0), axis=0))
    extent = extent or np.max(np.ptp(positions, axis=0))
    spacing = extent / np.sqrt(len(positions))
    with np.errstate(over="ignore", invalid="ignore"):
        off = np.abs(positions.astype(np.float32) - positions).max(axis=1)
    moved = off > _COARSE * spacing
    if np.any(moved):
        warn(
            f"{path}: {np.count_nonzero(moved)} of {len(moved)} points are moved by up to {off[moved].max():.2g}, for "
            "they are far from the others and glTF has floats of 32 bits; .ply and .npz keep them"
        )


WRITTEN = {".ply": _write_ply, ".las": write_las, ".laz": write_las, ".csv": _write_csv, ".npz": _write_npz}
WRITTEN |= {".vtp": _write_vtp, ".glb": _write_gltf, ".gltf": _write_gltf}
