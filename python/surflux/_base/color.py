"""sRGB and linear colours."""

import numpy as np

WHITE = 0.98
"""The reflectance of display white, 255: a surface that gave back all light would never let go of it."""


def srgb_to_linear(srgb):
    """Decode sRGB values in [0, 1] (IEC 61966-2-1)."""
    srgb = np.asarray(srgb, dtype=np.float64)
    return np.where(srgb <= 0.04045, srgb / 12.92, ((np.maximum(srgb, 0.04045) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(linear):
    """Encode linear values, clipped to [0, 1], as sRGB in [0, 1] (IEC 61966-2-1)."""
    linear = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055)


def reflectance_of_colors(colors, full):
    """Display colours, `full` being white, as linear reflectance: white is .98."""
    return WHITE * srgb_to_linear(np.clip(np.asarray(colors, dtype=np.float64) / full, 0.0, 1.0))


def white_of_colors(colors, type_name):
    """What a file calls white by its colours and their type: 1 for fractions, else 255, or 65535 for 16 bits.

    None where they are larger than all of these.
    """
    largest = np.max(colors, initial=0.0)
    if type_name in ("float", "double") and largest <= 1.0 + 1e-6:
        return 1.0
    return next((white for white in (255.0, 65535.0) if largest <= white), None)


def display_bytes(linear):
    """Linear values as sRGB bytes, float64 so that they can stand in a column."""
    return np.rint(255.0 * linear_to_srgb(linear))


def tone_mapped_bytes(radiosity):
    """Radiosity (n, 3) as sRGB bytes, exposed so that the brightest channel of 98 % of the surfels fits."""
    brightest = np.max(radiosity, axis=1)
    white = np.percentile(brightest, 98.0)
    if white <= 0.0:  # nearly all is dark: what shines alone decides
        white = brightest.max()
    return display_bytes(radiosity / white if white > 0.0 else radiosity)
