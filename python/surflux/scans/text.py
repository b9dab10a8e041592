"""XYZ, PTS and CSV: a point on a line of text."""

import codecs
import itertools

import numpy as np

from surflux._base.files import file_error
from surflux._base.warn import warn
from surflux.scans.columns import PointFile, require_xyz, sorted_out, triples
from surflux.scans.tables import as_text, delimiter_of, is_number, split, text_lines, text_rows

_LOOKED_AT = 1000  # lines, to see what columns without names are
_XYZ, _RGB, _NORMAL = ("x", "y", "z"), ("red", "green", "blue"), ("nx", "ny", "nz")
_SURVEYED = {"easting": "x", "east": "x", "northing": "y", "north": "y"}
_SURVEYED |= dict.fromkeys(("elevation", "height", "altitude"), "z")


def open_text(path, form):
    """A PointFile of lines of numbers between blanks, commas or semicolons; blank lines and comments are left out.

    The first line, or a comment at the beginning, may name the columns: x, y and z, or easting, northing and height
    (elevation, altitude), or Points:0, Points:1 and Points:2, and others as `read` has them. Between semicolons numbers
    may have decimal commas. Where nothing names columns, 3 columns are x y z, a fourth is intensity, 6 are x y z and a
    colour or a normal, 7 have intensity before the colour, or behind it, and 9 have colour and normal: normals are told
    by their length of 1, colours by whole numbers up to 255 (65535), or fractions. Further columns are `column_4` and
    so on. PTS has the number of points in front of them.

    Args:
        form: "xyz", "pts" or "csv", or one that says more: "xyzn" has normals, "xyzrgb" colours.
    """
    names, first = _named_columns(path)
    lines = (line for line in text_lines(path) if line[0] > first)
    ahead = list(itertools.islice(lines, _LOOKED_AT))
    if not ahead:
        raise file_error(path, "no points: no line has numbers")
    delimiter = delimiter_of(ahead[0][1])
    counts = None
    if form == "pts" or (len(split(ahead[0][1], delimiter)) == 1 and len(ahead) > 1):
        counts = _Counts(path)
        look = [line for line in ahead if len(split(line[1], delimiter)) > 1]
        delimiter = delimiter_of(look[0][1]) if look else delimiter
    else:
        look = ahead
    if not look:
        raise file_error(path, "no points: no line has more than one number", f"line {ahead[0][0]}")
    for word in split(look[0][1], delimiter):
        if not is_number(word):
            reason = f"{word[:40]!r} is no number"
            if names is None:
                reason += ", and the line does not name the columns x, y and z (easting, northing, height) either"
            raise file_error(path, reason, f"line {look[0][0]}")
    width = len(split(look[0][1], delimiter))
    if names is None or len(names) != width:
        names = _guessed(path, form, look, width, delimiter)
    require_xyz(path, names, None if first == 0 else f"line {first}")
    lines = itertools.chain(ahead, lines)
    if counts is not None:
        lines = counts.without(lines)
    rows = text_rows(path, width, delimiter=delimiter, lines=lines)
    return PointFile(None, (sorted_out(dict(zip(names, table.T, strict=True))) for table in rows))


class _Counts:
    """The lines of a PTS file that hold the number of points behind them, one at least."""

    def __init__(self, path):
        self._path = path

    def without(self, lines):
        """The other lines; raises FileError where there are fewer than promised."""
        promised = place = None
        taken = 0
        for number, text in lines:
            if len(text) < 20 and text.isdecimal():
                self._check(promised, taken, place)
                promised, taken, place = int(text), 0, number
                continue
            taken += 1
            yield number, text
        self._check(promised, taken, place)

    def _check(self, promised, taken, place):
        if promised is not None and taken != promised:
            less = "truncated: " if taken < promised else ""
            reason = f"{less}{promised} points are promised, and {taken} are there"
            raise file_error(self._path, reason, f"line {place}")


def _named_columns(path):
    """(names of the columns, or None; the number of the line that names them, or 0)."""
    with open(path, "rb") as file:
        for number in range(1, 30):
            raw = file.readline(1 << 16)
            if not raw:
                break
            text = as_text(raw.removeprefix(codecs.BOM_UTF8)).strip()
            comment = text.startswith(("#", "//"))
            bare = text.lstrip("#/ \t")
            words = split(bare, delimiter_of(bare))
            names = _surveyed(words)
            if "points" in triples(names) and len(set(names)) == len(names):
                return tuple(names), number
            if text and not comment:
                break
    return None, 0


def _surveyed(words):
    """Names of columns with x, y and z for the first words that mean these, if there are neither x nor y."""
    names, taken = list(words), {word.lower() for word in words}
    if {"x", "y"} & taken:
        return names
    for k, word in enumerate(words):
        name = _SURVEYED.get(word.lower())
        if name is not None and name not in taken:
            names[k] = name
            taken.add(name)
    return names


def _guessed(path, form, lines, width, delimiter):
    """Names of columns by how many there are and what their numbers look like."""
    if width < 3:
        raise file_error(path, f"has {width} values; wanted x, y and z", f"line {lines[0][0]}")
    sample = next(text_rows(path, width, delimiter=delimiter, lines=lines))
    more = sample[:, 3:].T
    rest = tuple(f"column_{k}" for k in range(4, width + 1))
    if width == 4:
        rest = ("intensity",)
    elif width == 6:
        normal = form == "xyzn" or (form != "xyzrgb" and _are_normals(more))
        rest = _NORMAL if normal else _RGB
    elif width == 7:
        rest = (*_RGB, "intensity") if form != "pts" and _are_bytes(more[:3]) else ("intensity", *_RGB)
        if form != "pts" and _are_bytes(more):
            _warn(path, f"{' '.join(rest)} for columns 4 to 7, which may be intensity red green blue as well")
    elif width == 9:
        rest = (*_NORMAL, *_RGB) if _are_normals(more[:3]) else (*_RGB, *_NORMAL)
    elif width > 3:
        _warn(path, f"x y z for the first of {width}, and nothing for the others, which are column_4 and so on")
    return (*_XYZ, *rest)


def _warn(path, taken):
    warn(
        f"{path}: no line names its columns: taken are {taken}; a first line like '# x y z intensity r g b' names them"
    )


def _are_normals(columns):
    lengths = np.linalg.norm(columns, axis=0)
    lengths = lengths[np.isfinite(lengths) & (lengths > 0.0)]
    return len(lengths) > 0 and bool(np.mean(np.abs(lengths - 1.0) < 0.01) > 0.9)


def _are_bytes(columns):
    return bool(np.all((columns >= 0) & (columns <= 255) & (columns == np.floor(columns))))
