"""Point files, read as surfels."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.color import reflectance_of_colors, white_of_colors
from surflux._base.files import file_error, require_file
from surflux._base.passes import watched
from surflux._base.types import FilePath, Progress
from surflux._base.warn import warn
from surflux.geometry.cores import replaced
from surflux.geometry.estimates import estimated_normals
from surflux.geometry.gloss import USUAL_EXPONENT
from surflux.points.surfels import Surfels
from surflux.points.writing import COLOR_NAMES, CORNER_NAMES

FORMATS = ("ply",)
OPEN3D = ("pcd", "pts", "xyz", "xyzn", "xyzrgb")  # formats of points that it reads
MESHES = ("obj", "stl", "off", "glb", "gltf", "vtp", "vtk")
COLOR_CHOICES = (COLOR_NAMES, ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))


def read(
    path: FilePath,
    format: Literal["ply"] | None = None,
    reflectance: ArrayLike | None = None,
    emission: ArrayLike = 0.0,
    viewpoint: ArrayLike | None = None,
    *,
    threads: int | None = None,
    progress: Progress = False,
) -> Surfels:
    """Read a point file as surfels.

    PLY, ascii or binary of either byte order. The vertices become surfels; faces, but for the patches that
    Surfels.save writes, are left out, with a warning (Surfels.from_mesh is for them). Read are the properties `x y z`,
    `nx ny nz`, `radius`, `area`, `reflectance_r/g/b`, `emission_r/g/b`, `specular_r/g/b`, `exponent` and the
    colours `red green blue`.

    Args:
        path: str or path.
        format: "ply"; None to let the suffix of the path decide.
        reflectance: one number, RGB (3,), (n,) or (n, 3), instead of what the file says; None for the file's
            `reflectance_r/g/b`, else its colours, sRGB made linear with white (255) at .98, else 0.5.
        emission: exitance, the same shapes; 0 keeps what the file says.
        viewpoint: (3,), where the points were seen from; orients normals that are estimated.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Surfels. Normals that the file lacks are estimated; also those that are zero or not finite, with a warning.

    Raises:
        FileError: the file cannot be read, or holds no points, or what it holds cannot be surfels. Names the path, the
            line or byte where there is one, and the reason.
        ValueError: an argument, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> path = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, 1]], radii=0.6).save("two.ply")
    >>> sf.read(path, reflectance=0.8)
    Surfels(2 surfels, no areas)
    """
    surfels, faces = read_with_faces(path, format, reflectance, emission, viewpoint, threads=threads, progress=progress)
    if faces:
        warn(
            f"{os.fsdecode(path)}: has {check.counted(faces, 'face')}, left out because it is read as points: "
            'surflux.Surfels.from_mesh reads it as a mesh (kind = "mesh" in a scene file, kind = "surfels" for points)'
        )
    return surfels


def read_with_faces(path, format=None, reflectance=None, emission=0.0, viewpoint=None, *, threads=None, progress=False):
    """What `read` returns, and how many faces the file has that are left out."""
    path = check.path("path", path)
    if viewpoint is not None:
        viewpoint = check.vector3("viewpoint", viewpoint)
    with watched(threads, progress):
        return _surfels_of_file(path, load_arrays(path, format), reflectance, emission, viewpoint)


def _surfels_of_file(path, arrays, reflectance, emission, viewpoint):
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
            **arrays["gloss"],
            viewpoint=viewpoint,
        )
    except ValueError as error:
        # A message begins with the argument it is about: these come from the file.
        if str(error).startswith(("points", "normals", "radii", "areas", "specular", "exponent")):
            raise file_error(path, str(error)) from error
        raise
    if len(arrays["triangles"]):
        core = surfels._core
        of = arrays["triangle_surfel"]
        surfels = Surfels._from_core(
            replaced(core, areas=arrays["areas"], triangles=arrays["triangles"], triangle_surfel=of)
        )
    return surfels, arrays["faces"]


def load_arrays(path, format=None):
    """Read what a point file says about surfels, as arrays; nothing is estimated.

    Returns:
        dict: "points" (n, 3); "normals" (n, 3), unit, rows of NaN where the file's are zero or not finite; "radii",
        "areas" (n,); "reflectance", "emission", "radiosity", "irradiance", "direct" (n, 3), linear; each of these but
        the points is None where the file has none. "gloss": dict of "specular" (n, 3) and "exponent" (n,), empty
        where the file has none. "triangles" (t, 3, 3) and "triangle_surfel" (t,), ascending: the
        patches. "faces": how many others there are, of which nothing is read. "columns": all other properties of the
        vertices by name, (n,). "comments": list of str.

    Raises:
        FileError: as read.
    """
    _check_format(path, format)
    ply = _core.read_ply(path, ["vertex", "patch"])
    columns = dict(ply["columns"].get("vertex", {}))
    types = ply["types"].get("vertex", {})
    if ply["elements"].get("vertex", 0) == 0:
        raise file_error(path, "no points: it has no element 'vertex', or an empty one")
    points = _take(path, columns, ("x", "y", "z"))
    if points is None:
        raise file_error(path, "no points: its vertices have no x, y and z")
    out = {"points": points, "normals": _take_normals(path, columns)}
    out["radii"] = _take_radii(path, columns)
    out["areas"] = columns.pop("area", None)
    _check_rows(path, "area", out["areas"], 0.0)
    colors = _take_colors(path, columns, types)
    for name in ("reflectance", "emission", "radiosity", "irradiance", "direct"):
        out[name] = _take(path, columns, tuple(f"{name}_{channel}" for channel in "rgb"))
        # What a solver computed may be below 0 by its rounding.
        _check_rows(path, name, out[name], 0.0 if name in ("reflectance", "emission") else -np.inf)
    if out["reflectance"] is None:
        out["reflectance"] = colors
    elif np.any(out["reflectance"] >= 1.0):
        row = int(np.argmax(np.any(out["reflectance"] >= 1.0, axis=1)))
        raise file_error(path, f"vertex {row}: reflectance is {out['reflectance'][row].max():g}; wanted less than 1")
    out["gloss"] = _take_gloss(path, columns)
    out["triangles"], out["triangle_surfel"] = _patches(path, ply, len(points))
    out["faces"] = ply["elements"].get("face", 0)
    out["columns"] = columns
    out["comments"] = ply["comments"]
    return out


def _check_format(path, format):
    shown = os.fsdecode(path)
    require_file(path)
    name = Path(shown).suffix.lstrip(".") if format is None else str(format)
    if name.lower() not in FORMATS:
        what = f"format {name!r}" if name else "a name without a suffix, and no format,"
        if name.lower() in MESHES:
            hint = 'surflux.Surfels.from_mesh reads it as a mesh (kind = "mesh" in a scene file)'
        elif name.lower() == "toml":
            hint = "surflux.load_scene reads it as a scene"
        elif name.lower() in OPEN3D:
            hint = "surflux.Surfels takes what Open3D reads of it (open3d.io.read_point_cloud); CloudCompare makes PLY"
        else:
            hint = f"PDAL (pdal translate {shown} {Path(shown).stem}.ply) and CloudCompare turn most scans into PLY"
        raise file_error(path, f"{what} cannot be read as points; supported now: {', '.join(FORMATS)}. {hint}")


def _take(path, columns, names):
    """The columns of these names, taken out, as one array; None where there are none."""
    there = [name for name in names if name in columns]
    if not there:
        return None
    if len(there) < len(names):
        missing = next(name for name in names if name not in columns)
        raise file_error(path, f"its vertices have {there[0]}, but no {missing}")
    return np.stack([columns.pop(name) for name in names], axis=-1)


def _check_rows(path, name, values, low):
    """Refuse what is not finite or below `low`, naming the first vertex of the kind."""
    if values is None:
        return
    with np.errstate(invalid="ignore"):
        bad = ~(np.isfinite(values) & (values >= low))
    if np.any(bad):
        row = int(np.argwhere(bad)[0][0])
        wanted = "a finite number" + (f" not below {low:g}" if np.isfinite(low) else "")
        raise file_error(path, f"vertex {row}: {name} is {values[bad][0]:g}; wanted {wanted}")


def _take_normals(path, columns):
    normals = _take(path, columns, ("nx", "ny", "nz"))
    if normals is None:
        return None
    # By the largest component first: squares of very large or small ones leave the range of float64.
    largest = np.max(np.abs(normals), axis=1, keepdims=True)
    usable = np.isfinite(largest) & (largest > 0.0)
    normals = normals / np.where(usable, largest, np.nan)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _take_radii(path, columns):
    radii = columns.pop("radius", None)
    # Some programs write the property and never fill it in.
    if radii is None or not np.any(radii):
        return None
    _check_rows(path, "radius", radii, np.nextafter(0.0, 1.0))
    return radii


def _take_gloss(path, columns):
    specular = _take(path, columns, tuple(f"specular_{channel}" for channel in "rgb"))
    if specular is None:  # and an exponent is something else
        return {}
    _check_rows(path, "specular", specular, 0.0)
    exponent = columns.pop("exponent", np.full(len(specular), USUAL_EXPONENT))
    _check_rows(path, "exponent", exponent, 0.0)
    return {"specular": specular, "exponent": exponent}


def _take_colors(path, columns, types):
    for names in COLOR_CHOICES:
        if not all(name in columns for name in names):
            continue
        colors = _take(path, columns, names)
        _check_rows(path, "colour", colors, 0.0)
        white = white_of_colors(colors, types[names[0]])
        if white is None:
            row = int(np.argmax(colors.max(axis=1)))
            raise file_error(path, f"vertex {row}: colour is {colors.max():g}; wanted at most 1, 255 or 65535")
        return reflectance_of_colors(colors, white)
    return None


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
        raise file_error(path, f"patch {row}: wanted the number of one of {n} surfels and finite corners")
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
    warn(
        f"{os.fsdecode(path)}: {np.count_nonzero(bad)} of {len(bad)} normals are zero or not finite and were estimated",
    )
    if np.all(bad):
        return None
    estimated = np.array(estimated_normals(arrays["points"], viewpoint))
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
