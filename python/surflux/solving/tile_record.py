"""Which outputs of tiles are finished, and by what options: a file beside them, so that a stopped run goes on."""

import hashlib
import json
import os
import pickle
from pathlib import Path

from surflux._base.files import file_error, write_whole
from surflux._base.installation import VERSION

NAME = "surflux-tiles.json"
_FIGURES = {"points": int, "left_out": int, "surfels": int, "around": int, "error": float, "seconds": float}


def key_of(paths, lights, settings):
    """What a run goes by, as text: the files as they are, lights and settings."""
    files = []
    for path in paths:
        found = os.stat(path)
        files.append((os.path.abspath(path), found.st_size, found.st_mtime_ns))
    lights = [hashlib.sha256(pickle.dumps(light, protocol=4)).hexdigest() for light in lights]
    text = json.dumps([VERSION, files, lights, settings], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


class Record:
    """The record of a folder of outputs."""

    def __init__(self, folder):
        self._path = Path(folder) / NAME
        self._folder, self._tiles, self._ours = Path(folder), {}, set()
        if self._path.exists():
            try:
                found = json.loads(self._path.read_text())
                self._tiles, self._ours = dict(found["tiles"]), set(map(str, found.get("outputs", ())))
            except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
                raise file_error(
                    self._path, f"is no record of solved tiles ({error}); wanted another folder"
                ) from error
        for name, entry in self._tiles.items():
            wrong = _wrong_in(entry)
            if wrong is not None:
                reason = f"is not as it was written: {wrong}; delete it with its outputs, or take another folder"
                raise file_error(self._path, reason, f"tiles: {name}")

    def finished(self, name, key):
        """The figures of an output that was finished by that key and is as it was written; None of any other."""
        entry = self._tiles.get(name)
        if entry is None or entry["key"] != key or entry["file"] != self._state(name):
            return None
        return entry["figures"]

    def require_ours(self, name):
        """Refuses a file that is there and that no run wrote."""
        if (self._folder / name).exists() and name not in self._tiles and name not in self._ours:
            raise file_error(
                self._folder / name, "is there already, and no tile that was solved; wanted another folder"
            )

    def claim(self, names):
        """Notes outputs that will be written: one that is there without its figures, as after a power cut, is ours."""
        self._ours |= set(names)
        self._write()

    def add(self, name, key, figures):
        """Notes an output that is written."""
        self._tiles[name] = {"key": key, "file": self._state(name), "figures": figures}
        self._write()

    def _write(self):
        text = json.dumps({"outputs": sorted(self._ours), "tiles": self._tiles}, indent=1)
        write_whole(self._path, (text + "\n").encode())

    def _state(self, name):
        try:
            found = os.stat(self._folder / name)
        except FileNotFoundError:
            return None
        return [found.st_size, found.st_mtime_ns]


def _wrong_in(entry):
    """What is wrong in an entry of a record, in words; None of one as `add` writes it."""
    if not isinstance(entry, dict):
        return f"wanted an object, got {entry!r}"
    wanted = {"key": str, "file": list, "figures": dict}
    for part, kinds in ((entry, wanted), (entry.get("figures"), _FIGURES)):
        for key, kind in kinds.items():
            if key not in part:
                return f"{key!r} is missing"
            value = part[key]
            if isinstance(value, bool) or not isinstance(value, (int, float) if kind is float else kind):
                return f"{key!r} is {value!r}"
        more = sorted(set(part) - set(kinds))
        if more:
            return f"{more[0]!r} does not belong there"
    return None
