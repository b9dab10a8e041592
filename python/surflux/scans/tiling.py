"""Tiles of one survey: what their headers say, whether they go together, and the points of them around a box."""

import os
from typing import NamedTuple

import numpy as np

from surflux._base.files import file_error
from surflux._base.passes import report, stage
from surflux.scans.formats import format_of
from surflux.scans.las import las_header, open_las
from surflux.scans.las_writing import frame_of
from surflux.scans.thinning import joined


class TileHeader(NamedTuple):
    """Of a LAS file, as it is promised.

    Attributes:
        path: as handed in, text.
        count: of points.
        low, high: (3,) corners of the box around them.
        step, offset: (3,) coordinates are whole multiples of `step` from `offset`.
        kind: of points: the number of their format, and the extra dimensions by name and type.
        reference: {number of a record: its bytes} of the coordinate reference system.
    """

    path: str
    count: int
    low: np.ndarray
    high: np.ndarray
    step: np.ndarray
    offset: np.ndarray
    kind: tuple
    reference: dict


def tile_header(path):
    """The TileHeader of a file.

    Raises:
        FileError: the file cannot be read, is no LAS, holds no points.
    """
    if format_of(path) != "las":
        raise file_error(path, "wanted tiles of LAS, LAZ or COPC")
    header = las_header(path)
    if header.point_count == 0:
        raise file_error(path, "no points: it has none; leave it out")
    frame = frame_of(header)
    extra = tuple(sorted((d.name, str(d.dtype)) for d in header.point_format.extra_dimensions))
    kind = (frame["point_format"], extra)
    reference = {record.record_id: record.record_data_bytes() for record in frame["reference"]}
    low, high = np.array(header.mins, np.float64), np.array(header.maxs, np.float64)
    if not np.all(np.isfinite([low, high])) or np.any(high < low):
        raise file_error(path, f"its header has no box around its points: {low} to {high}")
    lattice = frame["scales"], frame["offsets"]
    return TileHeader(os.fsdecode(path), int(header.point_count), low, high, *lattice, kind, reference)


def check_alike(headers):
    """Refuses tiles of which points or coordinates mean something else than those of the first.

    Raises:
        FileError: names the tile, and the first one.
    """
    first = headers[0]
    for tile in headers[1:]:
        beside = f"that of {first.path}; wanted tiles of one survey"
        if tile.kind[0] != first.kind[0]:
            raise file_error(tile.path, f"its point format is {tile.kind[0]}, and {first.kind[0]} is {beside}")
        if tile.kind[1] != first.kind[1]:
            mine, its = (", ".join(name for name, _ in one.kind[1]) or "none" for one in (tile, first))
            raise file_error(tile.path, f"its extra dimensions ({mine}) are others ({its}) than {beside}")
        if tile.reference != first.reference and not _same_system(tile, first):
            mine, its = (_system_text(one) for one in (tile, first))
            raise file_error(tile.path, f"its coordinate reference system is {mine}, and {its} is {beside}")


def _same_system(a, b):
    """Whether two ways to write a system mean one, as GeoTIFF keys and WKT do; False where that cannot be told."""
    found = [_system(one.path) for one in (a, b)]
    return None not in found and found[0] == found[1]


def _system(path):
    """The system of pyproj; None of a file without one, or where it is not understood, or without pyproj."""
    try:
        import pyproj

        return las_header(path).parse_crs()
    except ImportError:
        return None
    except pyproj.exceptions.CRSError:
        return None


def _system_text(tile):
    if not tile.reference:
        return "none"
    found = _system(tile.path)
    return "another" if found is None else repr(found.name)


def points_around(path, low, high, names, label):
    """Columns of the points of a file whose x and y lie in a box, read by chunks; None where there are none.

    Args:
        low, high: (2,) corners, both of them inside, or one number for x and y.
        names: set of the columns that are wanted beside "points".
        label: of the stage that progress is told for.
    """
    opened, kept, told, count = open_las(path), [], stage(label), 0
    for chunk in opened.chunks:
        count += len(chunk["points"])
        points = chunk["points"]
        inside = np.all((points[:, :2] >= low) & (points[:, :2] <= high), axis=1) & np.all(np.isfinite(points), axis=1)
        if np.any(inside):
            kept.append({name: chunk[name][inside] for name in chunk if name in names or name == "points"})
        report(told, count, opened.count)
    return joined(kept) if kept else None
