"""Every argument of the public face refuses what it cannot take, and says its own name."""

from functools import partial

import numpy as np
import pytest

import surflux as sf
from refused import COLORS, COUNTS, INF, NAN, NEVER, NUMBERS, RHO, VECTORS, cases, says_its_name
from surflux.drawing import plots

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
UP = [[0, 0, 1]] * 4
SQUARE = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])


def surfels(points=POINTS, normals=UP, radii=1.0, **options):
    return sf.Surfels(points, normals, radii=radii, **options)


def point(position=(0, 0, 0), intensity=1):
    return sf.PointLight(position, intensity)


def spot(position=(0, 0, 0), direction=(0, 0, 1), intensity=1, **options):
    return sf.SpotLight(position, direction, intensity, **options)


def lamp(corner=(0, 0, 0), edge_u=(1, 0, 0), edge_v=(0, 1, 0), exitance=1):
    return sf.AreaLight(corner, edge_u, edge_v, exitance)


def sun(direction=(0, 0, -1), irradiance=1):
    return sf.DirectionalLight(direction, irradiance)


def mesh(patch_area=None, vertices=SQUARE[0], faces=SQUARE[1], **options):
    return sf.Surfels.from_mesh((vertices, faces), patch_area, **options)


def sample(n=10, **options):
    return sf.Surfels.sample_mesh(SQUARE, n, **options)


def thinned(n=2, seed=0):
    return surfels().thinned(n, seed)


def areas_of(s=None, **options):
    return sf.effective_areas(surfels() if s is None else s, **options)


def set_areas(areas):
    surfels().areas = areas


def picked(selection):
    return surfels()[selection]


def solved(scene=None, **options):
    return sf.solve(sf.Scene([surfels(areas=1.0)]) if scene is None else scene, **options)


def meshless(scene=None, **options):
    return sf.solve_meshless(sf.Scene([surfels(areas=1.0)]) if scene is None else scene, **options)


def factors(scene=None, **options):
    return sf.form_factors(sf.Scene([surfels(areas=1.0)]) if scene is None else scene, **options)


def scene(objects=None, lights=(), **options):
    return sf.Scene([surfels()] if objects is None else objects, lights, **options)


def plotted(color="radius", **options):
    return plots.plot(surfels(), color=color, **options)


