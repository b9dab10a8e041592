"""Skies of many hours at once: where the sun is, what it brings, and the radiance of the sky around it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from surflux._base.types import Floats
from surflux.scenes import perez
from surflux.scenes.sky_patches import SkyPatches

# Directions of a patch that its mean radiance is found by, each way: of Tregenza's, and of smaller ones.
_ACROSS, _ACROSS_SMALL = 4, 2
_AT_ONCE = 2**22  # pairs of an hour and a direction
_EVEN = np.zeros((1, 5))  # a to e of a sky that is the same everywhere


def sun_directions(altitude, azimuth):
    """(h, 3) towards the sun, of degrees; azimuth clockwise from north, which is +y; east is +x and up +z."""
    up, around = np.radians(altitude), np.radians(azimuth)
    return np.stack([np.cos(up) * np.sin(around), np.cos(up) * np.cos(around), np.sin(up)], axis=-1)


@dataclass(frozen=True, eq=False)
class SkyHours:
    """h skies.

    Attributes:
        suns: (h, 3) directions towards the sun.
        direct_normal, diffuse: (h,) W/m2, on a plane that faces the sun, and from the sky on a level one.
        days: (h,) of the year.
        albedo: of the ground around.
    """

    suns: Floats
    direct_normal: Floats
    diffuse: Floats
    days: Any
    albedo: float

    def __len__(self) -> int:
        return len(self.suns)

    def of(self, which):
        """SkyHours of some of them."""
        values = (array[which] for array in (self.suns, self.direct_normal, self.diffuse, self.days))
        return SkyHours(*values, self.albedo)

    @property
    def beams(self) -> Floats:
        """(h,) W/m2 on a plane that faces the sun, 0 while it is down."""
        return np.where(self.suns[:, 2] > 0.0, self.direct_normal, 0.0)

    @property
    def ground(self) -> Floats:
        """(h,) radiance of the ground: it reflects evenly what reaches a level plane."""
        return self.albedo / np.pi * (self.diffuse + self.beams * self.suns[:, 2].clip(0.0))

    def index(self):
        """(clearness, brightness), (h,) each; NaN while the sun is down or the sky is dark."""
        zenith = np.arccos(self.suns[:, 2].clip(0.0, 1.0))
        seen = (self.suns[:, 2] > 0.0) & (self.diffuse > 0.0)
        diffuse = np.where(seen, self.diffuse, np.nan)
        return perez.clearness(zenith, self.direct_normal, diffuse), perez.brightness(zenith, diffuse, self.days)

    def relative(self, directions):
        """(h, m) radiance towards (m, 3) directions above the horizon, in a unit of each sky's own.

        While the sun is down, of which the model knows nothing, the sky is even.
        """
        clear, bright = self.index()
        seen = np.isfinite(clear)
        shapes = np.repeat(_EVEN, len(self), axis=0)
        zenith = np.arccos(self.suns[seen, 2].clip(0.0, 1.0))
        shapes[seen] = perez.shape(zenith, clear[seen], bright[seen])
        return perez.relative_radiance(shapes, self.suns, directions)

    def patch_radiances(self, patches: SkyPatches) -> Floats:
        """(h, patches) mean radiance of each patch, the ground's first, without the sun.

        Scaled so that what a level plane receives of the patches is `diffuse`, to rounding.
        """
        places = patches._places(_ACROSS if len(patches) <= 146 else _ACROSS_SMALL)
        out = np.zeros((len(self), len(patches)))
        step = max(1, _AT_ONCE // places[..., 0].size)
        bright = np.flatnonzero(self.diffuse > 0.0)
        for first in range(0, len(bright), step):
            some = bright[first : first + step]
            found = self.of(some).relative(places.reshape(-1, 3)).reshape(-1, *places.shape[:2]).mean(axis=2)
            level = found @ patches.projected[1:]
            out[some, 1:] = found * (self.diffuse[some] / level)[:, None]
        out[:, 0] = self.ground
        return out

    def sun_radiances(self, patches: SkyPatches) -> tuple[Any, Floats]:
        """(h,) which patch the sun is in, and what its light, spread over that, adds to its radiance."""
        which = patches.index(self.suns)
        return which, self.beams / patches.solid_angles[which]
