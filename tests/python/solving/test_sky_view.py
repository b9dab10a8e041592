"""Sky-view factors, of both definitions, against closed forms."""

import warnings

import numpy as np
import pytest

import surflux as sf
from canyons import canyon, floor_view, wall_view


def tilted(angle, azimuth=30.0):
    """One square that faces azimuth, tilted by an angle, in degrees."""
    b, a = np.radians(angle), np.radians(azimuth)
    normal = np.array([np.sin(b) * np.sin(a), np.sin(b) * np.cos(a), np.cos(b)])
    u = np.array([np.cos(a), -np.sin(a), 0.0])
    v = np.cross(normal, u)
    return sf.Surfels.from_mesh(([-u - v, u - v, u + v, v - u], [[0, 1, 2, 3]]))


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 90.0, 130.0, 180.0])
def test_open_planes_are_exact(angle):
    cosine = sf.sky_view_factor(tilted(angle), "cosine", rays=16)
    solid_angle = sf.sky_view_factor(tilted(angle), "solid_angle", rays=16)
    assert cosine == pytest.approx([0.5 * (1.0 + np.cos(np.radians(angle)))], abs=1e-7)
    assert solid_angle == pytest.approx([1.0 - angle / 180.0], abs=1e-7)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_infinite_canyon(seed):
    """At middles of strips; means over floor and wall by 16 midpoints are sqrt 2 - 1 and 1 - sqrt .5 to 2e-4."""
    surfels, at = canyon()
    view = sf.sky_view_factor(surfels, rays=4096, seed=seed)
    floor, left, right = view[:16], view[16:32], view[32:48]
    np.testing.assert_allclose(floor, floor_view(at), atol=0.004)
    np.testing.assert_allclose(left, wall_view(at), atol=0.004)
    np.testing.assert_allclose(right, wall_view(at), atol=0.004)
    assert floor.mean() == pytest.approx(np.sqrt(2.0) - 1.0, abs=0.002)
    assert left.mean() == pytest.approx(1.0 - np.sqrt(0.5), abs=0.002)
    assert view[7:9] == pytest.approx([0.447214] * 2, abs=0.006)


def test_a_canyon_by_solid_angle():
    """Wedges between the walls' tops: of the angle pi a wedge has its own share, whatever the cosines."""
    surfels, at = canyon()
    view = sf.sky_view_factor(surfels, "solid_angle", rays=4096)
    wedge = (np.arctan(at) + np.arctan(1.0 - at)) / np.pi
    np.testing.assert_allclose(view[:16], wedge, atol=0.004)
    np.testing.assert_allclose(view[16:32], np.arctan(1.0 / (1.0 - at)) / np.pi, atol=0.004)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_courtyard(seed):
    """2 x 3 wide and 1.5 deep, from the middle of its floor: the open rectangle above is a parallel one, of which the
    view factor and the solid angle are known; 4096 rays are off by .1 % of the sky (RMS, `sky_view_factor`).
    """
    a, b, h = 1.0, 1.5, 1.5
    corners = [[x, y, z] for z in (0.0, h) for x, y in ((-a, -b), (a, -b), (a, b), (-a, b))]
    inwards = [[0, 1, 2, 3], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    view = {name: sf.sky_view_factor(sf.Surfels.from_mesh((corners, inwards)), name, rays=4096, seed=seed)
            for name in ("cosine", "solid_angle")}  # fmt: skip
    x, y = a / h, b / h
    p, q = np.hypot(1.0, x), np.hypot(1.0, y)
    cosine = 2.0 / np.pi * (x / p * np.arctan(y / p) + y / q * np.arctan(x / q))
    solid_angle = 4.0 * np.arctan(a * b / (h * np.sqrt(a * a + b * b + h * h))) / (2.0 * np.pi)
    assert view["cosine"][0] == pytest.approx(cosine, abs=0.004)
    assert view["solid_angle"][0] == pytest.approx(solid_angle, abs=0.004)


@pytest.mark.slow
def test_what_irradiance_by_an_even_sky_says():
    """Cosine-weighted, it is irradiance by a sky of radiance 1 over the horizon, over pi: of a bumpy cloud."""
    rng = np.random.default_rng(0)
    xy = rng.uniform(0.0, 10.0, (3000, 2))
    x, y = xy.T
    height = np.sin(2.0 * x) * np.cos(1.5 * y)
    slope = np.c_[-2.0 * np.cos(2.0 * x) * np.cos(1.5 * y), 1.5 * np.sin(2.0 * x) * np.sin(1.5 * y), np.ones(len(x))]
    cloud = sf.Surfels(np.c_[xy, height], slope)
    image = np.zeros((2, 4, 3))
    image[0] = 1.0
    chosen = slice(0, 3000, 10)
    scene = sf.Scene([cloud], lights=[sf.Environment(image)])
    true, _ = sf.reference_irradiance(
        sf.Scene([sf.Surfels(cloud.points, cloud.normals, radii=cloud.radii, reflectance=0.0)], scene.lights),
        cloud.points[chosen],
        cloud.normals[chosen],
        samples=4096,
    )
    found = sf.sky_view_factor(scene, rays=512)[chosen]
    error = np.sqrt(np.mean((found - true[:, 0] / np.pi) ** 2) / np.mean((true[:, 0] / np.pi) ** 2))
    assert error < 0.012
    coarse = sf.sky_view_factor(scene, rays=64)[chosen]
    assert error < np.sqrt(np.mean((coarse - true[:, 0] / np.pi) ** 2))


def test_the_same_for_any_threads_and_for_a_seed():
    surfels, _ = canyon(4, 3)
    one = sf.sky_view_factor(surfels, rays=64, threads=1)
    np.testing.assert_array_equal(one, sf.sky_view_factor(surfels, rays=64, threads=2))
    assert (one != sf.sky_view_factor(surfels, rays=64, seed=1)).any()


def test_progress_goes_on_from_part_to_part():
    surfels, told = canyon(4, 3)[0], []
    sf.sky_view_factor(surfels, rays=2048, progress=lambda done, total: told.append((done, total)))
    whole = 2 * len(surfels)  # parts of 1024 rays
    first = max(k for k, (done, _) in enumerate(told) if done == 0)
    done = [each for each, total in told[first:] if total == whole]
    assert len(done) == len(told) - first
    assert done == sorted(done)
    assert len(surfels) in done
    assert done[-1] == whole


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scene": 1}, "^scene: wanted a Scene or Surfels, got int"),
        ({"weighting": "visible"}, "^weighting: wanted one of 'cosine', 'solid_angle', got 'visible'"),
        ({"rays": 8}, "^rays: wanted a whole number from 16 to 65536"),
        ({"seed": -1}, "^seed: wanted a whole number"),
    ],
)
def test_arguments_are_checked(options, message):
    with pytest.raises(ValueError, match=message):
        sf.sky_view_factor(**({"scene": tilted(0.0)} | options))


