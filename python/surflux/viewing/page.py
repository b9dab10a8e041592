"""Surfels as one HTML file that any browser shows by itself: it turns, and has its light exposed, without a network."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.color import white_of
from surflux._base.files import write_whole
from surflux._base.types import FilePath
from surflux.drawing.colors import label_digits, screen_bytes, trimmed_range
from surflux.pictures.camera import Camera
from surflux.scenes.lights import Environment
from surflux.solving.distant_transfer import DistantTransfer
from surflux.solving.turning_light import TurningLight
from surflux.viewing.page_data import Store, folded, packed_light
from surflux.viewing.properties import names_of, property_of
from surflux.viewing.subject import Subject, Thing
from surflux.viewing.turning_page import TURNING, TurningPage

# Of what there is, these go along; the first of them that there is comes first.
USUAL = ("radiosity", "direct", "indirect", "reflectance", "emission", "normal", "cut", "object")
_SCRIPTS = ("draw.js", "turning.js", "controls.js")
_SENT = ("radiosity", "emission")  # what a lamp has of its own; its irradiance nobody has asked for
_LAMP_COLORS = {"radiosity": 1.0, "emission": 1.0, "indirect": 0.0}  # the part of its exitance that a lamp shows


class Page:
    """A page that shows surfels in any browser with WebGL 2: a file of its own, and a cell of a Jupyter notebook.

    That of a DistantTransfer has a slider that turns its environment; `,` and `.` do so by 5 degrees. Radiosity,
    irradiance, direct and indirect light follow, with all bounces, as `DistantTransfer.relight` has them, but for
    .0001 of the most that a surfel ever has. Surfels are shown diffuse, as on all pages: what a lobe sends depends on
    where the eye is, too, which would take some 700 RGB numbers of each surfel in place of nine (see
    `turn_environment`).

    Args:
        thing: Surfels, Scene, Solution or DistantTransfer.
        environment: of a DistantTransfer, as its `relight` takes it; None for all else.
        axis: (3,), the direction that it turns around, counter-clockwise seen from the tip; None for what is up in an
            Environment, of harmonics for z.
        colors: names of what to colour by, the one to begin with first; None for what there is of radiosity, direct and
            indirect irradiance, reflectance, emission, normal, cut and object. Further ones: irradiance, radius, area,
            coverage, level, parent, group (the finest), and the names in values. Each takes 4 bytes a surfel, numbers
            8, all else 24, and 40 a triangle. Of a DistantTransfer, in place of the 4, irradiance takes 58 and direct
            light as many, which the others are made of; reflectance for radiosity 6, and emission 4.
        values: dict of further arrays by name: (n, 3) is exposed as light is, whatever its unit, (n,) numbers.
        camera: Camera to begin with; None for the one that comes with the thing, or one that has all in view.
        title: of the page.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[x, y, 0] for y in range(9) for x in range(9)], normals=[[0, 0, 1]] * 81)
    >>> sf.Page(floor, title="A floor").save("floor.html").name
    'floor.html'
    >>> transfer = sf.precompute_transfer(sf.Scene([floor]), "distant")
    >>> sky = sf.Environment([[[3.0, 2, 1], [1, 1, 1], [0, 0, 0], [1, 1, 1]]])
    >>> sf.Page(transfer, environment=sky).save("turning.html").name
    'turning.html'
    """

    def __init__(
        self,
        thing: Thing | DistantTransfer,
        *,
        environment: Environment | ArrayLike | None = None,
        axis: ArrayLike | None = None,
        colors: list[str] | tuple[str, ...] | None = None,
        values: Mapping[str, ArrayLike] | None = None,
        camera: Camera | None = None,
        title: str = "surflux",
    ) -> None:
        light = _light_of(thing, environment, axis)
        self._subject = subject = Subject(thing if light is None else light.relight(), values)
        there = names_of(subject)
        if colors is None:
            colors = [name for name in USUAL if name in there] + list(subject.values)
        if not isinstance(colors, (list, tuple)) or not colors:
            raise ValueError(f"colors: wanted a list of names, got {colors!r}")
        self._colors = [check.choice("colors", name, there) for name in colors]
        if not isinstance(camera, (Camera, type(None))):
            raise ValueError(f"camera: wanted a Camera or None, got {camera!r}")
        if not isinstance(title, str):
            raise ValueError(f"title: wanted text, got {type(title).__name__}")
        title = title.encode("utf-8", "replace").decode("utf-8")  # names of files may hold bytes that are no text
        self._camera = subject.framed((4, 3)) if camera is None else camera
        if self._camera.height is not None:
            raise ValueError("camera: wanted one without height, for a page is drawn in perspective alone")
        self._title = title
        self._turning = None if light is None else TurningPage(light, self._colors)

    def html(self) -> str:
        """The page as text."""
        about, data = self._data()
        web = resources.files("surflux.viewing") / "web"
        read = {name: (web / name).read_text("utf-8") for name in ("page.html", *_SCRIPTS)}
        # JSON in a page: "<" would end the script that holds it.
        parts = {
            "TITLE": html.escape(self._title),
            "ABOUT": json.dumps(about, allow_nan=False).replace("<", "\\u003c"),
            "DATA": base64.b64encode(data).decode("ascii"),
            "SCRIPT": "".join(read[name] for name in _SCRIPTS),
        }
        text = read["page.html"]
        pieces = [text]
        for name, part in parts.items():
            head, tail = pieces.pop().split(f"@{name}@")
            pieces += [head, part, tail]
        return "".join(pieces)

    def save(self, path: FilePath) -> Path:
        """Writes the page, whole or not at all; the path is returned.

        Raises:
            ValueError: a name that does not end in .html.
            FileError: the file cannot be written.
        """
        path = page_path("path", path)
        write_whole(path, self.html().encode("utf-8"))
        return path

    def _repr_html_(self) -> str:
        """What Jupyter shows: the page in a frame of its own."""
        return (
            '<iframe style="width: 100%; height: 480px; border: 0" sandbox="allow-scripts" '
            f'srcdoc="{html.escape(self.html())}"></iframe>'
        )

    def _data(self):
        """(what the page has to know, bytes of the arrays)."""
        subject, s = self._subject, self._subject.surfels
        radii, triangles = subject.drawn()
        order, corners, owners = _disks_first(s, triangles)
        places = np.column_stack([s.points - subject.origin(), radii])[order]
        normals, lamps = s.normals[order], subject.lamps
        if lamps:
            quads = subject.lamp_quads()
            u, v = quads[:, 1] - quads[:, 0], quads[:, 3] - quads[:, 0]
            reach = np.linalg.norm(np.abs(u) + np.abs(v), axis=1) / 2
            owners = np.concatenate([owners, len(s) + np.repeat(np.arange(len(lamps)), 2)])
            corners = np.concatenate([corners, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3, 3)])
            places = np.concatenate([places, np.column_stack([quads.mean(axis=1), reach])])
            across = np.cross(u, v)
            normals = np.concatenate([normals, across / np.linalg.norm(across, axis=1, keepdims=True)])
        store = Store()
        center = np.zeros(3) if len(places) == 0 else (places[:, :3].min(axis=0) + places[:, :3].max(axis=0)) / 2
        away = np.linalg.norm(places[:, :3] - center, axis=1) + places[:, 3]
        camera, origin = self._camera.to_dict(), subject.origin()
        about = {
            "count": len(places),  # lamps are the last ones
            "surfels": len(s),
            "disks": int(len(s) - len(np.unique(s.triangle_surfel))),
            "origin": origin.tolist(),
            "center": center.tolist(),
            "extent": float(away.max()),
            "camera": camera | {end: (np.array(camera[end]) - origin).tolist() for end in ("eye", "target")},
            "places": store.add(places, np.float32),
            "normals": store.add(folded(normals), np.int16),
            "indices": store.add(np.concatenate([order, np.arange(len(lamps))]), np.uint32),
            "corners": store.add(corners, np.float32),
            "owners": store.add(owners, np.uint32),
            "colors": [self._color(name, order, store) for name in self._colors],
            "turning": None if self._turning is None else self._turning.about(order, store),
        }
        return about, store.bytes()

    def _color(self, name, order, store):
        shown = property_of(self._subject, name)
        lamps = self._subject.lamps
        about = {"name": name, "label": shown.title, "kind": "screen"}
        if self._turning is not None and name in TURNING:
            white = self._turning.white(name)
            return about | {"kind": "light", "label": shown.label, "white": white, "unit": shown.unit, "turns": True}
        if shown.kind == "light":
            white = white_of(shown.values)
            exitance = np.array([lamp.exitance for lamp in lamps]).reshape(-1, 3) * _LAMP_COLORS.get(name, 1.0)
            if not shown.unit:  # of what lamps are no part, white as among colours of surfaces
                exitance = np.full_like(exitance, white)
            values = np.concatenate([shown.values[order], exitance])
            return about | {
                "kind": "light",
                "label": shown.label,
                "white": white,
                "unit": shown.unit,
                "sent": name in _SENT,
                "data": store.add(packed_light(values / white), np.uint32),
            }
        if shown.kind == "number":
            low, high, trimmed = trimmed_range(shown.values)
            about |= {"kind": "number", "low": float(low), "high": float(high), "trimmed": trimmed}
            about["digits"] = label_digits(low, high)
            if np.issubdtype(shown.values.dtype, np.integer) and len(shown.values):
                about["digits"] = max(about["digits"], len(str(int(np.abs(shown.values).max()))))
            with np.errstate(over="ignore"):
                about["above"] = store.add(shown.values[order] - low, np.float32)  # years in seconds have their digits
        rgb = np.concatenate([screen_bytes(shown)[order], np.full((len(lamps), 3), 255, np.uint8)]).astype(np.uint32)
        return about | {"data": store.add(rgb[:, 0] | rgb[:, 1] << 8 | rgb[:, 2] << 16 | 0xFF << 24, np.uint32)}


def _light_of(thing, environment, axis):
    """The TurningLight of a page, or None."""
    if isinstance(thing, DistantTransfer):
        if environment is None:
            raise ValueError("environment: wanted one, for a DistantTransfer has none of its own")
        return TurningLight(thing, environment, axis)
    for name, value in (("environment", environment), ("axis", axis)):
        if value is not None:
            raise ValueError(f"{name}: goes with a DistantTransfer, got {type(thing).__name__}")
    return None


def page_path(name, path):
    """The path of a page, as a Path; refused by `name` where it has another suffix."""
    path = Path(check.path(name, path))
    if path.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"{name}: wanted a name ending in .html, got {str(path)!r}")
    return path


def _disks_first(s, triangles):
    """(order (n,): disks, then patches; corners (t, 3, 3) around the middle; owners (t,), places in that order)."""
    patch = np.zeros(len(s), bool)
    patch[s.triangle_surfel] = True
    # Disks in no order: the first ones stand for all where a page has to be quick.
    order = np.concatenate([np.random.default_rng(0).permutation(np.flatnonzero(~patch)), np.flatnonzero(patch)])
    place = np.empty(len(s), np.int64)
    place[order] = np.arange(len(s))
    middle = (s.points.min(axis=0) + s.points.max(axis=0)) / 2
    return order, triangles - middle, place[s.triangle_surfel]
