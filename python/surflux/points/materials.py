"""Properties of Surfels that say how they reflect around the mirror direction."""

from __future__ import annotations

from typing import cast

from surflux._base.types import Floats, SomeSurfels


@property
def specular(self: SomeSurfels) -> Floats:
    """(n, 3) linear RGB specular reflectance k of a Phong lobe, beside the diffuse one: reflectance + specular < 1.

    Towards a direction whose mirror image about the normal is r, a surfel sends, beside (E + rho H) / pi, the mean of
    the radiance L that comes to it over a lobe around r, k times the integral of L (s + 1) / (2 pi) cos(r, w)^s over
    the directions w in front. As a BRDF that is k (s + 1) / (2 pi) cos(r, w)^s / cos(n, w): Phong's model, whose lobe
    spherical harmonics convolve with (Sloan, Kautz and Snyder 2002). It is not reciprocal; it never sends more than k
    of the light.

    Solvers leave it out: what they bounce is `reflectance` alone. surflux.reference_radiance knows it.
    """
    return cast(Floats, self._array("specular", lambda: self._core.specular))


@property
def exponent(self: SomeSurfels) -> Floats:
    """(n,) exponents s of the lobes of `specular`, at least 0: the higher, the narrower."""
    return cast(Floats, self._array("exponent", lambda: self._core.exponent))
