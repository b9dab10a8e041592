"""Copies and pickles of all that a user holds are equal to it, and stand by themselves."""

import copy
import pickle

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

WAYS = {"pickle": lambda thing: pickle.loads(pickle.dumps(thing)), "copy": copy.copy, "deepcopy": copy.deepcopy}
ARRAYS = ("points", "normals", "radii", "areas", "reflectance", "emission", "triangles", "triangle_surfel")
LIGHTS = [
    sf.PointLight([0, 0, 3], 1.0),
    sf.AreaLight([0, 0, 3], [1, 0, 0], [0, 1, 0], [1.0, 0.5, 0.2]),
    sf.DirectionalLight([0, 0, -1], 1.0),
    sf.Environment(np.full((4, 8, 3), 0.25)),
]


@pytest.fixture(params=WAYS)
def twin(request):
    return WAYS[request.param]


@pytest.fixture(scope="module")
def scene():
    ball = shapes.sphere(162)
    floor = sf.Surfels.from_mesh(([[-2, -2, -1], [2, -2, -1], [2, 2, -1], [-2, 2, -1]], [[0, 1, 2, 3]]), 0.5, 0.7)
    camera = sf.Camera([0, -5, 2], [0, 0, 0])
    return sf.Scene([ball, floor], LIGHTS, camera=camera, name="a ball", solve_options={"zeta": 0.1})


def assert_alike(a, b):
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


def test_surfels(twin):
    for s in (shapes.sphere(162), sf.Surfels.from_mesh(shapes.box(patches=2)[:2])):
        other = twin(s)
        assert_alike(other, s)
        before = s.areas
        other.areas = 3.0
        assert (s.areas is None) == (before is None)
        assert before is None or np.array_equal(s.areas, before)
        assert other.areas.tolist() == [3.0] * len(s)


def test_scenes_solve_to_the_same_bits(scene, twin):
    other = twin(scene)
    assert (other.name, other.camera, other.solve_options) == (scene.name, scene.camera, scene.solve_options)
    for a, b in zip(other.objects, scene.objects, strict=True):
        assert_alike(a, b)
    found, wanted = sf.solve(other), sf.solve(scene)
    np.testing.assert_array_equal(found.radiosity, wanted.radiosity)
    other.name = "another"
    assert scene.name == "a ball"


@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_lights_and_cameras(light, twin):
    other = twin(light)
    assert type(other) is type(light)
    for name, value in vars(light).items():
        np.testing.assert_array_equal(vars(other)[name], value, err_msg=name)
    camera = sf.Camera([0, -5, 2], [0, 0, 0])
    assert twin(camera) == camera


@pytest.mark.slow
@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_solutions(scene, twin, solver):
    solution = solver(scene)
    other = twin(solution)
    assert_alike(other.surfels, solution.surfels)
    for name in ("radiosity", "irradiance", "direct", "levels", "parents", "objects"):
        np.testing.assert_array_equal(getattr(other, name), getattr(solution, name), err_msg=name)
    assert (other.error, other.history, other.timings) == (solution.error, solution.history, solution.timings)
    places = solution.surfels.points[:20], solution.surfels.normals[:20]
    for direct in ("interpolated", "traced"):
        np.testing.assert_array_equal(
            other.irradiance_at(*places, direct=direct), solution.irradiance_at(*places, direct=direct)
        )
    other.camera = None
    assert solution.camera == scene.camera


@pytest.fixture(scope="module", params=[True, pytest.param(False, marks=pytest.mark.slow)])
def divided_by_a_wall(request):
    """A meshless solution, indirect_only or not, with functions that a wall ends."""
    floor = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]
    wall = [[0, -1, 0], [0, 1, 0], [0, 1, 1], [0, -1, 1]], [[0, 1, 2, 3], [3, 2, 1, 0]]
    objects = [sf.Surfels.from_mesh(mesh, 0.1, 0.7) for mesh in (floor, wall)]
    ball = shapes.sphere(162)
    objects.append(sf.Surfels(0.3 * ball.points + [0.5, 0.0, 0.5], ball.normals))
    camera = sf.Camera([-2, -3, 2], [0, 0, 0.3])
    lights = [sf.PointLight([-0.5, 0.2, 0.8], 1.0), sf.Environment(0.1)]
    solution = sf.solve_meshless(sf.Scene(objects, lights, camera=camera), indirect_only=request.param, levels=3)
    assert len(solution._field.basis.functions()["cut"]) > 0
    return solution


@pytest.mark.slow
def test_meshless_solutions_keep_their_basis(twin, divided_by_a_wall):
    """Functions, their coefficients and the walls that end them, between surfels and in pictures; also of a twin's."""
    solution = divided_by_a_wall
    places = np.column_stack([np.random.default_rng(0).uniform(-1, 1, (200, 2)), np.zeros(200)])
    up = np.tile([0.0, 0.0, 1.0], (200, 1))
    for other in (twin(solution), twin(twin(solution))):
        for direct in ("interpolated", "traced"):
            found, wanted = (s.irradiance_at(places, up, direct) for s in (other, solution))
            np.testing.assert_array_equal(found, wanted)
            found, wanted = (s.render(size=(40, 30), samples=1, direct=direct) for s in (other, solution))
            np.testing.assert_array_equal(found, wanted)


def test_what_holds_arrays_compares_by_contents_and_hashes():
    s = shapes.sphere(162)
    one, two, other = sf.area_shares(s, 3), sf.area_shares(s, 3), sf.area_shares(s, 4)
    assert one == two
    assert one != other
    assert len({one, two, other}) == 2


def test_patches_of_the_sky_are_copied(twin):
    patches = sf.SkyPatches(577)
    other = twin(patches)
    np.testing.assert_array_equal(other.directions, patches.directions)
    assert other is not patches


def test_hierarchies_are_copied(twin):
    tree = sf.build_hierarchy(shapes.sphere(162))
    other = twin(tree)
    assert other.counts == tree.counts
    np.testing.assert_array_equal(other.levels[0], tree.levels[0])


def test_a_meshless_solution_of_a_cloud_is_the_same_from_a_pickle():
    """Clouds repeat levels, of which one may have no points at all."""
    unit = shapes.sphere(1500)
    cloud = sf.Surfels(unit.points, -unit.normals, reflectance=0.5)[unit.points[:, 2] < 0.8]
    scene = sf.Scene([cloud], [sf.PointLight([0, 0, -0.97], 1.0)])
    solution = sf.solve_meshless(scene, levels=3, rays=32)
    again = pickle.loads(pickle.dumps(solution))
    at, facing = cloud.points[::100], cloud.normals[::100]
    assert np.array_equal(again.irradiance_at(at, facing), solution.irradiance_at(at, facing))
