"""The path tracer against closed forms (DESIGN section 7): z-scores, by a chi-square over points and seeds."""

import numpy as np
import pytest
from scipy import stats

import surflux as sf
from scenes import ball_inside, cube_inside, patch, surfels_of
from surflux import shapes

UP = (0.0, 0.0, 1.0)


def assert_agrees(scene, points, normals, expected, *, samples=4096, seeds=2, exact=1e-6):
    """Chi-square p > 1e-3 and no |z| above 4.5; where there is no spread, the value itself. Returns the mean error."""
    points = np.atleast_2d(np.asarray(points, float))
    normals = np.broadcast_to(np.asarray(normals, float), points.shape)
    expected = np.broadcast_to(np.asarray(expected, float), len(points))
    batches = round(samples**0.5)
    scores, errors = [], []
    for seed in range(seeds):
        value, error = (a[:, 0] for a in sf.reference_irradiance(scene, points, normals, samples=samples, seed=seed))
        sure = error < 1e-9 * np.maximum(1, expected)
        np.testing.assert_allclose(value[sure], expected[sure], rtol=exact, atol=exact)
        t = (value - expected)[~sure] / error[~sure]
        scores.append(stats.norm.isf(stats.t.sf(t, batches - 1)))
        errors.append(error)
    z = np.concatenate(scores)
    if len(z):
        assert np.abs(z).max() < 4.5
        assert stats.chi2.sf((z**2).sum(), len(z)) > 1e-3
        assert abs(z.mean()) < 4 / np.sqrt(len(z))  # all points off to the same side
    return np.mean(errors)


def even(n, dimensions=2):
    return stats.qmc.Halton(dimensions, seed=7).random(n)


def on_floor(n=64, low=-0.5, high=1.5):
    return np.c_[low + (high - low) * even(n), np.zeros(n)]


def from_corner(a, b, c):
    """Form factor from an element under the corner of a parallel rectangle a x b at distance c."""
    x, y = np.hypot(a, c), np.hypot(b, c)
    return (a / x * np.arctan(b / x) + b / y * np.arctan(a / y)) / (2 * np.pi)


def under_unit_square(points, height):
    x, y = points[:, 0], points[:, 1]
    signed = [(1 - x, 1 - y), (x, 1 - y), (1 - x, y), (x, y)]
    return sum(np.sign(a) * np.sign(b) * from_corner(abs(a), abs(b), height) for a, b in signed)


def ceiling(height, patch_area=None, emission=1.0):
    """The unit square, facing down."""
    return patch([0, 0, height], [0, 1, 0], [1, 0, 0], 0.0, emission, patch_area)


def speck(rho=0.5):
    """A surface for scenes that need one, far away and small."""
    return patch([0, 0, -1e3], [1, 0, 0], [0, 1, 0], rho)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.98])
def test_furnace(rho):
    """B = E / (1 - rho) all over, so H = 1 / (1 - rho); the polygons of a cube close exactly."""
    cube = cube_inside(2, rho, 1.0)
    floor = np.c_[even(16), np.zeros(16)]
    points = np.r_[cube.points, floor, [[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0]]]  # on edges and corners of patches, too
    normals = np.r_[cube.normals, np.tile(UP, (19, 1))]
    assert_agrees(sf.Scene([cube]), points, normals, 1 / (1 - rho), samples=1024)


def test_furnace_of_unlike_walls():
    """E = 1 - rho makes B = 1 whatever rho is."""
    rho = 0.95 * even(6 * 16, 1)[:, 0]
    cube = cube_inside(4, rho, 1 - rho)
    assert_agrees(sf.Scene([cube]), cube.points, cube.normals, 1.0, samples=1024)


