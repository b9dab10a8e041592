"""Rows of numbers, in bytes or in text, a chunk at a time."""

import codecs
import itertools
import os
import sys

import numpy as np

from surflux._base.files import file_error
from surflux.scans.columns import CHUNK

_LINES = 100_000  # of text taken at once


def byte_rows(path, row, count, begin):
    """Chunks of a table of `count` rows of the structured type `row` that begins at a byte.

    Raises FileError where the file is too short for it.
    """
    left = os.path.getsize(path) - begin
    if row.itemsize * count > left:
        reason = (
            f"truncated: the header promises {count} points of {row.itemsize} bytes, and {max(left, 0)} bytes are left"
        )
        raise file_error(path, reason, f"byte {begin}")
    step = max(1, min(CHUNK, (1 << 28) // max(1, row.itemsize)))
    with open(path, "rb") as file:
        file.seek(begin)
        for first in range(0, count, step):
            rows = np.fromfile(file, row, min(step, count - first))
            if len(rows) < min(step, count - first):
                raise file_error(path, "ends while it is read", f"byte {file.tell()}")
            yield rows


def as_text(raw):
    """Bytes of a header or a line as text: UTF-8, as we write it, else Latin-1, which takes any."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def text_lines(path, begin=0, line=0):
    """(number from 1, text) of the lines from a byte on that are neither blank nor comments (# and //)."""
    with open(path, "rb") as file:
        file.seek(begin)
        for raw in file:
            line += 1
            text = as_text(raw.removeprefix(codecs.BOM_UTF8)).strip()
            if text and not text.startswith(("#", "//")):
                yield line, text


def text_rows(path, width, begin=0, line=0, delimiter=None, most=None, lines=None):
    """Chunks (k, width) float64 of lines of numbers between blanks, commas or semicolons, whichever the first has.

    Args:
        width: numbers in a line.
        begin, line: the byte at which they begin, and the lines before it.
        delimiter: what stands between two numbers; None to see.
        most: lines to be read; None for all.
        lines: (number, text) instead of those of the file.
    """
    lines = text_lines(path, begin, line) if lines is None else lines
    numbers, texts = [], []
    for number, text in itertools.islice(lines, None if most is None else min(most, sys.maxsize)):
        if delimiter is None:
            delimiter = delimiter_of(text)
        numbers.append(number)
        texts.append(text)
        if len(texts) == _LINES:
            yield _parsed(path, numbers, texts, width, delimiter)
            numbers, texts = [], []
    if texts:
        yield _parsed(path, numbers, texts, width, delimiter)


def delimiter_of(text):
    """What stands between the words of a line: a semicolon, a comma, or blanks and tabs ("")."""
    return next((mark for mark in ";," if mark in text), "")


def _parsed(path, numbers, texts, width, delimiter):
    if delimiter == ";":
        texts = [_with_points(text) for text in texts]
    try:
        table = np.loadtxt(texts, delimiter=delimiter or None, comments=None, ndmin=2)
        if table.shape[1] == width:
            return table
    except ValueError:
        pass
    for number, text in zip(numbers, texts, strict=True):  # which of them it is
        words = split(text, delimiter)
        if len(words) != width:
            raise file_error(path, f"has {len(words)} values; wanted {width}", f"line {number}")
        for word in words:
            if not is_number(word):
                raise file_error(path, f"{word[:40]!r} is no number", f"line {number}")
    return np.array([[float(word) for word in split(text, delimiter)] for text in texts])


def _with_points(text):
    """A line between semicolons, whose commas are those of decimals, unless there are points, too."""
    return text if "." in text else text.replace(",", ".")


def split(text, delimiter):
    """The words of a line."""
    text = _with_points(text) if delimiter == ";" else text
    return [word.strip().strip('"') for word in text.split(delimiter)] if delimiter else text.split()


def is_number(word):
    """Whether a word is a number, inf and nan included."""
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word
