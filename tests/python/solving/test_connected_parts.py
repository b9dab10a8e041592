"""What one part of a scene lacks of its energy, no other part makes up for."""

import warnings

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from quick import quick
from scenes import surfels_of
from surflux.scenes import shapes

SOLVERS = {
    "pairs": lambda scene, **knobs: sf.solve(scene, transport="pairs", insert=False, **knobs),
    "rays": lambda scene, **knobs: sf.solve(scene, transport="rays", **knobs),
    "meshless": lambda scene, **knobs: sf.solve_meshless(scene, levels=3, **knobs),
}
POWER = ("power_in", "power_absorbed", "power_escaped", "power_into_backs", "power_lost", "power_lost_error")
PARTS = ("parts", "largest_part_lost")


@pytest.fixture(params=SOLVERS)
def solver(request):
    return SOLVERS[request.param]


def glowing_spheres():
    """Coarse ones, whose disks stand off them and whose rays' noise is large, a thousand times as bright."""
    coarse = [(150, [10.0, 0.0, 0.0]), (100, [12.5, 0.0, 0.0])]
    return [surfels_of(shapes.sphere(n).points + at, shapes.sphere(n).normals, 0.5, 1000.0) for n, at in coarse]


def mean_radiosity(solution, surfels):
    """Of the scene's first surfels."""
    own = solution.parents < surfels
    return np.average(solution.radiosity[own, 0], weights=solution.surfels.areas[own])


@pytest.mark.parametrize("rho", quick(0.99, of=[0.9, 0.97, 0.99, 0.993, 0.999]))
def test_furnace_beside_bright_spheres_is_exact(solver, rho):
    """E = 1 - rho makes B = 1. A factor for the energy of the whole scene made .11 to 1.25 of it at rho = .99."""
    room = cube_inside(10, rho, 1 - rho)
    # A residual counts 1 / (1 - rho) times.
    solution = solver(sf.Scene([room, *glowing_spheres()]), tolerance=1e-6 * (1.0 - rho))
    own = solution.parents < len(room)
    np.testing.assert_allclose(solution.radiosity[own], 1.0, atol=1e-6)
    assert solution.history[-1]["parts"] >= 2


