"""What this installation is made of."""

import os
import platform
from pathlib import Path
from typing import Any

import numpy as np

from surflux import _core

VERSION = _core.version()

# A wheel with libraries inside has their licences here, by name and version.
LICENCES = Path(__file__).parents[1] / "licences"


class Info(dict[str, Any]):
    """A dict that prints as a table."""

    def __str__(self) -> str:
        width = max(len(key) for key in self)
        return "\n".join(f"{key:<{width}}  {value}" for key, value in self.items())

    __repr__ = __str__


def info() -> Info:
    """Versions, GL device and driver, instruction set and threads, as a dict that prints as a table.

    Keys: "surflux", "python", "numpy", one per library of the core, "OpenImageIO", "inside" (of a wheel alone: what it
    brings along, by versions), "GL" (the device and driver, or the reason why there is none), "instruction set",
    "threads".

    >>> import surflux as sf
    >>> sf.info()["surflux"] == sf.__version__
    True
    """
    from surflux import _image  # loads OpenImageIO

    found = Info({"surflux": VERSION, "python": platform.python_version(), "numpy": np.__version__})
    found.update(_core.versions())
    found["OpenImageIO"] = _image.version()
    if inside := sorted((file.stem for file in LICENCES.glob("*.txt")), key=str.lower):
        found["inside"] = ", ".join(" ".join(name.rsplit("-", 1)) for name in inside)
    found["GL"] = _gl()
    found["instruction set"] = _core.instruction_set()
    found["threads"] = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return found


def _gl():
    try:
        gl = _core.gl_info()
    except _core.DeviceError as error:
        return f"none ({error})"
    if isinstance(gl, dict):
        return ", ".join(f"{key} {value}" for key, value in gl.items())
    return str(gl)
