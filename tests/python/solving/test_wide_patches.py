"""A furnished room each of whose walls is one patch: what few rays or places say of it is the light of all the room."""

import numpy as np
import pytest

import surflux as sf
from scenes import cell
from surflux.scenes import shapes

SIZE = np.array([6.0, 5.0, 3.0])
FURNITURE = [  # low corner and size; all stand on the floor
    ([0.6, 0.7, 0.0], [0.8, 0.5, 0.7]),
    ([2.0, 0.5, 0.0], [0.4, 0.6, 0.5]),
    ([3.2, 0.9, 0.0], [0.6, 0.7, 0.3]),
    ([4.6, 0.6, 0.0], [0.5, 0.5, 0.8]),
    ([1.0, 2.2, 0.0], [0.6, 0.6, 0.4]),
    ([2.6, 2.0, 0.0], [0.7, 0.3, 0.6]),
    ([4.0, 2.4, 0.0], [0.8, 0.6, 0.5]),
    ([1.4, 3.7, 0.0], [0.5, 0.7, 0.7]),
    ([3.1, 3.6, 0.0], [0.4, 0.4, 0.3]),
    ([4.8, 3.9, 0.0], [0.6, 0.5, 0.6]),
]
LAMP = sf.PointLight([3.1, 2.4, 2.6], 20.0)
PLACES = 32  # on a wall, each way


def mesh(quads):
    return np.array(quads, dtype=float).reshape(-1, 3), np.arange(4 * len(quads)).reshape(-1, 4)


def room(reflectance=0.7, furniture=FURNITURE, gap=0.0):
    """Its furniture stands that far above the floor."""
    walls = sf.Surfels.from_mesh(mesh([*cell([0, 0, 0], SIZE)]), reflectance=reflectance)
    boxes = [(np.add(low, [0, 0, gap]), np.add(np.add(low, size), [0, 0, gap])) for low, size in furniture]
    quads = [quad[::-1] for box in boxes for quad in cell(*box)]
    return sf.Scene([walls, sf.Surfels.from_mesh(mesh(quads), 0.2, 0.5 if reflectance else 0.0)], [LAMP])


# Of furniture on them, which is nothing to what is measured here.
pytestmark = pytest.mark.filterwarnings("ignore:object 0. walls of other objects", "ignore:backs of surfaces absorb")


def means_over_walls(scene, samples):
    """Irradiance of each wall, traced: (6,)."""
    walls = scene.objects[0]
    quads = np.array([*cell([0, 0, 0], SIZE)])
    s, t = (a.ravel()[:, None] for a in np.meshgrid(*2 * [(np.arange(PLACES) + 0.5) / PLACES]))
    places = np.concatenate([q[0] + s * (q[1] - q[0]) + t * (q[3] - q[0]) for q in quads])
    found, _ = sf.reference_irradiance(scene, places, np.repeat(walls.normals, PLACES**2, axis=0), samples=samples)
    return found[:, 0].reshape(6, -1).mean(axis=1)


@pytest.fixture(scope="module")
def truth():
    """(direct, indirect) of the walls, good to .3 %."""
    direct = means_over_walls(room(0.0), 16)
    return direct, means_over_walls(room(), 64) - direct


@pytest.mark.parametrize("seed", [3, 4, 5])
@pytest.mark.parametrize(
    ("solve", "options"), [(sf.solve, {"insert": False}), (sf.solve_meshless, {"levels": 1, "rays": 64})]
)
def test_direct_light_of_walls_comes_by_many_rays(truth, solve, options, seed):
    found = solve(room(), seed=seed, **options).direct[:6, 0]
    np.testing.assert_allclose(found, truth[0], rtol=0.015)


@pytest.mark.slow
def test_walls_have_the_mean_of_the_field_on_them(truth):
    """What walls that see all of the room have by a few hundred rays scatters by .6 %, their power by .4 %."""
    off, lost = [], []
    for seed in range(3, 11):
        solution = sf.solve_meshless(room(), seed=seed)
        off.append((solution.irradiance[:6, 0] - solution.direct[:6, 0]) / truth[1] - 1.0)
        lost.append(solution.history[-1]["power_lost"] / (4 * np.pi * 20.0))
    assert np.abs(np.mean(off, axis=0)).max() < 0.012, off
    assert np.abs(off).max() < 0.035, off
    assert abs(np.mean(lost)) < 0.005, lost
    assert np.abs(lost).max() < 0.015, lost


@pytest.mark.slow
@pytest.mark.parametrize("gap", [0.0, 0.001])
def test_what_stands_on_the_middle_of_a_floor_hides_that_alone(gap):
    """The floor is one patch; what its centre has, its other places have not."""
    scene = room(furniture=[([2.6, 2.1, 0.0], [0.8, 0.8, 0.7])], gap=gap)
    wanted = means_over_walls(scene, 64)
    for seed in range(3):
        np.testing.assert_allclose(sf.solve_meshless(scene, seed=seed).irradiance[:6, 0], wanted, rtol=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4, 5])
def test_a_millimetre_under_furniture_is_dark(seed):
    """On the floor and on the furniture, which had half of the room's light; the rest has no more for it."""
    scene = room(gap=0.001)
    solution = sf.solve_meshless(scene, seed=seed)
    wanted = means_over_walls(scene, 64)
    np.testing.assert_allclose(solution.irradiance[:6, 0], wanted, rtol=0.035)  # .6 % RMS; 2.5 once in 36 walls
    below = np.flatnonzero(scene.objects[1].normals[:, 2] < -0.9) + 6
    assert solution.irradiance[below].mean() < 0.05 * wanted[4]
    random = np.random.default_rng(seed)
    places = np.concatenate([low + random.random((20, 3)) * size * [1, 1, 0] for low, size in map(np.array, FURNITURE)])
    found = solution.irradiance_at(places, np.tile([0.0, 0.0, 1.0], (len(places), 1)))[:, 0]
    assert found.mean() < 0.05 * wanted[4]


@pytest.mark.slow
def test_light_behind_a_panel_is_not_that_of_the_lit_side():
    """What kept the power of walls of one patch each made the floor behind the panel a quarter too bright."""
    room = sf.Surfels.from_mesh(shapes.box((6, 4, 3), 1, inward=True)[:2], reflectance=0.5)
    sides = []
    for x, corners in ((3.01, [(0, 0), (3, 0), (3, 2.8), (0, 2.8)]), (2.99, [(0, 0), (0, 2.8), (3, 2.8), (3, 0)])):
        square = np.array([[x, 0.5 + y, 0.05 + z] for y, z in corners])
        sides.append(sf.Surfels.from_mesh((square, [[0, 1, 2, 3]]), reflectance=0.6))
    scene = sf.Scene([room, *sides], [sf.PointLight([1, 1, 2.5], 500.0)])
    behind = np.c_[np.random.default_rng(2).uniform([3.2, 0.5], [5.5, 3.5], (16, 2)), np.zeros(16)]
    up = np.tile([0.0, 0.0, 1.0], (16, 1))
    true, noise = sf.reference_irradiance(scene, behind, up, samples=16384)
    assert np.sqrt((noise**2).sum()) < 0.01 * true.sum()
    for seed in range(3):
        found = sf.solve_meshless(scene, levels=3, seed=seed).irradiance_at(behind, up)
        assert found.sum() == pytest.approx(true.sum(), rel=0.04), seed
