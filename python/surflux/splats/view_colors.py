"""Colours that depend on where they are seen from, as spherical harmonics in the convention of Gaussian splatting.

Renderers add 0.5 to harmonics of the direction d from the camera to the Gaussian, with the Condon-Shortley phase (-1)^m
(Kerbl and others 2023, after PlenOctrees; KHR_gaussian_splatting, appendix A). Radiance is given by directions away
from surfels, -d, where those of degree l are (-1)^l times as much.
"""

import numpy as np

from surflux import _core
from surflux._base.passes import report
from surflux.geometry.rotation import rotation_matrices
from surflux.splats import turning

HIGHEST = 3  # degree, of both file formats
BIAS = 0.5
_Y0 = 0.28209479177387814  # the harmonic of degree 0

_DEGREES = np.concatenate([np.full(2 * degree + 1, degree) for degree in range(HIGHEST + 1)])
_ORDERS = np.concatenate([np.arange(-degree, degree + 1) for degree in range(HIGHEST + 1)])
PHASE = (-1.0) ** np.abs(_ORDERS)
"""(16,) the Condon-Shortley phase, which harmonics of _core are without."""
_SEEN_FROM = PHASE * (-1.0) ** _DEGREES

# Of fitted colours: directions in front, and the weight of all that are behind over all in front, where the fit is to
# tend to the mean of the front. Nobody sees a surfel from behind, but a Gaussian: without it, what is not asked for may
# be off by .7 and more, and with it the front is off by .002 more. 64 directions leave it off by up to .01 more than
# 200 would.
_DIRECTIONS = 64
_BEHIND = 0.003
_BLOCK = 1 << 14  # surfels at a time


def even(colors):
    """Harmonics (n, 1, 3) of colours (n, 3) that are the same from everywhere."""
    return ((colors - BIAS) / _Y0)[:, None, :]


def even_color(harmonics):
    """(n, 3) of harmonics (n, k, 3), the part that is the same from everywhere."""
    return BIAS + _Y0 * harmonics[:, 0]


def colors_seen(harmonics, directions):
    """What a renderer shows of harmonics (n, k, 3) seen from where unit vectors (n, 3) point to; not below 0."""
    k = harmonics.shape[1]
    basis = _core.spherical_harmonics(directions, round(k**0.5)) * _SEEN_FROM[:k]
    return np.maximum(BIAS + np.einsum("nk,nkc->nc", basis, harmonics), 0.0)


def fitted(colors_towards, normals, degree, callback=None):
    """Harmonics (n, k, 3) that come closest to colours in front of surfels, in the mean over what pixels they cover.

    Least squares, at directions whose density goes by the cosine to the normal: so do the pixels that a surfel covers.

    Args:
        colors_towards: function of unit vectors (n, 3), one of each surfel, in front of it, to colours (n, 3).
        normals: (n, 3) unit vectors.
        degree: 0 to 3; k is (degree + 1)^2.
        callback: (done, total) of the directions, or None.
    """
    ahead = _ahead(_DIRECTIONS)
    weights = _least_squares(ahead, degree)
    frames = rotation_matrices(turning.to_normals(normals))
    local = np.zeros((len(normals), (degree + 1) ** 2, 3))
    for done, (direction, weight) in enumerate(zip(ahead, weights.T, strict=True)):
        report(callback, done, _DIRECTIONS)
        local += weight[:, None] * colors_towards(frames @ direction)[:, None, :]
    report(callback, _DIRECTIONS, _DIRECTIONS)
    return _to_world(local, frames, degree)


def mean_ahead(radiance_towards, normals, count=8):
    """(n, 3) mean of what surfels send, over what pixels they cover: times pi, their exitance."""
    frames = rotation_matrices(turning.to_normals(normals))
    return sum(radiance_towards(frames @ direction) for direction in _ahead(count)) / count


def _ahead(n):
    """Directions (n, 3) in front of +z, their density by the cosine: evenly spread on the disk below (Malley)."""
    out = _spiral(n)
    out[:, 2] = np.sqrt(0.5 * (1.0 + out[:, 2]))
    out[:, :2] *= (np.sqrt(1.0 - out[:, 2] ** 2) / np.linalg.norm(out[:, :2], axis=1))[:, None]
    return out


def _spiral(n):
    """Directions (n, 3) spread evenly over the sphere, from +z to -z (Vogel 1979)."""
    z = 1.0 - (2.0 * np.arange(n) + 1.0) / n
    phi = np.arange(n) * np.pi * (3.0 - np.sqrt(5.0))
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)


def _least_squares(ahead, degree):
    """(k, directions): what the colours ahead of a surfel whose normal is +z have to do with each harmonic."""
    front = _core.spherical_harmonics(ahead, degree + 1)
    behind = _core.spherical_harmonics(_spiral(512)[256:], degree + 1)
    matrix = front.T @ front / len(front) + _BEHIND * behind.T @ behind / len(behind)
    asked = front.T / len(front) + _BEHIND * behind.mean(axis=0)[:, None] / len(front)
    return np.linalg.solve(matrix, asked)


def _to_world(local, frames, degree):
    """Harmonics in the convention of renderers, of those in the frames (n, 3, 3) of surfels.

    Each surfel has a rotation of its own. Harmonics up to a degree are what they are at a few directions: from the
    values that the local ones have there.
    """
    places = _spiral(4 * (HIGHEST + 1) ** 2)
    back = np.linalg.pinv(_core.spherical_harmonics(places, degree + 1))
    out = np.empty_like(local)
    for begin in range(0, len(local), _BLOCK):
        some = slice(begin, begin + _BLOCK)
        seen = (places @ frames[some]).reshape(-1, 3)
        basis = _core.spherical_harmonics(seen, degree + 1).reshape(-1, len(places), local.shape[1])
        out[some] = back @ (basis @ local[some])
    out *= _SEEN_FROM[: local.shape[1], None]
    out[:, 0] -= BIAS / _Y0
    return out
