"""Point files: reading them as surfels, writing surfels to PLY."""

import json
import os
import warnings
from pathlib import Path

import numpy as np

from . import _core
from ._color import WHITE, display_bytes, reflectance_of_colors, tone_mapped_bytes
from .meshes import Mesh, read_mesh

__all__ = ["Mesh", "load_arrays", "pack_comments", "read", "read_mesh", "save_surfels", "unpack_comments"]

FORMATS = ("ply",)
COLOR_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
CORNER_NAMES = tuple(f"{axis}{corner}" for corner in range(3) for axis in "xyz")
COMMENT_KEY = "surflux "


def read(path, format=None, reflectance=None, emission=0.0, viewpoint=None):
    """Read a point file as surfels.

    PLY, ascii or binary of either byte order. The vertices become surfels; faces, but for the patches that
    `Surfels.save` writes, are not looked at (`Surfels.from_mesh` is for them). Read are the properties ``x y z``,
    ``nx ny nz``, ``radius``, ``area``, ``reflectance_r/g/b``, ``emission_r/g/b`` and the colours ``red green blue``.

    Parameters
    ----------
    path : str or path
        The file.
    format : str, optional
        ``"ply"``; by default the suffix of `path` decides.
    reflectance : float, (3,) or (n, 3) array, optional
        Instead of what the file says. By default ``reflectance_r/g/b``, else the colours, sRGB made linear with
        white (255) at .98, else 0.5.
    emission : float, (3,) or (n, 3) array
        Exitance; 0 keeps what the file says.
    viewpoint : (3,) array, optional
        Where the points were seen from; orients normals that are estimated.

    Returns
    -------
    Surfels
        Normals that the file lacks are estimated; also those that are zero or not finite, with a warning.

    Raises
    ------
    FileError
        The file cannot be read, or holds no points, or what it holds cannot be surfels. Names the path, the line or
        byte where there is one, and the reason.
    ValueError
        An argument is wrong.
    """
    from .surfels import Surfels

    arrays = load_arrays(path, format)
    if reflectance is None:
        reflectance = 0.5 if arrays["reflectance"] is None else arrays["reflectance"]
    if arrays["emission"] is not None and np.ndim(emission) == 0 and emission == 0:
        emission = arrays["emission"]
    try:
        surfels = Surfels(
            arrays["points"],
            _complete_normals(path, arrays, viewpoint),
            radii=arrays["radii"],
            areas=arrays["areas"],
            reflectance=reflectance,
            emission=emission,
            viewpoint=viewpoint,
        )
    except ValueError as error:
        # A message begins with the argument it is about: these four come from the file.
        if str(error).startswith(("points", "normals", "radii", "areas")):
            raise _file_error(path, str(error)) from error
        raise
    if len(arrays["triangles"]) == 0:
        return surfels
    return Surfels._from_core(
        _core.Surfels(
            surfels.points,
            surfels.normals,
            surfels.radii,
            arrays["areas"],
            surfels.reflectance,
            surfels.emission,
            arrays["triangles"],
            arrays["triangle_surfel"],
        )
    )


def load_arrays(path, format=None):
    """Read what a point file says about surfels, as arrays; nothing is estimated.

    Returns
    -------
    dict
        ``points`` (n, 3); ``normals`` (n, 3), rows of NaN where the file's normal is zero or not finite; ``radii``,
        ``areas`` (n,); ``reflectance``, ``emission``, ``radiosity``, ``irradiance``, ``direct`` (n, 3), linear; each
        of these but the points is None where the file has none. ``triangles`` (t, 3, 3) and ``triangle_surfel``
        (t,), ascending: the patches. ``columns``: all other properties of the vertices by name, (n,). ``comments``:
        list of str.

    Raises
    ------
    FileError
        As `read`.
    """
    _check_format(path, format)
    ply = _core.read_ply(path, ["vertex", "patch"])
    columns = dict(ply["columns"].get("vertex", {}))
    types = ply["types"].get("vertex", {})
    if ply["elements"].get("vertex", 0) == 0:
        raise _file_error(path, "no points: it has no element 'vertex', or an empty one")
    points = _take(path, columns, ("x", "y", "z"))
    if points is None:
        raise _file_error(path, "no points: its vertices have no x, y and z")
    out = {"points": points, "normals": _take_normals(path, columns)}
    out["radii"] = _take_radii(path, columns)
    out["areas"] = columns.pop("area", None)
    _check_rows(path, "area", out["areas"], 0.0, np.inf)
    colors = _take_colors(path, columns, types)
    for name in ("reflectance", "emission", "radiosity", "irradiance", "direct"):
        out[name] = _take(path, columns, tuple(f"{name}_{channel}" for channel in "rgb"))
        _check_rows(path, name, out[name], 0.0, np.inf)
    if out["reflectance"] is None:
        out["reflectance"] = colors
    elif np.any(out["reflectance"] >= 1.0):
        row = int(np.argmax(np.any(out["reflectance"] >= 1.0, axis=1)))
        raise _file_error(path, f"vertex {row}: reflectance is {out['reflectance'][row].max():g}; wanted less than 1")
    out["triangles"], out["triangle_surfel"] = _patches(path, ply, len(points))
    out["columns"] = columns
    out["comments"] = ply["comments"]
    return out


