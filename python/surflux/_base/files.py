"""Files that appear whole or not at all."""

import os
import re
import secrets
from contextlib import contextmanager
from pathlib import Path

from surflux._core import FileError


def file_error(path, reason, place=None):
    """The FileError of a whole file, or of a place in it; bytes of its name that are no text are shown as the core
    shows them.
    """
    name = os.fsencode(path).decode("utf-8", "backslashreplace")
    return FileError(f"{name}: {reason}" if place is None else f"{name} ({place}): {reason}")


def require_file(path):
    """Refuses a path where no file is, before its suffix is looked at."""
    if os.path.isdir(path):
        raise file_error(path, "is a folder, not a file")
    if not os.path.exists(path):
        raise file_error(path, "no such file")


def bytes_of(path):
    """All bytes of a file; FileError where it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault


def require_place(path, place=None):
    """Refuses a path where no file can be written, so that nobody works for hours before it is told.

    place: Path that it leads to; None for the path itself.
    """
    place = Path(path) if place is None else place
    folder = place.parent
    if not os.path.isdir(folder):
        raise file_error(path, f"cannot be written: there is no folder {folder}")
    if os.path.isdir(place):
        raise file_error(path, "is a folder, not a file")
    device = os.path.exists(place) and not os.path.isfile(place)  # such as /dev/stdout, whose folder takes no files
    if not os.access(place if device else folder, os.W_OK):
        raise file_error(path, f"cannot be written: no permission to write {'there' if device else f'in {folder}'}")


_UNFINISHED_NAME = re.compile(r"\..*-\d+\.part(\..*)?")  # names that unfinished_name gives
UNFINISHED = set()
"""Paths of files that this process has not written to their end."""


@contextmanager
def unfinished(path):
    """A Path beside `path` to write to, renamed when the block ends: a file that is there is replaced whole or not at
    all, and keeps its mode. What the block leaves behind when it fails is removed.

    Raises FileError.
    """
    real = Path(os.path.realpath(path))
    require_place(path, real)
    beside = real.with_name(unfinished_name(real))
    UNFINISHED.add(beside)
    try:
        yield beside
        if real.exists():
            os.chmod(beside, real.stat().st_mode & 0o7777)
        os.replace(beside, real)
    except OSError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        beside.unlink(missing_ok=True)
        UNFINISHED.discard(beside)


@contextmanager
def whole_file(path):
    """A binary file beside `path`, as of `unfinished`. Raises FileError."""
    with unfinished(path) as beside, open(beside, "xb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())  # some file systems say only here that there is no room


def write_whole(path, data):
    """Writes bytes as a whole_file."""
    with whole_file(path) as file:
        file.write(data)


def unfinished_name(path):
    """The name of a file beside `path` until it is whole, another for each call: threads, and nodes of a cluster, whose
    processes may have one number, write names beside each other that begin alike. The same suffix, and no longer than
    names may be.
    """
    return f".{path.stem[:40]}-{secrets.token_hex(4)}-{os.getpid()}.part{path.suffix[:40]}"


def is_unfinished_name(name):
    """Whether a file is one that its process was killed over before it was whole."""
    return _UNFINISHED_NAME.fullmatch(name) is not None
