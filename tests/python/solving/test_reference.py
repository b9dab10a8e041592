"""The path tracer against closed forms: z-scores, by a chi-square over points and seeds.

Here are places and sizes that ask something of it alone; the scenes of tests/cases are in test_cases.py.
"""

import numpy as np
import pytest
from scipy import stats

import surflux as sf
from cases import chance
from cases.closed_forms import element_to_parallel_rectangle
from scenes import ball_inside, cube_inside, patch, surfels_of
from surflux.scenes import shapes

UP = (0.0, 0.0, 1.0)


def assert_agrees(scene, points, normals, expected, *, samples=4096, seeds=2, exact=1e-6):
    """Chi-square p > 1e-3 and no |z| above 4.5; where there is no spread, the value itself. Returns the mean error."""
    points = np.atleast_2d(np.asarray(points, float))
    normals = np.broadcast_to(np.asarray(normals, float), points.shape)
    expected = np.broadcast_to(np.asarray(expected, float), len(points))
    scores, errors = [], []
    for seed in range(seeds):
        value, error = (a[:, 0] for a in sf.reference_irradiance(scene, points, normals, samples=samples, seed=seed))
        sure = error < 1e-9 * np.maximum(1, expected)
        np.testing.assert_allclose(value[sure], expected[sure], rtol=exact, atol=exact)
        scores.append(chance.scores(value[~sure], expected[~sure], error[~sure], samples))
        errors.append(error)
    z = np.concatenate(scores)
    if len(z):
        largest, probability, lean = chance.agreement(z)
        assert largest < chance.LARGEST_SCORE
        assert probability > chance.LEAST_PROBABILITY
        assert abs(lean) < 4  # all points off to the same side
    return np.mean(errors)


def even(n, dimensions=2):
    return stats.qmc.Halton(dimensions, seed=7).random(n)


def on_floor(n=64, low=-0.5, high=1.5):
    return np.c_[low + (high - low) * even(n), np.zeros(n)]


def under_unit_square(points, height):
    return element_to_parallel_rectangle(points[:, 0], points[:, 1], (0, 0), (1, 1), height)


def ceiling(height, patch_area=None, emission=1.0):
    """The unit square, facing down."""
    return patch([0, 0, height], [0, 1, 0], [1, 0, 0], 0.0, emission, patch_area)


def speck(rho=0.5):
    """A surface for scenes that need one, far away and small."""
    return patch([0, 0, -1e3], [1, 0, 0], [0, 1, 0], rho)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.98])
@pytest.mark.slow
def test_furnace(rho):
    """B = E / (1 - rho) all over, so H = 1 / (1 - rho); the polygons of a cube close exactly."""
    cube = cube_inside(2, rho, 1.0)
    floor = np.c_[even(16), np.zeros(16)]
    points = np.r_[cube.points, floor, [[0, 0, 0], [0.5, 0, 0], [0.5, 0.5, 0]]]  # on edges and corners of patches, too
    normals = np.r_[cube.normals, np.tile(UP, (19, 1))]
    assert_agrees(sf.Scene([cube]), points, normals, 1 / (1 - rho), samples=1024)


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.999, 1.0, 1.01])
def test_convex_cloud_under_a_uniform_sky(height):
    """H = pi L for whatever lies on it, between its disks, a little above or below: exactly."""
    cloud = ball_inside(642, rho=0.5, sign=1)
    points = even(256, 3) - 0.5
    points /= np.linalg.norm(points, axis=1)[:, None]
    scene = sf.Scene([cloud], [sf.Environment(2.0)])
    assert_agrees(scene, np.r_[height * points, cloud.points[:64]], np.r_[points, cloud.points[:64]], 2 * np.pi)


@pytest.mark.parametrize("radius", [0.5, 0.2])  # met by chance, and aimed at
@pytest.mark.slow
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


def test_a_disk_that_lies_on_a_place_face_to_face_covers_it():
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    floor = sf.Surfels.from_mesh((square, [[0, 1, 2, 3]]), 0.25, reflectance=0.5)
    disks = sf.Surfels(floor.points, -floor.normals, radii=0.2, areas=0.1, emission=1.0)
    scene = sf.Scene([floor, disks], [sf.PointLight([0.5, 0.5, 1.0], 1.0)])
    irradiance, _ = sf.reference_irradiance(scene, floor.points, floor.normals, samples=64)
    assert (irradiance == 0).all()


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


@pytest.mark.parametrize("below", [1e-5, 1e-4])
def test_places_that_rounding_puts_behind_their_surface(below):
    """They had 0 +- 0, without a word; where they are farther behind, they are in the body."""
    scene = sf.Scene([patch([-2, -2, 0], [4, 0, 0], [0, 4, 0], 0.5, patch_area=0.1)], [sf.PointLight([0, 0, 2], 10.0)])
    for depth, expected in ((below, 2.5), (0.05, 0.0)):
        (value,), (error,) = sf.reference_irradiance(scene, [[0.01, 0.02, -depth]], [UP], samples=16)
        np.testing.assert_allclose(value, expected, rtol=1e-3)
        assert error.max() < 1e-3
        looks = {"reflectance": 0.5, "specular": 0.0, "exponent": 1.0, "samples": 16}
        (value,), _ = sf.reference_radiance(scene, [[0.01, 0.02, -depth]], [UP], [UP], **looks)
        np.testing.assert_allclose(np.pi * value, 0.5 * expected, rtol=1e-3)


def test_places_inside_a_body_stay_there_far_from_the_origin():
    """Floats of coordinates of millions differ by .5: places that far below a roof had the sun on it."""
    vertices, faces, _ = shapes.box([4.0, 4.0, 1.0], 4)
    far = np.array([5e5, 5.8e6, 0.0])
    slab = sf.Surfels.from_mesh((np.asarray(vertices) + far, faces), reflectance=0.0)
    scene = sf.Scene([slab], [sf.DirectionalLight([0, 0, -1], 800.0)])
    value, _ = sf.reference_irradiance(scene, np.add(far, [[2.1, 2.2, 0.5], [2.1, 2.2, 1.0]]), [UP, UP], samples=16)
    np.testing.assert_allclose(value[:, 0], [0.0, 800.0])
