"""Scene files: TOML that says what a Scene holds."""

import os
import re
import tomllib
from pathlib import Path

from surflux import lights as light_types
from surflux._core import FileError
from surflux.scene import Scene
from surflux.scene_object import make_object

_LIGHTS = {
    "point": light_types.PointLight,
    "spot": light_types.SpotLight,
    "area": light_types.AreaLight,
    "directional": light_types.DirectionalLight,
    "environment": light_types.Environment,
}
_LIGHT_KEYS = {
    "point": ("position", "intensity"),
    "spot": ("position", "direction", "intensity", "cone", "penumbra"),
    "area": ("corner", "edge_u", "edge_v", "exitance"),
    "directional": ("direction", "irradiance"),
    "environment": ("radiance", "image", "up"),
}
_OPTIONAL = {"cone", "penumbra", "up", "radiance", "image", "fov"}
_SOLVE = {"zeta": (int, float), "tolerance": (int, float), "insert": bool, "max_surfels": int, "seed": int}


def load_scene(path):
    """A Scene from a TOML file; data/*.toml are examples.

    Tables: [[object]] (at least one), [[light]], [camera] with eye, target, up and fov, and [solve] with defaults for
    solve(). Top-level keys: name, units (a remark).

    Every [[object]] has `file` (points or a mesh; relative paths start at the scene file, ${NAME} comes from the
    environment) or `shape` ("box", "room", "sphere", "rectangle", "blob", "knot") with the shape's own keys, and may
    have kind ("mesh": one surfel per patch; "surfels": points), patch_area, points, thin, seed, scale, rotate,
    translate, reflectance, emission, two_sided. A reflectance is a number, RGB, or a table
    { pattern = "marble" | "spots" | "checker", colors = [[r, g, b], ...], size = 0.1, seed = 0 }.

    Every [[light]] has `type` ("point", "spot", "area", "directional", "environment") and the arguments of the light;
    an environment has `radiance` or `image`, a path.

    Raises:
        FileError: names the file, the table and the key, or the line where the TOML itself is wrong.

    >>> import surflux as sf
    >>> with open("room.toml", "w") as file:
    ...     written = file.write('''
    ... [[object]]
    ... shape = "room"
    ... size = 3.5
    ... patches = 4
    ... [[light]]
    ... type = "point"
    ... position = [1.75, 1.75, 3]
    ... intensity = 10
    ... ''')
    >>> sf.load_scene("room.toml")
    Scene('room', 1 object, 96 surfels, 1 light)
    """
    path = Path(path)
    try:
        text = path.read_bytes().decode()
        data = tomllib.loads(text)
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise FileError(f"{path} (byte {error.start}): is not UTF-8 text") from None
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        where = f" (line {place[1]}, column {place[2]})" if place else " (end of file)"
        raise FileError(f"{path}{where}: {str(error).partition(' (at ')[0]}") from None

    top = Table(path, "", data)
    name = top.text("name", path.stem)
    top.text("units", "m")
    objects = [make_object(table) for table in top.tables("object")]
    if not objects:
        raise top.error("object", "wanted at least one [[object]], got none")
    lights = [_light(table) for table in top.tables("light")]
    camera = top.table("camera")
    solve = top.table("solve")
    top.no_more_keys()
    return Scene(
        objects,
        lights,
        camera=None if camera is None else _camera(camera),
        name=name,
        solve_options=None if solve is None else _solve_options(solve),
    )


class Table:
    """One table of a scene file. Its errors name file, table and key; keys nobody asked for are errors too."""

    def __init__(self, path, name, data):
        self.path, self.name, self._data, self._known = path, name, data, []

    def error(self, key, reason):
        place = ", ".join(part for part in (self.name, key) if part)
        return FileError(f"{self.path} ({place}): {reason}")

    def __contains__(self, key):
        return key in self._data

    def get(self, key, default=None):
        """The value of a key as TOML has it."""
        self._known.append(key)
        return self._data.get(key, default)

    def text(self, key, default=None):
        """The text of a key, with ${NAME} from the environment."""
        value = self.get(key, default)
        if value is not default and not isinstance(value, str):
            raise self.error(key, f"wanted text, got {value!r}")
        return None if value is None else re.sub(r"\$\{(\w*)\}", lambda match: self._variable(key, match[1]), value)

    def _variable(self, key, name):
        if name not in os.environ:
            raise self.error(key, f"the environment variable {name} is not set")
        return os.environ[name]

    def file(self, key):
        """The path of an existing file, relative to the scene file; None where the key is not there."""
        text = self.text(key)
        if text is None:
            return None
        path = self.path.parent / text
        if not path.is_file():
            raise self.error(key, f"there is no file {path}")
        return path

    def choice(self, key, choices, default=None):
        value = self.get(key, default)
        if not isinstance(value, str) or value not in choices:
            wanted = ", ".join(f'"{choice}"' for choice in choices)
            raise self.error(key, f"wanted one of {wanted}, got {'nothing' if value is None else repr(value)}")
        return value

    def table(self, key):
        """The table under a key, or None."""
        value = self.get(key)
        if value is not None and not isinstance(value, dict):
            raise self.error(key, f"wanted a table, got {value!r}")
        return None if value is None else Table(self.path, f"{self.name}, {key}" if self.name else key, value)

    def tables(self, key):
        """The tables of an array of tables, named by their number from 1."""
        value = self.get(key, [])
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise self.error(key, f"wanted tables, each headed [[{key}]]")
        return [Table(self.path, f"{key} {number}", entry) for number, entry in enumerate(value, start=1)]

    def no_more_keys(self):
        for key in self._data:
            if key not in self._known:
                known = ", ".join(dict.fromkeys(self._known))
                raise self.error(key, f"is not a key here; there is {known}")

    def call(self, function, *arguments, **named):
        """function(...), with its ValueError, which names the key, as an error of this table."""
        try:
            return function(*arguments, **named)
        except ValueError as error:
            key, _, reason = str(error).partition(": ")
            if key in self._known:
                raise self.error(key, reason) from None
            raise self.error("", str(error)) from None


def _arguments(table, keys):
    found = {key: table.get(key) for key in keys}
    for key, value in found.items():
        if value is None and key not in _OPTIONAL:
            raise table.error(key, "is missing")
    return {key: value for key, value in found.items() if value is not None}


def _light(table):
    kind = table.choice("type", tuple(_LIGHTS))
    keys = _LIGHT_KEYS[kind]
    if kind == "environment":
        if ("image" in table) == ("radiance" in table):
            raise table.error("radiance", "wanted either radiance or image")
        image = table.file("image")
        arguments = _arguments(table, ("radiance", "up"))
        arguments["image_or_rgb"] = image if image is not None else arguments.pop("radiance")
    else:
        arguments = _arguments(table, keys)
    table.no_more_keys()
    return table.call(_LIGHTS[kind], **arguments)


def _camera(table):
    from surflux.camera import Camera

    arguments = _arguments(table, ("eye", "target", "up", "fov"))
    table.no_more_keys()
    return table.call(Camera, **arguments)


def _solve_options(table):
    options = {}
    for key, kinds in _SOLVE.items():
        value = table.get(key)
        if value is None:
            continue
        if not isinstance(value, kinds) or (isinstance(value, bool) and kinds is not bool):
            wanted = "true or false" if kinds is bool else "a whole number" if kinds is int else "a number"
            raise table.error(key, f"wanted {wanted}, got {value!r}")
        options[key] = value
    table.no_more_keys()
    return options
