"""Properties of surfels among the columns of a file: each is taken out, checked, and None where it is not there."""

import os

import numpy as np

from surflux._base.check import listed
from surflux._base.color import reflectance_of_colors, rgb_of_grey, white_of_colors
from surflux._base.files import file_error
from surflux._base.warn import warn
from surflux.geometry.gloss import USUAL_EXPONENT
from surflux.scans.columns import like_colors, triples

_SHOWN = 4  # names in a warning
LINEAR = ("reflectance", "emission")  # RGB that surfels have, property by property with _r, _g and _b


def found(columns, name):
    """What the column of a name, in lower case, is called there: that name, or another case of it; None without one."""
    return name if name in columns else next((key for key in columns if str(key).lower() == name.lower()), None)


def pop(columns, name):
    """The column of a name, in any case, taken out; None where there is none."""
    return columns.pop(found(columns, name), None)


def take(path, columns, names):
    """The columns of these names, in any case, taken out, as one array; None where there are none."""
    there = {name: key for name in names if (key := found(columns, name)) is not None}
    if not there:
        return None
    if len(there) < len(names):
        missing = next(name for name in names if name not in there)
        raise file_error(path, f"its vertices have {next(iter(there.values()))}, but no {missing}")
    return np.stack([columns.pop(there[name]) for name in names], axis=-1)


def take_linear(path, columns, name, nan=True):
    """RGB (n, 3) of a property of LINEAR, taken out; None where there is none. nan: it may hold NaN, not known.

    It is what name_r, name_g and name_b say, else an array of its own name, as NPZ files have; which is no exitance or
    reflectance, and stays, where its shape or values are others: a warning says so.
    """
    taken, key = take(path, columns, tuple(f"{name}_{channel}" for channel in "rgb")), found(columns, name)
    if taken is not None or key is None:
        return taken
    why = _not_linear(name, columns[key], nan)
    if why is not None:
        warn(f"{os.fsdecode(path)}: its column {key} is not used: {why}")
        return None
    values = np.asarray(columns.pop(key), dtype=np.float64)
    return values if values.ndim == 2 else rgb_of_grey(values)


def has_linear(columns, name):
    """Whether take_linear finds something there."""
    key = found(columns, name)
    return found(columns, f"{name}_r") is not None or (key is not None and _not_linear(name, columns[key]) is None)


def _not_linear(name, values, nan=True):
    """Why (n,) or (n, k) values are none of a property of LINEAR; None where they are."""
    if values.ndim != 1 and values.shape[1:] != (3,):
        return f"wanted shape (n,) or (n, 3), got {values.shape}"
    known = values[~np.isnan(values)] if nan else values
    below = 1.0 if name == "reflectance" else np.inf
    if len(known) and not (known.min() >= 0.0 and known.max() < below):
        wanted = "from 0 to below 1" if below == 1.0 else "from 0, finite"
        return f"wanted values {wanted}, got {known.min():g} to {known.max():g}"
    return None


def check_rows(path, name, values, low):
    """Refuse what is not finite or below `low`, naming the first vertex of the kind."""
    if values is None:
        return
    with np.errstate(invalid="ignore"):
        bad = ~(np.isfinite(values) & (values >= low))
    if np.any(bad):
        row = int(np.argwhere(bad)[0][0])
        wanted = "a finite number" + (f" not below {low:g}" if np.isfinite(low) else "")
        raise file_error(path, f"vertex {row}: {name} is {values[bad][0]:g}; wanted {wanted}")


def require_less_than_one(path, reflectance):
    """Refuses what reflects all light or more, naming the first vertex of the kind."""
    if np.any(reflectance >= 1.0):
        row = int(np.argmax(np.any(reflectance >= 1.0, axis=1)))
        raise file_error(path, f"vertex {row}: reflectance is {reflectance[row].max():g}; wanted less than 1")


def take_normals(path, columns):
    """The normals, of length 1, rows of NaN where they are zero or not finite; None where there are none."""
    normals = take(path, columns, triples(columns).get("normals", ("nx", "ny", "nz")))
    if normals is None:
        return None
    return unit_normals(normals)


def unit_normals(normals):
    """Normals of length 1, rows of NaN where they are zero or not finite."""
    # By the largest component first: squares of very large or small ones leave the range of float64.
    normals = np.asarray(normals, dtype=np.float64)
    largest = np.max(np.abs(normals), axis=1, keepdims=True)
    usable = np.isfinite(largest) & (largest > 0.0)
    normals = normals / np.where(usable, largest, np.nan)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals


def take_radii(path, columns):
    """The radii; None where there are none, or nobody filled them in."""
    radii = pop(columns, "radius")
    # Some programs write the property and never fill it in.
    if radii is None or not np.any(radii):
        return None
    check_rows(path, "radius", radii, np.finfo(float).smallest_subnormal)
    return radii


def take_gloss(path, columns):
    """dict of "specular" and "exponent", empty where there are none."""
    specular = take(path, columns, tuple(f"specular_{channel}" for channel in "rgb"))
    if specular is None:  # and an exponent is something else
        return {}
    check_rows(path, "specular", specular, 0.0)
    exponent = pop(columns, "exponent")
    exponent = np.full(len(specular), USUAL_EXPONENT) if exponent is None else exponent
    check_rows(path, "exponent", exponent, 0.0)
    return {"specular": specular, "exponent": exponent}


def take_colors(path, columns, types):
    """The colours as linear reflectance; None where there are none."""
    names = triples(columns).get("colors")
    if names is None:
        return None
    colors = take(path, columns, names)
    check_rows(path, "colour", colors, 0.0)
    white = white_of_colors(colors, types[names[0]], path)
    if white is None:
        row = int(np.argmax(colors.max(axis=1)))
        raise file_error(path, f"vertex {row}: colour is {colors.max():g}; wanted at most 1, 255 or 65535")
    return reflectance_of_colors(colors, white)


def warn_of_colors_left(path, columns):
    """Names the columns that look like colours, where none were taken: of two channels, or of one number for all."""
    left = like_colors(columns)
    if left:
        warn(
            f"{os.fsdecode(path)}: what looks like colours is not taken ({listed(left, _SHOWN)}): wanted three columns "
            "such as red, green, blue, or r, g, b, or Rf, Gf, Bf (fractions), and not one number for all three"
        )
