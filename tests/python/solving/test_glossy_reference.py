"""Outgoing radiance by path tracing, against closed forms and quadrature: z-scores over points and seeds."""

import numpy as np
import pytest

import surflux as sf
from cases import chance
from quick import quick
from scenes import cube_inside, patch

UP = np.array([0.0, 0.0, 1.0])
GLOSSY = {"reflectance": 0.3, "specular": [0.5, 0.2, 0.6], "exponent": 30.0}


def floor(**material):
    """The square of 2 x 2 around the origin, facing up."""
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    return sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), **(GLOSSY | material))


def directions(n, seed=0, least=0.05):
    """Upwards, no flatter than `least`."""
    d = np.random.default_rng(seed).normal(size=(8 * n, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return d[d[:, 2] > least][:n]


def sent(w, out, reflectance, specular, exponent):
    """Radiance from the floor towards out (m, 3) for each unit of it and solid angle from w (k, 3): (m, k, 3)."""
    mirror = out * [-1, -1, 1]
    rho, k = np.broadcast_to(reflectance, 3), np.broadcast_to(specular, 3)
    lobe = (exponent + 1) / (2 * np.pi) * np.maximum(mirror @ w.T, 0) ** exponent
    return np.where(w[:, 2:] > 0, rho / np.pi * w[:, 2:] + k * lobe[..., None], 0.0)


def at_origin(scene, out, **options):
    n = len(out)
    return sf.reference_radiance(scene, np.zeros((n, 3)), np.tile(UP, (n, 1)), out, **options)


def assert_agrees(scene, out, expected, samples=1024, seeds=2, most=None, **options):
    """Chi-square p > 1e-3 and no |z| above 4.5, channel by channel; `most` is the largest error that is allowed."""
    scores = []
    for seed in range(seeds):
        value, error = at_origin(scene, out, samples=samples, seed=seed, **options)
        assert np.all(error > 0)
        if most is not None:
            assert error.max() < most
        # Channels of one path go up and down together: one of them tells.
        scores.append(chance.scores(value[:, 0], expected[:, 0], error[:, 0], samples))
        np.testing.assert_allclose(value, expected, atol=6 * error.max())
    largest, probability, lean = chance.agreement(np.concatenate(scores))
    assert largest < chance.LARGEST_SCORE
    assert probability > chance.LEAST_PROBABILITY
    assert abs(lean) < 4


@pytest.mark.parametrize("exponent", [1.0, 20.0, 1e5])
def test_an_even_sky_seen_straight_on_is_reflected_without_noise(exponent):
    """The whole lobe is above the surface, and every path finds the same: (rho + k) L."""
    scene = sf.Scene([floor(specular=0.6, exponent=exponent)], [sf.Environment(2.0)])
    value, error = at_origin(scene, UP[None], samples=64)
    np.testing.assert_allclose(value, 1.8, rtol=1e-12)
    assert error.max() < 1e-12


def test_what_of_a_lobe_is_below_the_surface_is_lost():
    """Of exponent 1 the part above is what a tilted plane has of a half sky, (1 + cos) / 2.

    Half of the paths at most are lost, of a radiance of 1.4: errors of .7 / sqrt(1024) at most, for as many samples.
    """
    out = directions(32, least=0.0)
    scene = sf.Scene([floor(reflectance=0.2, exponent=1.0)], [sf.Environment([2.0, 1.0, 0.5])])
    expected = (0.2 + np.array([0.5, 0.2, 0.6]) * (1 + out[:, 2:]) / 2) * [2.0, 1.0, 0.5]
    assert_agrees(scene, out, expected, most=0.03)


@pytest.mark.parametrize("light", ["point", "sun", "spot"])
def test_lights_without_extent_in_closed_form(light):
    out = directions(16)
    place = np.array([0.6, -0.3, 0.9])
    w = place / np.linalg.norm(place)
    irradiance = {"point": 4.0 / (place @ place), "sun": 4.0, "spot": 4.0 / (place @ place)}[light]
    lights = {
        "point": sf.PointLight(place, 4.0),
        "sun": sf.DirectionalLight(-w, 4.0),
        "spot": sf.SpotLight(place, -w, 4.0),
    }
    value, error = at_origin(sf.Scene([floor()], [lights[light]]), out, samples=16)
    np.testing.assert_allclose(value, irradiance * sent(w[None], out, **GLOSSY)[:, 0], rtol=1e-9, atol=1e-12)
    assert error.max() < 1e-12


def over_rectangle(out, exponent, low, high, height, radiance):
    """The integral over a rectangle above that faces down, by the midpoint rule."""
    n = 400
    x, y = (a + (b - a) * (np.arange(n) + 0.5) / n for a, b in zip(low, high, strict=True))
    d = np.stack(np.meshgrid(x, y, [height], indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.linalg.norm(d, axis=1)
    w = d / distance[:, None]
    solid_angle = (high[0] - low[0]) * (high[1] - low[1]) / n**2 * w[:, 2] / distance**2
    material = GLOSSY | {"exponent": exponent}
    return np.array([radiance * (solid_angle[:, None] * sent(w, o[None], **material)[0]).sum(axis=0) for o in out])


@pytest.mark.parametrize("exponent", quick(300.0, of=[5.0, 300.0]))
@pytest.mark.parametrize("lamp", ["light", "surfel"])
def test_lamps_by_light_samples_and_by_the_lobe(lamp, exponent):
    """Both find them: combined, neither counts twice, and the error stays small for wide lobes and narrow ones."""
    low, high, height = (-0.4, -0.5), (0.6, 0.1), 1.0
    radiance = 3.0
    if lamp == "light":
        lights = [sf.AreaLight([low[0], low[1], height], [0, 0.6, 0], [1.0, 0, 0], np.pi * radiance)]
        objects = [floor(exponent=exponent)]
    else:
        lights = []
        glow = patch([low[0], low[1], height], [0, 0.6, 0], [1.0, 0, 0], 0.0, np.pi * radiance)
        objects = [floor(exponent=exponent), glow, patch([0, 0, -50], [20, 0, 0], [0, 20, 0], 0.0)]
    out = directions(24)
    expected = over_rectangle(out, exponent, low, high, height, radiance)
    assert_agrees(sf.Scene(objects, lights), out, expected, most=0.05 * max(1.0, expected.max()))


@pytest.mark.slow
@pytest.mark.parametrize("exponent", quick(300.0, of=[5.0, 300.0]))
def test_the_image_of_a_sky(exponent):
    """A few bright pixels: against the sum over directions inside of each."""
    image = 0.1 * np.ones((16, 32, 3))
    image[[2, 5, 6], [3, 20, 21]] = [[50, 20, 5], [30, 30, 30], [5, 80, 5]]
    fine = 40
    theta = np.pi * (np.arange(8 * fine) + 0.5) / (16 * fine)
    phi = np.pi - 2 * np.pi * (np.arange(32 * fine) + 0.5) / (32 * fine)
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    w = np.c_[np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)]
    radiance = np.kron(image[:8], np.ones((fine, fine, 1))).reshape(-1, 3)
    weights = radiance * (np.sin(t) * (np.pi / 16 / fine) ** 2)[:, None]
    out = directions(24)
    material = GLOSSY | {"exponent": exponent}
    expected = np.array([(weights * sent(w, o[None], **material)[0]).sum(axis=0) for o in out])
    scene = sf.Scene([floor(exponent=exponent)], [sf.Environment(image)])
    assert_agrees(scene, out, expected, most=0.1 * expected.max())


@pytest.mark.parametrize("exponent", [8.0, 60.0])
def test_light_of_few_harmonics_is_that_convolved_with_the_lobe(exponent):
    """Seen straight on, where all of an even exponent's lobe is in front. The light is below 0 in places."""
    c = np.random.default_rng(3).normal(size=(25, 3))
    light = sf.Environment.from_harmonics(c, height=256)
    assert light.image.min() < -0.5
    lobe = (exponent + 1) / (2 * np.pi) * sf.convolve_harmonics(c, exponent)
    normals = np.vstack([directions(12), -directions(12)])
    # Each from a point of the air, whose surface is given; nothing else is in the scene but a speck.
    speck = sf.Surfels([[0, 0, -1e3]], [[0, 0, 1]], radii=1e-3)
    material = {"reflectance": 0.3, "specular": 0.6, "exponent": exponent}
    both = 0.3 / np.pi * sf.convolve_harmonics(c) + 0.6 * lobe
    expected = sf.spherical_harmonics(normals) @ both
    scene = sf.Scene([speck], [light])
    scores = []
    for seed in range(2):
        value, error = sf.reference_radiance(
            scene, np.zeros((24, 3)), normals, normals, **material, samples=1024, seed=seed
        )
        scores.append(chance.scores(value[:, 1], expected[:, 1], error[:, 1], 1024))
    # Pixels smooth band 4 by at most 20 (pi / 256)^2 / 12 = 2.5e-4 of it: less than a tenth of the errors.
    assert error.min() > 2.5e-3 * 0.6
    largest, probability, _ = chance.agreement(np.concatenate(scores))
    assert largest < chance.LARGEST_SCORE
    assert probability > chance.LEAST_PROBABILITY


def test_irradiance_of_light_below_zero():
    c = np.random.default_rng(4).normal(size=(9, 3))
    normals = np.vstack([directions(12), -directions(12)])
    speck = sf.Surfels([[0, 0, -1e3]], [[0, 0, 1]], radii=1e-3)
    scene = sf.Scene([speck], [sf.Environment.from_harmonics(c, height=256)])
    expected = (sf.spherical_harmonics(normals, 3) @ sf.convolve_harmonics(c))[:, 2]
    assert expected.min() < 0
    value, error = sf.reference_irradiance(scene, np.zeros((24, 3)), normals, samples=1024)
    largest, probability, _ = chance.agreement(chance.scores(value[:, 2], expected, error[:, 2], 1024))
    assert largest < chance.LARGEST_SCORE
    assert probability > chance.LEAST_PROBABILITY


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_solvers_refuse_light_below_zero(solver):
    scene = sf.Scene([floor()], [sf.Environment.from_harmonics([1.0, 0.0, 3.0, 0.0])])
    with pytest.raises(ValueError, match=r"^scene: solvers take light of at least 0, and its Environment of harmonics"):
        solver(scene)


def test_without_specular_it_is_the_radiance_of_the_irradiance():
    cube = cube_inside(2, 0.5, [1.0, 0.5, 0.25]).replace(reflectance=[0.7, 0.5, 0.2])
    scene = sf.Scene([cube], [sf.PointLight([0.3, 0.4, 0.6], 2.0)])
    points, normals = cube.points, cube.normals
    irradiance, error = sf.reference_irradiance(scene, points, normals, samples=1024)
    sideways = normals + 0.5 * np.roll(normals, 1, axis=1)
    radiance, mine = sf.reference_radiance(scene, points, normals, sideways, samples=1024, seed=1)
    rho = cube.reflectance
    expected = (cube.emission + rho * irradiance) / np.pi
    spread = np.hypot(mine, rho * error / np.pi)
    assert np.abs((radiance - expected) / spread).max() < 4.8  # 72 numbers of t with some 31 degrees of freedom
    assert np.all(spread < 0.02 * expected)


@pytest.mark.parametrize("rho", quick(0.2, of=[0.0, 0.2]))
def test_furnace_of_narrow_lobes(rho):
    """A closed cube that glows: E / pi / (1 - rho - k) all over, but for what lobes 1e-3 wide lose at the horizon."""
    cube = cube_inside(2, 0.5, 1.0).replace(reflectance=rho, specular=0.5, exponent=1e6)
    inwards = cube.normals + 0.3 * np.roll(cube.normals, 1, axis=1)
    value, error = sf.reference_radiance(sf.Scene([cube]), cube.points, cube.normals, inwards, samples=1024)
    expected = 1 / np.pi / (0.5 - rho)
    assert np.all(np.abs(value - expected) < 4.5 * error + 2e-3 * expected)
    assert error.max() < 0.01 * expected


def test_never_more_than_the_furnace_of_all_that_is_reflected():
    """Whatever the exponent: E / pi / (1 - rho - k) is the most, E / pi / (1 - rho) the least."""
    cube = cube_inside(2, 0.5, 1.0).replace(reflectance=0.3, specular=0.5, exponent=3.0)
    value, error = sf.reference_radiance(sf.Scene([cube]), cube.points, cube.normals, cube.normals, samples=1024)
    assert np.all(value + 4.5 * error < 1 / np.pi / 0.2)
    assert np.all(value - 4.5 * error > 1 / np.pi / 0.7)


def two_mirrors(sky):
    """A mirror on the floor, at 45 degrees, shows one that faces down at (1, 0, 1); that one shows the sky beyond."""
    above = patch([0.5, -0.5, 1.0], [0, 1, 0], [1, 0, 0], 0.0).replace(specular=0.4, exponent=1e6)
    return sf.Scene([floor(reflectance=0.0, specular=0.5, exponent=1e6), above], [sf.Environment(sky)])


def test_glossy_surfaces_show_each_other():
    out = np.array([[-1.0, 0, 1]])
    value, _ = at_origin(two_mirrors(2.0), out, samples=64)
    np.testing.assert_allclose(value, 0.5 * 0.4 * 2.0, rtol=1e-9)
    value, _ = at_origin(two_mirrors(2.0), out, samples=64, glossy_bounces=False)
    assert value.max() == 0.0  # what is shown is black but for its lobe


def test_materials_of_the_surfels_and_given_ones_are_the_same_bits():
    scene = two_mirrors([2.0, 1.0, 0.5])
    out = directions(5)
    own = at_origin(scene, out, samples=64)
    given = at_origin(scene, out, samples=64, reflectance=0.0, specular=0.5, exponent=1e6)
    for a, b in zip(own, given, strict=True):
        np.testing.assert_array_equal(a, b)


def test_any_number_of_threads_gives_the_same_bits():
    scene = sf.Scene([floor()], [sf.Environment(np.random.default_rng(0).random((8, 16, 3)))])
    out = directions(20)
    one, two = (at_origin(scene, out, samples=256, seed=5, threads=k) for k in (1, 2))
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)


def test_from_behind_it_is_black():
    scene = sf.Scene([floor(emission=1.0)], [sf.Environment(1.0)])
    value, error = at_origin(scene, np.array([[0.1, 0, -1.0], [0, 0, 1.0]]), samples=16)
    assert value[0].max() == error[0].max() == 0.0
    assert value[1].min() > 1 / np.pi


def test_points_in_the_air_need_materials():
    scene = sf.Scene([floor()], [sf.Environment(1.0)])
    place = [[0, 0, 5.0]]
    with pytest.raises(
        ValueError, match=r"^points: 0 lies on no surfel: give reflectance, specular and exponent of all$"
    ):
        sf.reference_radiance(scene, place, [UP], [UP], reflectance=0.5, specular=0.2)
    value, _ = sf.reference_radiance(scene, place, [UP], [UP], reflectance=0.5, specular=0.2, exponent=4, samples=16)
    np.testing.assert_allclose(value, 0.7, rtol=1e-12)


def test_more_than_all_cannot_be_reflected():
    with pytest.raises(
        ValueError, match=r"^specular: wanted reflectance \+ specular below 1 in every channel, got 1\.1"
    ):
        at_origin(sf.Scene([floor()]), UP[None], reflectance=0.5, specular=0.6, exponent=2)


def test_solvers_and_irradiance_leave_specular_out():
    lights = [sf.PointLight([0.2, 0.1, 1.0], 3.0)]
    wall = patch([1, -1, 0], [0, 2, 0], [0, 0, 1], 0.5)
    plain, shiny = (sf.Scene([floor(specular=k), wall.replace(specular=k)], lights) for k in (0.0, 0.4))
    for solver in (sf.solve, sf.solve_meshless):
        np.testing.assert_array_equal(solver(plain).irradiance, solver(shiny).irradiance)
    points = [[0.5, 0, 0], [0, 0.5, 0]]
    value = [sf.reference_irradiance(scene, points, [UP, UP], samples=64)[0] for scene in (plain, shiny)]
    np.testing.assert_array_equal(*value)


def test_a_callback_cancels():
    with pytest.raises(sf.Cancelled):
        at_origin(sf.Scene([floor()], [sf.Environment(1.0)]), UP[None], progress=lambda done, total: False)
