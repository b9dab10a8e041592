"""What surfels have of themselves, and how it is coloured: as light, as it is, as numbers, or as members of groups."""

from dataclasses import dataclass

import numpy as np

from surflux._base import check
from surflux._base.color import display_bytes, white_of
from surflux.geometry.areas import effective_areas

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# What surfels have of themselves; name: (kind, title), with kind as of Shown.
SURFACE = {
    "emission": ("light", "emission E, W/m2"),
    "reflectance": ("surface", "reflectance"),
    "normal": ("surface", "normal n as red, green, blue: (n + 1) / 2"),
    "radius": ("number", "radius R, units of length"),
    "area": ("number", "effective area S, units of length squared"),
    "coverage": ("number", "area / disk area"),
}
_UNIT = ", W/m2"  # ends the titles of light
_MANY = 100
_LARGEST = np.finfo(float).max
_ROUNDING = {4: 1e-6, 8: 1e-11}  # of a number, by its bytes: times and coordinates differ in their last digits
_GOLDEN = 0.6180339887


@dataclass(frozen=True, eq=False)
class Shown:
    """One property of n surfels.

    kind: "light": values (n, 3) linear. "surface": values (n, 3) linear, or what stands for it on the screen as it is.
    "number": values (n,). "members": values (n,) integers.
    """

    name: str
    kind: str
    title: str
    values: np.ndarray

    @property
    def unit(self):
        """Of light: W/m2 of what is solved for, none of arrays that somebody gave, whatever they are."""
        return "W/m2" if self.title.endswith(_UNIT) else ""

    @property
    def label(self):
        """The title without the unit of light."""
        return self.title.removesuffix(_UNIT)


def surface_property(s, name, values=None):
    """Shown: a property that Surfels have of themselves, one of SURFACE, or one of further arrays by name.

    Areas left open are computed.

    Raises:
        ValueError: "color", a name that is not there; an array of another shape, by its name.
    """
    values = {key: check.per_row(key, value, len(s)) for key, value in (values or {}).items() if value is not None}
    names = {*SURFACE, *values}
    if not isinstance(name, str) or name not in names:
        raise ValueError(f"color: wanted one of {', '.join(sorted(names))}, which these surfels have, got {name!r}")
    if name in values:
        value = values[name]
        kind = "light" if value.ndim == 2 and value.shape[1] == 3 else "number"
        return Shown(name, *SURFACE.get(name, (kind, name)), value)
    if name in ("area", "coverage"):
        areas = values.get("area", s.areas)
        areas = effective_areas(s) if areas is None else areas
        return Shown(name, *SURFACE[name], coverage(s, areas) if name == "coverage" else areas)
    own = {"emission": s.emission, "reflectance": s.reflectance, "normal": s.normals, "radius": s.radii}
    return Shown(name, *SURFACE[name], own[name])


def coverage(s, areas):
    """(n,) the share of its disk that each surfel keeps: area / (pi R^2)."""
    return areas / (np.pi * s.radii**2)


def range_of(values):
    """(low, high) of the colours of numbers: where they are many, a few outliers leave colours for the others."""
    return trimmed_range(values)[:2]


def trimmed_range(values):
    """(low, high, whether numbers lie outside) of the colours of numbers, low < high: the 1st and the 99th percentile
    where there are many. Those that differ by rounding alone are one, which stands in the middle of its scale.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0, False
    low, high = np.percentile(finite, (1, 99))
    rounding = _ROUNDING.get(finite.dtype.itemsize, 0.0) if finite.dtype.kind == "f" else 0.0
    least, most = float(finite.min()), float(finite.max())
    if len(finite) >= _MANY and _differ(low, high, rounding):
        return low, high, bool(least < low or most > high)
    if _differ(least, most, rounding):
        return least, most, False
    around = 0.5 * abs(least) or 0.5
    return max(least - around, -_LARGEST), min(most + around, _LARGEST), False


def _differ(low, high, rounding):
    return high - low > rounding * max(abs(low), abs(high))


def label_digits(low, high, steps=4):
    """Digits that tell the marks of a scale apart, from low to high in so many steps."""
    step, largest = float(high) / steps - float(low) / steps, max(abs(float(low)), abs(float(high)))
    return int(np.clip(np.ceil(np.log10(largest / step)) + 2, 4, 15)) if step > 0.0 else 4


def screen_bytes(shown, exposure=1.0, white=None):
    """(n, 3) uint8: the colours of a Shown on the screen.

    exposure: factor on light, of which `white` (None: white_of) becomes 255.
    """
    if shown.kind == "light":
        return display_bytes(exposure * shown.values / (white_of(shown.values) if white is None else white)).astype(
            np.uint8
        )
    if shown.name == "normal":
        return np.round(127.5 * (shown.values + 1)).astype(np.uint8)
    if shown.kind == "surface":
        return display_bytes(shown.values).astype(np.uint8)
    if shown.kind == "members":
        return member_colors(shown.values)
    low, high = range_of(shown.values)
    return viridis((shown.values - low) / (high - low))


def member_colors(members):
    """(n, 3) uint8: a colour for each number, the same ever again; numbers beside each other are far apart in hue."""
    members = np.asarray(members, np.int64)
    hue, which = (members * _GOLDEN) % 1.0, members % 5
    saturation, value = 0.45 + 0.1 * which, 0.95 - 0.09 * ((members // 5) % 4)
    sector = np.abs((hue[:, None] * 6 + [0, 4, 2]) % 6 - 3) - 1  # of the hexagon of full colours
    rgb = value[:, None] * (1 - saturation[:, None] * (1 - np.clip(sector, 0, 1)))
    return np.round(255 * rgb).astype(np.uint8)


def viridis(fraction):
    """(n, 3) uint8 of numbers from 0 to 1; what is not finite is light grey."""
    import pyvista

    table = np.array(pyvista.LookupTable("viridis").values)[:, :3]
    fraction = np.asarray(fraction, np.float64)
    known = np.isfinite(fraction)
    place = np.rint((len(table) - 1) * np.clip(np.where(known, fraction, 0.0), 0.0, 1.0)).astype(np.int64)
    return np.where(known[:, None], table[place], 211).astype(np.uint8)
