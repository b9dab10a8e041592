"""How bright colours of a scan are: as bright as its light and exposure were when they were taken."""

import numpy as np

from surflux import _core
from surflux._base.passes import LOG
from surflux._base.warn import warn

# A mean reflectance outside of this is the exposure's.
_DIMMEST, _BRIGHTEST, _WHITE = 0.3, 0.5, 0.98
_HARDLY = 0.05  # a factor so close to 1 is none: what has white in it is exposed as far as it goes
_MANY_BLACK = 0.01
# Where black stands for no colour, hardly any point is nearly so: as bright as bytes of 25, of pictures black is the
# end of that. Beside many black ones .02 as many are in a fragment of a room that lacks colours.
_NEARLY, _HARDLY_ANY = 0.01, 0.1
_AROUND = 8  # points that lend one a colour


def warn_of_black(name, colors):
    """Warns where many of the colours (n, 3), None where there are none, are exactly black."""
    if colors is not None:
        warn_of_so_many_black(name, np.count_nonzero(~np.any(colors, axis=1)), len(colors))


def warn_of_so_many_black(name, black, count):
    """Warns where `black` of `count` colours are many: most files write black where they have none."""
    if _MANY_BLACK * count < black < count:
        warn(f"{name}: {black} of {count} colours are black (0, 0, 0), as where a scan has none, and reflect nothing")


def with_colors_beside(points, reflectance, raw):
    """Reflectance (n, 3) where many of points (n, 3) are black and hardly any nearly so, as where a scan has no colour:
    these take the colours beside them, from the rims inwards. Others' is as it is. raw: see exposure_of_colors.
    """
    brightest = reflectance.max(axis=1, initial=0.0)
    black = brightest == 0.0
    many = int(np.count_nonzero(black))
    nearly = np.count_nonzero(brightest < _NEARLY) - many
    if not _MANY_BLACK * len(points) < many < len(points) or nearly > _HARDLY_ANY * many:
        return reflectance
    rows = np.flatnonzero(black)
    near = _core.nearest_points(np.ascontiguousarray(points), min(_AROUND + 1, len(points)))[rows]
    out = np.where(black[:, None], reflectance[~black].mean(axis=0), reflectance)  # of those that only black is near
    while len(rows):
        weights = (~black[near]).astype(np.float64)
        reached = weights.any(axis=1)
        if not np.any(reached):
            break
        lent = np.einsum("ij,ijk->ik", weights[reached], out[near[reached]])
        out[rows[reached]] = lent / weights[reached].sum(axis=1)[:, None]
        black[rows[reached]] = False
        rows, near = rows[~reached], near[~reached]
    LOG.info("%d points that are black, hardly any being nearly so, have the colours beside them (%s: none)", many, raw)
    return out


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
