"""Surfels that transport="pairs" inserts: steep light is found at them, as at the scene's own, not interpolated."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

LAMP = [[0.9, 0.9, 1.2], [0.9, 1.1, 1.2], [1.1, 1.1, 1.2], [1.1, 0.9, 1.2]]


def on_a_floor(*more, lights=()):
    """A box on coarse patches, and what else there is."""
    floor = sf.Surfels.from_mesh(
        (np.add([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [-2, -2, 0]), [[0, 1, 2, 3]]), 0.25
    )
    vertices, faces, _ = shapes.box((0.8, 0.8, 0.8), 3)
    return sf.Scene([floor, sf.Surfels.from_mesh((np.add(vertices, [-0.3, -0.2, 0]), faces)), *more], lights)


def under_a_sun():
    sky = np.full((64, 128, 3), 0.3)
    sky[14, 40] = 600.0
    return on_a_floor(lights=[sf.Environment(sky)])


def under_a_mesh_lamp():
    return on_a_floor(sf.Surfels.from_mesh((np.array(LAMP), [[0, 1, 2, 3]]), reflectance=0.0, emission=50.0))


@pytest.mark.filterwarnings("ignore:object 0. walls of other objects")
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("scene", "most"), [(under_a_sun, 0.1), (under_a_mesh_lamp, 0.06)])
def test_inserted_surfels_have_shadows_of_skies_and_mesh_lamps(scene, most, seed):
    """Means over them by path tracing: .18 and .09 were off where that light was interpolated between patches."""
    solution = sf.solve(scene(), transport="pairs", seed=seed)
    s = solution.surfels
    inserted = np.flatnonzero((np.bincount(solution.parents)[solution.parents] > 1) & (s.points[:, 2] < 1e-6))
    assert len(inserted) > 50
    random = np.random.default_rng(seed)
    places = s.points[inserted].repeat(64, axis=0)
    places[:, :2] += (random.random((len(places), 2)) - 0.5) * np.sqrt(s.areas[inserted])[:, None].repeat(64, axis=0)
    found, _ = sf.reference_irradiance(scene(), places, np.tile([0.0, 0.0, 1.0], (len(places), 1)), samples=64)
    wanted = found.reshape(-1, 64, 3).mean(axis=1)
    off = solution.irradiance[inserted] - wanted
    assert np.sqrt((off**2).mean() / (wanted**2).mean()) < most
    assert solution.error < 0.02


@pytest.mark.parametrize("seed", range(3))
def test_inserted_surfels_under_a_cloud_that_shines(seed):
    """Rays to its overlapping disks are noise of 15 %, and all pairs have none: .2 % became 10 by insertion."""
    corners = [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.02)
    normals = np.random.default_rng(seed).normal(size=(600, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lamp = sf.Surfels(0.15 * normals + [0.0, 0.0, 1.0], normals=normals, reflectance=0.0, emission=10.0)
    solution = sf.solve(sf.Scene([floor, lamp]), transport="pairs", seed=seed)
    assert len(solution.surfels) > 1.5 * (len(floor) + len(lamp))
    true = 10.0 * 0.15**2 / (floor.points[:, 0] ** 2 + floor.points[:, 1] ** 2 + 1.0) ** 1.5
    off = solution.per_surfel()[: len(floor), 0] - true
    assert np.sqrt(np.mean(off**2) / np.mean(true**2)) < 0.01


def test_what_is_inserted_reflects_as_its_point_does():
    """Black points beside white ones were a mixture where a border of shadow passes: B was up to 20 times rho H."""
    random = np.random.default_rng(0)
    points = np.column_stack([random.uniform(-1, 1, (1500, 2)), np.zeros(1500)])
    rho = np.where(random.random(1500) < 0.5, 0.1, 0.9)
    cloud = sf.Surfels(points, normals=[[0, 0, 1]] * 1500, reflectance=rho)
    corners = [[-0.4, -0.4, 0.5], [0.4, -0.4, 0.5], [0.4, 0.4, 0.5], [-0.4, 0.4, 0.5]]
    plate = sf.Surfels.from_mesh((corners, [[3, 2, 1, 0]]), 0.02, two_sided=True)
    for transport in ("pairs", "rays"):
        scene = sf.Scene([cloud, plate], [sf.DirectionalLight([0.3, 0.1, -1.0], 2.0)])
        solution = sf.solve(scene, transport=transport)
        assert len(solution.surfels) > len(cloud) + len(plate)
        light, sent = (solution.per_surfel(name)[:1500, 0] for name in ("irradiance", "radiosity"))
        np.testing.assert_allclose(sent, rho * light, rtol=1e-5)