def test_inside_of_a_sphere():
    """H = mean(E) / (1 - mean(rho)) wherever; what the disks' form adds to that is below 1 %."""
    rho, emission = 0.9 * even(642, 1)[:, 0], 2.0 * even(642, 2)[:, 1]
    ball = ball_inside(642, rho=rho, emission=emission)
    points = even(200, 3) - 0.5
    points /= np.linalg.norm(points, axis=1)[:, None]
    value, error = sf.reference_irradiance(sf.Scene([ball]), points, -points, samples=1024)
    assert value[:, 0].mean() == pytest.approx(emission.mean() / (1 - rho.mean()), rel=0.01)
    assert (error / value).max() < 0.1


@pytest.mark.parametrize("height", [0.999, 1.0, 1.01])
def test_convex_cloud_under_a_uniform_sky(height):
    """H = pi L for whatever lies on it, between its disks, a little above or below: exactly."""
    cloud = ball_inside(642, rho=0.5, sign=1)
    points = even(256, 3) - 0.5
    points /= np.linalg.norm(points, axis=1)[:, None]
    scene = sf.Scene([cloud], [sf.Environment(2.0)])
    assert_agrees(scene, np.r_[height * points, cloud.points[:64]], np.r_[points, cloud.points[:64]], 2 * np.pi)


@pytest.mark.parametrize("radius", [0.5, 0.2])  # met by chance, and aimed at
def test_concentric_spheres(radius):
    """Inner black with M = 1, rho2 = .5: for r1 = .5 B2 = .2, H2 = .4. For polyhedra with the ratio of their areas."""
    points, faces = shapes.icosphere(4)
    inner = sf.Surfels.from_mesh((radius * points, faces), reflectance=0.0, emission=1.0)
    outer = sf.Surfels.from_mesh((points, faces[:, ::-1]), reflectance=0.5)
    at = slice(None, None, 20)
    scene = sf.Scene([inner, outer])
    value, error = sf.reference_irradiance(scene, outer.points[at], outer.normals[at], samples=2048)
    ratio = np.sum(inner.areas) / np.sum(outer.areas)  # F21: inner ones see outer ones alone
    mean, spread = value[:, 0].mean(), np.sqrt((error[:, 0] ** 2).sum()) / len(error)
    assert abs(mean - ratio / (1 - 0.5 * (1 - ratio))) < 4.5 * spread + 5e-4
    # The order of an icosphere's faces is periodic: were they drawn in it, the spread would be five times as large.
    assert error.max() < 0.02 * mean


def test_canyon():
    """Floor of an infinite canyon of black walls to the sky; mid-floor .447214."""
    far = 1e4
    vertices = [[x, y, z] for x in (0, 1) for y in (-far, far) for z in (0, 1)]
    canyon = sf.Surfels.from_mesh((vertices, [[0, 4, 6, 2], [0, 2, 3, 1], [4, 5, 7, 6]]), reflectance=0.0)
    x = np.r_[0.5, even(63, 1)[:, 0]]
    sky = 0.5 * (x / np.hypot(x, 1) + (1 - x) / np.hypot(1 - x, 1))
    assert sky[0] == pytest.approx(0.447214, abs=1e-6)
    points = np.c_[x, np.zeros((64, 2))]
    assert_agrees(sf.Scene([canyon], [sf.Environment(1.0)]), points, UP, np.pi * sky)


def test_half_sky():
    """A plane tilted by b under the upper half, no ground: (1 + cos b) / 2 of pi L."""
    image = np.zeros((8, 16, 3))
    image[:4] = 3.0
    b = np.pi * even(64, 1)[:, 0]
    scene = sf.Scene([speck()], [sf.Environment(image)])
    points, normals = np.zeros((64, 3)), np.c_[np.sin(b), np.zeros(64), np.cos(b)]
    assert_agrees(scene, points, normals, 3 * np.pi * (1 + np.cos(b)) / 2)


