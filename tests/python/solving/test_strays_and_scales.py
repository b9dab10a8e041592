"""What must not change a result: the unit of length, a stray far away, dropped returns piled up at one place."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from scenes import rms, surfels_of
from surflux.scenes import shapes

# Powers of 2 scale float64 without rounding, so that the same computation is done: 1.4e-20, 9.1e-13, 1.8e13, 7.0e13.
SCALES = [2.0**-66, 2.0**-40, 2.0**44, 2.0**46]


def lit_room(scale=1.0, stray_point=None, stray_triangle=None):
    """A room of 6 x 8 x 8 patches with a ball of 100 disks in it, under a lamp: in any unit of length."""
    vertices, faces, _ = shapes.box(1.0, 8, inward=True)
    faces = [list(face) for face in faces]
    if stray_triangle is not None:
        at = len(vertices)
        vertices = np.vstack([vertices, np.add([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [stray_triangle, 0, 0])])
        faces.append([at, at + 1, at + 2])
    room = sf.Surfels.from_mesh((vertices * scale, faces), reflectance=0.5)
    unit = shapes.sphere(100)
    ball = surfels_of((0.2 * unit.points + [0.5, 0.5, 0.4]) * scale, unit.normals, 0.6)
    strays = []
    if stray_point is not None:
        strays = [sf.Surfels([[stray_point, stray_point, 0]], [[0, 0, 1]], radii=[0.05], areas=[0.007])]
    lamp = sf.AreaLight(np.array([0.3, 0.3, 0.99]) * scale, [0, 0.4 * scale, 0], [0.4 * scale, 0, 0], 10.0)
    return sf.Scene([room, ball, *strays], lights=[lamp])


PASSES = {
    "pairs": lambda scene, _: sf.solve(scene, transport="pairs", insert=False).irradiance,
    "rays": lambda scene, _: sf.solve(scene, transport="rays", insert=False).irradiance,
    "reference": lambda scene, k: sf.reference_irradiance(
        scene, np.array([[0.5, 0.5, 0.0], [0.2, 0.1, 0.0]]) * k, [[0, 0, 1]] * 2, samples=256
    )[0],
    "form factors": lambda scene, _: sf.form_factors(scene),
    "areas": lambda scene, k: sf.effective_areas(scene.objects[1]) / k**2,
}


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", PASSES)
@pytest.mark.slow
def test_light_does_not_depend_on_the_unit_of_length(name, scale):
    """To the rounding of logarithms of lengths, which contour integrals add up: 1e-9, what form factors promise."""
    expected, found = PASSES[name](lit_room(), 1.0), PASSES[name](lit_room(scale), scale)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * expected.max())


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.slow
def test_light_by_functions_does_not_depend_on_the_unit_of_length(scale):
    """Points draw their numbers from where they are: another unit is another seed, and no farther off than one."""
    one = sf.solve_meshless(lit_room(), levels=3)
    other_seed = sf.solve_meshless(lit_room(), levels=3, seed=1)
    found = sf.solve_meshless(lit_room(scale), levels=3)
    areas = one.surfels.areas
    noise = rms(other_seed.irradiance, one.irradiance, areas)
    assert rms(found.irradiance, one.irradiance, areas) < 2 * noise  # sqrt(2) apart are two, and chance
    places, up = np.array([[0.2, 0.2, 0.0], [0.8, 0.3, 0.0]]), [[0, 0, 1]] * 2
    np.testing.assert_allclose(
        found.irradiance_at(places * scale, up, "interpolated"), one.irradiance_at(places, up, "interpolated"), rtol=0.1
    )


@pytest.mark.parametrize("name", ["pairs", "rays", "reference", "form factors"])
def test_scales_beyond_numbers_are_refused_by_name(name):
    with pytest.raises(ValueError, match=r"^(scene: it is|radii: the largest is) .* wanted between 1e-30 and 1e\+30"):
        PASSES[name](lit_room(1e-31), 1e-31)
    with pytest.raises(ValueError, match=r"^mesh vertices: wanted coordinates up to 1e\+30"):
        lit_room(1e31)


@pytest.mark.parametrize("scale", [1e-160, 1e-40])
def test_areas_beyond_numbers_are_refused_by_name(scale):
    unit = shapes.sphere(50)
    ball = sf.Surfels(unit.points * scale, unit.normals, radii=np.full(50, 0.3 * scale))
    with pytest.raises(ValueError, match=r"^radii: the largest is .* wanted between 1e-30 and 1e\+30"):
        sf.effective_areas(ball)


@pytest.mark.parametrize("distance", quick(1e5, of=[1e3, 1e5, 1e8]))
def test_a_stray_point_changes_nothing(distance):
    """By pairs: the same numbers, but for the stray's own share of light, below 1e-6 of any."""
    n = len(lit_room().surfels)
    expected = PASSES["pairs"](lit_room(), 1)
    np.testing.assert_allclose(PASSES["pairs"](lit_room(stray_point=distance), 1)[:n], expected, rtol=1e-6)
    for name in ("reference", "areas"):
        expected = PASSES[name](lit_room(), 1.0)
        np.testing.assert_allclose(PASSES[name](lit_room(stray_point=distance), 1.0), expected, rtol=1e-6)


