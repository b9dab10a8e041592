"""What a solver found, taken home to the points of a scan, all of them in their order."""

import numpy as np

from surflux._base.passes import stage
from surflux.solutions.fields import light_between

LIGHT = ("irradiance", "direct", "radiosity")


def light_at_points(solution, of, points, normals, reflectance, emission):
    """{"irradiance", "direct", "radiosity": (m, 3)} of m points of the surface.

    Args:
        of: (m,) which surfel of the scene each is; -1 where it is none, which has what surfels around it have.
        points, normals, reflectance, emission: (m, 3).
    """
    at = of >= 0
    found = {name: np.empty((len(of), 3)) for name in LIGHT}
    for name, values in found.items():
        values[at] = solution.per_surfel(name)[of[at]]
    if not np.all(at):
        irradiance, direct = light_between(solution, points[~at], normals[~at], stage("irradiance"))
        found["irradiance"][~at], found["direct"][~at] = irradiance, direct
        found["radiosity"][~at] = emission[~at] + reflectance[~at] * irradiance
    return found


def save_lit(scan, path, found, lit, normals, alone, colors, columns, comments=(), up=(0.0, 0.0, 1.0), pixels=None):
    """Writes a Scan with the light of its rows `lit`, NaN in the others; the Path.

    Args:
        found: as light_at_points gives it.
        lit: (m,) rows.
        normals: (m, 3).
        alone: (n,) booleans of points that are left out: 1 as `left_out`.
        colors: (m, 3) bytes to be seen, or None for the scan's own.
        columns: (n,) or (n, k) each, beside these.
        comments, up: as Scan.save takes them.
        pixels: as of write_points.
    """
    count = len(scan)
    columns = {name: spread(values, lit, count) for name, values in found.items()} | columns
    if np.any(alone) or "left_out" in scan.attributes:
        columns["left_out"] = alone.astype(np.uint8)
    if colors is not None:
        shown = scan.display_colors()
        shown[lit] = colors
        colors = shown
    return scan._save(path, columns, spread(normals, lit, count), colors, comments, up, pixels)


def spread(values, rows, count, kind=np.float32):
    """(count, ...) with values in some rows, NaN in the others."""
    out = np.full((count, *np.shape(values)[1:]), np.nan, dtype=kind)
    out[rows] = values
    return out
