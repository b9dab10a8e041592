"""The rules of the house (cpp/README.md), each a function from a source tree to complaints: "file:line: why"."""

import ast
import re
from pathlib import Path

# The floors of cpp/surflux, top to bottom: a room includes only what stands below it.
FLOORS = ["render", "transfer", "radiosity", "meshless", "reference", "solution", "area", "lights", "trace"]
FLOORS += ["neighbors", "files", "image", "gl", "scene", "core"]
# Four rooms on four floors that do not see each other all the same: a caller hands areas in.
STRANGERS = {"radiosity", "meshless", "reference", "area"}
# Compiled into a module of its own, which loads with the first picture: all others take arrays.
ALONE = "image"

# The rooms of python/surflux, top to bottom; the face (surflux/__init__.py) finds public names in them when asked.
ROOMS = ["cli", "bench", "viewing", "solving", "cluster", "splats", "solutions", "scenes", "points", "scans", "drawing"]
ROOMS += ["pictures", "meshes", "geometry", "_base"]

# Outside libraries by their headers' folder, and where those may be included. Eigen may be used anywhere.
HOMES = {
    r"embree[34]?/": "cpp/surflux/trace/",
    r"flann/": "cpp/surflux/neighbors/",
    r"OpenImageIO/": "cpp/surflux/image/",
    r"(EGL|GL|GLES\d?|KHR)/": "cpp/surflux/gl/",
    r"(oneapi/)?tbb/": "cpp/surflux/core/parallel.cpp",
    r"pybind11/": "bindings/",
    r"Eigen/": "",
    r"sys/": "",
}
# Headers that other rooms may see through a header of the library's own room: types of OpenGL, for area and render,
# and those of Eigen and pybind11.
SEEN_FROM_OUTSIDE = re.compile(r"(GL|Eigen|pybind11|sys)/")

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)
CODE = {".cpp", ".h", ".py", ".cmake", ".glsl", ".vert", ".frag", ".comp", ""}
MAX_LINES = 400
# Joined here, so that this file does not hold the words themselves.
OPEN_WORDS = ["TO" + "DO", "FIX" + "ME", "XX" + "X", "HA" + "CK"]


def sources(root, *folders, suffixes=CODE):
    """Paths of all source files under the folders, relative to root, in a fixed order."""
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and path.suffix in suffixes and "__pycache__" not in path.parts:
                yield path.relative_to(root)


def includes(root, path):
    """(line number, quote or bracket, included header) of one C++ file."""
    text = (root / path).read_text()
    return [(text.count("\n", 0, m.start(2)) + 1, m[1], m[2]) for m in INCLUDE.finditer(text)]


def room_of(path):
    """The room a path such as cpp/surflux/area/quadrature.h belongs to; None outside cpp/surflux."""
    parts = Path(path).parts
    return parts[2] if parts[:2] == ("cpp", "surflux") and len(parts) == 4 else None


def upward_includes(root):
    """Project headers included from a room on the same floor or above, by a path of another form, or not there."""
    for path in sources(root, "cpp/surflux", "bindings", suffixes={".cpp", ".h"}):
        here = room_of(path)
        if here not in FLOORS and path.parts[0] == "cpp":
            yield f"{path}: not in one of the rooms {', '.join(FLOORS)}"
            continue
        for line, quote, header in includes(root, path):
            if quote == "<" and header.startswith("surflux/"):
                yield f'{path}:{line}: <{header}> is ours: "{header}"'
            if quote == "<":
                continue
            if path.parts[0] == "bindings" and (root / path.parent / header).is_file() and ".." not in header:
                continue
            there = room_of(Path("cpp") / header)
            if there is None or not (root / "cpp" / header).is_file():
                yield f'{path}:{line}: "{header}" is no header of the house: wanted "surflux/room/file.h"'
            elif path.parts[0] == "cpp" and here != there:
                if FLOORS.index(there) < FLOORS.index(here):
                    yield f"{path}:{line}: {here} includes {header}, which stands above it"
                elif there == ALONE:
                    yield f"{path}:{line}: {here} includes {header}: {ALONE} is no part of the core, which takes arrays"
                elif {here, there} <= STRANGERS:
                    yield f"{path}:{line}: {here} and {there} do not see each other"


def strange_headers(root):
    """Headers of outside libraries included outside their room, and libraries that have no room."""
    for path in sources(root, "cpp/surflux", "bindings", suffixes={".cpp", ".h"}):
        for line, quote, header in includes(root, path):
            if quote == '"' or "/" not in header or header.startswith("surflux/"):
                continue
            homes = [home for pattern, home in HOMES.items() if re.match(pattern, header)]
            if not homes:
                yield f"{path}:{line}: <{header}> belongs to a library without a room"
            elif not path.as_posix().startswith(homes[0]):
                yield f"{path}:{line}: <{header}> belongs in {homes[0]} alone"


