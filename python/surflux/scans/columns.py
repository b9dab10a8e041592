"""What a file of points says, row by row: columns by their names, in chunks of rows."""

import re
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from surflux._base.files import file_error

CHUNK = 1_000_000  # rows read at once


def _numbered(*names):
    """Three components as ParaView names them in CSV: Normals:0 where data are saved, Normals_0 of its spreadsheets."""
    return tuple(tuple(f"{name}{mark}{k}" for k in range(3)) for name in names for mark in ":_")


# Three columns that belong together, by the names that programs give them, in lower case; rf, gf and bf are fractions,
# as CloudCompare writes them.
TRIPLES = {
    "points": (
        ("x", "y", "z"),
        ("cartesianx", "cartesiany", "cartesianz"),
        ("//x", "y", "z"),
        *_numbered("points"),
    ),
    "normals": (
        ("nx", "ny", "nz"),
        ("normal_x", "normal_y", "normal_z"),
        ("normalx", "normaly", "normalz"),
        *_numbered("normals"),
    ),
    "colors": (
        ("red", "green", "blue"),
        ("diffuse_red", "diffuse_green", "diffuse_blue"),
        ("r", "g", "b"),
        ("rf", "gf", "bf"),
        *_numbered("rgb", "rgba", "colors"),
    ),
}
_LIKE_COLORS = re.compile(r"colou?r|rgb|(?<![a-z])(red|green|blue|[rgb]f)(?![a-z]|_edge)")
# What else is known of a point, by the name that it has here.
OTHER_NAMES = {
    "i": "intensity",
    "scalar_intensity": "intensity",
    "class": "classification",
    "scalar_classification": "classification",
    "returnnumber": "return_number",
    "numberofreturns": "number_of_returns",
    "pointsourceid": "point_source_id",
    "gpstime": "gps_time",
    "scalar_gpstime": "gps_time",
    "scananglerank": "scan_angle",
    "scan_angle_rank": "scan_angle",
    "scanangle": "scan_angle",
}


class PointFile(NamedTuple):
    """An open file of points.

    A chunk is a dict of columns, all of one length: "points" (k, 3) float64, "normals" (k, 3) and "colors" (k, 3),
    where the file has them, and attributes (k,) or (k, m) by their names.
    """

    count: int | None  # the rows that the file promises; None where it does not say
    chunks: Iterator[dict[str, np.ndarray]]
    viewpoints: Callable[[], list] = list  # after the last chunk: where each scan was taken from, None where unknown
    faces: int = 0  # of which nothing is read
    frame: dict | None = None  # of a LAS file: what write_las takes over


def triples(names):
    """{"points", "normals", "colors": the three names of columns among `names` that they are made of}."""
    found = {}
    lower = {}
    for name in names:
        lower.setdefault(str(name).lower(), name)
    for what, choices in TRIPLES.items():
        choice = next((choice for choice in choices if all(name in lower for name in choice)), None)
        if choice is not None:
            found[what] = tuple(lower[name] for name in choice)
    return found


def like_colors(names):
    """Those of the names that look like colours."""
    return [name for name in map(str, names) if _LIKE_COLORS.search(name.lower())]


def attribute_name(name):
    """The name that an attribute has here: one for all formats where it is a usual one, else the file's own."""
    return OTHER_NAMES.get(str(name).lower(), str(name).lower() if str(name).lower() in _USUAL else str(name))


# Of LAS: what is all 0 says nothing.
FLAGS = ("synthetic", "key_point", "withheld", "overlap", "scanner_channel", "scan_direction_flag")
FLAGS += ("edge_of_flight_line", "user_data")
_USUAL = {*OTHER_NAMES.values(), *FLAGS, "label"}


def add_attribute(chunk, name, values):
    """Under the name that it has here, or its own where that is another column's: none takes another's place."""
    key = attribute_name(name)
    if key in chunk or key in TRIPLES:
        key = str(name)
    while key in chunk or key in TRIPLES:
        key += "_"
    chunk[key] = values


def sorted_out(columns):
    """Columns by the file's names as a chunk: x, y and z become points, and so on."""
    left = dict(columns)
    chunk = {}
    for what, names in triples(left).items():
        kind = np.float64 if what != "colors" else None
        chunk[what] = np.stack([left.pop(name) for name in names], axis=-1, dtype=kind)
    for name, values in left.items():
        add_attribute(chunk, name, values)
    return chunk


def require_xyz(path, names, place=None):
    """Refuses a file without coordinates."""
    if "points" not in triples(names):
        shown = ", ".join(map(str, list(names)[:12])) or "none"
        raise file_error(path, f"no points: wanted columns x, y and z, got {shown}", place)
