"""sRGB and linear colours, and what is white.

Light of surfels, in views, on pages and in the colours of files, is exposed by white_of, and cut off there; in files
by what does not emit. A
picture (write_image, tone_map) also sees lamps and what is behind the scene, weighs surfels by the pixels they cover,
and bends highlights instead of cutting them off: it goes by the log-average luminance (image/tone_map.h). Either is
times 2^stops.
"""

import numpy as np

from surflux import _core
from surflux._base.warn import warn

COLOR_CHOICES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
"""What files call the colours of points and faces, the first that is there."""
_WHITES = 255.0, 65535.0
_SLIGHTLY = 1.0 + 1e-6
_SOME = 0.01  # of the rows
WHITE = 0.98
"""The reflectance of display white, 255: a surface that gave back all light would never let go of it."""


def srgb_to_linear(srgb):
    """Decode sRGB values in [0, 1] (IEC 61966-2-1): by the core's curve, that of PNG files."""
    return _core.srgb_decode(srgb)


def linear_to_srgb(linear):
    """Encode linear values, clipped to [0, 1], as sRGB in [0, 1] (IEC 61966-2-1): by the core's curve."""
    return _core.srgb_encode(linear)


def rgb_of_grey(values):
    """(..., 3) of grey values (...): the same in all channels."""
    return np.repeat(np.asarray(values)[..., None], 3, axis=-1)


def reflectance_of_colors(colors, full):
    """Display colours, `full` being white, as linear reflectance: white is .98."""
    return WHITE * srgb_to_linear(np.clip(np.asarray(colors, dtype=np.float64) / full, 0.0, 1.0))


def white_of_colors(colors, type_name, name=None):
    """What a file calls white by its colours (n, 3) and their type: 1 for fractions, else 255, or 65535 for 16 bits.

    By 99 % of those that are not black: a few may be brighter, as filters and interpolation leave them, of which a
    warning tells, under `name`. None where one is larger than all of these.
    """
    brightest = np.max(colors, axis=1, initial=0.0)
    if np.max(brightest, initial=0.0) > _WHITES[-1]:
        return None
    lit = brightest[brightest > 0]
    most = np.percentile(lit, 99, method="lower") if len(lit) else 0.0
    fractions = type_name in ("float", "double") and most <= 2.0
    if fractions and np.max(lit, initial=0.0) > _SLIGHTLY:
        fractions = not np.array_equal(colors, np.rint(colors))  # dark ones of 255
    white = 1.0 if fractions else next(white for white in _WHITES if most <= white)
    above = np.count_nonzero(lit > _SLIGHTLY * white)
    if above and name is not None:
        warn(f"{name}: {above} of {len(colors)} colours are brighter than white, which is {white:g}: they are cut off")
    return white


def display_bytes(linear):
    """Linear values as sRGB bytes, float64 so that they can stand in a column."""
    return np.rint(255.0 * linear_to_srgb(linear))


def white_of(values, emission=None):
    """What is white of light (n, 3): what the brightest channel of 99 % of it fits below; if they are dark, of all.

    emission: (n, 3), where lamps are not to count beside what they light: rows that emit are left out, unless next to
    nothing else has light.
    """
    brightest = values.max(axis=1, initial=0.0)
    if emission is not None:
        others = brightest[~np.any(emission, axis=1)]
        if np.count_nonzero(others) > _SOME * len(brightest):
            brightest = others
    white = np.percentile(brightest, 99) if len(brightest) else 0.0
    white = white if white > 0 else brightest.max(initial=0.0)
    return float(white) if white > 0 else 1.0


def tone_mapped_bytes(radiosity, emission):
    """Radiosity (n, 3) as sRGB bytes, white as white_of says of what does not emit."""
    return display_bytes(radiosity / white_of(radiosity, emission))
