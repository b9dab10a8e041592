"""Hard scenes by numbers: rho -> 1, densities, copies, ranges of emission."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from scenes import ball_inside, cloud_room, cube_inside, surfels_of
from surflux.scenes import shapes


def two_rooms(slit, rho, emission=0.0, of_wall=0.0):
    """A closed box, parted by a wall that leaves a slit."""
    vertices, faces, _ = shapes.box((2, 1, 1), (16, 8, 8), inward=True)
    wall = ([[1, 0, 0], [1, 1 - slit, 0], [1, 1 - slit, 1], [1, 0, 1]], [[0, 1, 2, 3]])
    return [
        sf.Surfels.from_mesh((vertices, faces), reflectance=rho, emission=emission),
        sf.Surfels.from_mesh(wall, 1 / 64, rho, of_wall, two_sided=True),
    ]


CLOSED = {
    "patches": lambda rho, e: [cube_inside(10, rho, e)],
    "sphere": lambda rho, e: [ball_inside(642, rho=rho, emission=e)],
    "clouds": lambda rho, e: cloud_room(8, rho, e),
    "two rooms": lambda rho, e: two_rooms(0.02, rho, e, e),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize(
    ("rho", "emission"), [(0.99, 2.0), (0.999, 2.0), ([0.5, 0.99, 0.999], [1.0, 2.0, 3.0])], ids=str
)
def test_furnaces_of_nearly_white_walls(name, rho, emission):
    """B = E / (1 - rho), for each colour, within .1 %."""
    solution = sf.solve(sf.Scene(CLOSED[name](rho, emission)))
    expected = np.broadcast_to(np.array(emission) / (1 - np.array(rho)), solution.radiosity.shape)
    np.testing.assert_allclose(solution.radiosity, expected, rtol=1e-3)


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("whiteness", quick(1 - 1e-9, of=[1 - 1e-6, 1 - 1e-9, np.nextafter(1.0, 0.0)]))
@pytest.mark.filterwarnings("ignore:the linear solver stopped")  # which is what it is to say at the last of them
def test_the_last_step_to_white_never_diverges(name, whiteness):
    """Finite, positive, and not above the furnace it would be; within 2 % of it as far as single precision bears."""
    solution = sf.solve(sf.Scene(CLOSED[name](whiteness, 1.0)))
    assert np.all(np.isfinite(solution.radiosity))
    assert solution.radiosity.min() >= 1.0
    furnace = 1 / (1 - whiteness)
    if whiteness == 1 - 1e-6:
        np.testing.assert_allclose(solution.radiosity, furnace, rtol=0.02)
    with pytest.raises(ValueError, match=r"^reflectance: wanted values in \[0, 1\), got 1 "):
        CLOSED[name](1.0, 1.0)


def white_rooms():
    random = np.random.default_rng(3)
    room = cube_inside(12, 0.5)
    n, z = len(room), room.points[:, 2]
    lamp = np.where(z > 0.99, 1.0, 0.0)
    unit = shapes.sphere(200)
    balls = [surfels_of(0.15 * unit.points + at, unit.normals, 0.999) for at in ([0.3, 0.3, 0.2], [0.7, 0.6, 0.5])]
    emission = np.where(two_rooms(0.02, 0.5)[0].points[:, 0] < 0.2, 1.0, 0.0)
    return {
        "rho and E at random": [cube_inside(12, random.uniform(0.5, 0.999, n), random.uniform(0, 1, n))],
        "E at random": [cube_inside(12, 0.999, random.uniform(0, 1, n))],
        "lit from above": [cube_inside(12, random.uniform(0.99, 0.999, n), lamp)],
        "in bands": [cube_inside(12, 0.998 + 0.001 * np.sin(9 * z), lamp)],
        "sphere": [ball_inside(642, rho=random.uniform(0.9, 0.999, 642), emission=random.uniform(0, 1, 642))],
        "balls in a room": [cube_inside(8, 0.999, np.repeat([0.0, 0.0, 0.0, 0.0, 0.0, 1.0], 64)), *balls],
        "two rooms": two_rooms(0.02, 0.999, emission),
        "coloured": [cube_inside(12, random.uniform(0.9, 0.999, (n, 3)), random.uniform(0, 1, (n, 3)))],
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", white_rooms())
def test_at_most_30_applications(name):
    """rho up to .999, neither rho nor E uniform: a Neumann series would need 9206 of them."""
    solution = sf.solve(sf.Scene(white_rooms()[name]))
    assert solution.history[-1]["applications"] <= 30
    assert solution.history[-1]["residual"] <= 1e-4
    assert np.all(np.isfinite(solution.radiosity))


def test_furnace_with_a_ball_in_it():
    unit = shapes.sphere(300)
    ball = surfels_of(0.15 * unit.points + np.array([0.5, 0.5, 0.3]), unit.normals, 0.999, 2.0)
    solution = sf.solve(sf.Scene([cube_inside(8, 0.999, 2.0), ball]))
    np.testing.assert_allclose(solution.radiosity, 2000.0, rtol=1e-3)


def ever_denser_sphere(ratio, step=0.3):
    """A grid in Mercator's projection, which is conformal: spacings shrink by the ratio from the equator to a pole."""
    k = round(2 * np.pi / step)
    top = np.arccosh(ratio)
    rows = round(top * k / np.pi)
    y = ((np.arange(rows) + 0.5) / rows * 2 - 1)[:, None] * top
    angle = 2 * np.pi * (np.arange(k) + 0.5 * (np.arange(rows) % 2)[:, None]) / k
    y = y + 0.25 * step * np.random.default_rng(0).uniform(-1, 1, angle.shape)
    points = np.stack([np.cos(angle) / np.cosh(y), np.sin(angle) / np.cosh(y), np.tanh(y)], axis=-1).reshape(-1, 3)
    return np.concatenate([points, [[0, 0, 1], [0, 0, -1]]])


