"""What surfels can be coloured by, and how: as light, as they are, as numbers, or as members of something."""

from dataclasses import dataclass

import numpy as np

from surflux import _check
from surflux._color import display_bytes
from surflux.areas import effective_areas

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# name: (kind, title). Light is RGB, exposed; "members" have a colour each.
PROPERTIES = {
    "radiosity": ("light", "radiosity B, W/m2"),
    "irradiance": ("light", "irradiance H, W/m2"),
    "direct": ("light", "direct irradiance D, W/m2"),
    "indirect": ("light", "irradiance from surfels H - D, W/m2"),
    "emission": ("light", "emission E, W/m2"),
    "reflectance": ("surface", "reflectance"),
    "normal": ("surface", "normal n as red, green, blue: (n + 1) / 2"),
    "radius": ("number", "radius R, units of length"),
    "area": ("number", "effective area S, units of length squared"),
    "coverage": ("number", "area / disk area"),
    "level": ("number", "level that light was gathered at (Solution.levels); below 0 inserted"),
    "object": ("members", "objects of the scene"),
    "parent": ("members", "surfels of the scene; those inserted in place of one have its colour"),
    "group": ("members", "groups of the hierarchy"),
    "cut": ("members", "the cut: nodes that light was solved for"),
}
LIGHTS = ("all", "direct", "indirect")
_MANY = 100
_GOLDEN = 0.6180339887


@dataclass(frozen=True)
class Shown:
    """One property of n surfels.

    kind: "light": values (n, 3) linear. "surface": values (n, 3) linear, or what stands for it on the screen as it is.
    "number": values (n,). "members": values (n,) integers.
    """

    name: str
    kind: str
    title: str
    values: np.ndarray


def names_of(subject):
    """The properties that a Subject has, in the order of PROPERTIES, and its further arrays."""
    solved, several = subject.solution is not None, subject.objects.max(initial=0) > 0
    there = {
        "radiosity": solved,
        "irradiance": solved,
        "direct": solved,
        "indirect": solved,
        "emission": bool(subject.surfels.emission.any()),
        "level": solved and bool(subject.inserted().any()),
        "object": several,
        "parent": solved and bool(subject.inserted().any()),
        "cut": solved and subject.solution.cut is not None,
    }
    return [*(name for name in PROPERTIES if there.get(name, True)), *subject.values]


def property_of(subject, name, light="all", groups=None):
    """Shown: one property of a Subject.

    Args:
        subject: Subject.
        name: one of names_of(subject).
        light: "all", "direct" or "indirect": what radiosity and irradiance are made of. Emission is direct light.
        groups: (n,) of the level of the hierarchy that "group" shows; None for the finest.

    Raises:
        ValueError: name and light, by those names.
    """
    _check.choice("color", name, (*names_of(subject), "emission"))
    _check.choice("light", light, LIGHTS)
    s, solution = subject.surfels, subject.solution
    if name in subject.values:
        values = subject.values[name]
        kind = "light" if values.ndim == 2 else "number"
        return Shown(name, kind, name, values)
    kind, title = PROPERTIES[name]
    if name in ("radiosity", "irradiance"):
        part = {"all": 1, "direct": solution.direct, "indirect": solution.irradiance - solution.direct}[light]
        if light == "all":
            values = getattr(solution, name)
        else:
            values = part if name == "irradiance" else s.reflectance * part + (s.emission if light == "direct" else 0.0)
            title = f"{title.removesuffix(', W/m2')} by {light} light alone, W/m2"
    elif name == "indirect":
        values = solution.irradiance - solution.direct
    elif name in ("direct", "cut", "parent"):
        values = getattr(solution, "parents" if name == "parent" else name)
    elif name in ("area", "coverage"):
        values = effective_areas(s) if s.areas is None else s.areas
        values = coverage(s, values) if name == "coverage" else values
    elif name == "level":
        values = solution.values()["level"]
    elif name == "group":
        values = subject.tree().levels[0] if groups is None else groups
    else:
        values = {"emission": s.emission, "reflectance": s.reflectance, "normal": s.normals, "radius": s.radii}.get(
            name, subject.objects
        )
    return Shown(name, kind, title, values)


def coverage(s, areas):
    """(n,) the share of its disk that each surfel keeps: area / (pi R^2)."""
    return areas / (np.pi * s.radii**2)


def white_of(values):
    """What is white of light (n, 3): what the brightest channel of 99 % of it fits below; if they are dark, of all."""
    brightest = values.max(axis=1, initial=0.0)
    white = np.percentile(brightest, 99) if len(values) else 0.0
    white = white if white > 0 else brightest.max(initial=0.0)
    return float(white) if white > 0 else 1.0


def range_of(values):
    """(low, high) of the colours of numbers: where they are many, a few outliers leave colours for the others."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, high = np.percentile(finite, (1, 99)) if len(finite) >= _MANY else (finite.min(), finite.max())
    return (low, high) if low < high else (finite.min(), finite.max())


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
    return viridis((shown.values - low) / (high - low if high > low else 1.0))


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
