"""Scene files: TOML that says what a Scene holds."""

from __future__ import annotations

import os
import re
import tomllib
from functools import partial
from pathlib import Path

from surflux._base import check
from surflux._base.passes import in_threads, watched
from surflux._base.types import FilePath, Progress
from surflux._core import FileError
from surflux.pictures.camera import Camera
from surflux.points.arranging import divide_patches
from surflux.scenes import lights as light_types
from surflux.scenes.options import OPTIONS, check_options
from surflux.scenes.photometry import read_photometry
from surflux.scenes.scene import Scene
from surflux.scenes.scene_counts import shared_out
from surflux.scenes.scene_object import open_object

LIGHT_TYPES = {
    "point": light_types.PointLight,
    "spot": light_types.SpotLight,
    "photometric": light_types.PhotometricLight,
    "area": light_types.AreaLight,
    "directional": light_types.DirectionalLight,
    "environment": light_types.Environment,
}
LIGHT_KEYS = {
    "point": ("position", "intensity"),
    "spot": ("position", "direction", "intensity", "cone", "penumbra"),
    "photometric": ("position", "photometry", "direction", "azimuth", "intensity"),
    "area": ("corner", "edge_u", "edge_v", "exitance"),
    "directional": ("direction", "irradiance"),
    "environment": ("radiance", "image", "up", "azimuth"),
}
_OPTIONAL = {"cone", "penumbra", "up", "azimuth", "radiance", "image", "fov", "height"}