def test_a_surface_beyond_all_floats_is_refused():
    with pytest.raises(ValueError, match=r"^scene: surfel 484 reaches .* leave it out"):
        sf.solve(lit_room(stray_point=1e13))


@pytest.mark.parametrize("distance", [None, 1e3, 1e5, 1e8])
def test_a_sheet_close_over_a_floor_stands_apart_from_it(distance):
    """1 mm over a floor of 2 m: black below it, pi above it under a uniform sky, wherever a stray is."""
    across = np.linspace(-1, 1, 41)
    flat = np.stack(np.meshgrid(across, across, [0.0]), axis=-1).reshape(-1, 3)
    up = [[0, 0, 1]] * len(flat)
    objects = [sf.Surfels(flat, up), sf.Surfels(flat * 0.3 + [0, 0, 1e-3], up)]
    if distance is not None:
        objects.append(sf.Surfels([[distance, distance, 0]], [[0, 0, 1]], radii=[0.05], areas=[0.01]))
    scene = sf.Scene(objects, lights=[sf.Environment(1.0)])
    below = np.abs(flat).max(axis=1) < 0.25
    irradiance = sf.solve(scene, transport="rays", insert=False).irradiance[:, 0]
    assert irradiance[: len(flat)][below].max() < 1e-3
    np.testing.assert_allclose(irradiance[len(flat) : 2 * len(flat)], np.pi, rtol=1e-6)
    found, _ = sf.reference_irradiance(scene, [[0, 0, 0], [0, 0, 1e-3]], [[0, 0, 1]] * 2, samples=64)
    np.testing.assert_allclose(found[:, 0], [0, np.pi], rtol=1e-6)


@pytest.mark.parametrize("distance", [1e2, 1e5])
@pytest.mark.slow
def test_a_stray_triangle_of_the_same_mesh_takes_no_points(distance):
    """No farther from the room without it than another seed is (it was 12 % off)."""
    solutions = [sf.solve_meshless(scene) for scene in (lit_room(), lit_room(stray_triangle=distance))]
    other_seed = sf.solve_meshless(lit_room(), seed=1).irradiance
    walls = 6 * 64
    areas, expected = solutions[0].surfels.areas[:walls], solutions[0].irradiance[:walls]
    noise = rms(other_seed[:walls], expected, areas)
    assert rms(solutions[1].irradiance[:walls], expected, areas) < 2 * noise


