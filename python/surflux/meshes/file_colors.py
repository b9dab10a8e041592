"""Colours that files of meshes have at vertices and faces, as reflectance."""

import numpy as np

from surflux import _core
from surflux._base.color import reflectance_of_colors, white_of_colors
from surflux._base.warn import warn


def reflectance_in_file(path, colors, type_name, element="vertex"):
    """Linear reflectance (n, 3) of display colours of elements; None where there are none, or one is not finite.

    Raises:
        FileError: a colour is below 0, or larger than any white.
    """
    if colors is None or len(colors) == 0:
        return None
    if not np.all(np.isfinite(colors)):
        row = int(np.argmax(~np.all(np.isfinite(colors), axis=1)))
        warn(f"{path}: {element} {row} has a colour that is not finite; the colours are ignored")
        return None
    if np.any(colors < 0):
        row = int(np.argmax(np.any(colors < 0, axis=1)))
        raise _core.FileError(f"{path}: {element} {row}: colour is {colors[row].min():g}; wanted not below 0")
    white = white_of_colors(colors, type_name, path)
    if white is None:
        row = int(np.argmax(colors.max(axis=1)))
        raise _core.FileError(f"{path}: {element} {row}: colour is {colors.max():g}; wanted at most 1, 255 or 65535")
    return reflectance_of_colors(colors, white)
