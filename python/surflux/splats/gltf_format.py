"""What glTF files of Gaussians have: names and numbers of glTF 2.0 and of KHR_gaussian_splatting.

Written after the release candidate of 2026, which Khronos has ratified since:
https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_gaussian_splatting
Names, order and signs are also those of what splat-transform 2.7.1 of PlayCanvas makes of our PLY files.
"""

EXTENSION = "KHR_gaussian_splatting"
ROTATION, SCALE, OPACITY = f"{EXTENSION}:ROTATION", f"{EXTENSION}:SCALE", f"{EXTENSION}:OPACITY"
COLOR_SPACES = {"srgb": "srgb_rec709_display", "linear": "lin_rec709_display"}


def harmonic(degree, order):
    """The attribute of a coefficient, from order -degree to degree."""
    return f"{EXTENSION}:SH_DEGREE_{degree}_COEF_{order + degree}"


def harmonics(degree):
    """Attributes of all coefficients up to a degree, in their order."""
    return [harmonic(d, order) for d in range(degree + 1) for order in range(-d, d + 1)]
