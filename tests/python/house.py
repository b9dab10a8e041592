"""The rules of the house (cpp/README.md), each a function from a source tree to complaints: "file:line: why"."""

import ast
import re
from pathlib import Path

# The floors of cpp/surflux, top to bottom: a room includes only what stands below it.
FLOORS = ["render", "transfer", "radiosity", "meshless", "reference", "solution", "area", "lights", "trace"]
FLOORS += ["neighbors", "files", "image", "gl", "scene", "core"]
# Four rooms on four floors that do not see each other all the same: a caller hands areas in.
STRANGERS = {"radiosity", "meshless", "reference", "area"}

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


def python_imports(root):
    """{module: {module: line}} of the imports that run when a module of python/surflux is loaded."""
    files = {path.stem: path for path in sources(root, "python/surflux", suffixes={".py"})}
    files["surflux"] = files.pop("__init__", Path())
    found = {}
    for module, path in files.items():
        found[module] = {}
        tree = ast.parse((root / path).read_text()) if (root / path).is_file() else ast.Module([], [])
        # Imports inside functions run later: they let Surfels.plot reach up to the viewer without loading it.
        lazy = {n for f in ast.walk(tree) if isinstance(f, (ast.FunctionDef, ast.Lambda)) for n in ast.walk(f)}
        for node in ast.walk(tree):
            if node in lazy or not isinstance(node, (ast.Import, ast.ImportFrom)):
                continue
            names = [alias.name for alias in node.names]
            if isinstance(node, ast.ImportFrom):
                base = "surflux." * bool(node.level) + (node.module or "")
                base = base.rstrip(".")
                names = [f"{base}.{name}" for name in names] if base == "surflux" else [base]
            for name in names:
                package, _, rest = name.partition(".")
                if package == "surflux":
                    rest = rest.partition(".")[0]
                    found[module].setdefault(rest if rest in files or rest == "_core" else "surflux", node.lineno)
    return found


def upward_imports(root):
    """Python modules that import each other in a circle, or that import a command."""
    graph = python_imports(root)
    for module, imported in graph.items():
        for name, line in imported.items():
            if name in ("cli", "__main__") and module not in ("cli", "__main__"):
                yield f"python/surflux/{module}.py:{line}: imports {name}, which stands above everything"
    floor = {}
    while True:
        stands = [m for m in graph if m not in floor and all(n in floor or n not in graph for n in graph[m])]
        if not stands:
            break
        floor.update(dict.fromkeys(stands, len(floor)))
    circle = sorted(set(graph) - set(floor))
    if circle:
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