def leaking_headers(root):
    """Headers of a room that show an outside library to other rooms, straight or through further headers."""
    wanted = {
        path: {header.removeprefix("surflux/") for _, quote, header in includes(root, path) if quote == '"'}
        for path in sources(root, "cpp/surflux", "bindings", suffixes={".cpp", ".h"})
    }
    for path in [p for p in wanted if p.suffix == ".h"]:
        for line, quote, header in includes(root, path):
            if quote == '"' or "/" not in header or SEEN_FROM_OUTSIDE.match(header):
                continue
            seen_in, added = set(), {path}
            while added:
                seen_in |= added
                names = {p.relative_to("cpp/surflux").as_posix() for p in added if p.parts[0] == "cpp"}
                added = {p for p, headers in wanted.items() if headers & names} - seen_in
            for other in sorted(p for p in seen_in if p.parent != path.parent):
                yield f"{other}: sees <{header}> through {path}:{line}"


def python_modules(root):
    """{module: path} of python/surflux, by dotted names below surflux: "points.surfels"; the face itself is ""."""
    found = {}
    for path in sources(root, "python/surflux", suffixes={".py"}):
        parts = path.relative_to("python/surflux").with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def python_imports(root):
    """(module, imported module, also a compiled one, line, does it run when the module is loaded?) of all imports."""
    modules = python_modules(root)
    for module, path in modules.items():
        tree = ast.parse((root / path).read_text())
        lazy = {n for f in ast.walk(tree) if isinstance(f, (ast.FunctionDef, ast.Lambda)) for n in ast.walk(f)}
        package = module if path.stem == "__init__" else module.rpartition(".")[0]
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                above = ["surflux", *filter(None, package.split("."))]
                base = ".".join(above[: len(above) - node.level + 1]) if node.level else ""
                base = ".".join(filter(None, (base, node.module)))
                names = [f"{base}.{alias.name}" for alias in node.names]
            else:
                continue
            for name in names:
                outer, _, inner = name.partition(".")
                if outer != "surflux":
                    continue
                # What is imported from a module is no module; what is imported from the face is its own.
                while inner and inner not in ("_core", "_image") and inner not in modules:
                    inner = inner.rpartition(".")[0]
                yield module, inner, node.lineno, node not in lazy


def upward_imports(root):
    """Modules outside the rooms; imports, also those that run later, of what stands above; circles within a room."""
    modules = python_modules(root)
    room = {module: module.partition(".")[0] for module in modules}
    for module, path in modules.items():
        if module not in ("", "__main__") and (room[module] not in ROOMS or len(path.parts) != 4):
            yield f"{path}: not in one of the rooms {', '.join(ROOMS)}"
    graph = {module: set() for module in modules}
    for module, there, line, at_once in python_imports(root):
        where, here = f"{modules[module]}:{line}", room[module]
        if at_once and there in graph:
            graph[module].add(there)
        if there == "" and here not in ("cli", "bench"):
            yield f"{where}: imports the face, which stands above everything but the commands"
        elif here in ROOMS and room.get(there) in ROOMS and ROOMS.index(room[there]) < ROOMS.index(here):
            yield f"{where}: {here} imports {there}, which stands above it"
    floor = {"": 0}
    while stands := [m for m in graph if m not in floor and graph[m] <= floor.keys()]:
        floor.update(dict.fromkeys(stands, len(floor)))
    if circle := sorted(set(graph) - set(floor)):
        yield f"python/surflux: import each other in a circle, or what is in one: {', '.join(circle)}"


def long_files(root):
    """Files past MAX_LINES: two ideas."""
    for path in sources(root, "cpp", "bindings", "python", "tests", "script", "cmake"):
        lines = (root / path).read_text().count("\n")
        if lines > MAX_LINES:
            yield f"{path}: {lines} lines, perhaps two ideas (at most {MAX_LINES})"


def left_open(root):
    """Work that somebody meant to come back to."""
    for path in sources(
        root, "cpp", "bindings", "python", "tests", "script", "cmake", "data", suffixes=CODE | {".toml"}
    ):
        for number, line in enumerate((root / path).read_text().splitlines(), 1):
            if word := re.search(rf"\b({'|'.join(OPEN_WORDS)})\b", line):
                yield f"{path}:{number}: left open: {word[0]}"


RULES = (upward_includes, strange_headers, leaking_headers, upward_imports, long_files, left_open)