@pytest.mark.parametrize("pile", [2, 200, 20_000])
@pytest.mark.slow
def test_a_pile_is_one_points_worth_of_surface(pile):
    """Each of k that coincide has a kth of what one has there; no pass compares each of them with all others."""
    rng = np.random.default_rng(1)
    points = np.vstack([[0.5, 0.5, 0.0], np.column_stack([rng.random((3000, 2)), np.zeros(3000)])])
    up = np.tile([0.0, 0.0, 1.0], (len(points) + pile - 1, 1))
    one = sf.Surfels(points, up[: len(points)])
    many = sf.Surfels(np.vstack([np.tile(points[:1], (pile - 1, 1)), points]), up)
    np.testing.assert_array_equal(many.radii[pile - 1 :], one.radii)
    expected, found = sf.effective_areas(one), sf.effective_areas(many)
    np.testing.assert_allclose(found[:pile], expected[0] / pile, rtol=1e-12)
    np.testing.assert_allclose(found[pile:], expected[1:], rtol=1e-12)
    lit = sf.solve(sf.Scene([many], lights=[sf.PointLight([0.5, 0.5, 1.0], 1.0)]), transport="rays", insert=False)
    np.testing.assert_allclose(lit.irradiance[:pile], 1.0, rtol=1e-9)  # cos / r^2, and nothing in the way


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_loose_leaf_has_at_most_its_disk(seed):
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(600, 3))
    leaves = sf.Surfels(rng.random((600, 3)), normals, radii=np.full(600, 0.06))
    shares = sf.effective_areas(leaves) / (np.pi * 0.06**2)
    assert shares.max() <= 1 + 1e-12
    assert shares.min() > 0


def parallel_rectangles(a, b, gap):
    """F between equal rectangles a x b that face each other (Howell C-11)."""
    x, y = a / gap, b / gap
    u, v = np.hypot(1, x), np.hypot(1, y)
    logarithm = np.log(u) + np.log(v) - 0.5 * np.log1p(x * x + y * y)
    arcs = x * v * np.arctan(x / v) + y * u * np.arctan(y / u) - x * np.arctan(x) - y * np.arctan(y)
    return 2 / (np.pi * x * y) * (logarithm + arcs)


@pytest.mark.parametrize(
    ("a", "b", "gap"),
    [(1000, 1, 5e-4), (1000, 1, 0.1), (1000, 1, 1), (100, 1, 1e-3), (1, 1, 1e-5), (1, 1, 1e-3), (1, 1, 1), (1, 2, 0.5)],
)
def test_factors_of_parallel_rectangles(a, b, gap):
    """Thin gaps and long strips: as the closed form, with visibility too, also where hardly a ray would escape."""
    corners = [[x, y, z] for z in (0, gap) for x, y in ((0, 0), (a, 0), (a, b), (0, b))]
    pair = sf.Scene([sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [7, 6, 5, 4]]))])
    expected = parallel_rectangles(a, b, gap)
    for factors in (sf.form_factors(pair, visibility=False), sf.form_factors(pair)):
        np.testing.assert_allclose([factors[0, 1], factors[1, 0]], expected, rtol=1e-6)
    assert sf.form_factors(pair, return_escape=True)[1] == pytest.approx(1 - expected, abs=1e-6)


@pytest.mark.slow
def test_light_inside_geometry_does_not_depend_on_the_order_of_points():
    """What is under a back asks twelve more rays, turned by chance: by the place's own, not by its number's.

    Inside a ball full of holes, some of them find one, or none, as they are turned.
    """
    unit = shapes.sphere(300)
    spacing = np.sqrt(4 * np.pi / 300)
    ball = sf.Surfels(0.3 * unit.points + [0.5, 0.5, 0.5], unit.normals, radii=np.full(300, 0.3 * 0.5 * spacing))
    scene = sf.Scene(
        [sf.Surfels.from_mesh(shapes.box(1.0, 8, inward=True)[:2]), ball], lights=[sf.PointLight([0.1, 0.1, 0.9], 1.0)]
    )
    solution = sf.solve_meshless(scene, levels=2)
    rng = np.random.default_rng(0)
    points = 0.5 + rng.uniform(-0.15, 0.15, (1000, 3))
    normals = np.tile([0.0, 0.0, 1.0], (1000, 1))
    expected = solution.irradiance_at(points, normals)
    inside = (expected == 0).all(axis=1).mean()
    assert 0 < inside < 1  # both are there
    order = rng.permutation(1000)
    np.testing.assert_array_equal(solution.irradiance_at(points[order], normals), expected[order])