@pytest.mark.slow
def test_spacings_of_1_to_1500():
    points = ever_denser_sphere(1500)
    s = sf.Surfels(points, -points, reflectance=0.5 + 0.4 * points[:, 0] * points[:, 1], emission=1 + points[:, 2])
    assert s.radii.max() > 1000 * s.radii.min()
    solution = sf.solve(sf.Scene([s]))
    areas = solution.surfels.areas
    assert areas.sum() == pytest.approx(4 * np.pi, rel=1e-3)
    # H = mean(E) / (1 - mean(rho)) = 1 / .5; every surfel, of whatever size (DESIGN section 7).
    np.testing.assert_allclose(solution.irradiance, 2.0, rtol=2e-3)
    sky = sf.solve(sf.Scene([sf.Surfels(points, points, reflectance=0.5)], [sf.Environment(1.0)]))
    np.testing.assert_allclose(sky.irradiance, np.pi, rtol=1e-3)


@pytest.mark.parametrize("copies", ["twice", "nearly_twice", "ten_times_at_one_place"])
def test_copies_of_points_change_nothing(copies):
    once = shapes.sphere(500).points
    more = {"twice": once, "nearly_twice": once * (1 + 1e-9), "ten_times_at_one_place": np.repeat(once[:1], 9, axis=0)}
    points = np.concatenate([once, more[copies]])
    s = sf.Surfels(points, -points, reflectance=0.9, emission=1.0)
    solution = sf.solve(sf.Scene([s]))
    np.testing.assert_allclose(solution.radiosity, 10.0, rtol=1e-3)
    assert solution.surfels.areas.sum() == pytest.approx(4 * np.pi, rel=1e-3)


def test_two_objects_at_one_place():
    ball = ball_inside(500, rho=0.9, emission=1.0)
    np.testing.assert_allclose(sf.solve(sf.Scene([ball, ball])).radiosity, 10.0, rtol=1e-3)


@pytest.mark.slow
def test_emission_over_six_decades():
    """Inside a sphere H = mean(E) / (1 - mean(rho)) all the same; and each colour for itself."""
    random = np.random.default_rng(0)
    rho, emission = random.uniform(0, 0.9, 1000), 10 ** random.uniform(-3, 3, 1000)
    solution = sf.solve(sf.Scene([ball_inside(1000, rho=rho, emission=emission)]))
    areas = solution.surfels.areas
    expected = (areas * emission).sum() / (areas * (1 - rho)).sum()
    np.testing.assert_allclose(solution.irradiance, expected, rtol=1e-3)
    one = np.outer(random.uniform(size=600), [1e-6, 1.0, 1e6])
    colours = sf.solve(sf.Scene([cube_inside(10, 0.5, one)])).irradiance
    np.testing.assert_allclose(colours * [1e6, 1.0, 1e-6], np.repeat(colours[:, 1:2], 3, axis=1), rtol=1e-9)


def test_two_coaxial_disks_of_one_surfel_each():
    """Radius 1, gap h: F = 1 + h^2 / 2 - sqrt((1 + h^2 / 2)^2 - 1)."""
    for gap in (1e-3, 0.0165, 0.1, 0.5, 1.0):
        disks = sf.Surfels([[0, 0, 0], [0, 0, gap]], [[0, 0, 1], [0, 0, -1]], radii=1.0, areas=np.pi)
        half = 1 + gap**2 / 2
        assert sf.form_factors(sf.Scene([disks]))[0, 1] == pytest.approx(half - np.sqrt(half**2 - 1), rel=0.01)
