"""The JSON schema of scene files takes and refuses what load_scene does, key by key."""

import json
import re
import tomllib
from pathlib import Path

import pytest

import surflux as sf
from surflux._core import FileError
from surflux.scenes.options import OPTIONS
from surflux.scenes.patterns import PATTERNS
from surflux.scenes.scene_file import LIGHT_KEYS, make_scene
from surflux.scenes.scene_object import SHAPES

jsonschema = pytest.importorskip("jsonschema")
SCHEMA = json.loads(sf.examples.schema().read_text())
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
DATA = Path(__file__).parents[3] / "data"
FLOOR = {"shape": "rectangle", "patches": 4}
V = [0.5, 1.0, 2.0]

# The least table of every kind of object.
OBJECTS = {
    "points of a file": {"file": "mesh.ply"},
    "points spread on a mesh of a file": {"file": "mesh.ply", "points": 20},
    "patches of a mesh of a file": {"file": "mesh.ply", "kind": "mesh"},
    "patches of a box": {"shape": "box"},
    "patches of a room": {"shape": "room"},
    "points spread on a room": {"shape": "room", "kind": "surfels", "points": 20},
    "patches of a rectangle": FLOOR,
    "points spread on a rectangle": {"shape": "rectangle", "kind": "surfels", "points": 20},
    "points of a sphere": {"shape": "sphere"},
    "patches of an icosphere": {"shape": "sphere", "kind": "mesh"},
    "points of a boulder": {"shape": "blob", "points": 50},
    "points of a torus knot": {"shape": "knot", "points": 50},
}
# For every key of an object values of all sorts: whether they are right is for the loader and the schema to agree on.
VALUES = {
    "file": ["mesh.ply", 3],
    "shape": ["box", "ball", 3],
    "kind": ["mesh", "surfels", "both", True],
    "patch_area": [0.5, 0, -1.0, "0.5", [1.0]],
    "points": [42, 1, 42.5, "42", [42]],
    "thin": [2, 1, 2.5, True],
    "orient": [True, 1, "yes"],
    "rooms": [False, True, 0],
    "seed": [7, -1, 7.5, "7"],
    "scale": [2, 0.5, 0, -1.0, "2", V],
    "rotate": [V, [1, 2], 90, ["a", "b", "c"]],
    "translate": [V, [1, 2], 90],
    "up": [[0, 1, 0], [0, 1], "z"],
    "viewpoint": [V, [1, 2], 3],
    "clean": [True, False, 1, "yes"],
    "reflectance": [
        0.3,
        [0.1, 0.2, 0.3],
        1.0,
        -0.1,
        [0.1, 0.2],
        "grey",
        {"pattern": "checker", "colors": [[0.1] * 3, [0.2] * 3], "size": 0.5, "seed": 1},
        {"pattern": "checker", "colors": [[0.1] * 3, [0.2] * 3], "sise": 0.5},
        {"pattern": "checker", "colors": [[0.1] * 3]},
        {"pattern": "stripes", "colors": [[0.1] * 3, [0.2] * 3]},
        {"pattern": "marble"},
    ],
    "emission": [3.0, V, -1, [1, 2], "bright"],
    "specular": [0.2, [0.1, 0.2, 0.3], 1.0, -0.1, "shiny"],
    "exponent": [5, 0, -1, "5"],
    "two_sided": [True, "sheets", "both", 1],
    "size": [2.0, V, 0, [1, 2], "2"],
    "patches": [2, [2, 2], [2, 2, 2], 0, 2.5, "2"],
    "corner": [V, [1, 2], 3],
    "edge_u": [[2, 0, 0], [1, 2], 3],
    "edge_v": [[0, 2, 0], [1, 2], 3],
    "radius": [2.0, 0, "2"],
    "bumps": [0.1, 1.0, "0.1"],
    "tube": [0.1, 0, "0.1"],
    "swelling": [0.1, 1.0, "0.1"],
    "windings": [[2, 5], [2], [2.5, 5], 2],
    "walls": [{"left": 0.2, "ceiling": [0.1, 0.2, 0.3]}, {"top": 0.2}, {"left": 1.5}, 0.2],
    "colour": [0.5],
}
LIGHTS = {
    "point": {"position": V, "intensity": 1},
    "spot": {"position": V, "direction": V, "intensity": 1},
    "photometric": {"position": V, "photometry": "lamp.ies"},
    "area": {"corner": V, "edge_u": [1, 0, 0], "edge_v": [0, 1, 0], "exitance": 1},
    "directional": {"direction": V, "irradiance": 1},
    "environment": {"radiance": 1},
}
LIGHT_VALUES = {
    **{key: [V, [1, 2], "x"] for key in ("position", "direction", "corner", "edge_u", "edge_v", "up")},
    **{key: [2, V, -1, [1, 2], "x"] for key in ("intensity", "exitance", "irradiance", "radiance")},
    "edge_u": [[3, 0, 0], 3],
    "edge_v": [[0, 3, 0], 3],
    "cone": [60, 0, 400, "60"],
    "penumbra": [3, -1, "3"],
    "azimuth": [30, "north"],
    "image": ["sky.hdr", 3],
    "photometry": ["lamp.ies", 3],
    "color": [1],
}
CAMERA = {"eye": [0, -3, 1], "target": [0, 0, 0]}
CAMERA_VALUES = {
    "eye": [[0, -4, 1], 3, [1, 2]],
    "target": [[0, 0, 1], "x"],
    "up": [[0, 1, 1], 3],
    "fov": [30, 0, 180, "wide"],
    "height": [2, 0, "2"],
    "lens": [35],
}
SOLVE_VALUES = {
    "error": [0.02, 0, 1, "1%"],
    "seconds": [20, 0, "20"],
    "transport": ["rays", "light"],
    "zeta": [0.05, 0, "fine"],
    "insert": [False, 0],
    "tolerance": [1e-3, 1],
    "max_surfels": [1000, 0, 1.5],
    "rays": [64, 8, 64.5],
    "probes": [8, 0],
    "shadow_rays": [128, "many"],
    "epsilon": [0.5, 1],
    "max_memory": [1e9, 0],
    "seed": [3, -1],
    "threads": [2],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes")
    head = ["ply", "format ascii 1.0", "element vertex 5", *(f"property float {k}" for k in "xyz")]
    head += ["element face 3", "property list uchar int vertex_indices", "end_header"]
    body = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 1 1", "3 0 1 2", "3 0 2 3", "3 0 3 4"]
    (folder / "mesh.ply").write_text("\n".join([*head, *body]) + "\n")
    (folder / "lamp.ies").write_text("TILT=NONE\n1 100 1 2 1 1 2 0 0 0 1 1 5 0 90 0 9 0\n")
    sf.write_image(folder / "sky.hdr", [[[1.0, 1.0, 1.0]] * 4] * 2)
    return folder


def agree(folder, data):
    """Whether both take the tables; where they do not agree, what they say."""
    try:
        make_scene(folder / "scene.toml", data)
        said = ""
    except FileError as error:
        said = str(error)
    faults = [fault.message for fault in VALIDATOR.iter_errors(data)]
    assert bool(said) == bool(faults), f"{data}\nloader: {said or 'takes it'}\nschema: {faults or 'takes it'}"
    return not said


SLOW = "points of a boulder", "points of a torus knot"  # which are sampled anew for every value


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param(o, marks=[pytest.mark.slow] * (o in SLOW)) for o in OBJECTS])
def test_an_object_has_the_keys_and_types_that_the_loader_takes(folder, name):
    least = OBJECTS[name]
    assert agree(folder, {"object": [least]})
    taken = {key for key in VALUES for value in VALUES[key] if agree(folder, {"object": [{**least, key: value}]})}
    assert set(least) - {"shape"} <= taken
    assert "colour" not in taken


