"""Effective areas: closed forms, Voronoi cells, quadrature weights, invariances, and the shares of a disk."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

import surflux as sf
from surflux.bench import clouds
from surflux.geometry import areas
from surflux.scenes import shapes


def relative_total(cloud, **options):
    return sf.effective_areas(cloud.surfels(), **options).sum() / cloud.area - 1


def per_surfel(cloud):
    """Root mean square of the relative differences from the cells, and the extremes of the ratio."""
    ratio = sf.effective_areas(cloud.surfels()) / cloud.cells
    return np.sqrt(np.mean((ratio - 1) ** 2)), ratio.min(), ratio.max()


@pytest.mark.parametrize(
    ("make", "n", "within"),
    [
        (clouds.icosphere, 642, 0.001),
        (clouds.icosphere, 2562, 0.001),
        (clouds.fibonacci_sphere, 642, 0.001),
        (clouds.fibonacci_sphere, 10_000, 0.001),
        (clouds.random_sphere, 2000, 0.003),
        (clouds.random_sphere, 35_000, 0.003),
        (clouds.random_torus, 3000, 0.005),
        (clouds.uneven_sphere, 5000, 0.01),
    ],
)
def test_total_areas(make, n, within):
    assert abs(relative_total(make(n))) < within


def test_single_areas_are_those_of_voronoi_cells():
    assert per_surfel(clouds.fibonacci_sphere(642))[0] < 0.02
    for seed in range(3):
        assert per_surfel(clouds.random_sphere(2000, seed))[0] < 0.15


@pytest.mark.slow
def test_totals_converge_faster_than_second_order():
    # Of the random torus: an ellipsoid's curvature varies too, but its area is no closed form.
    errors = []
    for n in (250, 1000, 4000, 16_000):
        errors.append(np.mean([abs(relative_total(clouds.random_torus(n, seed))) for seed in range(4)]))
    order = -np.polyfit(np.log([250, 1000, 4000, 16_000]), np.log(errors), 1)[0]
    assert order > 1.0  # in n; 1 is second order in the spacing


@pytest.mark.slow
def test_as_quadrature_weights_they_converge_and_beat_equal_ones():
    sizes, ours, equal = (500, 2000, 8000, 32_000), [], []
    for n in sizes:
        found = []
        for seed in range(2):
            cloud = clouds.random_sphere(n, seed)
            basis = clouds.harmonics(cloud.points)
            areas = sf.effective_areas(cloud.surfels())
            found.append([np.mean((basis @ areas) ** 2), np.mean((basis.mean(axis=1) * cloud.area) ** 2)])
        o, e = np.sqrt(np.mean(found, axis=0))
        ours.append(o)
        equal.append(e)
    assert np.all(np.array(ours) < 0.2 * np.array(equal))
    order = -np.polyfit(np.log(sizes), np.log(ours), 1)[0]
    assert order > 1.0  # equal weights: 1/2


@pytest.mark.parametrize("seed", [0, 2, 7])  # 2 and 7 have points right beside a corner
@pytest.mark.parametrize("inward", [False, True])
def test_creases_end_a_disk(inward, seed):
    cloud = clouds.cube(400, seed)
    normals = -cloud.normals if inward else cloud.normals
    areas = sf.effective_areas(sf.Surfels(cloud.points, normals))
    assert areas.sum() == pytest.approx(6.0, rel=0.001)
    ratio = areas / cloud.cells
    assert ratio.min() > 0.5
    assert ratio.max() < 2.0


def test_borders_end_a_disk():
    for seed in range(3):
        cloud = clouds.open_square(1000, seed)
        areas = sf.effective_areas(cloud.surfels())
        assert areas.sum() == pytest.approx(1.0, rel=0.02)
        ratio = areas / cloud.cells
        assert ratio.min() > 0.5
        assert ratio.max() < 2.0


def test_borders_of_dart_throwing():
    darts = qmc.PoissonDisk(2, radius=0.0278, seed=1).fill_space()
    flat = sf.Surfels(np.insert(darts, 2, 0.0, axis=1), np.tile([0.0, 0.0, 1.0], (len(darts), 1)))
    assert sf.effective_areas(flat).sum() == pytest.approx(1.0, rel=0.02)


def test_borders_of_a_curved_sheet():
    sphere = clouds.fibonacci_sphere(4000)
    cap = sphere.points[:, 2] > 0.5
    areas = sf.effective_areas(sf.Surfels(sphere.points[cap], sphere.normals[cap]))
    assert areas.sum() == pytest.approx(np.pi, rel=0.02)  # 2 pi (1 - z)


@pytest.mark.parametrize("make", [clouds.fibonacci_sphere, clouds.random_sphere])
def test_noise(make):
    for seed in range(2):
        assert abs(relative_total(clouds.noisy(make(2000), seed=seed))) < 0.02


@pytest.mark.parametrize("make", [clouds.fibonacci_sphere, clouds.random_sphere, clouds.open_square])
def test_points_stored_twice_share_their_area(make):
    cloud = make(1000)
    once = sf.effective_areas(cloud.surfels())
    double = sf.effective_areas(clouds.twice(cloud).surfels())
    np.testing.assert_allclose(double[:1000], double[1000:], rtol=1e-5)
    assert double.sum() == pytest.approx(once.sum(), rel=2e-3)
    # A cell's area changes only by how often its neighbours count in the fit.
    np.testing.assert_allclose(2 * double[:1000], once, rtol=0.05)


@pytest.mark.parametrize("method", ["curved", "paper"])
@pytest.mark.parametrize("make", [clouds.random_sphere, clouds.open_square])
@given(seed=st.integers(0, 1000), exponent=st.sampled_from([-6, 0, 6]))
@settings(max_examples=5, deadline=None)
def test_areas_turn_and_scale_with_the_cloud(method, make, seed, exponent):
    cloud, scale = make(500), 10.0**exponent
    radii = cloud.surfels().radii
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    before = sf.effective_areas(sf.Surfels(cloud.points, cloud.normals, radii=radii), method=method)
    turned = sf.Surfels(scale * cloud.points @ turn.T, cloud.normals @ turn.T, radii=scale * radii)
    after = sf.effective_areas(turned, method=method) / scale**2
    np.testing.assert_allclose(after, before, rtol=1e-4)


@pytest.mark.parametrize("method", ["curved", "paper"])
def test_survey_coordinates_cost_nothing(method):
    cloud = clouds.random_sphere(500)
    radii = cloud.surfels().radii
    before = sf.effective_areas(sf.Surfels(cloud.points, cloud.normals, radii=radii), method=method)
    far = sf.Surfels(cloud.points + np.array([5e6, -5e6, 5e6]), cloud.normals, radii=radii)
    np.testing.assert_allclose(sf.effective_areas(far, method=method), before, rtol=1e-4)


@pytest.mark.parametrize("method", ["curved", "paper"])
@given(seed=st.integers(0, 1000), index=st.integers(0, 299))
@settings(max_examples=10, deadline=None)
def test_shares_are_a_partition_of_unity(method, seed, index):
    s = clouds.random_sphere(300, seed).surfels()
    found = sf.area_shares(s, index, method=method, resolution=16)
    counted = ~np.isnan(found.shares[0])
    assert found.neighbors[0] == index
    assert len(set(found.neighbors)) == len(found.neighbors)
    assert np.all(found.shares[:, counted] >= 0)
    np.testing.assert_allclose(found.shares[:, counted].sum(axis=0), 1.0, rtol=1e-12)
    assert found.extent == pytest.approx((1.3 if method == "curved" else 1.0) * s.radii[index])
    np.testing.assert_allclose(found.frame @ found.frame.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(found.frame[2], s.normals[index], atol=1e-12)


def test_shares_of_negative_indices_and_refusals():
    s = clouds.random_sphere(100).surfels()
    assert sf.area_shares(s, -1).area == sf.area_shares(s, 99).area == sf.effective_areas(s)[99]
    for index in (100, -101, 1.5, True, None):
        with pytest.raises(ValueError, match=r"^index: wanted"):
            sf.area_shares(s, index)
    patch = sf.Surfels.from_mesh((np.eye(3), np.array([[0, 1, 2]])))
    with pytest.raises(ValueError, match=r"^index: surfel 0 is a patch"):
        sf.area_shares(patch, 0)


@pytest.mark.scans
@pytest.mark.parametrize(
    ("name", "within"), [("bunny_34834", 0.02), pytest.param("armadillo_43k", 0.03, marks=pytest.mark.slow)]
)
def test_statues(scans, name, within):
    from surflux.meshes.reading import read_mesh

    path = scans / "statues" / f"{name}.ply"
    mesh = read_mesh(path)
    a, b, c = np.moveaxis(mesh.vertices[mesh.indices.reshape(-1, 3)], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    cloud = sf.read(path)
    assert sf.effective_areas(cloud).sum() == pytest.approx(area, rel=within)


def test_the_area_of_very_many_surfels_is_told_from_some(monkeypatch):
    ball = shapes.sphere(4000)
    whole = areas.surface_area(ball)
    assert whole == sf.effective_areas(ball).sum()
    monkeypatch.setattr(areas, "_ENOUGH", 1000)
    assert areas.surface_area(ball) == pytest.approx(whole, rel=0.03)
    assert areas.surface_area(ball) != whole
    ball.areas = 0.5
    assert areas.surface_area(ball) == 2000.0
