"""The camera of a file that holds a solution: written without touching anything else in it."""

import os
import shutil

from surflux._base.files import file_error, whole_file
from surflux.points.writing import COMMENT_KEY, pack_comments, unpack_comments
from surflux.scans.ply import header_of
from surflux.solutions.solution_file import NO_SOLUTION


def write_camera(path, camera):
    """Puts a Camera into the comments of a PLY file with a solution: all other comments, columns and rows, those of
    points without light among them, stay byte by byte. The file is replaced whole or not at all.

    Raises FileError: a file that cannot be read or written, or holds no solution.
    """
    try:
        header = header_of(path)
        if header is None:
            raise file_error(path, NO_SOLUTION)
        lines, newline, begin = header
        rows = [k for k, line in enumerate(lines) if _of_ours(line)]
        texts = [lines[k].split(None, 1)[1].decode("utf-8", "replace") for k in rows]
        about = unpack_comments(texts, path)
        if about.get("solution") != 1:
            raise file_error(path, NO_SOLUTION)
        end = b"\r" if newline == b"\n" and lines[0].endswith(b"\r") else b""
        ours = [b"comment " + line.encode() + end for line in pack_comments(about | {"camera": camera.to_dict()})]
        kept = [line for k, line in enumerate(lines) if k not in rows]
        kept[rows[0] : rows[0]] = ours  # nothing of ours stands before the first of them
        with open(path, "rb") as file, whole_file(path) as out:
            file.seek(begin)
            out.write(newline.join([*kept, b"end_header" + end]) + newline)
            shutil.copyfileobj(file, out, 1 << 22)
    except OSError as error:
        if error.errno is None:  # a FileError, which says it
            raise
        raise file_error(path, f"cannot be read: {os.strerror(error.errno)}") from error


def _of_ours(line):
    return line.split(None, 2)[:2] == [b"comment", COMMENT_KEY.strip().encode()]