def test_one_bright_pixel():
    """L times the integral of cos over the pixel, and next to no noise although it covers 1e-3 of the sky."""
    image = np.zeros((32, 64, 3))
    image[5, 20] = 1e3
    low, high = np.pi * np.array([5, 6]) / 32
    expected = 1e3 * 2 * np.pi / 64 * (np.sin(high) ** 2 - np.sin(low) ** 2) / 2
    error = assert_agrees(sf.Scene([speck()], [sf.Environment(image)]), [[0, 0, 0]], UP, expected, seeds=8)
    assert error < 2e-3 * expected


@pytest.mark.parametrize(("height", "patch_area"), [(1.0, None), (1.0, 0.01), (0.05, 0.01)])
@pytest.mark.parametrize("others", [False, True])
def test_square_emitter(height, patch_area, others):
    """The unit square of exitance 1 over elements beside and under it, met by chance or, if small, aimed at."""
    points = on_floor()
    floor = [patch([-5, -5, 0], [10, 0, 0], [0, 10, 0], 0.5)] if others else []
    scene = sf.Scene([*floor, ceiling(height, patch_area)])
    error = assert_agrees(scene, points, UP, under_unit_square(points, height))
    assert error < (2e-3 if others else 1e-2)


def test_tabulated_emitters():
    """Element to disk on and off axis, element to a unit square over its corner and at a right angle."""
    disk = surfels_of([[0, 0, 1]], [[0, 0, -1]], 0.0, 1.0, radii=1.0)
    assert_agrees(sf.Scene([disk]), [[0, 0, 0], [0.5, 0, 0]], UP, [0.5, 0.4379826327], seeds=8)
    square = sf.Scene([ceiling(1.0)])
    normals = [[0, 0, 1], [1, 0, 0]]
    assert_agrees(square, np.zeros((2, 3)), normals, [0.1385316060, 0.0557341970], seeds=8)


@pytest.mark.parametrize("height", [1.0, 0.1, 0.01])
def test_area_light(height):
    """Lambert's closed form, however near the light."""
    points = on_floor()
    light = sf.AreaLight([0, 0, height], [0, 1, 0], [1, 0, 0], 1.0)
    error = assert_agrees(sf.Scene([speck()], [light]), points, UP, under_unit_square(points, height))
    assert error < 3e-3
    assert_agrees(sf.Scene([speck()], [light]), points, UP, under_unit_square(points, height), samples=256)


def test_lights_without_extent():
    """I cos / r^2, the same within a spot, E cos: exact, and shadows are sharp."""
    floor = patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.5)
    points, down = [[0.3, 0.4, 0.0], [0.0, 0.0, 0.0]], [0, 0, -1]
    point = sf.Scene([floor], [sf.PointLight([0, 0, 1], 3.0)])
    assert_agrees(point, points, UP, [3 / 1.25**1.5, 3.0])
    angle = np.degrees(np.arctan(0.5))
    spot = sf.Scene([floor], [sf.SpotLight([0, 0, 1], down, 3.0, cone=2 * angle + 10, penumbra=20)])
    assert_agrees(spot, points, UP, [0.5 * 3 / 1.25**1.5, 3.0])  # half way through the penumbra
    sun = sf.Scene([floor], [sf.DirectionalLight([0, 3, -4], 5.0)])
    assert_agrees(sun, points, UP, 4.0)
    shade = patch([0.1, 0.1, 0.5], [0.2, 0, 0], [0, 0.2, 0], 0.0)
    value, _ = sf.reference_irradiance(sf.Scene([floor, shade], point.lights), points, [UP, UP], samples=16)
    np.testing.assert_allclose(value[:, 0], [0.0, 3.0], rtol=1e-9)  # the shade's back is black: nothing else comes