REFUSED = [
    (surfels, "points", [*VECTORS, np.zeros((0, 3)), np.zeros((3, 2)), [[0, 0, NAN]], [["a", "b", "c"]], [[0, 0, 1j]]]),
    (
        surfels,
        "normals",
        [*NEVER[:1], *NEVER[2:], [[0, 0, 1]] * 3, [[0, 0, 0]] * 4, [[0, 0, NAN]] * 4, [[INF, 0, 0]] * 4],
    ),
    (surfels, "radii", [*COLORS, 0.0, [1, 1, 1], [1, 1, 1, 0], [1, 1, 1, -1], [1, 1, 1, NAN], np.ones((4, 1))]),
    (surfels, "areas", [*COLORS, [1, 1, 1], [1, 1, 1, -1], [1, 1, 1, NAN]]),
    (surfels, "reflectance", [*(v for v in COLORS if v is not None), *RHO, [0.1] * 5, [[0.5] * 3] * 3]),
    (surfels, "reflectance", [[[0.5] * 3] * 3 + [[1.0] * 3]]),
    (surfels, "emission", [*COLORS, [1, 1, 1, -1], [[1, 1, INF]] * 4, None]),
    (surfels, "specular", [*COLORS, None, *RHO, [0.1] * 5, 0.5]),
    (surfels, "exponent", [*NUMBERS, None, [1, 2, 3], -1, 2e6]),
    (surfels, "viewpoint", [v for v in VECTORS if v is not None]),
    (surfels, "two_sided", [1, 0, None, "yes"]),
    (set_areas, "areas", [[1, 2, 3], [1, 1, 1, -1], [1, 1, 1, NAN], "text", True, np.ones((4, 3))]),
    (picked, "selection", [[True] * 3, np.zeros(0, bool), [0.5], "a", None, np.zeros((2, 2), int), [[]], True]),
    (mesh, "patch_area", [*NUMBERS, 0.0, -1.0]),
    (mesh, "reflectance", [*(v for v in COLORS if v is not None), *RHO, [0.5, 0.5]]),
    (mesh, "emission", [*(v for v in COLORS if v is not None), [1.0, 1.0]]),
    (mesh, "specular", [*COLORS, None, *RHO, [0.1, 0.1]]),
    (mesh, "exponent", [*NUMBERS, None, -1]),
    (mesh, "two_sided", [1, None, "leaves"]),
    (sample, "n", [*COUNTS, None]),
    (sample, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (sample, "reflectance", [*(v for v in COLORS if v is not None), *RHO[:3]]),
    (sample, "emission", [v for v in COLORS if v is not None]),
    (sample, "specular", [*COLORS, None, *RHO[:3]]),
    (sample, "exponent", [*NUMBERS, None, -1]),
    (thinned, "n", [*COUNTS, None, 5]),
    (thinned, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (areas_of, "s", [POINTS, "text", 3]),
    (areas_of, "method", ["best", None, 1, "curved "]),
    (areas_of, "backend", ["gpu", None, 1]),
    (areas_of, "kappa", [*NUMBERS, None, 0.0, -1]),
    (areas_of, "resolution", [*COUNTS, None, 1025]),
    (areas_of, "epsilon", [*NUMBERS, None, 1.5, -1.5]),
    (areas_of, "threads", [0, -1, 1.5, True, "2"]),
    (areas_of, "progress", [None, 1, "yes"]),
    (point, "position", VECTORS),
    (point, "intensity", [*COLORS, None]),
    (spot, "position", VECTORS),
    (spot, "direction", [*VECTORS, [0, 0, 0]]),
    (spot, "intensity", [*COLORS, None]),
    (spot, "cone", [*NUMBERS, None, 0, -10, 361]),
    (spot, "penumbra", [*NUMBERS, None, -1, 46]),
    (lamp, "corner", VECTORS),
    (lamp, "edge_u", [*VECTORS, [0, 0, 0]]),
    (lamp, "edge_v", [*VECTORS, [0, 0, 0], [1, 0, 0], [1, 1, 0]]),
    (lamp, "exitance", [*COLORS, None]),
    (sun, "direction", [*VECTORS, [0, 0, 0]]),
    (sun, "irradiance", [*COLORS, None]),
    (
        sf.Environment,
        "image_or_rgb",
        [None, object(), [], [1, 2], -1, NAN, True, 1j, np.zeros((2, 2)), np.zeros((0, 4, 3))],
    ),
    (sf.Environment, "image_or_rgb", [np.full((2, 4, 3), NAN), np.full((2, 4, 3), -1.0), np.zeros((2, 4, 4))]),
    (scene, "objects", [[], surfels(), [surfels(), 3], "text", 5, [[surfels()]], {"a": surfels()}]),
    (scene, "lights", [5, "sun", [5], [surfels()], point(), None]),
    (scene, "camera", [5, "front", (0, 0, 1)]),
    (scene, "name", [5, None]),
    (scene, "solve_options", [5, [("zeta", 1)], {1: 2}]),
    (solved, "scene", [surfels(), [surfels()], "room.toml", 5]),
    (solved, "zeta", [*NUMBERS, None, 0.0, -1]),
    (solved, "insert", [1, 0, None, "yes"]),
    (solved, "tolerance", [*NUMBERS, None, 0.0, 1.0, -1]),
    (solved, "max_surfels", [v for v in COUNTS if v != 1] + [0]),
    (solved, "rays", [*COUNTS, None, 15]),
    (solved, "probes", [v for v in COUNTS if v != 1] + [None, 0]),
    (solved, "shadow_rays", [*COUNTS, None, 0, 15]),
    (solved, "epsilon", [*NUMBERS, None, 0.0, 1.0, -1]),
    (solved, "max_memory", [*NUMBERS, 0.0, -1]),
    (solved, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (solved, "threads", [0, -1, 1.5, True, "2"]),
    (solved, "progress", [None, 1, "yes"]),
    (meshless, "scene", [surfels(), [surfels()], "room.toml", 5]),
    (meshless, "levels", [v for v in COUNTS if v != 1] + [None, 0, 11]),
    (meshless, "radius", [*NUMBERS, 0.0, -1]),
    (meshless, "epsilon_e", [*NUMBERS, None, 0.0, -1]),
    (meshless, "epsilon_omega", [*NUMBERS, None, 0.0, -1]),
    (meshless, "rays", [*COUNTS, None, 15, 65536]),
    (meshless, "bounces", [v for v in COUNTS if v != 1]),
    (meshless, "indirect_only", [1, 0, None, "yes"]),
    (meshless, "tolerance", [*NUMBERS, None, 0.0, 1.0, -1]),
    (meshless, "probes", [v for v in COUNTS if v != 1] + [None, 0]),
    (meshless, "shadow_rays", [*COUNTS, None, 0, 15]),
    (meshless, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (meshless, "threads", [0, -1, 1.5, True, "2"]),
    (meshless, "progress", [None, 1, "yes"]),
    (factors, "scene", [surfels(), [surfels()], "room.toml", 5]),
    (factors, "visibility", [1, 0, None, "yes"]),
    (factors, "return_escape", [1, 0, None, "yes"]),
    (factors, "error", [*NUMBERS, None, 0.0, 1e-7, 1.1]),
    (factors, "rays", [*COUNTS, None, 15]),
    (factors, "epsilon", [*NUMBERS, None, 0.0, 1.0, -1]),
    (factors, "seed", [-1, 0.5, "0", True, None, 2**64]),
    (factors, "threads", [0, -1, 1.5, True, "2"]),
    (factors, "progress", [None, 1, "yes"]),
    (plotted, "color", ["level", "colour", None, 3]),
    (plotted, "size", [800, (800,), (0, 600), (800.0, 600.0), (800, 600, 3)]),
    (plotted, "screenshot", ["picture.tiff", "picture", 3]),
]


@pytest.mark.parametrize(("function", "argument", "value"), list(cases(REFUSED)))
def test_refuses_with_the_name_of_the_argument(function, argument, value):
    says_its_name(function, argument, value)


def test_environment_refuses_its_up():
    for up in [*VECTORS, [0, 0, 0]]:
        with pytest.raises(ValueError, match=r"^up: wanted"):
            sf.Environment(1.0, up=up)


@pytest.mark.parametrize(
    "given",
    [
        {"vertices": [[0, 0, NAN], *SQUARE[0][1:]]},
        {"vertices": np.zeros((4, 2))},
        {"vertices": "text"},
        {"faces": [[0, 1, 2, 4]]},
        {"faces": [[0, 1, 2, -1]]},
        {"faces": [[0.0, 1.0, 2.0]]},
        {"faces": []},
        {"faces": [[0, 0, 1]]},
    ],
)
@pytest.mark.filterwarnings("ignore:.*degenerate")
def test_mesh_refusals_name_the_mesh(given):
    with pytest.raises(ValueError, match=r"^mesh"):
        mesh(**given)


@pytest.mark.parametrize("given", [5, "", [[0, 0, 0]], {"vertices": 1}, None])
def test_things_that_are_no_mesh(given):
    with pytest.raises((ValueError, sf.FileError)):
        sf.Surfels.from_mesh(given)


def test_messages_tell_what_came_and_what_was_wanted():
    with pytest.raises(ValueError, match=r"^points: wanted shape \(n, 3\), got \(3, 2\)$"):
        surfels(points=np.zeros((3, 2)))
    with pytest.raises(ValueError, match=r"^normals: wanted shape \(4, 3\), got \(3, 3\)$"):
        surfels(normals=[[0, 0, 1]] * 3)
    with pytest.raises(ValueError, match=r"^normals: wanted vectors of non-zero length, got \(0, 0, 0\) at index 2$"):
        surfels(normals=[[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 1]])
    with pytest.raises(ValueError, match=r"^reflectance: wanted values in \[0, 1\), got 1 at index \(0, 1\)$"):
        surfels(reflectance=[[0.5, 1.0, 0.5]] * 4)
    with pytest.raises(ValueError, match=r"^radii: must be given for a single point"):
        sf.Surfels([[0, 0, 0]], [[0, 0, 1]])
    with pytest.raises(ValueError, match=r"^normals: wanted .* plane cannot be fitted to 2 points"):
        sf.Surfels([[0, 0, 0], [1, 0, 0]])
    with pytest.raises(ValueError, match=r"^method: wanted one of .*, got 'best'$"):
        areas_of(method="best")
    with pytest.raises(ValueError, match=r"^backend: wanted one of 'auto', 'cpu', 'gl', got 'gpu'$"):
        areas_of(backend="gpu")
    with pytest.raises(ValueError, match=r"^n: wanted at most 4, for there are only 4 surfels; got 5$"):
        thinned(5)
    with pytest.raises(ValueError, match=r"^n: wanted at most 4, .*; got 10000000000$"):
        thinned(10**10)
    with pytest.raises(ValueError, match=r"^n: wanted at most 1, for there is only 1 surfel; got 2$"):
        sf.Surfels([[0, 0, 0]], UP[:1], radii=1.0).thinned(2)
    with pytest.raises(ValueError, match=r"^radii: wanted shape \(\) or \(1,\) for 1 surfel, got \(2,\)$"):
        sf.Surfels([[0, 0, 0]], UP[:1], radii=[1, 2])
    with pytest.raises(ValueError, match=r"^normals: .* fitted to 1 point; got None$"):
        sf.Surfels([[0, 0, 0]])


def test_what_does_not_go_together_in_a_solve():
    with pytest.raises(ValueError, match=r"^shadow_rays: wanted at least the 100 probes, got 64$"):
        solved(probes=100)
    with pytest.raises(ValueError, match=r"^return_escape: wanted visibility=True with it"):
        factors(visibility=False, return_escape=True)
    # 4 surfels, 4 x 4 pairs of 4 bytes; 63 bytes hold sqrt(63 / 4) = 3.97.
    with pytest.raises(ValueError, match=r"^scene: the exchange of all pairs of 4 .*at most 3 surfels fit"):
        solved(max_memory=63)
    assert len(solved(max_memory=64).surfels) == 4
    with pytest.raises(ValueError, match=r"^areas: surfel 2 has area 0, wanted a positive number$"):
        solved(sf.Scene([surfels(areas=[1, 1, 0, 1])]))
    scene = sf.Scene([surfels(), surfels(areas=[1, 0, 1, 1])])
    for refused in (solved, factors, sf.form_factor_operator, partial(sf.precompute_transfer, lighting="local")):
        with pytest.raises(ValueError, match=r"^areas: surfel 1 of object 1 has area 0, wanted a positive number$"):
            refused(scene)
    with pytest.raises(TypeError):
        solved(bounces=3)


PATHS = {
    "read": sf.read,
    "load_operator": sf.load_operator,
    "load_scene": sf.load_scene,
    "load_solution": sf.load_solution,
    "load_transfer": sf.load_transfer,
    "read_image": sf.read_image,
    "write_image": lambda path: sf.write_image(path, np.zeros((2, 2, 3))),
    "Surfels.save": lambda path: surfels().save(path),
    "Solution.save": lambda path: solved().save(path),
}


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("value", [3, None, 1.5, ["a.ply"]])
def test_what_is_no_path(name, value):
    with pytest.raises(ValueError, match=rf"^path: wanted a path, got {type(value).__name__}$"):
        PATHS[name](value)


MISSING = [("read", "none.ply"), ("read", "none.las"), ("read", "none"), ("load_scene", "none.toml")]
MISSING += [("load_solution", "none.ply"), ("load_solution", "none"), ("read_image", "none.exr")]
MISSING += [("load_operator", "none.npz"), ("Surfels.from_mesh", "none.obj"), ("Surfels.from_mesh", "none")]
MISSING += [("load_transfer", "none.transfer"), ("load_transfer", "none")]


@pytest.mark.parametrize(("name", "file"), MISSING)
def test_a_missing_file_has_the_same_words_everywhere(name, file, tmp_path):
    path = tmp_path / file
    for given in (path, str(path), bytes(path)):
        with pytest.raises(sf.FileError) as caught:
            (PATHS | {"Surfels.from_mesh": sf.Surfels.from_mesh})[name](given)
        assert str(caught.value) == f"{path}: no such file"


@pytest.mark.parametrize("name", ["Surfels.save", "Solution.save"])
@pytest.mark.parametrize("file", ["a.obj", "a", "a.ply.txt", b"a.las"])
def test_surfels_and_solutions_are_saved_under_names_of_their_formats(name, file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=r"^path: wanted a name ending in \.ply(, \.glb, \.gltf)?, got 'a"):
        PATHS[name](file)
    assert not list(tmp_path.iterdir())
    PATHS[name]("A.PLY")
    assert len(sf.read("A.PLY")) == 4


def test_an_index_past_the_end_is_an_index_error():
    for selection in (4, -5, [0, 4]):
        with pytest.raises(IndexError, match="out of range for 4 surfels"):
            picked(selection)


def test_arrays_are_read_only_and_lights_are_immutable():
    s = surfels(areas=1.0)
    for name in ("points", "normals", "radii", "areas", "reflectance", "emission", "triangles", "triangle_surfel"):
        array = getattr(s, name)
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    with pytest.raises(AttributeError):
        s.points = np.zeros((4, 3))
    with pytest.raises(AttributeError):
        point().intensity = 3