@pytest.mark.parametrize("points", [300, 1000])
def test_furnace_around_a_ball_is_exact(solver, points):
    """Of a closed room and a closed ball nobody sees a back: at rho = .999 what they took would add up 1000 times."""
    ball = surfels_of(
        0.25 * shapes.sphere(points).points + [0.5, 0.45, 0.4], shapes.sphere(points).normals, 0.999, 1e-3
    )
    solution = solver(sf.Scene([cube_inside(6, 0.999, 1e-3), ball]))
    assert solution.history[-1]["power_into_backs"] == 0.0
    # Shares of hemispheres are sums of floats in the meshless basis: 1e-7 of them, 1000 times.
    np.testing.assert_allclose(solution.radiosity, 1.0, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("rho", [0.95, 0.99])
def test_lit_room_has_the_light_that_it_has_alone(solver, rho):
    """A wall glows: light is reflected twenty or a hundred times before it is absorbed."""
    glowing = np.zeros(600)
    glowing[:100] = 1.0
    room = cube_inside(10, rho, glowing)
    alone, beside = (solver(sf.Scene(objects), seed=2) for objects in ([room], [room, *glowing_spheres()]))
    # The mean of B over the room is sum A E / (sum A (1 - rho)): energy alone decides it.
    for solution in (alone, beside):
        assert mean_radiosity(solution, len(room)) == pytest.approx(1.0 / 6 / (1.0 - rho), rel=1e-3)
        assert solution.history[-1]["largest_part_lost"] < 1e-3


def ball_on_a_floor():
    unit = shapes.sphere(1500)
    ball = surfels_of(0.5 * unit.points + [0, 0, 0.6], unit.normals, 0.6)
    corners = [[-4, -4, 0], [4, -4, 0], [4, 4, 0], [-4, 4, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.04, reflectance=0.6)
    return sf.Scene([ball, floor], [sf.AreaLight([-0.5, -0.5, 4], [0, 1, 0], [1, 0, 0], 30.0)])


def escape_from(surfels):
    """What of each hemisphere is open in ball_on_a_floor(): in closed form from the floor, by rays from the ball."""
    p, n = surfels.points, surfels.normals
    away = p - [0, 0, 0.6]
    escape = 1 - 0.6 * 0.25 / np.linalg.norm(away, axis=1) ** 3
    ball = p[:, 2] > 0.05
    # Unit vectors plus the normal are distributed by cosine.
    u = shapes.sphere(2000).points + n[ball][:, None]
    down = u[..., 2] < 0
    with np.errstate(divide="ignore", invalid="ignore"):
        end = p[ball][:, None, :2] - u[..., :2] * (p[ball][:, None, 2:] / u[..., 2:])
    escape[ball] = 1 - (down & (np.abs(end) < 4).all(axis=2)).mean(axis=1)
    return escape


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
@pytest.mark.parametrize("transport", quick("rays", of=["rays", "meshless"]))
def test_account_of_an_open_scene_is_a_check(transport, seed):
    """Three fifths of the light leave it. That is counted by senders, and not taken to be what receivers lack."""
    scene = ball_on_a_floor()
    solution = SOLVERS[transport](scene, seed=seed, **({"insert": False} if transport == "rays" else {}))
    figures = solution.history[-1]
    error = figures["power_lost_error"]
    assert 0.0 < error < 1e-3 * figures["power_in"]
    assert abs(figures["power_lost"]) <= 1e-3 * figures["power_in"] + 3 * error
    escaped = (solution.surfels.areas * escape_from(solution.surfels) * solution.radiosity.sum(axis=1)).sum()
    assert abs(figures["power_escaped"] - escaped) <= 1e-3 * figures["power_in"] + 3 * error


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
@pytest.mark.parametrize("transport", quick("rays", of=["rays", "meshless"]))
def test_ball_on_an_open_floor_is_as_bright_as_path_tracing_says(transport, seed):
    """Nearly all light leaves the floor for the sky. What little the ball gets is known by its own rays."""
    scene = ball_on_a_floor()
    solution = SOLVERS[transport](scene, seed=seed)
    own = solution.parents < 1500
    s, places = solution.surfels[own], np.arange(0, own.sum(), 3)
    truth, error = sf.reference_irradiance(scene, s.points[places], s.normals[places], samples=1024, seed=7)
    direct = solution.direct[own][places]
    found = (solution.irradiance[own][places] - direct)[:, 0].mean()
    expected = (truth - direct)[:, 0].mean()
    noise = np.sqrt((error[:, 0] ** 2).sum()) / len(places)
    assert abs(found - expected) <= 0.02 * expected + 3 * noise


@pytest.mark.slow
@pytest.mark.parametrize("transport", ["rays", "meshless"])
def test_open_floor_has_the_light_that_the_ball_sends(transport):
    """By reciprocity that is known by the ball, while few rays of the floor meet it: it was 2.4 % too bright."""
    scene = ball_on_a_floor()
    ball = scene.objects[0]
    truth, _ = sf.reference_irradiance(scene, ball.points, ball.normals, samples=4096, seed=5)
    areas = sf.effective_areas(ball)
    met = 1.0 - escape_from(ball)
    expected = (areas * met * 0.6 * truth[:, 0]).sum()
    found = []
    for seed in range(6):
        solution = SOLVERS[transport](scene, seed=seed)
        floor = solution.parents >= len(ball)
        indirect = (solution.irradiance - solution.direct)[floor, 0]
        found.append((solution.surfels.areas[floor] * indirect).sum())
    assert np.mean(found) == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_every_solver_says_where_the_power_went(solver):
    scene = sf.Scene([cube_inside(8, 0.6)], [sf.PointLight([0.5, 0.4, 0.7], 3.0)])
    solution = solver(scene)
    figures, s = solution.history[-1], solution.surfels
    assert {*POWER, *PARTS} <= set(figures)
    absorbed = (s.areas[:, None] * (1 - s.reflectance) * solution.irradiance).sum()
    assert figures["power_absorbed"] == pytest.approx(absorbed, rel=1e-6)
    assert figures["power_in"] == pytest.approx((s.areas[:, None] * solution.direct).sum(), rel=1e-6)
    assert abs(figures["power_lost"]) < 1e-3 * figures["power_in"]
    assert figures["parts"] == 1


@pytest.mark.slow
def test_figures_are_numbers_also_of_what_is_buried(solver):
    """A ball within a solid box has no outside: it is a part of its own, of no area that light could reach."""
    vertices, faces, _ = shapes.box(0.4, 4, inward=False)
    box = sf.Surfels.from_mesh((vertices + np.full(3, 0.3), faces), reflectance=0.5)
    buried = surfels_of(0.1 * shapes.sphere(60).points + [0.5, 0.5, 0.5], shapes.sphere(60).normals, 0.5)
    scene = sf.Scene([cube_inside(6, 0.5), box, buried], [sf.PointLight([0.5, 0.5, 0.9], 1.0)])
    for figures in solver(scene).history:
        assert all(np.isfinite(value) for value in figures.values()), figures


def test_backs_that_take_much_of_the_light_are_warned_of(solver):
    """The ceiling faces up: a sixth of what the other walls send meets its back, and more with every bounce."""
    room = cube_inside(6, 0.5)
    floor_and_walls, ceiling = room[:180], room[180:]
    turned = sf.Surfels.from_mesh(([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[0, 1, 2, 3]]), 1 / 36)
    lamp = [sf.PointLight([0.5, 0.4, 0.5], 3.0)]
    with pytest.warns(UserWarning, match=r"backs of surfaces absorb \d\d% of the light"):
        solver(sf.Scene([floor_and_walls, turned], lamp))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solver(sf.Scene([floor_and_walls, ceiling], lamp))


def test_what_glows_beneath_a_box_shines_into_its_backs(solver):
    """By solve_meshless it was "lost by the solver", for which more rays were to help."""
    corners = [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.04, reflectance=0.3, emission=1.0)
    vertices, faces, _ = shapes.box(1.0, 1)
    box = sf.Surfels.from_mesh((vertices - np.array([0.5, 0.5, 0.0]), faces), 0.04, reflectance=0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        power = solver(sf.Scene(sf.divide_patches([floor, box]))).history[-1]
    assert power["power_into_backs"] == pytest.approx(power["power_in"] / 16, rel=0.01)
    assert abs(power["power_lost"]) < 0.002 * power["power_in"]
