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
from surflux.drawing.colors import screen_bytes
from surflux.pictures.camera import Camera
from surflux.viewing.properties import names_of, property_of
from surflux.viewing.subject import Subject, Thing

# Of what there is, these go along; the first of them that there is comes first.
USUAL = ("radiosity", "direct", "indirect", "reflectance", "emission", "normal", "cut", "object")
_LAMP_COLORS = {"radiosity": 1.0, "emission": 1.0, "indirect": 0.0}  # the part of its exitance that a lamp shows


class Page:
    """A page that shows surfels in any browser with WebGL 2: a file of its own, and a cell of a Jupyter notebook.

    Args:
        thing: Surfels, Scene or Solution.
        colors: names of what to colour by, the one to begin with first; None for what there is of radiosity, direct and
            indirect irradiance, reflectance, emission, normal, cut and object. Further ones: irradiance, radius, area,
            coverage, level, parent, group (the finest), and the names in values. Each takes 4 bytes a surfel, all else
            24, and 40 a triangle.
        values: dict of further arrays by name: (n, 3) is linear light, (n,) numbers.
        camera: Camera to begin with; None for the one that comes with the thing, or one that has all in view.
        title: of the page.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[x, y, 0] for y in range(9) for x in range(9)], normals=[[0, 0, 1]] * 81)
    >>> sf.Page(floor, title="A floor").save("floor.html").name
    'floor.html'
    """

    def __init__(
        self,
        thing: Thing,
        *,
        colors: list[str] | tuple[str, ...] | None = None,
        values: Mapping[str, ArrayLike] | None = None,
        camera: Camera | None = None,
        title: str = "surflux",
    ) -> None:
        self._subject = subject = Subject(thing, values)
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

    def html(self) -> str:
        """The page as text."""
        about, data = self._data()
        web = resources.files("surflux.viewing") / "web"
        read = {name: (web / name).read_text("utf-8") for name in ("page.html", "draw.js", "controls.js")}
        # JSON in a page: "<" would end the script that holds it.
        parts = {
            "TITLE": html.escape(self._title),
            "ABOUT": json.dumps(about, allow_nan=False).replace("<", "\\u003c"),
            "DATA": base64.b64encode(data).decode("ascii"),
            "SCRIPT": read["draw.js"] + read["controls.js"],
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
        store = _Store()
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
            "unit": "W/m2",
            "camera": camera | {end: (np.array(camera[end]) - origin).tolist() for end in ("eye", "target")},
            "places": store.add(places, np.float32),
            "normals": store.add(folded(normals), np.int16),
            "indices": store.add(np.concatenate([order, np.arange(len(lamps))]), np.uint32),
            "corners": store.add(corners, np.float32),
            "owners": store.add(owners, np.uint32),
            "colors": [self._color(name, order, store) for name in self._colors],
        }
        return about, store.bytes()

    def _color(self, name, order, store):
        shown = property_of(self._subject, name)
        lamps = self._subject.lamps
        about = {"name": name, "label": shown.title, "kind": "screen"}
        if shown.kind == "light":
            white = white_of(shown.values)
            exitance = np.array([lamp.exitance for lamp in lamps]).reshape(-1, 3) * _LAMP_COLORS.get(name, 1.0)
            values = np.concatenate([shown.values[order], exitance])
            # Its name stands before its unit already.
            label = shown.title.removesuffix(", W/m2")
            return about | {
                "kind": "light",
                "label": label,
                "white": white,
                "data": store.add(packed_light(values / white), np.uint32),
            }
        rgb = np.concatenate([screen_bytes(shown)[order], np.full((len(lamps), 3), 255, np.uint8)]).astype(np.uint32)
        return about | {"data": store.add(rgb[:, 0] | rgb[:, 1] << 8 | rgb[:, 2] << 16 | 0xFF << 24, np.uint32)}


def page_path(name, path):
    """The path of a page, as a Path; refused by `name` where it has another suffix."""
    path = Path(check.path(name, path))
    if path.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"{name}: wanted a name ending in .html, got {str(path)!r}")
    return path


class _Store:
    """Arrays one after another, little-endian, each at a multiple of four bytes."""

    def __init__(self):
        self._parts, self._size = [], 0

    def add(self, array, dtype):
        """[type, first byte, how many] of what was added."""
        flat = np.ascontiguousarray(array).astype(np.dtype(dtype).newbyteorder("<")).ravel()
        part = flat.tobytes()
        part += bytes(-len(part) % 4)
        place = [np.dtype(dtype).name, self._size, len(flat)]
        self._parts.append(part)
        self._size += len(part)
        return place

    def bytes(self):
        return b"".join(self._parts)


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


def folded(normals):
    """(n, 2) int16: unit vectors on an octahedron, unfolded into a square (Meyer and others 2010)."""
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    turned = (1 - np.abs(flat[:, 1::-1])) * np.where(flat[:, :2] < 0, -1, 1)
    return np.rint(32767 * np.where(flat[:, 2:] < 0, turned, flat[:, :2])).astype(np.int16)


def packed_light(rgb):
    """(n,) uint32: nine bits of each channel with a common exponent of five, as OpenGL's RGB9_E5; clipped to it."""
    rgb = np.clip(rgb, 0.0, 65408.0)
    top = rgb.max(axis=1)
    exponent = np.clip(np.floor(np.log2(np.maximum(top, 2.0**-40))), -16, 15) + 1
    exponent += np.rint(top / 2.0 ** (exponent - 9)) >= 512  # rounded up to the next power of two
    mantissa = np.rint(rgb / 2.0 ** (exponent - 9)[:, None]).astype(np.uint32)
    return mantissa[:, 0] | mantissa[:, 1] << 9 | mantissa[:, 2] << 18 | (exponent + 15).astype(np.uint32) << 27