def uneven_plane(noise, seed, count=3000, apart=0.0):
    """A level square, sampled evenly, with noise and every other point higher by so much, in spacings."""
    side = int(np.sqrt(count))
    random = np.random.default_rng(seed)
    xy = (np.indices((side, side)).reshape(2, -1).T + random.uniform(0.15, 0.85, (side * side, 2))) / side
    z = noise * random.normal(size=len(xy)) + apart * random.integers(0, 2, len(xy))
    inside = (np.abs(xy - 0.5) < 0.35).all(axis=1)
    return sf.Surfels(np.c_[xy, z / side], viewpoint=[0.5, 0.5, 9.0]), inside


def told(function, *arguments, **options):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return function(*arguments, **options), [w for w in said if "are backs of others close by" in str(w.message)]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("noise", "apart", "share"), [(0.5, 0.0, 0.9), (1.0, 0.0, 0.8), (0.0, 1.0, 0.95)])
def test_noise_and_strips_apart_that_hide_the_sky_are_told(seed, noise, apart, share):
    """Of an open level plane, which sees all of it; and in the way of paths as of rays."""
    surfels, inside = uneven_plane(noise, seed, apart=apart)
    view, said = told(sf.sky_view_factor, surfels)
    assert view[inside].mean() < share
    assert len(said) == 1
    thinned = surfels.thinned(len(surfels) // 4)
    middle = (np.abs(thinned.points[:, :2] - 0.5) < 0.35).all(axis=1)
    assert told(sf.sky_view_factor, thinned)[0][middle].mean() > view[inside].mean() + 0.03
    some = np.flatnonzero(inside)[:50]
    scene = sf.Scene([surfels], [sf.Environment(1.0)])
    (found, _), said = told(sf.reference_irradiance, scene, surfels.points[some], surfels.normals[some], 16)
    assert found.mean() < share * np.pi + 0.1
    assert len(said) == 1


@pytest.mark.parametrize("seed", range(3))
def test_surfaces_and_backs_far_away_are_no_noise(seed):
    """Roofs alone, whose backs the ground sees, as of airborne tiles; and meshes."""
    smooth, inside = uneven_plane(0.05, seed)
    roof = uneven_plane(0.05, seed)[0].points * [0.4, 0.4, 1.0] + [0.3, 0.3, 0.3]
    roofed = sf.Surfels(np.vstack([smooth.points, roof]), np.tile([0.0, 0.0, 1.0], (len(smooth) + len(roof), 1)))
    view, said = told(sf.sky_view_factor, smooth)
    assert said == []
    assert view[inside].mean() > 0.99
    assert told(sf.sky_view_factor, roofed)[1] == []
    assert told(sf.sky_view_factor, canyon()[0])[1] == []
