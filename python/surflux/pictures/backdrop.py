"""The radiance of what is to be seen behind a scene, whatever the exposure."""

import numpy as np

from surflux import _core
from surflux._base.color import rgb_of_grey, srgb_to_linear

_WHITEST = 0.9985  # linear: the sRGB byte 255 from here on, where bent highlights only come near to 1
_MOST, _STEPS = 4.0, 40_001  # of radiance times exposure: the shoulder is steeper than a byte everywhere below


def radiance_shown_as(color, factor, filmic=True):
    """(3,) radiance that a picture shows as a display colour.

    Args:
        color: (3,), sRGB from 0 to 1, as a PNG file has it over 255.
        factor: of the exposure, with stops.
        filmic: as of tone_map.
    """
    linear = np.minimum(srgb_to_linear(np.asarray(color, dtype=np.float64)), _WHITEST)
    exposed = np.linspace(0.0, _MOST, _STEPS)
    grey = rgb_of_grey(exposed[None].astype(np.float32))
    seen = np.asarray(_core.tone_map(grey, 1.0, filmic), dtype=np.float64)[0, :, 0]
    rising = np.append(True, np.diff(seen) > 0.0)  # a picture that is cut off stays at 1
    return np.interp(linear, seen[rising], exposed[rising]) / factor