def save_surfels(
    path, surfels, *, radiosity=None, irradiance=None, direct=None, columns=None, comments=(), colors=None
):
    """Write surfels, and what was computed for them, as binary little-endian PLY.

    Positions, radii and areas come back bit by bit (double where float does not hold them), all else as float. The
    vertices are the surfels, so that any reader of PLY shows them. The patches of a mesh follow in an element of
    their own, ``patch``, one row per triangle: its surfel and its corners x0 y0 z0 ... x2 y2 z2 as doubles.

    Parameters
    ----------
    path : str or path
        Written beside and renamed: a file that was there is replaced whole or not at all.
    surfels : _core.Surfels
        What to write.
    radiosity, irradiance, direct : (n, 3) array, optional
        Linear RGB. ``red green blue``, for other programs, show the radiosity, exposed so that 98 % of it fits;
        without it, the reflectance.
    columns : dict of str to (n,) or (n, 3) array, optional
        More properties; (n, 3) become ``name_r name_g name_b``.
    comments : sequence of str
        Lines for the header.
    colors : (n, 3) array, optional
        Bytes for ``red green blue`` instead.

    Raises
    ------
    FileError
        The file cannot be written.
    ValueError
        An array has another shape, or is not finite.
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
        shown = tone_mapped_bytes(results["radiosity"])
    else:
        shown = display_bytes(reflectance / WHITE)
    vertex += _columns(COLOR_NAMES[0], shown, lambda _: "uchar")
    # Rounding to float must not make a perfect mirror of .99999999.
    below_one = np.minimum(reflectance, np.nextafter(np.float32(1.0), np.float32(0.0)))
    for name, values in {"reflectance": below_one, "emission": surfels.emission, **results}.items():
        vertex += _columns([f"{name}_{channel}" for channel in "rgb"], values, _float_type)
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
    _core.write_ply(path, elements, None, list(comments))


def pack_comments(data):
    """A dict as comments for `save_surfels`: JSON behind the word ``surflux``, in pieces that every reader takes."""
    # Blanks, which only stand inside strings here, are escaped: readers may trim or join them.
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace(" ", "\\u0020")
    longest = 400  # rply, and with it Open3D, gives up on lines of 1024 bytes
    return [COMMENT_KEY + text[i : i + longest] for i in range(0, len(text), longest)]


def unpack_comments(comments, path=""):
    """The dict of `pack_comments`, from the comments of a file; empty where they hold none. Raises FileError."""
    text = "".join(line[len(COMMENT_KEY) :].strip() for line in comments if line.startswith(COMMENT_KEY))
    if not text.startswith("{"):
        return {}
    try:
        return json.loads(text)
    except ValueError as error:
        raise _file_error(path, f"the comments that begin with 'surflux' are no valid JSON ({error})") from error


def _file_error(path, reason):
    return _core.FileError(f"{os.fsdecode(path)}: {reason}")


def _check_format(path, format):
    name = Path(os.fsdecode(path)).suffix.lstrip(".") if format is None else str(format)
    if name.lower() not in FORMATS:
        what = f"format {name!r}" if name else "a name without a suffix, and no format,"
        raise _file_error(path, f"{what} cannot be read as points; supported now: {', '.join(FORMATS)}")


def _take(path, columns, names):
    """The columns of these names, taken out, as one array; None where there are none."""
    there = [name for name in names if name in columns]
    if not there:
        return None
    if len(there) < len(names):
        missing = next(name for name in names if name not in columns)
        raise _file_error(path, f"its vertices have {there[0]}, but no {missing}")
    return np.stack([columns.pop(name) for name in names], axis=-1)


def _check_rows(path, name, values, low, high):
    """Refuse what is not in [low, high) and finite, naming the first vertex of the kind."""
    if values is None:
        return
    with np.errstate(invalid="ignore"):
        bad = ~((values >= low) & (values < high))
    if np.any(bad):
        row = int(np.argwhere(bad)[0][0])
        wanted = f"from {low:g} to {high:g}" if np.isfinite(high) else f"finite and not below {low:g}"
        raise _file_error(path, f"vertex {row}: {name} is {values[bad][0]:g}; wanted {wanted}")


def _take_normals(path, columns):
    normals = _take(path, columns, ("nx", "ny", "nz"))
    if normals is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            length = np.linalg.norm(normals, axis=1)
        normals[~(np.isfinite(length) & (length > 1e-100))] = np.nan
    return normals


def _take_radii(path, columns):
    radii = columns.pop("radius", None)
    # Some programs write the property and never fill it in.
    if radii is None or not np.any(radii):
        return None
    _check_rows(path, "radius", radii, np.nextafter(0.0, 1.0), np.inf)
    return radii


def _take_colors(path, columns, types):
    for names in COLOR_NAMES:
        if not all(name in columns for name in names):
            continue
        colors = _take(path, columns, names)
        _check_rows(path, "colour", colors, 0.0, np.inf)
        return reflectance_of_colors(colors, _white_of(path, colors, types[names[0]]))
    return None


def _white_of(path, colors, type_name):
    """What a file's colours call white: 1 for fractions, else 255, or 65535 for 16 bits."""
    largest = colors.max()
    if type_name in ("float", "double") and largest <= 1.0 + 1e-6:
        return 1.0
    for white in (255.0, 65535.0):
        if largest <= white:
            return white
    row = int(np.argmax(colors.max(axis=1)))
    raise _file_error(path, f"vertex {row}: colour is {largest:g}; wanted at most 1, 255 or 65535")


