"""Files that appear whole or not at all."""

import os
from pathlib import Path

from surflux._core import FileError


def write_whole(path, data):
    """Writes bytes beside `path` and renames: a file that is there is replaced whole or not at all, and keeps its mode.

    Raises FileError.
    """
    real = Path(os.path.realpath(path))
    if not real.parent.is_dir():
        raise FileError(f"{path}: cannot be written: there is no folder {real.parent}")
    beside = real.with_name(f".{real.name}.{os.getpid()}")
    try:
        with open(beside, "xb") as file:
            file.write(data)
        if real.exists():
            os.chmod(beside, real.stat().st_mode & 0o7777)
        os.replace(beside, real)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise FileError(f"{path}: cannot be written: {error.strerror}") from error
