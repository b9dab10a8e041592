"""Solution.error, the solver's own estimate, against the truth."""

import numpy as np
import pytest
from scipy import stats

import surflux as sf
from fresh_rays import starts
from quick import quick
from scenes import patch, solve_own, surfels_of
from surflux.bench.estimates import SOLVERS, Estimated
from surflux.scenes import shapes

SUN = sf.DirectionalLight([0.3, 0.2, -1.0], 3.0)
SIDE = 1e-3  # of a lamp at height 1 over the middle of a floor


def ball_over_a_floor(rho, patch_area):
    unit = shapes.sphere(162)
    ball = surfels_of(0.3 * unit.points + np.array([0, 0, 0.35]), unit.normals, rho)
    return sf.Scene([patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], rho, 0.0, patch_area), ball], [SUN])


def floor_of_points(n=20):
    x, y = (a.ravel() for a in np.meshgrid(*[2 * (np.arange(n) + 0.5) / n - 1] * 2))
    return surfels_of(np.stack([x, y, 0 * x], axis=1), [[0, 0, 1]] * n * n, 0.0)


def means(scene, solution, seed, per=64, samples=64):
    """H by the path tracer, as the mean over places of each surfel, the same places for the same seed."""
    s, random = solution.surfels, np.random.default_rng(seed)
    uv = (stats.qmc.Sobol(2, rng=random).random(per) + random.random((len(s), 1, 2))) % 1.0
    normals = np.repeat(s.normals, per, axis=0)
    found, _ = sf.reference_irradiance(scene, starts(s, uv).reshape(-1, 3), normals, samples=samples, seed=seed)
    return found[:, 0].reshape(len(s), per).mean(axis=1)


def measured(scene, solution):
    """Relative RMS error, as Solution.error has it, and its standard error: by two halves, whose noise has no part in
    the product."""
    weight, h = solution.surfels.areas, solution.irradiance[:, 0]  # all is grey
    off = [h - means(scene, solution, seed) for seed in (1, 2)]
    true = [h - d for d in off]
    size = (weight * true[0] * true[1]).sum()
    error = np.sqrt((weight * off[0] * off[1]).sum() / size)
    spread = np.sqrt((weight**2 * (off[0] - off[1]) ** 2 * (off[0] + off[1]) ** 2 / 4).sum()) / size
    return error, spread / (2 * error)


@pytest.mark.slow
@pytest.mark.parametrize("patch_area", [0.25, 0.0625])
def test_it_sees_what_one_value_per_surfel_loses(patch_area):
    """A ball hangs over a floor whose patches have one value each, in and out of its shadow."""
    scene = ball_over_a_floor(0.6, patch_area)
    solution = solve_own(scene)
    truth, error = measured(scene, solution)
    assert error < truth / 8
    assert 0.7 * truth < solution.error < 1.5 * truth


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
@pytest.mark.slow
def test_it_sees_direct_light_and_what_it_brings(solve, seed):
    """Borders of a shadow with few shadow rays: what is off is direct light, which no bounce shows."""
    scene = ball_over_a_floor(0.6, 0.01)
    solution = solve(scene, seed=seed, probes=4, shadow_rays=8)
    truth, error = measured(scene, solution)
    assert error < truth / 8
    assert 0.7 * truth < solution.error < 1.5 * truth


@pytest.mark.parametrize("seed", quick(0, of=[0, 1, 2]))
@pytest.mark.parametrize("lamp", ["surfel", "patch"])
def test_a_tiny_lamp_is_no_reason_to_doubt(lamp, seed):
    """1e-6 of a steradian, which no ray finds by chance; E a^2 cos^2 / (pi r^2) in closed form."""
    floor = floor_of_points()
    if lamp == "surfel":
        radius = SIDE / np.sqrt(np.pi)
        small = sf.Surfels([[0, 0, 1]], [[0, 0, -1]], radii=radius, areas=SIDE**2, reflectance=0.0, emission=1e6)
    else:
        small = patch([-SIDE / 2, -SIDE / 2, 1], [0, SIDE, 0], [SIDE, 0, 0], 0.0, 1e6)
    solution = solve_own(sf.Scene([floor, small]), rays=4096, seed=seed)
    to_lamp = np.array([0, 0, 1]) - floor.points
    expected = 1e6 * SIDE**2 * to_lamp[:, 2] ** 2 / (np.pi * (to_lamp**2).sum(axis=1) ** 2)
    weight, found = solution.surfels.areas[:-1], solution.irradiance[:-1, 0]
    truth = np.sqrt((weight * (found - expected) ** 2).sum() / (weight * expected**2).sum())
    # It never claims less than its rays can tell, which is 1e-4 here.
    assert 0.5 * truth < solution.error < max(2 * truth, 1e-4)


@pytest.mark.parametrize(("solve", "cone"), [(sf.solve, 5.0), (sf.solve, 1.0), (sf.solve_meshless, 5.0)])
def test_it_sees_a_spot_that_few_surfels_have(solve, cone):
    """A thousandth of the floor and less, of which 2000 places drawn by area may have none."""
    floor = patch([-5, -5, 0], [10, 0, 0], [0, 10, 0], 0.5, 0.0, 0.05)
    scene = sf.Scene([floor], [sf.SpotLight([1.1, 1.1, 2], [0, 0, -1], 1.0, cone, penumbra=0.0)])
    found = [solve(scene, seed=seed) for seed in range(3)]
    assert all(solution.direct.max() > 0.0 for solution in found)
    assert all(solution.error < 0.05 for solution in found)
    # It is exact, in closed form; what is not is seen.
    for solution in found:
        solution.irradiance = 1.1 * solution.irradiance
        assert solution.estimate_error() == pytest.approx(0.1, rel=0.1)


@pytest.fixture(scope="module")
def ball_on_a_floor():
    """Under an area lamp, whose penumbra on points has most of the error."""
    unit = shapes.sphere(1500)
    ball = surfels_of(0.5 * unit.points + np.array([0, 0, 0.6]), unit.normals, 0.6)
    floor = patch([-4, -4, 0], [8, 0, 0], [0, 8, 0], 0.6, 0.0, 0.04)
    return Estimated(sf.Scene([floor, ball], [sf.AreaLight([-0.5, -0.5, 4], [0, 1, 0], [1, 0, 0], 30.0)]))


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("solver", ["rays", "meshless"])
@pytest.mark.slow
def test_it_is_the_error_of_ordinary_scenes(ball_on_a_floor, solver, seed):
    solution = SOLVERS[solver](ball_on_a_floor.scene, seed=seed)
    error, doubt = ball_on_a_floor.error(solution)
    assert doubt < 0.2 * error
    assert 0.7 < solution.error / error < 1.5
