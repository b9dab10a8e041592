"""What holds for every scene whatever: random small ones, of disks anywhere and meshes between them."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

import surflux as sf
from scenes import cube_inside, patch, solve_own


@st.composite
def scenes(draw):
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    objects = []
    for _ in range(draw(st.integers(1, 2))):
        n = draw(st.integers(1, 20))
        points = random.uniform(-1, 1, size=(n, 3))
        if draw(st.booleans()):  # on few places, so that disks touch, coincide and turn their backs on each other
            points = np.round(2 * points) / 2
        normals = random.normal(size=(n, 3))
        if draw(st.booleans()):
            normals = np.eye(3)[random.integers(3, size=n)] * random.choice([-1, 1], size=(n, 1))
        radii = random.uniform(0.05, draw(st.sampled_from([0.1, 0.5, 2.0])), n)
        # Areas of the disks' size: the solver takes them as they are.
        areas = np.pi * radii**2 * random.uniform(0.3, 1.0, n)
        rho, emission = (
            random.uniform(0, 0.99, (n, 3)),
            random.uniform(0, 2, (n, 3)) * (random.uniform(size=(n, 1)) < 0.5),
        )
        two_sided = draw(st.booleans())
        objects.append(
            sf.Surfels(
                points, normals, radii=radii, areas=areas, reflectance=rho, emission=emission, two_sided=two_sided
            )
        )
    if draw(st.booleans()):
        corner, u, w = random.uniform(-1, 1, size=(3, 3))
        objects.append(patch(corner, u, np.cross(u, w), rho=random.uniform(0, 0.99, 3), patch_area=draw(st.just(0.2))))
    if draw(st.booleans()):
        objects.append(cube_inside(draw(st.integers(1, 3)), random.uniform(0, 0.99, 3)))
    lights = [
        sf.PointLight(random.uniform(-1, 1, 3), random.uniform(0, 5, 3)),
        sf.DirectionalLight(random.normal(size=3), random.uniform(0, 5, 3)),
        sf.Environment(random.uniform(0, 2, 3)),
        sf.AreaLight(random.uniform(-1, 1, 3), [0.5, 0, 0], [0, 0.5, 0], random.uniform(0, 5, 3)),
    ]
    kept = draw(st.lists(st.sampled_from(range(4)), unique=True))
    return sf.Scene(objects, [lights[k] for k in kept])


SETTINGS = settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@SETTINGS
@given(scenes(), st.booleans())
@pytest.mark.slow
def test_the_exchange_is_reciprocal_and_closed(scene, visibility):
    areas = scene._to_core().surfels.areas  # which count once where disks of two objects are one surface
    if not visibility:
        factors = sf.form_factors(scene, visibility=False)
        escape = None
    else:
        factors, escape = sf.form_factors(scene, return_escape=True)
    assert np.all(np.isfinite(factors))
    assert factors.min() >= 0.0
    if visibility:
        assert factors.sum(axis=1).max() <= 1 + 1e-7
    exchange = areas[:, None] * factors
    np.testing.assert_allclose(exchange, exchange.T, rtol=1e-15, atol=0)
    if visibility:
        rows = factors.sum(axis=1) + escape
        assert escape.min() >= 0.0
        # A surfel shut in by front faces that it has no exchange with has nothing to close.
        closed = rows > 0
        np.testing.assert_allclose(rows[closed], 1.0, rtol=0, atol=1e-6)


@SETTINGS
@given(scenes())
@pytest.mark.slow
def test_light_is_neither_made_nor_lost(scene):
    solution = sf.solve(scene)
    s = solution.surfels
    for values in (solution.radiosity, solution.irradiance, solution.direct):
        assert np.all(np.isfinite(values))
    assert np.isfinite(solution.error) or not solution.irradiance.any()  # a part of nothing is unknown
    assert np.all(solution.direct >= 0)
    top = solution.irradiance.max()
    assert np.all(solution.irradiance >= solution.direct - 1e-3 * top)
    assert np.all(solution.radiosity >= s.emission - 1e-3 * top)
    figures = solution.history[-1]
    ends = figures["power_absorbed"] + figures["power_escaped"] + figures["power_into_backs"]
    assert abs(figures["power_in"] - ends) <= 1e-3 * figures["power_in"]


def with_materials(scene, reflectance, emission):
    """The same disks with other materials, and no light but their own."""
    objects, first = [], 0
    for s in scene.objects:
        part = slice(first, first + len(s))
        first += len(s)
        shape = {"radii": s.radii, "areas": s.areas}
        objects.append(sf.Surfels(s.points, s.normals, **shape, reflectance=reflectance[part], emission=emission[part]))
    return sf.Scene(objects)


@st.composite
def disks_and_seed(draw):
    """Disks alone, and what their materials are drawn with."""
    scene = draw(scenes())
    disks = [s for s in scene.objects if not len(s.triangles)]
    return sf.Scene(disks), np.random.default_rng(draw(st.integers(0, 2**32 - 1)))


@SETTINGS
@given(disks_and_seed())
@pytest.mark.slow
def test_radiosity_is_linear_in_emission(given):
    """B(a E + b E') = a B(E) + b B(E'), to what conjugate gradients leave. All emit in each: one set of rays."""
    scene, random = given
    n = len(scene.surfels)
    rho = random.uniform(0, 0.95, (n, 3))
    first, second = random.uniform(0.1, 1, (2, n, 3))
    one, two, both = (
        solve_own(with_materials(scene, rho, e), tolerance=1e-10).radiosity
        for e in (first, second, 2 * first + 3 * second)
    )
    np.testing.assert_allclose(both, 2 * one + 3 * two, rtol=1e-7)


@SETTINGS
@given(disks_and_seed())
@pytest.mark.slow
def test_whiter_walls_are_brighter(given):
    """B grows with every rho, everywhere, and is never below E: all F >= 0."""
    scene, random = given
    n = len(scene.surfels)
    emission = random.uniform(0, 1, (n, 3))
    rho = random.uniform(0, 0.9, (n, 3))
    more = rho + (0.99 - rho) * random.uniform(0, 1, (n, 3)) * (random.uniform(size=(n, 1)) < 0.3)
    low, high = (solve_own(with_materials(scene, r, emission), tolerance=1e-10).radiosity for r in (rho, more))
    assert np.all(low >= emission)
    assert np.all(high >= low * (1 - 1e-8))
