"""OFF files of Geomview: polygons, with colours of vertices and of faces."""

import re
from itertools import chain

import numpy as np

from surflux._base.check import counted
from surflux._base.color import white_of_colors
from surflux._base.files import bytes_of, file_error
from surflux._base.warn import warn
from surflux.meshes.file_colors import reflectance_in_file
from surflux.meshes.foreign_meshes import Mesh

_HEADER = re.compile(rb"((?:ST|C|N|4|n)*)OFF")
_MARK = b"\xef\xbb\xbf"  # of byte order
_COLORS = (3, 4)  # numbers, the fourth of which is alpha
_DIGITS = 18  # at most, that 64 bits hold


def read_off_mesh(path):
    """The Mesh of an OFF file of text: a vertex in each line, then a face, which may have a colour behind its corners.

    Colours of faces count before those of vertices (COFF). Rows of whole numbers are of 255 where one of them, alpha
    too, is above 1; others are fractions, unless they go up to 255.

    Raises:
        FileError: with the line.
    """
    rows = [line.split(b"#", 1)[0].split() for line in bytes_of(path).removeprefix(_MARK).splitlines()]
    lines = [number for number, words in enumerate(rows, 1) if words]
    rows = [words for words in rows if words]
    header, sizes = _header(path, rows)
    if not sizes:
        rows, lines = rows[1:], lines[1:]
        sizes = rows[0] if rows else []
    if len(sizes) < 2 or not all(word.isdigit() and len(word) <= _DIGITS for word in sizes[:2]):
        got = _text(sizes) if sizes else "nothing"
        place = f"line {lines[0]}" if lines else None
        raise file_error(path, f"wanted the numbers of its vertices and faces, got {got}", place)
    vertices, faces = int(sizes[0]), int(sizes[1])
    rows, lines = rows[1:], lines[1:]
    for names, first, many in ((("vertex", "vertices"), 0, vertices), (("face",), vertices, faces)):
        if len(rows) < first + many:
            there = max(0, len(rows) - first)
            raise file_error(path, f"is cut off: it has {there} of its {counted(many, *names)}")
    if len(rows) > vertices + faces:
        place = f"line {lines[vertices + faces]}"
        raise file_error(path, f"goes on after its {counted(faces, 'face')}: a number in its header is wrong", place)
    points, rho = _vertices(path, header, rows[:vertices], lines)
    offsets, indices = _faces(path, vertices, rows[vertices:], lines[vertices:])
    mesh = Mesh(points, offsets, indices, rho)
    return mesh._replace(of_faces=_colors_of_faces(path, mesh, rows[vertices:], lines[vertices:]))


def _header(path, rows):
    """(what stands before OFF, the words after it in that line)."""
    found = _HEADER.match(rows[0][0]) if rows else None
    if found is None:
        raise file_error(path, "is no OFF file, by what it begins with" if rows else "the file is empty")
    rest = [word for word in (rows[0][0][found.end() :], *rows[0][1:]) if word]
    if rest and rest[0].upper().startswith(b"BINARY"):
        raise file_error(path, "is a binary OFF file, which is not read; wanted one of text")
    header = found[1].decode()
    if "4" in header or "n" in header:
        raise file_error(path, f"has coordinates of other dimensions ({header}OFF); wanted 3")
    return header, rest


def _text(words):
    return repr(b" ".join(words).decode("utf-8", "replace"))


def _vertices(path, header, rows, lines):
    """(points (v, 3), linear reflectance (v, 3) or None)."""
    before, behind = 3 + 3 * header.count("N"), 2 * header.count("ST")
    wanted = before + behind + (_COLORS[0] if "C" in header else 0)
    if not rows:
        return np.zeros((0, 3)), None
    width = min(map(len, rows))
    if width < wanted:
        row = next(row for row, words in enumerate(rows) if len(words) == width)
        raise file_error(
            path, f"a vertex of {counted(width, 'number')}; wanted {wanted} ({header}OFF)", f"line {lines[row]}"
        )
    points = _numbers(path, [words[:3] for words in rows], lines, float).reshape(-1, 3)
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        raise file_error(path, f"a coordinate is not finite: {_text(rows[row][:3])}", f"line {lines[row]}")
    more = width - wanted - ("C" in header)  # for alpha
    if more > 0:
        warn(f"{path}: vertices have {counted(more, 'number')} more than {header}OFF has, which are left out")
    if "C" not in header:
        return points, None
    end = before + _COLORS[width > wanted]
    return points, _reflectance(path, [words[before:end] for words in rows], "vertex", lines)


