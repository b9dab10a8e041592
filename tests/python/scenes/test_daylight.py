"""Light and ground for clouds that have none."""

import numpy as np
import pytest

import surflux as sf
from surflux.points.layers import layer_of
from surflux.scenes.studio import daylight, ground


@pytest.mark.parametrize("eye", [(5, 0, 3), (-4, 4, 6), (0.1, -7, 1), (1, 1, 9)])
def test_the_sun_stands_over_the_left_shoulder(eye):
    """40 degrees high, 60 to the left of the way back: what is level has 800 sin 40 + 100 W/m2."""
    camera = sf.Camera(eye, [0, 0, 0])
    (sky,) = daylight(camera)
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1, reflectance=0.0)
    found = sf.solve(sf.Scene([floor], [sky])).irradiance
    assert found == pytest.approx(800.0 * np.sin(np.radians(40.0)) + 100.0, rel=0.01)
    (sun,) = (light for light in sky.lights if isinstance(light, sf.DirectionalLight))
    towards = -np.asarray(sun.direction)
    back = np.array([eye[0], eye[1], 0.0])
    back /= np.linalg.norm(back)
    left = np.cross(back, [0, 0, 1.0])  # of who looks along -back
    flat = towards[:2] / np.linalg.norm(towards[:2])
    assert towards[2] == pytest.approx(np.sin(np.radians(40.0)))
    assert flat @ back[:2] == pytest.approx(0.5)
    assert flat @ left[:2] == pytest.approx(np.sqrt(0.75))


@pytest.mark.parametrize("up", [(0, 1, 0), (0, 0, -2), (0.6, 0, 0.8), (-3, 0, 0)])
def test_a_day_stands_upright_as_up_says(up):
    """It stood along z, whatever --up said: a floor with y up had a sixth of the light that one with z up has."""
    axis = np.asarray(up) / np.linalg.norm(up)
    u = np.cross(axis, [0.36, 0.48, 0.8])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    lights = daylight(sf.Camera(5 * u + 3 * axis, [0, 0, 0], up=up), up)
    floor = sf.Surfels.from_mesh(([0 * u, u, u + v, v], [[0, 1, 2, 3]]), 0.1, reflectance=0.0)
    found = sf.solve(sf.Scene([floor], lights)).irradiance
    assert found == pytest.approx(800.0 * np.sin(np.radians(40.0)) + 100.0, rel=0.01)
    (sun,) = (light for light in lights if isinstance(light, sf.DirectionalLight))
    assert -np.asarray(sun.direction) @ axis == pytest.approx(np.sin(np.radians(40.0)))
    assert -np.asarray(sun.direction) @ u == pytest.approx(0.5 * np.cos(np.radians(40.0)))


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (0.6, 0, 0.8), (0, 0, -2)])
def test_a_ground_is_level_beneath_all(up):
    rng = np.random.default_rng(0)
    points = rng.uniform([1000, 0, 0], [1001, 2, 3], (5000, 3))
    axis = np.asarray(up) / np.linalg.norm(up)
    s = sf.Surfels(points, np.tile([0.0, 0, 1], (5000, 1)), radii=0.1)
    below = ground(s, up)
    assert below.normals == pytest.approx(np.tile(axis, (len(below), 1)))
    heights = below.points @ axis
    assert np.ptp(heights) < 1e-9
    assert 0.0005 <= np.mean(points @ axis < heights[0]) <= 0.003
    # A square three diagonals wide, around the middle.
    diagonal = np.linalg.norm([1, 2, 3])
    assert below.areas.sum() == pytest.approx((3 * diagonal) ** 2, rel=0.02)
    middle = below.points.mean(axis=0) - points.mean(axis=0)
    assert np.linalg.norm(middle - (middle @ axis) * axis) < 0.05


def test_terrain_is_told_from_bodies_and_walls():
    rng = np.random.default_rng(1)
    xy = rng.uniform(0, 100, (20_000, 2))
    hills = np.column_stack([xy, 5 * np.sin(xy[:, 0] / 15) * np.cos(xy[:, 1] / 12)])
    assert layer_of(hills) == "terrain"
    assert layer_of(hills[:, [0, 2, 1]]) is None
    ball = rng.normal(size=(20_000, 3))
    assert layer_of(ball / np.linalg.norm(ball, axis=1, keepdims=True)) is None
