"""What a PLY file says about surfels, as arrays."""

import numpy as np

from surflux import _core
from surflux._base.files import file_error
from surflux.points.exposure import warn_of_black
from surflux.points.properties import (
    LINEAR,
    check_rows,
    require_less_than_one,
    take,
    take_colors,
    take_gloss,
    take_linear,
    take_normals,
    take_radii,
    warn_of_colors_left,
)
from surflux.points.writing import CORNER_NAMES
from surflux.scans.columns import triples
from surflux.scans.formats import format_of
from surflux.scans.viewpoints import rows_of_places, viewpoints_of


def load_arrays(path, format=None):
    """Read what a point file says about surfels, as arrays; nothing is estimated.

    Returns:
        dict: "points" (n, 3); "normals" (n, 3), unit, rows of NaN where the file's are zero or not finite; "radii",
        "areas" (n,); "reflectance", "emission", "radiosity", "irradiance", "direct" (n, 3), linear; each of these but
        the points is None where the file has none. "gloss": dict of "specular" (n, 3) and "exponent" (n,), empty
        where the file has none. "triangles" (t, 3, 3) and "triangle_surfel" (t,), ascending: the patches.
        "environment": (k, 3), the pixels of lights that solutions have, or None. "faces": how many others there are, of
        which nothing is read. "columns": all other properties of the vertices by name, (n,). "comments": list of str.
        "viewpoints": (k, 3), rows of NaN where not known, and "scan": (n,) which of them is each vertex's, or None.

    Raises:
        FileError: as read.
    """
    form = format_of(path, format)
    if form != "ply":
        raise file_error(path, f"is no PLY file, but {form}")
    ply = _core.read_ply(path, ["vertex", "patch", "environment"])
    columns = _solved(dict(ply["columns"].get("vertex", {})))
    types = ply["types"].get("vertex", {})
    if ply["elements"].get("vertex", 0) == 0:
        raise file_error(path, "no points: it has no element 'vertex', or an empty one")
    points = take(path, columns, triples(columns).get("points", ("x", "y", "z")))
    if points is None:
        raise file_error(path, "no points: its vertices have no x, y and z")
    for axis, values in zip("xyz", points.T, strict=True):
        check_rows(path, axis, values, -np.inf)  # the core does so under these names only
    out = {"points": points, "normals": take_normals(path, columns)}
    out["radii"] = take_radii(path, columns)
    out["areas"] = columns.pop("area", None)
    check_rows(path, "area", out["areas"], 0.0)
    colors = take_colors(path, columns, types)
    for name in ("reflectance", "emission", "radiosity", "irradiance", "direct"):
        if name in LINEAR:
            out[name] = take_linear(path, columns, name, nan=False)
        else:
            out[name] = take(path, columns, tuple(f"{name}_{channel}" for channel in "rgb"))
        # What a solver computed may be below 0 by its rounding.
        check_rows(path, name, out[name], 0.0 if name in ("reflectance", "emission") else -np.inf)
    if out["reflectance"] is None:
        out["reflectance"] = colors
        warn_of_black(path, colors)
        if colors is None:
            warn_of_colors_left(path, columns)
    else:
        require_less_than_one(path, out["reflectance"])
    out["gloss"] = take_gloss(path, columns)
    out["triangles"], out["triangle_surfel"] = _patches(path, ply, len(points))
    out["faces"] = ply["elements"].get("face", 0)
    pixels = ply["columns"].get("environment", {})
    channels = [pixels[name] for name in "rgb" if name in pixels]
    out["environment"] = np.stack(channels, axis=-1) if len(channels) == 3 else None
    out["columns"] = columns
    out["comments"] = ply["comments"]
    out["viewpoints"], out["scan"] = rows_of_places(viewpoints_of(ply["comments"])), columns.get("scan")
    return out


def _solved(columns):
    """Without points that are no surfels of the solution that the file holds."""
    none = left_of_solution(columns)
    return columns if none is None else {name: values[~none] for name, values in columns.items()}


def left_of_solution(columns):
    """(n,) booleans: points that are no surfels of the solution that these columns are of, for their radius and area
    are NaN; None where there are none.
    """
    radius, area = columns.get("radius"), columns.get("area")
    if radius is None or area is None or "irradiance_r" not in columns:
        return None
    none = np.isnan(radius) & np.isnan(area)
    return none if np.any(none) else None


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