def test_many_lights_at_once():
    """One shadow ray for all of them: their sum, without noise from which is chosen where they are alike."""
    lights = [sf.PointLight([x, 0, 1], [1.0, 2.0, 3.0]) for x in (-0.5, 0.0, 0.5)]
    lights += [sf.DirectionalLight([0, 0, -1], 0.5), sf.Environment(1.0)]
    value, error = sf.reference_irradiance(sf.Scene([speck()], lights), [[0, 0, 0]], [UP], samples=4096)
    expected = np.array([1, 2, 3]) * (1 + 2 / 1.25**1.5) + 0.5 + np.pi
    assert np.all(np.abs(value[0] - expected) < 4.5 * error[0] + 1e-9)
    assert np.all(error[0] < 0.01 * expected)


def test_disk_that_hides_the_sky():
    """A black disk takes its form factor away: .5 on axis."""
    disk = surfels_of([[0, 0, 1]], [[0, 0, 1]], 0.0, radii=1.0)  # its back, which absorbs, is seen
    scene = sf.Scene([disk], [sf.Environment(1.0)])
    assert_agrees(scene, [[0, 0, 0], [0.5, 0, 0]], UP, np.pi * np.array([0.5, 1 - 0.4379826327]), seeds=8)


def test_one_bounce_between_plates():
    """Floor lit by the sun alone, seen from the black ceiling: rho E F for a floor without end."""
    floor = patch([-500, -500, 0], [1000, 0, 0], [0, 1000, 0], [0.8, 0.5, 0.2])
    value, _ = sf.reference_irradiance(
        sf.Scene([floor], [sf.DirectionalLight([0, 0, -1], 10.0)]), [[0, 0, 1.0]], [[0, 0, -1]], samples=4096
    )
    np.testing.assert_allclose(value[0], [8.0, 5.0, 2.0], rtol=1e-4)


def test_same_for_any_number_of_threads_and_by_seed():
    scene = sf.Scene([cube_inside(2, 0.5, 0.1)], [sf.PointLight([0.5, 0.5, 0.5], 1.0)])
    points = np.c_[even(8), np.zeros(8)]
    run = {t: sf.reference_irradiance(scene, points, [UP] * 8, samples=256, threads=t) for t in (1, 2, 4)}
    for t in (2, 4):
        np.testing.assert_array_equal(run[1], run[t])
    assert np.any(sf.reference_irradiance(scene, points, [UP] * 8, samples=256, seed=1)[0] != run[1][0])
    # A point's value does not depend on which others are asked with it, but for its place in the list.
    alone, _ = sf.reference_irradiance(scene, points[:1], [UP], samples=256)
    np.testing.assert_array_equal(alone[0], run[1][0][0])


def test_errors_and_cancel():
    cube = cube_inside(1)
    scene, at = sf.Scene([cube]), ([[0.5, 0.5, 0]], [UP])
    with pytest.raises(ValueError, match="scene: wanted a Scene, got Surfels"):
        sf.reference_irradiance(cube, *at)
    with pytest.raises(ValueError, match=r"points: wanted shape \(n, 3\), got \(3,\)"):
        sf.reference_irradiance(scene, [0, 0, 0], [UP])
    with pytest.raises(ValueError, match=r"normals: wanted shape \(1, 3\), got \(2, 3\)"):
        sf.reference_irradiance(scene, at[0], [UP, UP])
    with pytest.raises(ValueError, match="normals: wanted vectors of non-zero length"):
        sf.reference_irradiance(scene, at[0], [[0, 0, 0]])
    with pytest.raises(ValueError, match="samples: wanted a whole number from 16 to"):
        sf.reference_irradiance(scene, *at, samples=15)
    with pytest.raises(ValueError, match="seed: wanted a whole number"):
        sf.reference_irradiance(scene, *at, seed=-1)
    with pytest.raises(ValueError, match="threads: wanted a whole number"):
        sf.reference_irradiance(scene, *at, threads=0)
    with pytest.raises(sf.Cancelled):
        sf.reference_irradiance(scene, *at, progress=lambda done, total: False)
    seen = []
    sf.reference_irradiance(scene, *at, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1][0] == seen[-1][1]
    assert scene.surfels.areas is not None  # a mesh has them; the pass left the scene as it was