def _faces(path, vertices, rows, lines):
    """(offsets (f + 1,), indices (k,)) of corners."""
    corners, there = _numbers(path, [words[:1] for words in rows], lines, int), _lengths(rows) - 1
    bad = (corners < 3) | (corners > there)
    if bad.any():
        row = int(np.argmax(bad))
        reason = f"a face of {counted(int(corners[row]), 'corner')}"
        reason += "; wanted 3 or more" if corners[row] < 3 else f" has {there[row]} of them"
        raise file_error(path, reason, f"line {lines[row]}")
    if (corners < there).any():
        rows = [words[: count + 1] for count, words in zip(corners.tolist(), rows, strict=True)]
    offsets = np.concatenate([[0], np.cumsum(corners)]).astype(np.int64)
    indices = np.delete(_numbers(path, rows, lines, int), offsets[:-1] + np.arange(len(corners)))
    bad = (indices < 0) | (indices >= vertices)
    if bad.any():
        at = int(np.argmax(bad))
        row = int(np.searchsorted(offsets, at, side="right")) - 1
        wanted = f"the file has {counted(vertices, 'vertex', 'vertices')}, numbered from 0"
        raise file_error(path, f"a face has the corner {indices[at]}; {wanted}", f"line {lines[row]}")
    return offsets, indices


def _colors_of_faces(path, mesh, rows, lines):
    """(f, 3) linear reflectance of faces, where one has a colour behind its corners; or None."""
    more = _lengths(rows) - np.diff(mesh.offsets) - 1
    if not more.any():
        return None
    behind = [words[len(words) - count :] for count, words in zip(more.tolist(), rows, strict=True)]
    has = np.isin(more, _COLORS)
    other = np.count_nonzero(more) - np.count_nonzero(has)
    if other:
        what = "numbers behind its corners that are no colour" if other == 1 else "numbers that are no colours"
        warn(f"{path}: {counted(other, 'face')} with {what} (3 or 4): they are left out")
    if not has.any():
        return None
    colored, lines = ([one for one, colored in zip(every, has, strict=True) if colored] for every in (behind, lines))
    found = _reflectance(path, colored, "face", lines)
    if found is None:
        return None
    out = np.array(mesh.face_reflectance())
    out[has] = found
    return out


def _reflectance(path, rows, element, lines):
    """(n, 3), linear, of rows of three numbers and maybe alpha; or None."""
    colors = _numbers(path, [words[:3] for words in rows], lines, float).reshape(-1, 3)
    whole = np.array([b"".join(words).isdigit() for words in rows])
    of_255 = any(float(word) > 1.0 for words, is_whole in zip(rows, whole, strict=True) if is_whole for word in words)
    if of_255 and not whole.all() and white_of_colors(colors[~whole], "float") == 1.0:
        colors[whole] /= 255.0
    return reflectance_in_file(path, colors, "uchar" if of_255 and whole.all() else "float", element)


def _lengths(rows):
    return np.fromiter(map(len, rows), np.int64, len(rows))


def _numbers(path, rows, lines, kind):
    """The words of all rows as one array of numbers."""
    try:
        return _array(kind, chain.from_iterable(rows))
    except (ValueError, OverflowError):
        line, word = next(
            (line, word) for line, words in zip(lines, rows, strict=False) for word in words if not _is(kind, word)
        )
        wanted = "number" if kind is float else "whole number"
        raise file_error(path, f"{_text([word])} is no {wanted}", f"line {line}") from None


def _is(kind, word):
    try:
        _array(kind, [word])
    except (ValueError, OverflowError):
        return False
    return True


def _array(kind, words):
    """Of float64 or int64; raises OverflowError where that has too few bits."""
    return np.fromiter(map(kind, words), {int: np.int64, float: np.float64}[kind])
