"""What processes have exchanged, kept on disk, so that a call can go on from there."""

import hashlib
import json
import os
import struct
from pathlib import Path

from surflux._base import check
from surflux._base.files import file_error, is_unfinished_name, whole_file, write_whole
from surflux.cluster.agreement import difference, machine_facts

_ABOUT = "checkpoint.json"
_MAGIC = b"surflux exchange 1\n"
_HEAD = struct.Struct("<32sQ")  # the digest of all behind it, and its length
_START = len(_MAGIC) + _HEAD.size
_FORMAT = 2


class Checkpoint:
    """A folder with one file for each exchange, in order, each of which appears whole.

    Args:
        folder: its path; made where there is none.
        facts: of the call, which must be those of the folder.

    Raises:
        FileError: the folder cannot be made, is damaged, or belongs to another call.
    """

    def __init__(self, folder, facts):
        self._folder = Path(folder)
        facts = {**machine_facts(), **facts}
        about = self._folder / _ABOUT
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise file_error(folder, f"cannot be made: {fault.strerror or fault}") from fault
        names = self._names()
        if _ABOUT in names:
            self._require_same(about, facts)
        elif not all(map(is_unfinished_name, names)):
            raise file_error(folder, f"is no checkpoint: it holds other files, and no {_ABOUT}")
        else:
            write_whole(about, json.dumps({"format": _FORMAT, "facts": facts}, indent=1).encode())
        for name in filter(is_unfinished_name, names):  # of a process that was killed
            (self._folder / name).unlink(missing_ok=True)
        self.count = 0  # of exchanges that are there, from the first on
        while self._file(self.count).name in names:
            self.count += 1

    def _names(self):
        try:
            return {entry.name for entry in self._folder.iterdir()}
        except OSError as fault:
            raise file_error(self._folder, fault.strerror or str(fault)) from fault

    def _require_same(self, about, facts):
        try:
            kept = json.loads(about.read_bytes())
            version, theirs = kept["format"], dict(kept["facts"])
        except OSError as fault:
            raise file_error(about, fault.strerror or str(fault)) from fault
        except (ValueError, KeyError, TypeError) as fault:
            raise file_error(about, "is damaged: wanted the facts of a call, as JSON") from fault
        if version != _FORMAT:
            raise file_error(about, f"is of another format, {version!r}; wanted {_FORMAT}")
        if found := difference(facts, theirs):
            name, ours, other = found
            raise file_error(about, f"is of another call: its {name} is {other}, wanted {ours}; take another folder")

    def read(self, k, name):
        """The parts of exchange k, which is of that name.

        Raises:
            FileError: it is damaged, or another exchange.
        """
        found, parts = self.entry(k)
        if found != name:
            raise file_error(
                self._file(k), f"is exchange {k}, {found!r}, where {name!r} was wanted", f"byte {_START + 8}"
            )
        return parts

    def entry(self, k):
        """(name, parts) of exchange k. Raises FileError where it is damaged."""
        path = self._file(k)
        try:
            data = memoryview(path.read_bytes())
        except OSError as fault:
            raise file_error(path, fault.strerror or str(fault)) from fault
        if data[: len(_MAGIC)] != _MAGIC:
            raise file_error(path, "is no exchange of a checkpoint", "byte 0")
        if len(data) < _START:
            raise file_error(path, "is cut off", f"byte {len(data)}")
        digest, length = _HEAD.unpack(data[len(_MAGIC) : _START])
        if len(data) != _START + length:
            raise file_error(path, f"is cut off, or goes on: wanted {_START + length} bytes", f"byte {len(data)}")
        if hashlib.blake2b(data[_START:], digest_size=32).digest() != digest:
            raise file_error(path, "is damaged: its checksum is another", f"from byte {_START}")
        (head_length,) = struct.unpack_from("<Q", data, _START)
        at = _START + 8 + head_length
        head = json.loads(bytes(data[_START + 8 : at]))
        if head["index"] != k:
            text = f"is exchange {head['index']}, {head['name']!r}, where exchange {k} was wanted"
            raise file_error(path, text, f"byte {_START + 8}")
        parts = []
        for size in head["sizes"]:
            parts.append(bytes(data[at : at + size]))
            at += size
        return head["name"], parts

    def write(self, k, name, parts):
        """Keeps the parts of exchange k.

        Raises:
            FileError: there is no room, or no permission.
        """
        head = json.dumps({"name": name, "index": k, "sizes": [len(part) for part in parts]}).encode()
        pieces = [struct.pack("<Q", len(head)), head, *parts]
        digest = hashlib.blake2b(digest_size=32)
        for piece in pieces:
            digest.update(piece)
        with whole_file(self._file(k)) as file:
            file.write(_MAGIC + _HEAD.pack(digest.digest(), sum(map(len, pieces))))
            for piece in pieces:
                file.write(piece)
        self.count = k + 1

    def _file(self, k):
        return self._folder / f"{k:05d}.exchange"


def checkpoint_folder(value):
    """The folder that checkpoint= names, or None."""
    if value is None:
        return None
    folder = check.path("checkpoint", value)
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise file_error(folder, "is a file, not a folder")
    return folder
