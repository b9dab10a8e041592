"""What surfels reflect around the mirror direction: checked arrays of it."""

import numpy as np

from surflux._base import check
from surflux._base.warn import warn

USUAL_EXPONENT = 20.0
NO_GLOSS = {"specular": None, "exponent": None}  # for the core
MOST = 1e6  # an exponent: the lobe is then .1 degrees wide


def gloss_arrays(specular, exponent, n, what="surfel"):
    """{} where nothing is specular, else "specular" (n, 3) and "exponent" (n,), as users may give them."""
    specular = check.per_surfel_rgb("specular", specular, n, high=1.0, high_open=True, what=what)
    exponent = check.in_range("exponent", check.per_surfel("exponent", exponent, n), 0.0, MOST)
    if not specular.any() and np.all(exponent == USUAL_EXPONENT):
        return {}
    return {"specular": specular, "exponent": exponent}


def warn_of_gloss(surfels):
    """Says of surfels of the core that what they reflect around the mirror direction is left out, if any do."""
    if surfels.has_specular:
        warn(
            "specular is left out: all that is computed here is reflected diffusely; "
            "precompute_transfer(lighting='distant') and reference_radiance have it"
        )


def require_energy(reflectance, gloss, where="index"):
    """gloss, if no surfel reflects more than it gets: reflectance + specular < 1 in each channel."""
    if gloss and gloss["specular"].any():
        both = reflectance + gloss["specular"]
        if np.any(both >= 1.0):
            at = tuple(int(i) for i in np.argwhere(both >= 1.0)[0])
            got = f"got {both[at]:g} at {where} {at}"
            raise ValueError(f"specular: wanted reflectance + specular below 1 in every channel, {got}")
    return gloss