def _patches(path, ply, n):
    patch = dict(ply["columns"].get("patch", {}))
    names = ("surfel", *CORNER_NAMES)
    # An element of this name may be somebody else's.
    if not all(name in patch for name in names):
        return np.zeros((0, 3, 3)), np.zeros(0, dtype=np.uint32)
    surfel = patch["surfel"]
    corners = np.stack([patch[name] for name in CORNER_NAMES], axis=-1)
    bad = ~((surfel >= 0) & (surfel < n) & (surfel == np.floor(surfel)) & np.all(np.isfinite(corners), axis=1))
    if np.any(bad):
        row = int(np.argmax(bad))
        raise _file_error(path, f"patch {row}: wanted the number of one of {n} surfels and finite corners")
    order = np.argsort(surfel, kind="stable")
    return corners[order].reshape(-1, 3, 3), surfel[order].astype(np.uint32)


def _complete_normals(path, arrays, viewpoint):
    """The file's normals, the bad ones among them estimated; None where all are bad or missing."""
    normals = arrays["normals"]
    if normals is None:
        return None
    bad = np.isnan(normals[:, 0])
    if not np.any(bad):
        return normals
    warnings.warn(
        f"{os.fsdecode(path)}: {np.count_nonzero(bad)} of {len(bad)} normals are zero or not finite; they are estimated",
        stacklevel=3,
    )
    if np.all(bad):
        return None
    from .surfels import Surfels

    estimated = np.array(Surfels(arrays["points"], viewpoint=viewpoint).normals)
    if viewpoint is None:
        nearest = _nearest(arrays["points"][~bad], arrays["points"][bad])
        flipped = np.sum(estimated[bad] * normals[~bad][nearest], axis=1) < 0.0
        estimated[np.flatnonzero(bad)[flipped]] *= -1.0
    return np.where(bad[:, None], estimated, normals)


def _nearest(points, queries):
    """For each query the index of the nearest point."""
    import pyvista
    from vtkmodules.vtkCommonDataModel import vtkStaticPointLocator

    locator = vtkStaticPointLocator()
    locator.SetDataSet(pyvista.PolyData(points))
    locator.BuildLocator()
    return np.array([locator.FindClosestPoint(query) for query in queries], dtype=np.int64)


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