def test_one_key_asks_for_another(folder):
    assert agree(folder, {"object": [{**FLOOR, "orient": True, "rooms": True}]})
    assert not agree(folder, {"object": [{**FLOOR, "rooms": True}]})
    assert not agree(folder, {"object": [{"shape": "box", "patches": 4, "thin": 9, "walls": {"left": 0.1}}]})
    assert not agree(folder, {"object": [{"kind": "mesh"}]})
    assert not agree(folder, {"object": [{"shape": "blob", "kind": "mesh"}]})
    assert not agree(folder, {"object": [{"shape": "box", "kind": "surfels"}]})


@pytest.mark.parametrize("kind", LIGHTS)
def test_a_light_has_the_keys_and_types_that_the_loader_takes(folder, kind):
    least = {"type": kind, **LIGHTS[kind]}
    assert agree(folder, {"object": [FLOOR], "light": [least]})
    for key in LIGHTS[kind]:
        assert not agree(folder, {"object": [FLOOR], "light": [{k: v for k, v in least.items() if k != key}]})
    for key, values in LIGHT_VALUES.items():
        for value in values:
            agree(folder, {"object": [FLOOR], "light": [{**least, key: value}]})


def test_an_environment_has_an_image_or_a_radiance(folder):
    assert agree(folder, {"object": [FLOOR], "light": [{"type": "environment", "image": "sky.hdr"}]})