def load_scene(
    path: FilePath, *, surfels: int | None = None, threads: int | None = None, progress: Progress = False
) -> Scene:
    """A Scene from a TOML file; those of sf.examples (data/*.toml) show how they go.

    At the top: name (text; default: the file's name), units (text, a remark), then the tables [[object]] (one or
    more), [[light]] (any number), [camera] and [solve] (one each, optional). Lengths are in one unit of your own.

    Every [[object]] has either `file` or `shape`, and may have:

    - kind: "mesh", one surfel per patch, with exact areas; or "surfels", points. Default: "mesh" for "box", "room"
      and "rectangle", else "surfels".
    - patch_area (kind "mesh"): largest area of a patch, measured after `scale`; default: one patch per face.
    - points: of a "sphere", "blob" or "knot", how many (see there). With kind = "surfels" and a mesh (a "box", "room",
      "rectangle" or a mesh file): spread this many blue-noise points on it.
    - thin: keep this many of the surfels, 2 or more, as blue noise; patches become disks.
    - orient (false): true turns round the patches of surfels that point inwards, as some scans have them (see
      sf.inward_patches), after they are thinned, and faces of meshes that are wound against most of those beside: not
      for rooms that are seen from inside, unless `rooms` says so.
    - rooms (false): with orient, closed sheets may be rooms: the side that most of their surfels face is right.
    - seed (0): of all that is random in the object.
    - scale (1), rotate ([0, 0, 0]), translate ([0, 0, 0]): applied in this order, about the origin: first p times the
      number `scale`, then turned about the x axis by the first angle, about y by the second, about z by the third,
      in degrees (counter-clockwise seen from the tip of the axis), then moved.
    - reflectance (0.5; for files what they say, by colours too): a number or RGB in [0, 1), linear; or a pattern.
    - emission (0; for files what they say, of materials of OBJ, too): exitance of the surfels themselves in W/m2, a
      number or RGB, at least 0.
    - specular (0), exponent (20): what surfels reflect around the mirror direction (see Surfels.specular), a number or
      RGB, and a number.
    - two_sided (false): true adds a copy of every surfel that faces the other way; with kind "mesh" "sheets" of those
      alone that belong to open sheets, such as leaves (see Surfels.from_mesh).

    file: the path of points (PLY and others, see read), with kind = "mesh" or `points` of a mesh (PLY, OBJ and others,
    see Surfels.from_mesh). Relative paths start at the scene file; ${NAME} comes from the environment. With it go:

    - up ([0, 0, 1]; of glTF, .glb and .gltf, [0, 1, 0], as its specification says): what is up in the file; it is
      turned to z before `scale` and `rotate`.
    - viewpoint: of points alone, the place in the file's coordinates from which they were seen; estimated normals turn
      towards it. Default: what the file says, see read.
    - clean (false): of points alone, true leaves out isolated points, those that a LAS file withholds, and repeated
      ones, and moves those of a depth camera to the planes that its depth has steps of, before `thin`, as `surflux
      solve` does with a cloud; see read.

    shape, with its keys and their defaults:

    - "box": size (1; one number or [x, y, z]), patches (1; cells along each edge, one number or one each for the edges
      along x, y, z). One corner at the origin, the opposite one at `size`; its sides face outwards.
    - "room": as "box", but the sides face inwards.
    - "rectangle": corner ([0, 0, 0]), edge_u ([1, 0, 0]), edge_v ([0, 1, 0]), patches (1; one number or one each along
      u and v). Faces along edge_u x edge_v.
    - "sphere": points (642), radius (1). Centre at the origin. 12, 42, 162, 642, 2562, ... (10 * 4^k + 2) points are
      an icosphere, the only ones that kind = "mesh" takes; any other number, 12 or more, a Fibonacci lattice.
    - "blob": points (3000), radius (1), bumps (0.25, from 0 to 0.9). A rounded boulder, centre at the origin.
    - "knot": points (3000), radius (1; of its torus), tube (0.28; of the knot's own tube, in the same unit), swelling
      (0.3, from 0 to below 1), windings ([2, 3], coprime). A torus knot around the z axis, centre at the origin.

    "box" and "room" of kind "mesh" may have a table `walls` with the reflectance of single sides, by name: left (low
    x), right (high x), front (low y), back (high y), floor (low z), ceiling (high z).

    A pattern is a table in place of a reflectance, painted in the space of the scene:
    { pattern = "marble" | "spots" | "checker", colors = [[r, g, b], ...], size = 0.1, seed = 0 }, with two colors or
    more in [0, 1) and the size of a band, a spot or a cube. marble fades from the first to the last color; spots has
    the ground first, then the spots, then (where there are three) their middle; checker takes them in turn.

    Every [[light]] has a `type`, and the keys that are the arguments of that light; those without a default here must
    be there. All colours are a number or RGB, at least 0:

    - "point": position, intensity (W/sr).
    - "spot": position, direction (from the light into the scene), intensity (W/sr on the axis), cone (45) and penumbra
      (5), full angles in degrees.
    - "photometric": position, photometry (the path of a luminaire's IES or EULUMDAT file), direction ([0, 0, -1]),
      azimuth (0), degrees about it, and intensity (1), times what the file has.
    - "area": corner, edge_u, edge_v (perpendicular; shines along edge_u x edge_v), exitance (W/m2).
    - "directional": direction (of travel), irradiance (W/m2).
    - "environment": either radiance (W/(m2 sr)) or image, the path of a latitude-longitude picture, whose columns go
      from left to right as seen from inside and whose middle looks along +x; up ([0, 0, 1]); azimuth (0), degrees by
      which the picture is turned about up, counter-clockwise seen from its tip.

    [camera]: eye, target, up ([0, 0, 1]), fov (45), the vertical field of view in degrees; or height, of what an
    orthographic camera shows.

    [solve]: defaults for the command `surflux solve`, by the names that sf.solve has: error, seconds, transport, zeta,
    insert, tolerance, max_surfels, rays, probes, shadow_rays, epsilon, max_memory, seed. They become
    Scene.solve_options, which count in sf.solve, and those that it has in sf.solve_meshless, wherever the call does not
    give others.

    Args:
        path: str or path of the file.
        surfels: of the whole scene, exactly this many; None for what the file says. Clouds, thinned, sampled or whole,
            become denser or sparser in proportion, by what `thin` and `points` stand for; patches stay. A file of
            points gives no more than it has, other than one of a mesh with `points`.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Scene, with one Surfels per [[object]] in the file's order, the lights, camera, name and solve_options.

    Raises:
        ValueError: path is none; `surfels`, where the scene cannot be had in that number.
        FileError: names the file, the table and the key, or the line where the TOML itself is wrong; a file that an
            object or light names and that is not there or cannot be read.
        Cancelled: the callback returned False.

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
    path = Path(check.path("path", path))
    if surfels is not None:
        surfels = check.count("surfels", surfels)
    return make_scene(path, read_toml(path), surfels, threads=threads, progress=progress)


def read_toml(path):
    """The tables of a TOML file as dicts and lists; FileError where it cannot be read."""
    try:
        text = path.read_bytes().decode("utf-8-sig")  # some editors begin with a byte order mark
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise FileError(f"{path}: is a folder; wanted a scene file (.toml)") from None
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise FileError(f"{path} (byte {error.start}): is not UTF-8 text") from None
    _check_keys(path, text)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        where = f" (line {place[1]}, column {place[2]})" if place else " (end of file)"
        reason = str(error).partition(" (at ")[0]
        bare = place and re.match(r"[+-]?\.\d[\d_]*", text.splitlines()[int(place[1]) - 1][int(place[2]) - 1 :])
        if bare:
            reason += f": in TOML a number begins with a digit, write {bare[0].replace('.', '0.')}"
        raise FileError(f"{path}{where}: {reason}") from None
    except ValueError as error:  # of Python itself: a whole number of thousands of digits
        raise FileError(f"{path}: {error}") from None
    except RecursionError:
        raise FileError(f"{path}: its tables or lists are nested too deeply") from None


# A key of very many parts takes tomllib the square of their number.
_MOST_PARTS = 100
# A text that does not end, which tomllib refuses, is one up to the end: each character is looked at once. No group of
# more than one character is repeated possessively, which Python below 3.11.5 gets wrong.
_TEXT = r'"(?:[^"\\\n]++|\\[^\n]?)*(?:"|(?=\n)|\Z)|\'[^\'\n]*+(?:\'|(?=\n)|\Z)'
_LONG_TEXT = r'"""(?:[^"\\]++|\\(?:.|\Z)|"(?!""))*(?:"""|\Z)|' + r"'''(?:[^']++|'(?!''))*(?:'''|\Z)"
_PART = rf"(?:[\w-]++|{_TEXT})"
# Comments and texts of several lines are passed over; what stands for a key may also be a value.
_TOKEN = re.compile(rf"#[^\n]*+|{_LONG_TEXT}|(?P<key>{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*)", re.DOTALL)


def _check_keys(path, text):
    for token in _TOKEN.finditer(text):
        key = token["key"]
        if key and key.count(".") >= _MOST_PARTS and len(re.findall(_PART, key)) > _MOST_PARTS:
            line = text.count("\n", 0, token.start()) + 1
            raise FileError(f"{path} (line {line}): a key of more than {_MOST_PARTS} parts")


_VARIABLE = re.compile(r"\$\{(\w*)\}")


def named_files(path):
    """Paths of the existing files that the tables of a TOML file name, as Table.file has them. Raises FileError."""
    path = Path(path)
    tables = [value for value in read_toml(path).values() if not isinstance(value, str)]  # text at the top names none
    texts = [_VARIABLE.sub(lambda match: os.environ.get(match[1], match[0]), text) for text in _texts(tables)]
    return [path.parent / text for text in texts if os.path.isfile(path.parent / text)]


def _texts(value):
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from _texts(entry)


def make_scene(path, data, surfels=None, *, threads=None, progress=False):
    """The Scene of a file's tables; path is what errors name and where relative paths start."""
    top = Table(path, "", data)
    name = top.text("name", path.stem)
    top.text("units", "m")
    tables = top.tables("object")
    lights = [_light(table) for table in top.tables("light")]
    camera = top.table("camera")
    solve = top.table("solve")
    top.no_more_keys()
    if not tables:
        raise top.error("object", "wanted at least one [[object]], got none")
    with watched(threads, progress):
        objects = _objects(tables, surfels, threads)
    return Scene(
        objects,
        lights,
        camera=None if camera is None else _camera(camera),
        name=name,
        solve_options=None if solve is None else _solve_options(solve),
    )


def _objects(tables, surfels, threads):
    """The Surfels of object tables."""
    names = [table.name for table in tables]
    sources = in_threads([partial(open_object, table) for table in tables], names, threads)
    counts = [source.count for source in sources] if surfels is None else shared_out(sources, surfels)
    # The most work first, or one thread has nothing to do while the other ends with it.
    order = sorted(range(len(sources)), key=lambda k: -counts[k])
    makers = [partial(source.make, count) for source, count in zip(sources, counts, strict=True)]
    return divide_patches(in_threads(makers, names, threads, order))


class Table:
    """One table of a scene file. Its errors name file, table and key; keys nobody asked for are errors too."""

    def __init__(self, path, name, data):
        self.path, self.name, self._data, self._known = path, name, data, []
        self._key_of_file = ""

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
        return None if value is None else _VARIABLE.sub(lambda match: self._variable(key, match[1]), value)

    def _variable(self, key, name):
        if name not in os.environ:
            raise self.error(key, f"the environment variable {name} is not set")
        return os.environ[name]

    def file(self, key):
        """The path of an existing file, relative to the scene file; None where the key is not there."""
        text = self.text(key)
        if text is None:
            return None
        self._key_of_file = key
        path = self.path.parent / text
        if not path.is_file():
            raise self.error(key, f"no such file: {path}")
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

    def no_more_keys(self, *keys):
        """Refuses keys that were not asked for and are none of these."""
        self._known += keys
        for key in self._data:
            if key not in self._known:
                known = ", ".join(dict.fromkeys(self._known))
                raise self.error(key, f"is not a key here; there is {known}")

    def call(self, function, *arguments, **named):
        """function(...), with its ValueError, which names the key, or its FileError as an error of this table."""
        try:
            return function(*arguments, **named)
        except ValueError as error:
            key, _, reason = str(error).partition(": ")
            if key in self._known:
                raise self.error(key, reason) from None
            raise self.error("", str(error)) from None
        except FileError as error:  # names the file that a key of this table gave
            raise self.error(self._key_of_file, str(error)) from None


def arguments_of(table, keys, optional=frozenset()):
    """What the table has of these keys; a misspelt key is told before the one that is missing for it."""
    found = {key: table.get(key) for key in keys}
    table.no_more_keys()
    for key, value in found.items():
        if value is None and key not in _OPTIONAL | optional:
            raise table.error(key, "is missing")
    return {key: value for key, value in found.items() if value is not None}


def lamp_arguments(table, kind):
    """What the table of a light, which is no environment, has of that light's keys."""
    if kind != "photometric":
        return arguments_of(table, LIGHT_KEYS[kind])
    found = arguments_of(table, LIGHT_KEYS[kind], {"direction", "intensity"})
    return found | {"photometry": read_photometry(table.file("photometry"))}


def _light(table):
    if "type" not in table:  # perhaps misspelt
        table.no_more_keys("type", *(key for keys in LIGHT_KEYS.values() for key in keys))
    kind = table.choice("type", tuple(LIGHT_TYPES))
    keys = LIGHT_KEYS[kind]
    if kind == "environment":
        arguments = arguments_of(table, keys)
        if ("image" in table) == ("radiance" in table):
            raise table.error("radiance", "wanted either radiance or image")
        if "image" in table:
            arguments["image"] = table.file("image")
    else:
        arguments = lamp_arguments(table, kind)
    return table.call(LIGHT_TYPES[kind], **arguments)


def _camera(table):
    arguments = arguments_of(table, ("eye", "target", "up", "fov", "height"))
    return table.call(Camera, **arguments)


def _solve_options(table):
    options = {key: table.get(key) for key in OPTIONS}
    table.no_more_keys()
    options = {key: value for key, value in options.items() if value is not None}
    table.call(check_options, options)
    return options
