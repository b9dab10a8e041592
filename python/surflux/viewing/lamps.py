"""Lamps that a person moves: a light, and how its power and colour were changed."""

from __future__ import annotations

import colorsys
import json
import os
from dataclasses import dataclass, replace

import numpy as np

from surflux.drawing.colors import LUMINANCE
from surflux.scenes.lights import (
    AreaLight,
    DirectionalLight,
    Light,
    PhotometricLight,
    PointLight,
    SpotLight,
    power_name,
)
from surflux.scenes.photometry import Photometry

KINDS = {
    PointLight: "point",
    SpotLight: "spot",
    PhotometricLight: "photometric",
    AreaLight: "area",
    DirectionalLight: "directional",
}
STOPS = 6.0  # how much brighter or darker a lamp can be made


@dataclass
class Lamp:
    """A light of a window.

    Attributes:
        light: Light as it is now.
        stops: so many times twice as bright as it was handed in.
        hue, saturation: of its colour, 0 to 1 each.
    """

    light: Light
    stops: float
    hue: float
    saturation: float
    _luminance: float  # as it was handed in

    @classmethod
    def of(cls, light):
        """A light as it comes; one without power can be given some."""
        color = np.array(getattr(light, power_name(light)))
        hue, saturation, _ = colorsys.rgb_to_hsv(*(color / color.max() if color.any() else color))
        return cls(light, 0.0, hue, saturation, float(color @ LUMINANCE) if color.any() else 1.0)

    @property
    def place(self):
        """(3,) where it stands, the middle of an area light; None where light comes from afar."""
        if isinstance(self.light, DirectionalLight):
            return None
        if isinstance(self.light, AreaLight):
            return np.add(self.light.corner, np.add(self.light.edge_u, self.light.edge_v) / 2)
        return np.array(self.light.position)

    @property
    def color(self):
        """(3,) RGB whose largest part is 1."""
        return np.array(colorsys.hsv_to_rgb(self.hue, self.saturation, 1.0))

    def move_to(self, place):
        """Puts its place there."""
        key = "corner" if isinstance(self.light, AreaLight) else "position"
        self.light = replace(self.light, **{key: np.add(getattr(self.light, key), np.subtract(place, self.place))})

    def shine(self, *, stops=None, hue=None, saturation=None):
        """Changes its power or its colour; the luminance is that of `stops` in all colours."""
        if stops is not None:
            self.stops = float(np.clip(stops, -STOPS, STOPS))
        self.hue = self.hue if hue is None else float(hue)
        self.saturation = self.saturation if saturation is None else float(saturation)
        color = self.color * (self._luminance * 2.0**self.stops / (self.color @ LUMINANCE))
        self.light = replace(self.light, **{power_name(self.light): color})

    def words(self):
        """What it is now, in a line."""
        power = getattr(self.light, power_name(self.light))
        unit = {"intensity": "W/sr", "exitance": "W/m2", "irradiance": "W/m2"}[power_name(self.light)]
        if isinstance(self.light, PhotometricLight):
            unit = "times its photometry"
        place = "" if self.place is None else f" at {_numbers(self.place)},"
        return f"{KINDS[type(self.light)]} light{place} {_numbers(power)} {unit}"


def _numbers(values):
    return " ".join(f"{v:.3g}" for v in values)


def lamps_text(lights):
    """Lights as the [[light]] tables of a scene file, or of a file for load_lamps."""
    tables = []
    for light in lights:
        lines = ["[[light]]", f'type = "{KINDS[type(light)]}"']
        for name, value in vars(light).items():
            if isinstance(value, Photometry):
                if value.source is None:
                    raise ValueError("lights: the photometry of one is of no file, which a table would name")
                value = json.dumps(os.path.abspath(value.source), ensure_ascii=False)
            lines.append(f"{name} = {list(value) if isinstance(value, tuple) else value}")
        tables.append("\n".join(lines) + "\n")
    return "\n".join(tables)
