"""How bright colours of a scan are: as bright as its light and exposure were when they were taken."""

import numpy as np

from surflux._base.passes import LOG
from surflux._base.warn import warn

# A mean reflectance outside of this is the exposure's.
_DIMMEST, _BRIGHTEST, _WHITE = 0.3, 0.5, 0.98
_HARDLY = 0.05  # a factor so close to 1 is none: what has white in it is exposed as far as it goes
_MANY_BLACK = 0.01


def warn_of_black(name, colors):
    """Warns where many of the colours (n, 3), None where there are none, are exactly black."""
    if colors is not None:
        warn_of_so_many_black(name, np.count_nonzero(~np.any(colors, axis=1)), len(colors))


def warn_of_so_many_black(name, black, count):
    """Warns where `black` of `count` colours are many: most files write black where they have none."""
    if _MANY_BLACK * count < black < count:
        warn(f"{name}: {black} of {count} colours are black (0, 0, 0), as where a scan has none: they reflect nothing")


def exposure_of_colors(mean, bright, raw):
    """The factor on reflectance that makes its mean plausible, 1 where it is; what is done is logged.

    Args:
        mean: of all that are not black.
        bright: what the brightest channel of 99 % of these is below: hardly any of them become white.
        raw: what the caller calls the option that leaves colours as they are.
    """
    if mean == 0.0 or _DIMMEST <= mean <= _BRIGHTEST:
        return 1.0
    factor = min(max(mean, _DIMMEST), _BRIGHTEST) / mean
    if factor > 1.0:
        factor = max(1.0, min(factor, _WHITE / float(bright)))
    if abs(factor - 1.0) < _HARDLY:
        return 1.0
    LOG.info(
        "colours of the scan have a mean reflectance of %.2f, made %.2f (%s keeps them); "
        "shading in them is not taken off",
        mean,
        factor * mean,
        raw,
    )
    return float(factor)


def exposed_by(factor, reflectance):
    """Reflectance (n, 3) times a factor, none of which becomes white by it."""
    return reflectance if factor == 1.0 else np.minimum(factor * reflectance, np.maximum(reflectance, _WHITE))
