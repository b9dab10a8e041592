"""What a page has to know of an environment that turns in the browser."""

import numpy as np

from surflux._base.color import white_of
from surflux.solving.turning_light import WAVES, waves_at
from surflux.viewing.page_data import LARGEST, packed_light, packed_waves

TURNING = ("radiosity", "irradiance", "direct", "indirect")  # what depends on the environment


_MADE_OF = {"radiosity": ("irradiance",), "indirect": ("irradiance", "direct")}  # others of themselves


class TurningPage:
    """Light of a TurningLight as a page holds it: nine waves of irradiance, of all of it and of direct light.

    Args:
        light: TurningLight.
        names: of the colours of the page; what none of them needs stays out.
    """

    def __init__(self, light, names):
        self._surfels = light.transfer.scene.surfels
        needed = sorted({part for name in names if name in TURNING for part in _parts_of(name)})
        self._waves = {part: getattr(light.waves, part) for part in needed}
        self._reflects = "radiosity" in names

    def white(self, name):
        """What is white of a colour, all the way round: nine angles have the say together."""
        return white_of(np.concatenate([self.shown(name, 2.0 * np.pi * k / WAVES) for k in range(WAVES)]))

    def about(self, order, store):
        """What the page is told: where in the store everything is, surfels in that order; None where nothing turns."""
        found = {}
        for part, waves in self._waves.items():
            whole, scales = packed_waves(waves[:, order])
            found[part] = {"waves": store.add(whole, np.int16), "scales": store.add(scales, np.float32)}
        if self._reflects:
            s = self._surfels
            found["reflectance"] = store.add(np.rint(LARGEST * s.reflectance[order]), np.int16)
            if s.emission.any():
                bright = float(s.emission.max())
                found["emission"] = store.add(packed_light(s.emission[order] / bright), np.uint32)
                found["brightest"] = bright
        return found or None

    def shown(self, name, angle):
        """(n, 3) of a colour at an angle in radians, as Solutions have it: what is below 0 is cut off."""
        at = waves_at(angle).astype(np.float32)
        light = [np.maximum(np.tensordot(at, self._waves[part], 1), 0.0) for part in _parts_of(name)]
        if name == "radiosity":
            return self._surfels.emission + self._surfels.reflectance * light[0]
        return light[0] if name != "indirect" else np.maximum(light[0] - light[1], 0.0)


def _parts_of(name):
    return _MADE_OF.get(name, (name,))
