"""The camera of a scene file: written without touching anything else in the file."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import numpy as np

from surflux._base import check
from surflux._base.files import write_whole
from surflux._base.types import FilePath
from surflux._core import FileError
from surflux.pictures.camera import Camera

_HEADER = re.compile(r"^\s*\[\s*(.*?)\s*\]\s*(#.*)?$")
_DEFAULTS = {"up": [0.0, 0.0, 1.0], "fov": 45.0}


def save_camera(path: FilePath, camera: Camera) -> Path:
    """Writes a Camera into the [camera] table of a scene file; a file without one gets it at its end.

    Everything else in the file stays as it is, letter by letter: comments, order, the ends of lines. The file is
    replaced whole or not at all.

    Args:
        path: of a TOML file that is there.
        camera: Camera.

    Returns:
        The Path written.

    Raises:
        ValueError: camera is none.
        FileError: a file that cannot be read or written, is no TOML, or says its camera in a form that this does not
            rewrite (`camera = {...}` or `camera.eye = ...`); it stays as it was.

    >>> from pathlib import Path
    >>> import surflux as sf
    >>> _ = Path("ball.toml").write_text('[[object]] # one\\nshape = "sphere"')
    >>> path = sf.save_camera("ball.toml", sf.Camera([0, -4, 1], [0, 0, 0]))
    >>> sf.load_scene(path).camera
    Camera(eye=[0.0, -4.0, 1.0], target=[0.0, 0.0, 0.0], up=[0.0, 0.0, 1.0], fov=45)
    """
    path = Path(check.path("path", path))
    if not isinstance(camera, Camera):
        raise ValueError(f"camera: wanted a Camera, got {type(camera).__name__}")
    try:
        text = path.read_bytes().decode("utf-8")
        before = tomllib.loads(text)
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise FileError(f"{path}: is no TOML ({error})") from error
    wanted = _plain(camera)
    after = _rewritten(text, wanted)
    # What is read from it must be what it was, with this camera.
    kept = (
        {key: value for key, value in before.get("camera", {}).items() if key not in wanted and key != "height"}
        if isinstance(before.get("camera", {}), dict)
        else {}
    )
    expected = before | {"camera": kept | wanted}
    try:
        found = tomllib.loads(after)
        found["camera"] = _DEFAULTS | found["camera"]
        right = found == expected
    except (tomllib.TOMLDecodeError, KeyError, TypeError):
        right = False
    if not right:
        raise FileError(f"{path} (camera): is not a table headed [camera], and cannot be rewritten; it stays as it was")
    write_whole(path, after.encode("utf-8"))
    return path


def _plain(camera):
    """A Camera's numbers, to 7 digits: one placed by hand means no more. Places to 7 of how far it looks, wherever
    they are.
    """
    places = max(0, 6 - math.floor(math.log10(np.linalg.norm(camera.target - camera.eye))))

    def digits(value):
        return float(f"{value:.7g}") + 0.0

    return {
        "eye": [round(float(v), places) + 0.0 for v in camera.eye],
        "target": [round(float(v), places) + 0.0 for v in camera.target],
        "up": [digits(v) for v in camera.up],
        "fov": digits(camera.fov),
        **({} if camera.height is None else {"height": digits(camera.height)}),
    }


def _rewritten(text, wanted):
    lines = re.findall(r"[^\n]*\n|[^\n]+", text)  # TOML knows no other ends of lines
    end = "\r\n" if "\r\n" in text else "\n"
    table = _table_of(lines)
    if table is None:
        if lines and not lines[-1].endswith("\n"):
            lines[-1] += end
        new = [key for key in wanted if wanted[key] != _DEFAULTS.get(key)]
        blank = [end] if lines else []
        return "".join([*lines, *blank, f"[camera]{end}", *(f"{key} = {_text(wanted[key])}{end}" for key in new)])
    first, last = table
    body, out, written, k = lines[first:last], [], set(), 0
    while k < len(body):
        key, until = _assignment(body, k)
        if key in wanted:
            tail = re.search(r"\s*(#.*)?$", body[until - 1].rstrip("\r\n"))[0]
            ending = body[until - 1][len(body[until - 1].rstrip("\r\n")) :]
            head = body[k][: len(body[k]) - len(body[k].lstrip())]
            out.append(f"{head}{key} = {_text(wanted[key])}{tail}{ending}")
            written.add(key)
        elif key != "height":  # of a camera that was orthographic, and is not any more
            out += body[k:until]
        k = until
    missing = [key for key in wanted if key not in written and wanted[key] != _DEFAULTS.get(key)]
    # Behind the last line that says something: a blank line and the comments of the next table stay with that.
    place = max((k + 1 for k, line in enumerate(out) if line.strip() and not line.lstrip().startswith("#")), default=0)
    if place and not out[place - 1].endswith("\n"):
        out[place - 1] += end
    head = lines[:first]
    if head and not head[-1].endswith("\n"):
        head[-1] += end
    out[place:place] = [f"{key} = {_text(wanted[key])}{end}" for key in missing]
    return "".join(head + out + lines[last:])


def _table_of(lines):
    """(first, last) line of what stands below the header [camera]; None where there is none."""
    first = None
    for k, line in enumerate(lines):
        header = _HEADER.match(line.rstrip("\r\n"))
        if header is None or not _is_outside(lines[:k]):
            continue
        if first is not None:
            return first, k
        if header[1].strip("\"'") == "camera":
            first = k + 1
    return None if first is None else (first, len(lines))


def _is_outside(lines):
    """Whether what follows these lines begins a statement: not inside a list or a long text."""
    try:
        tomllib.loads("".join(lines))
    except tomllib.TOMLDecodeError:
        return False
    return True


def _assignment(body, k):
    """(key, line behind it) of what begins at line k: a statement, or a line that is none, of key None."""
    match = re.match(r"""^\s*(["']?)([A-Za-z0-9_-]+)\1\s*=""", body[k])
    if match is None:
        return None, k + 1
    for until in range(k + 1, len(body) + 1):
        if _is_outside(body[k:until]):
            return match[2], until
    return None, k + 1


def _text(value):
    if isinstance(value, list):
        return f"[{', '.join(_text(v) for v in value)}]"
    return repr(float(value)) if value != int(value) or abs(value) > 1e15 else f"{value:.1f}"