@pytest.mark.parametrize(("table", "least", "values"), [("camera", CAMERA, CAMERA_VALUES), ("solve", {}, SOLVE_VALUES)])
def test_a_camera_and_solve_have_the_keys_and_types_that_the_loader_takes(folder, table, least, values):
    for key, several in values.items():
        for value in several:
            agree(folder, {"object": [FLOOR], table: {**least, key: value}})
    assert not agree(folder, {"object": [FLOOR], "camera": {"eye": V}})
    assert not agree(folder, {"object": [FLOOR], "solve": {"error": 0.02, "rays": 64}})


@pytest.mark.parametrize(
    "data",
    [
        {},
        {"object": []},
        {"object": FLOOR},
        {"object": [FLOOR], "name": 3},
        {"object": [FLOOR], "units": ["m"]},
        {"object": [FLOOR], "lights": []},
        {"object": [FLOOR], "light": {"type": "point"}},
        {"object": [FLOOR], "light": [{"type": "laser"}]},
        {"object": [FLOOR], "camera": []},
        {"object": [FLOOR], "solve": 3},
    ],
)
def test_faults_of_the_file_as_a_whole(folder, data):
    assert not agree(folder, data)


def keys_that_the_loader_asks_for(folder, data, table):
    """What "is not a key here; there is ..." lists, when a table has a key that is not one."""
    table["zz"] = 1
    with pytest.raises(FileError, match="is not a key here; there is ") as error:
        make_scene(folder / "scene.toml", data)
    return set(re.split(", ", str(error.value).partition("there is ")[2]))


def test_no_key_of_the_loader_is_unknown_here(folder):
    """A key that is added to the loader has to come into the schema, and into the values above."""
    asked = set()
    for least in OBJECTS.values():
        table = dict(least)
        asked |= keys_that_the_loader_asks_for(folder, {"object": [table]}, table)
    variants = SCHEMA["$defs"]["object"]["oneOf"]
    assert {key for variant in variants for key in variant["properties"]} == asked == set(VALUES) - {"colour"}
    lights = {light["properties"]["type"]["const"]: light["properties"] for light in SCHEMA["$defs"]["light"]["oneOf"]}
    assert {kind: set(keys) - {"type"} for kind, keys in lights.items()} == {k: set(v) for k, v in LIGHT_KEYS.items()}
    assert {key for keys in LIGHT_KEYS.values() for key in keys} == set(LIGHT_VALUES) - {"color"}
    for name, values in (("camera", CAMERA_VALUES), ("solve", SOLVE_VALUES)):
        table = dict(CAMERA) if name == "camera" else {}
        asked = keys_that_the_loader_asks_for(folder, {"object": [FLOOR], name: table}, table)
        assert set(SCHEMA["$defs"][name]["properties"]) == asked == set(values) - {"lens", "threads"}
    assert set(SCHEMA["$defs"]["solve"]["properties"]) == set(OPTIONS)
    top = {"object": [FLOOR]}
    assert set(SCHEMA["properties"]) == keys_that_the_loader_asks_for(folder, top, top)
    assert set(SCHEMA["$defs"]["pattern"]["properties"]["pattern"]["enum"]) == set(PATTERNS)
    shapes = [variant["properties"].get("shape", {}) for variant in variants]
    assert {name for shape in shapes for name in shape.get("enum", [shape.get("const")])} - {None} == set(SHAPES)


@pytest.mark.parametrize("path", sorted(DATA.glob("*.toml")), ids=lambda path: path.stem)
def test_the_scene_files_here_are_right_by_it(path):
    assert [fault.message for fault in VALIDATOR.iter_errors(tomllib.loads(path.read_text()))] == []


def test_it_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
