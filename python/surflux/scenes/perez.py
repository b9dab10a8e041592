"""The all-weather model of the sky's radiance: Perez, Seals and Michalsky 1993, with its erratum.

Relative radiance towards a direction at the angle zeta from the zenith and gamma from the sun is

    (1 + a exp(b / cos zeta)) (1 + c exp(d gamma) + e cos^2 gamma)

with a to e by the clearness and the brightness of the sky, which direct and diffuse irradiance tell.

Limited are the brightness, as gendaylit does; radiance, to at least 0; and the gradation, the first factor: in the
skies that were fitted b is at most 0, and the zenith has some radiance. Carrying a bin's line on to skies brighter or
darker than those gives others, of which nothing is left but a ring along the horizon (a and b above 0: the sun below 8
degrees in a bright sky, e^27 times the radiance of the zenith; or none at the zenith), nothing but a spot at the
zenith, or nothing at all. Such a sky is as bright towards the horizon as at the zenith, but for what is around the sun;
gendaylit keeps the ring.
"""

import numpy as np

SOLAR_CONSTANT = 1367.0  # W/m2, what the brightness of the model goes by
DAYS = 365.0

# Of clearness: where the bins 2 to 8 begin (Perez and others 1990, table 1).
_BINS = (1.065, 1.230, 1.500, 1.950, 2.800, 4.500, 6.200)
# Of each bin: a1 a2 a3 a4, b1 ... e4 (Perez and others 1993, table 1), as in Radiance's gendaylit.
_NUMBERS = """
1.3525 -0.2576 -0.2690 -1.4366 -0.7670 0.0007 1.2734 -0.1233 2.8000 0.6004 1.2375 1.0000
1.8734 0.6297 0.9738 0.2809 0.0356 -0.1246 -0.5718 0.9938
-1.2219 -0.7730 1.4148 1.1016 -0.2054 0.0367 -3.9128 0.9156 6.9750 0.1774 6.4477 -0.1239
-1.5798 -0.5081 -1.7812 0.1080 0.2624 0.0672 -0.2190 -0.4285
-1.1000 -0.2515 0.8952 0.0156 0.2782 -0.1812 -4.5000 1.1766 24.7219 -13.0812 -37.7000 34.8438
-5.0000 1.5218 3.9229 -2.6204 -0.0156 0.1597 0.4199 -0.5562
-0.5484 -0.6654 -0.2672 0.7117 0.7234 -0.6219 -5.6812 2.6297 33.3389 -18.3000 -62.2500 52.0781
-3.5000 0.0016 1.1477 0.1062 0.4659 -0.3296 -0.0876 -0.0329
-0.6000 -0.3566 -2.5000 2.3250 0.2937 0.0496 -5.6812 1.8415 21.0000 -4.7656 -21.5906 7.2492
-3.5000 -0.1554 1.4062 0.3988 0.0032 0.0766 -0.0656 -0.1294
-1.0156 -0.3670 1.0078 1.4051 0.2875 -0.5328 -3.8500 3.3750 14.0000 -0.9999 -7.1406 7.5469
-3.4000 -0.1078 -1.0750 1.5702 -0.0672 0.4016 0.3017 -0.4844
-1.0000 0.0211 0.5025 -0.5119 -0.3000 0.1922 0.7023 -1.6317 19.0000 -5.0000 1.2438 -1.9094
-4.0000 0.0250 0.3844 0.2656 1.0468 -0.3788 -2.4517 1.4656
-1.0500 0.0289 0.4260 0.3590 -0.3250 0.1156 0.7781 0.0025 31.0625 -14.5000 -46.1148 55.3750
-7.2312 0.4050 13.3500 0.6234 1.5000 -0.6426 1.8564 0.5636
"""
_TABLE = np.array(_NUMBERS.split(), dtype=float).reshape(8, 5, 4)
# Towards the horizon exp(b / cos zeta) is taken where cos zeta is this, as Radiance's perezlum.cal does.
_LEAST_COSINE = 0.01
# From the erratum's range on: brightness of partly clear skies, and of all (gendaylit).
_PARTLY, _LEAST_BRIGHTNESS = (1.065, 2.8), 0.2
_BRIGHTNESS = 0.01, 0.6


def extraterrestrial(day):
    """W/m2 on a plane that faces the sun, above the atmosphere, on a day of the year (Spencer 1971)."""
    angle = 2.0 * np.pi * (np.asarray(day, dtype=float) - 1.0) / DAYS
    return SOLAR_CONSTANT * (
        1.00011
        + 0.034221 * np.cos(angle)
        + 0.00128 * np.sin(angle)
        + 0.000719 * np.cos(2.0 * angle)
        + 0.000077 * np.sin(2.0 * angle)
    )


def air_mass(zenith):
    """Relative optical air mass at angles from the zenith in radians, at most pi / 2 (Kasten 1966)."""
    return 1.0 / (np.cos(zenith) + 0.15 * (93.885 - np.degrees(zenith)) ** -1.253)


def clearness(zenith, direct_normal, diffuse):
    """Of the sky, from 1, overcast: Perez 1993 eq. 1, with angles in radians; diffuse is above 0."""
    cube = 1.041 * zenith**3
    return ((diffuse + direct_normal) / diffuse + cube) / (1.0 + cube)


def brightness(zenith, diffuse, day):
    """Of the sky: Perez 1993 eq. 2."""
    return diffuse * air_mass(zenith) / extraterrestrial(day)


def shape(zenith, clear, bright):
    """(h, 5): a, b, c, d and e of skies with the sun at `zenith` (h,), in radians; limited, see above."""
    which = np.searchsorted(_BINS, clear, side="right")
    partly = (clear > _PARTLY[0]) & (clear < _PARTLY[1])
    bright = np.clip(np.where(partly, np.maximum(bright, _LEAST_BRIGHTNESS), bright), *_BRIGHTNESS)
    x = _TABLE[which]
    found = x[..., 0] + x[..., 1] * zenith[:, None] + bright[:, None] * (x[..., 2] + x[..., 3] * zenith[:, None])
    c, d = x[:, 2], x[:, 3]  # of overcast skies by eqs. 7 and 8, as the erratum has them
    overcast_c = np.exp((bright * (c[:, 0] + c[:, 1] * zenith)) ** np.where(which == 0, c[:, 2], 1.0)) - c[:, 3]
    overcast_d = -np.exp(bright * (d[:, 0] + d[:, 1] * zenith)) + d[:, 2] + bright * d[:, 3]
    found[:, 2] = np.where(which == 0, overcast_c, found[:, 2])
    found[:, 3] = np.where(which == 0, overcast_d, found[:, 3])
    at_zenith = 1.0 + found[:, 0] * np.exp(found[:, 1])
    found[(found[:, 1] > 0.0) | (at_zenith <= 0.0), :2] = 0.0
    return found


def relative_radiance(shapes, suns, directions):
    """(h, m): of h skies towards m directions above the horizon, at least 0, in a unit of each sky's own.

    shapes: (h, 5); suns: (h, 3) and directions: (m, 3), unit vectors.
    """
    a, b, c, d, e = (column[:, None] for column in shapes.T)
    cosine = np.clip(suns @ directions.T, -1.0, 1.0)
    gradation = 1.0 + a * np.exp(b / np.maximum(directions[:, 2], _LEAST_COSINE))
    indicatrix = 1.0 + c * np.exp(d * np.arccos(cosine)) + e * cosine**2
    return np.maximum(gradation * indicatrix, 0.0)
