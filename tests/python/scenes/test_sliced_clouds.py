"""One cloud as several objects, as a column of classes parts it: area and light of the whole."""

import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose

import surflux as sf

SUN = sf.DirectionalLight([0, 0, -1], 1.0)


def square(kind, n=3000, seed=0):
    rng = np.random.default_rng(seed)
    if kind == "grid":
        m = round(n**0.5)
        at = (np.stack(np.meshgrid(np.arange(m), np.arange(m)), -1).reshape(-1, 2) + 0.5) / m
    elif kind == "random":
        at = rng.random((n, 2))
    else:
        corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        at = sf.Surfels.sample_mesh((corners, [[0, 1, 2, 3]]), n, seed=seed).points[:, :2]
    points = np.c_[at, np.zeros(len(at))]
    return sf.Surfels(points, np.tile([0, 0, 1.0], (len(points), 1)), reflectance=0.3)


def sliced(cloud, seed=1):
    classes = np.random.default_rng(seed).integers(0, 3, len(cloud))
    return [cloud[classes == k] for k in range(3)]


def solved(objects, *lights):
    solution = sf.solve(sf.Scene(objects, list(lights)), insert=False, rays=16)
    return solution.surfels.areas.sum(), solution.history[-1]["power_in"] / 3


@pytest.mark.parametrize("kind", ["random", "grid", "blue"])
def test_classes_of_a_floor_in_the_sun(kind):
    cloud = square(kind)
    whole = solved([cloud], SUN)
    assert_allclose(solved(sliced(cloud), SUN), whole, rtol=0.01)
    assert_allclose(whole, 1.0, rtol=0.035)  # the border of a grid is half a cell farther out than disks go


def slabs(cloud, count):
    slab = np.minimum((count * cloud.points[:, 0]).astype(int), count - 1)
    return [cloud[slab == k] for k in range(count)]


@pytest.mark.parametrize("kind", ["random", "grid", "blue"])
def test_slabs_of_a_floor_go_on_in_each_other(kind):
    """What lies between the last points of one and the first of the next is theirs: 3 to 7 % of it were lost."""
    cloud = square(kind)
    assert_allclose(solved(slabs(cloud, 5), SUN), solved([cloud], SUN), rtol=0.005)


@pytest.mark.parametrize("part", [lambda cloud: slabs(cloud, 4), lambda cloud: [cloud[::2], cloud[1::2]]])
def test_slices_of_a_lamp_end_where_the_whole_does(part):
    """Slabs lost a tenth of the lamp's light; disks of mixed slices reached out over its border for rays."""
    cloud = square("blue", 200)
    lamp = sf.Surfels(cloud.points, -cloud.normals, radii=cloud.radii, reflectance=0.0, emission=1.0)
    corners = [[0, 0, -0.4], [1, 0, -0.4], [1, 1, -0.4], [0, 1, -0.4]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.05, reflectance=0.0)
    scenes = sf.Scene([floor, lamp]), sf.Scene([floor, *part(lamp)])
    whole, parts = (sf.reference_irradiance(s, floor.points, floor.normals, 1024)[0].mean() for s in scenes)
    assert_allclose(parts, whole, rtol=0.015)
    for transport in ("pairs", "rays"):
        solutions = [sf.solve(scene, transport=transport, insert=False) for scene in scenes]
        whole, parts = (solution.irradiance[: len(floor)].mean() for solution in solutions)
        assert_allclose(parts, whole, rtol=0.02)


def test_halves_of_a_glowing_ball():
    normals = np.random.default_rng(0).normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    ball = sf.Surfels(normals, normals, emission=1.0, reflectance=0.5)
    assert_allclose(solved([ball[::2], ball[1::2]]), 4 * np.pi, rtol=0.005)


def test_areas_given_to_the_whole_stay_in_its_classes():
    """They are shares already; two scans that have their own areas each share them."""
    cloud = square("random").replace(emission=1.0)
    cloud.areas = sf.effective_areas(cloud)
    parts = sliced(cloud)
    scene = sf.Scene(parts)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        areas = sf.solve(scene, insert=False, rays=16).surfels.areas
    assert np.array_equal(areas, np.concatenate([part.areas for part in parts]))
    other = square("random", 1500, seed=2)
    other.areas = sf.effective_areas(other)
    assert np.isclose(solved([cloud.replace(emission=0.0), other], SUN)[0], 1.0, rtol=0.02)


def test_a_lamp_of_points_keeps_its_border_in_a_sparser_ceiling():
    ceiling = square("grid", 100)
    hole = np.abs(ceiling.points[:, :2] - 0.5).max(axis=1) < 0.2
    lamp = square("grid", 900)
    lamp = sf.Surfels(lamp.points * 0.4 + [0.3, 0.3, 0.0], lamp.normals, emission=1.0)
    alone = solved([lamp])[0]
    assert_allclose(solved([ceiling[~hole], lamp])[1], alone, rtol=0.05)


@pytest.mark.parametrize("factor", [0.7, 0.8, 1.0])
def test_given_areas_that_fit_neither_reading_are_shared(factor):
    """Of two clouds on one floor: .7 of a cloud's own areas are nearer to a half than to all, and no half."""
    objects = [square("blue", seed=seed) for seed in (0, 1)]
    for cloud in objects:
        cloud.areas = factor * sf.effective_areas(cloud)
    area, power = solved(objects, SUN)
    assert area == pytest.approx(factor, rel=0.02)
    assert power == pytest.approx(factor, rel=0.02)
