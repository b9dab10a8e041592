"""NPZ: numpy's arrays of points, and of what is known of each."""

import lzma
import zipfile
import zlib
from contextlib import contextmanager

import numpy as np

from surflux._base.files import file_error
from surflux._core import FileError
from surflux.scans.columns import CHUNK, PointFile, add_attribute, triples
from surflux.scans.viewpoints import NAME, places_of

_NAMES = {
    "points": ("points", "xyz", "positions", "position", "pos", "coords", "coordinates", "vertices"),
    "normals": ("normals", "normal"),
    "colors": ("colors", "colours", "color", "rgb"),
}
# What numpy's reader of headers and zipfile raise of any bytes, NotImplementedError a RuntimeError.
_PYTHON_FAULTS = (ValueError, EOFError, RuntimeError, KeyError, SyntaxError, TypeError, OverflowError)


class _Member:
    """An array of the archive, read row by row: as many bytes as its type and shape say, and no more."""

    def __init__(self, archive, name):
        self.name = name.removesuffix(".npy")
        self._at = 0
        size = archive.getinfo(name).file_size
        self._file = archive.open(name)
        version = np.lib.format.read_magic(self._file)
        header = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}.get(version)
        if header is None:
            raise ValueError(f"version {version} of arrays")
        self.shape, self._fortran, self.dtype = header(self._file)
        if self.dtype.hasobject or self.dtype.kind not in "biuf":
            self.shape = ()  # nothing of points
            return
        values = 1
        for length in self.shape:
            values *= length
        if values * self.dtype.itemsize > size:
            raise ValueError("the array is larger than the file")

    def rows(self, count):
        """The next rows."""
        if self._fortran and len(self.shape) > 1:  # columns stand one behind the other
            if not self._at:
                self._all = self._taken(self.shape[::-1]).T
            self._at += count
            return self._all[self._at - count : self._at]
        return self._taken((count, *self.shape[1:]))

    def _taken(self, shape):
        wanted = int(np.prod(shape)) * self.dtype.itemsize
        data = self._file.read(wanted)
        if len(data) < wanted:
            raise ValueError("the array ends too soon")
        return np.frombuffer(data, self.dtype).reshape(shape)


def open_npz(path):
    """A PointFile.

    `points` (n, 3), or `xyz`, `positions`, or `x`, `y` and `z`, with `normals` and `colors` (rgb), (n, 3) or more;
    all other numbers of n rows are attributes by their names, but for `viewpoints` (k, 3).
    """
    with _damage_said(path):
        archive = zipfile.ZipFile(path)
    try:
        with _damage_said(path):
            members = {}
            for name in archive.namelist():
                if name.endswith(".npy"):
                    member = _Member(archive, name)
                    if member.shape:
                        members[member.name] = member
            count, chunks, places = _opened(path, members)
    except BaseException:
        archive.close()
        raise
    return PointFile(count, _closing(archive, chunks), lambda: places)


def _closing(archive, chunks):
    """The chunks; behind the last one, or where reading stops, the archive is closed."""
    with archive:
        yield from chunks


def _opened(path, members):
    lower = {name.lower(): name for name in members}
    parts = {}
    for what, names in _NAMES.items():
        there = [lower[name] for name in names if name in lower]
        fits = (name for name in there if len(members[name].shape) == 2 and members[name].shape[1] >= 3)
        name = next(fits, None)
        if name is not None:
            parts[what] = (name,)
    for what, names in triples(members).items():
        parts.setdefault(what, names)
    if "points" not in parts:
        shown = ", ".join(list(members)[:12]) or "none"
        raise file_error(path, f"no points: wanted an array points (n, 3), or x, y and z; got {shown}")
    count = members[parts["points"][0]].shape[0]
    used = {name for names in parts.values() for name in names}
    for what, names in parts.items():
        if any(members[name].shape[0] != count for name in names):
            raise file_error(path, f"{what}: wanted {count} rows, as many as there are points")
        if len(names) == 3 and any(len(members[name].shape) != 1 for name in names):
            raise file_error(path, f"{what}: wanted {', '.join(names)} of one dimension")
    places = []
    if _are_places(members, count):
        places = places_of(members[NAME].rows(members[NAME].shape[0]))
        used.add(NAME)
    others = [name for name in members if name not in used and members[name].shape[0] == count]
    return count, _chunks(path, members, parts, others, count), places


def _are_places(members, count):
    """Whether there is an array of where scans were taken from; one row for each point is an attribute."""
    shape = members[NAME].shape if NAME in members else ()
    return len(shape) == 2 and shape[1] == 3 and (shape[0] != count or count == 1 or "scan" in members)


def _chunks(path, members, parts, others, count):
    for begin in range(0, count, CHUNK):
        rows = min(CHUNK, count - begin)
        with _damage_said(path):
            chunk = {}
            for what, names in parts.items():
                values = [members[name].rows(rows) for name in names]
                chunk[what] = values[0][:, :3] if len(names) == 1 else np.stack(values, axis=-1)
            chunk["points"] = np.asarray(chunk["points"], dtype=np.float64)
            for name in others:
                add_attribute(chunk, name, members[name].rows(rows))
        yield chunk


@contextmanager
def _damage_said(path):
    """What zipfile, its decompressors and numpy find wrong is a FileError."""
    try:
        yield
    except FileError:
        raise
    except (OSError, zipfile.BadZipFile, zlib.error, lzma.LZMAError, *_PYTHON_FAULTS) as fault:
        said = " ".join(str(fault).split())[:200] or type(fault).__name__
        raise file_error(path, f"is damaged, or no NPZ file ({said})") from fault
