"""Writing surfels, and what was computed for them, to PLY."""

import json
import math
import os
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.color import WHITE, display_bytes, tone_mapped_bytes
from surflux._base.files import file_error

COLOR_NAMES = ("red", "green", "blue")
CORNER_NAMES = tuple(f"{axis}{corner}" for corner in range(3) for axis in "xyz")
COMMENT_KEY = "surflux "


def ply_path(path, name="path"):
    """path as a Path, if PLY can be written under that name."""
    path = Path(check.path(name, path))
    if path.suffix.lower() != ".ply":
        raise ValueError(f"{name}: wanted a name ending in .ply, got {str(path)!r}")
    return path


def save_surfels(
    path, surfels, *, radiosity=None, irradiance=None, direct=None, columns=None, comments=(), colors=None, pixels=None
):
    """Write surfels, and what was computed for them, as binary little-endian PLY.

    Positions, radii and areas come back bit by bit (double where float does not hold them), all else as float. The
    vertices are the surfels, so that any reader of PLY shows them. The patches of a mesh follow in an element of
    their own, `patch`, one row per triangle: its surfel and its corners x0 y0 z0 ... x2 y2 z2 as doubles.

    Args:
        path: str or path. Written beside and renamed: a file that was there is replaced whole or not at all.
        surfels: _core.Surfels, what to write.
        radiosity, irradiance, direct: (n, 3) linear RGB, or None. `red green blue`, for other programs, show the
            radiosity, exposed so that 99 % of what does not emit fits; without it, the reflectance.
        columns: dict of more properties, (n,) or (n, 3) each; (n, 3) become name_r, name_g and name_b.
        comments: lines of text for the header.
        colors: (n, 3) bytes for `red green blue` instead.
        pixels: (k, 3) of what is seen behind, an element `environment` of their own; None for none.

    Returns:
        The Path written.

    Raises:
        FileError: the file cannot be written.
        ValueError: an array has another shape, or is not finite.
    """
    n = len(surfels)
    vertex = _columns("xyz", surfels.positions, _exact_type)
    vertex += _columns(("nx", "ny", "nz"), surfels.normals, _float_type)
    vertex += _columns(("radius",), surfels.radii, _exact_type)
    if surfels.areas is not None:
        vertex += _columns(("area",), surfels.areas, _exact_type)
    reflectance = surfels.reflectance
    results = {"radiosity": radiosity, "irradiance": irradiance, "direct": direct}
    results = {name: _checked(name, values, n, 3) for name, values in results.items() if values is not None}
    if colors is not None:
        shown = _checked("colors", colors, n, 3)
    elif "radiosity" in results:
        shown = tone_mapped_bytes(results["radiosity"], surfels.emission)
    else:
        shown = display_bytes(reflectance / WHITE)
    vertex += _columns(COLOR_NAMES, shown, lambda _: "uchar")
    # Rounding to float must not make a perfect mirror of .99999999.
    below_one = np.minimum(reflectance, np.nextafter(np.float32(1.0), np.float32(0.0)))
    for name, values in {"reflectance": below_one, "emission": surfels.emission, **results}.items():
        vertex += _columns([f"{name}_{channel}" for channel in "rgb"], values, _float_type)
    if surfels.has_gloss:
        # Nor must it make both together reflect all.
        most = np.nextafter((1.0 - below_one.astype(np.float32).astype(float)).astype(np.float32), np.float32(0.0))
        specular = np.minimum(surfels.specular, most)
        vertex += _columns([f"specular_{channel}" for channel in "rgb"], specular, _float_type)
        vertex += _columns(("exponent",), surfels.exponent, _exact_type)
    for name, values in (columns or {}).items():
        values = np.asarray(values)
        wide = values.ndim == 2
        values = _checked(name, values, n, 3 if wide else None)
        vertex += _columns([f"{name}_{c}" for c in "rgb"] if wide else (name,), values, _type_of)
    elements = [("vertex", n, vertex)]
    triangles = surfels.triangles
    if len(triangles):
        patch = _columns(("surfel",), surfels.triangle_surfel, _type_of)
        patch += _columns(CORNER_NAMES, triangles.reshape(-1, 9), lambda _: "double")
        elements.append(("patch", len(triangles), patch))
    if pixels is not None:
        elements.append(("environment", len(pixels), _columns("rgb", pixels, _float_type)))
    path = Path(os.fsdecode(path))
    _core.write_ply(path, elements, None, list(comments))
    return path


def pack_comments(data):
    """A dict as comments for `save_surfels`: JSON behind the word "surflux", in pieces that every reader takes.

    NaN, which JSON does not have, becomes null.
    """
    # Blanks, which only stand inside strings here, are escaped: readers may trim or join them.
    text = json.dumps(_without_nan(data), separators=(",", ":"), allow_nan=False).replace(" ", "\\u0020")
    longest = 400  # rply, and with it Open3D, gives up on lines of 1024 bytes
    return [COMMENT_KEY + text[i : i + longest] for i in range(0, len(text), longest)]


def _without_nan(data):
    if isinstance(data, dict):
        return {name: _without_nan(value) for name, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_without_nan(value) for value in data]
    return None if isinstance(data, float) and math.isnan(data) else data


def unpack_comments(comments, path=""):
    """The dict of `pack_comments`, from the comments of a file; empty where they hold none. Raises FileError."""
    text = "".join(line[len(COMMENT_KEY) :].strip() for line in comments if line.startswith(COMMENT_KEY))
    if not text.startswith("{"):
        return {}
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise file_error(path, f"the comments that begin with 'surflux' are no valid JSON ({error})") from error


def _checked(name, values, n, width):
    values = np.asarray(values)
    wanted = (n,) if width is None else (n, width)
    if values.shape != wanted:
        raise ValueError(f"{name}: got shape {values.shape}; wanted {wanted}")
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{name}: not finite at {tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])}")
    return values


def _columns(names, values, type_of):
    """(name, type, values) of each column of `values`, all of the same type."""
    type_name = type_of(values)
    values = np.asarray(values, dtype=np.float64).reshape(-1, len(names))
    return [(name, type_name, np.ascontiguousarray(values[:, i])) for i, name in enumerate(names)]


def _exact_type(values):
    with np.errstate(over="ignore"):
        return "float" if np.array_equal(values.astype(np.float32).astype(np.float64), values) else "double"


def _float_type(values):
    return "float" if np.all(np.abs(values) <= np.finfo(np.float32).max) else "double"


def _type_of(values):
    """Integers stay integers while PLY has a type for them."""
    if values.dtype == bool:
        return "uchar"
    if not np.issubdtype(values.dtype, np.integer):
        return _float_type(values)
    for name, dtype in (("uchar", np.uint8), ("int", np.int32), ("uint", np.uint32)):
        if np.can_cast(values.dtype, dtype) or (
            len(values) and np.iinfo(dtype).min <= values.min() and values.max() <= np.iinfo(dtype).max
        ):
            return name
    return "double"
