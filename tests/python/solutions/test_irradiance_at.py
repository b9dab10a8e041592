"""Solution.irradiance_at, and solutions with inserted surfels through a file and back."""

import warnings

import numpy as np
import pytest

import surflux as sf
from cases.closed_forms import element_to_polygon
from scenes import cube_inside, patch, rms, solve_own, surfels_of, up
from surflux.scenes import shapes

SUN = sf.DirectionalLight([0.3, 0.2, -1.0], 3.0)


def floor_and_ball(n=20):
    unit = shapes.sphere(300)
    ball = surfels_of(0.3 * unit.points + np.array([0, 0, 0.4]), unit.normals, [0.7, 0.5, 0.3])
    return sf.Scene([patch([-1, -1, 0], [2, 0, 0], [0, 2, 0], 0.5, 0.0, 4 / n**2), ball], [SUN])


@pytest.fixture(scope="module")
def solved():
    return sf.solve(floor_and_ball(), transport="rays")


def on_the_floor(count, seed=0):
    return np.column_stack([np.random.default_rng(seed).uniform(-0.95, 0.95, (count, 2)), np.zeros(count)])


@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_at_surfels_it_is_their_own(transport):
    for insert in (False, True):
        solution = sf.solve(floor_and_ball(), transport=transport, insert=insert)
        s = solution.surfels
        np.testing.assert_allclose(
            solution.irradiance_at(s.points, s.normals, "interpolated"), solution.irradiance, rtol=1e-9, atol=1e-12
        )


def test_a_lamp_over_a_floor_of_points():
    """Between surfels, interpolated, within 1 % of the closed form; traced, the closed form itself."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-1, 1, 40)] * 2))
    floor = surfels_of(np.stack([x, y, 0 * x], axis=1), up(x), 0.0)
    corners = np.array([[-0.3, -0.3, 1], [-0.3, 0.3, 1], [0.3, 0.3, 1], [0.3, -0.3, 1]])
    lamp = sf.AreaLight(corners[0], corners[1] - corners[0], corners[3] - corners[0], 5.0)
    solution = solve_own(sf.Scene([floor], [lamp]))
    at = on_the_floor(300)
    expected = 5 * element_to_polygon(at, up(at), corners)
    found = solution.irradiance_at(at, up(at), direct="interpolated")[:, 0]
    assert np.sqrt(((found - expected) ** 2).mean() / (expected**2).mean()) < 2e-3
    assert np.abs(found / expected - 1).max() < 0.01
    traced = solution.irradiance_at(at, up(at), direct="traced")[:, 0]
    np.testing.assert_allclose(traced, expected, rtol=1e-6)


def wide_floor(patch_area, light):
    return sf.Scene([patch([-5, -5, 0], [10, 0, 0], [0, 10, 0], 0.5, 0.0, patch_area)], [light])


@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
def test_a_lamp_closer_than_patches_are_wide(solve):
    """Of direct light patches hold means alone; the light between them is that of the place."""
    at = 0.3 * on_the_floor(300)
    for height in (0.2, 0.05):
        solution = solve(wide_floor(1.0, sf.PointLight([0.03, 0.07, height], 1.0)))
        to = np.array([0.03, 0.07, height]) - at
        expected = height / np.linalg.norm(to, axis=1) ** 3
        np.testing.assert_allclose(solution.irradiance_at(at, up(at))[:, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("height", [0.5, 0.05])
def test_between_lit_surfels_no_place_is_dark(height):
    """Slopes of the brightest patches would carry on to below nothing."""
    solution = sf.solve(wide_floor(1.0, sf.PointLight([0.0, 0.0, height], 1.0)))
    assert solution.direct.min() > 0.0
    at = 5.0 * on_the_floor(1500)
    assert solution.irradiance_at(at, up(at), direct="interpolated").min() > 0.0


@pytest.mark.parametrize("height", [2.0, 0.5, 0.05])
def test_no_place_on_a_floor_is_in_mid_air(height):
    """Pieces of patches are not round: their corners are farther than twice their radius from the centre."""
    solution = sf.solve(wide_floor(1.0, sf.PointLight([0.0, 0.0, height], 1.0)))
    assert len(solution.surfels) > 100
    at = np.concatenate([[[0.0, 0.0, 0.0]], 0.3 * on_the_floor(400), 5.0 * on_the_floor(400, 1)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution.irradiance_at(at, up(at))


def test_direct_light_is_traced_unless_there_is_no_scene(solved, tmp_path):
    at = on_the_floor(200)
    assert np.array_equal(solved.irradiance_at(at, up(at)), solved.irradiance_at(at, up(at), "traced"))
    solved.save(tmp_path / "room.ply")
    back = sf.load_solution(tmp_path / "room.ply")
    assert np.array_equal(back.irradiance_at(at, up(at)), back.irradiance_at(at, up(at), "interpolated"))


def test_it_converges_to_second_order_nearly():
    """A point light half a unit over a black floor, I cos / r^2, seen between 10 x 10 to 40 x 40 points."""

    def error(n):
        at = 2 * (np.arange(n) + 0.5) / n - 1
        x, y = (a.ravel() for a in np.meshgrid(at, at))
        floor = surfels_of(np.stack([x, y, 0 * x], axis=1), up(x), 0.0)
        solution = solve_own(sf.Scene([floor], [sf.PointLight([0.1, 0.2, 0.7], 1.0)]))
        at = 0.8 * on_the_floor(500)
        d = np.array([0.1, 0.2, 0.7]) - at
        expected = 0.7 / np.linalg.norm(d, axis=1) ** 3
        return np.sqrt(
            ((solution.irradiance_at(at, up(at), "interpolated")[:, 0] - expected) ** 2).mean() / (expected**2).mean()
        )

    errors = [error(n) for n in (10, 20, 40)]
    assert errors[-1] < 3e-3
    assert np.log(errors[0] / errors[-1]) / np.log(4) > 1.3


@pytest.mark.slow
def test_traced_light_of_a_sky_converges_with_its_rays():
    """Even rays: an error that goes by n^-3/4 is an eighth with 16 times as many; random ones have a fourth."""
    sky = np.random.default_rng(2).uniform(0.2, 1.0, (16, 32, 3))
    sky[4, 9] = 50.0
    scene = sf.Scene([*floor_and_ball().objects], [sf.Environment(sky)])
    solution = sf.solve(scene, insert=False)
    at = 0.4 * on_the_floor(60)
    known = solution.irradiance_at(at, up(at), direct="traced", rays=1 << 15, seed=9)
    errors = []
    for rays in (64, 1024):
        found = [solution.irradiance_at(at, up(at), direct="traced", rays=rays, seed=seed) for seed in range(3)]
        errors.append(np.linalg.norm(np.array(found) - known) / np.sqrt(3) / np.linalg.norm(known))
    assert errors[1] < 0.25 * errors[0] < 0.25 * 0.05
    with pytest.raises(ValueError, match=r"^rays: wanted a whole number from 1 to 65536, got 0"):
        solution.irradiance_at(at, up(at), direct="traced", rays=0)


def test_traced_shadows_are_sharp(solved):
    at = on_the_floor(400)
    d = -np.array(SUN.direction) / np.linalg.norm(SUN.direction)
    # How far the ray towards the sun passes the ball's middle.
    to = np.array([0, 0, 0.4]) - at
    past = np.linalg.norm(np.cross(to, d), axis=1)
    traced = solved.irradiance_at(at, up(at), direct="traced")
    interpolated = solved.irradiance_at(at, up(at), direct="interpolated")
    sure = np.abs(past - 0.3) > 0.02  # 300 disks make a sphere to within that
    open_sky = 3.0 * d[2]
    np.testing.assert_array_less(open_sky * (1 - 1e-9), traced[sure & (past > 0.3)].min())
    assert traced[sure & (past < 0.3)].max() < 0.5 * open_sky
    # And far from the border both say the same.
    far = np.abs(past - 0.3) > 0.2
    np.testing.assert_allclose(interpolated[far], traced[far], rtol=0.05)


def test_a_constant_field_is_constant_anywhere():
    solution = solve_own(sf.Scene([cube_inside(8, 0.5, 2.0)]))
    random = np.random.default_rng(0)
    at = random.uniform(0, 1, (200, 3))
    axis = random.integers(0, 3, 200)
    at[np.arange(200), axis] = 0.0
    normals = np.eye(3)[axis]
    np.testing.assert_allclose(solution.irradiance_at(at, normals), 4.0, rtol=1e-6)
    # Any length of normals but 0, and points beside the surface.
    np.testing.assert_allclose(solution.irradiance_at(at + 0.01, 7.0 * normals), 4.0, rtol=1e-6)


def test_faces_of_an_edge_are_told_apart():
    """A step's tread in the sun and its riser in the dark, with the point on the edge between them."""
    tread = patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.0, 0.0, 0.01)
    riser = patch([0, 0, -1], [1, 0, 0], [0, 0, 1], 0.0, 0.0, 0.01)
    solution = solve_own(sf.Scene([tread, riser], [sf.DirectionalLight([0, 0, -1], 2.0)]))
    edge = [[0.33, 0.0, 0.0]] * 2
    np.testing.assert_allclose(solution.irradiance_at(edge, [[0, 0, 1], [0, -1, 0]])[:, 0], [2.0, 0.0], atol=1e-12)


def test_shapes_and_refusals(solved):
    one = solved.irradiance_at([[0.5, 0.5, 0.0]], [[0, 0, 1]])
    assert one.shape == (1, 3)
    assert one.dtype == np.float64
    good = [[0.5, 0.5, 0.0]], [[0, 0, 1]]
    for arguments, message in (
        ((np.zeros((0, 3)), np.zeros((0, 3))), r"^points: "),
        (([0.5, 0.5, 0.0], good[1]), r"^points: "),
        (([[0.5, np.nan, 0.0]], good[1]), r"^points: "),
        (([[0.5, np.inf, 0.0]], good[1]), r"^points: "),
        ((good[0], [[0, 0, 1], [0, 0, 1]]), r"^normals: "),
        ((good[0], [[0, 0, 0]]), r"^normals: "),
        ((good[0], [[0, 0, np.nan]]), r"^normals: "),
        ((*good, "none"), r"^direct: "),
        ((*good, True), r"^direct: "),
    ):
        with pytest.raises(ValueError, match=message):
            solved.irradiance_at(*arguments)
    with pytest.raises(ValueError, match=r"^seed: "):
        solved.irradiance_at(*good, seed=-1)
    with pytest.raises(ValueError, match=r"^threads: "):
        solved.irradiance_at(*good, threads=0)


def test_a_field_without_a_scene_is_interpolated():
    floor = patch([0, 0, 0], [1, 0, 0], [0, 1, 0], 0.0, 0.0, 0.01)
    objects = np.zeros(len(floor), dtype=np.uint32)
    field = sf._core.Field(floor._core, objects, [np.ones((len(floor), 3))], None, None)
    at, normals = np.array([[0.5, 0.5, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(field.at(0, at, normals, None), 1.0)
    with pytest.raises(ValueError, match=r"^field: there are 1"):
        field.at(1, at, normals, None)


@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_inserted_surfels_come_back_from_a_file(transport, tmp_path):
    scene = floor_and_ball()
    solution = sf.solve(scene, transport=transport)
    s = solution.surfels
    assert len(s) > len(scene.surfels)
    solution.save(tmp_path / "room.ply")
    back = sf.load_solution(tmp_path / "room.ply")
    for name in ("points", "radii", "areas", "triangles", "triangle_surfel"):
        assert np.array_equal(getattr(back.surfels, name), getattr(s, name)), name
    assert np.array_equal(back.parents, solution.parents)
    assert np.array_equal(back.objects, solution.objects)
    assert back.history == solution.history
    assert back.error == solution.error
    at = on_the_floor(100)
    np.testing.assert_allclose(
        back.irradiance_at(at, up(at), "interpolated"),
        solution.irradiance_at(at, up(at), "interpolated"),
        rtol=1e-5,
        atol=1e-6,
    )
    with pytest.raises(ValueError, match=r"^direct: .*has no scene to trace rays in"):
        back.irradiance_at(at, up(at), direct="traced")


@pytest.mark.slow
@pytest.mark.parametrize("transport", ["pairs", "rays"])
def test_children_take_over_from_their_parents(transport):
    """Areas and patches of each surfel add up to its own; what it is made of stays with it."""
    scene = floor_and_ball()
    for most in (None, len(scene.surfels), len(scene.surfels) + 100, 5000):
        solution = sf.solve(scene, transport=transport, max_surfels=most)
        s, parents = solution.surfels, solution.parents
        assert len(s) <= (2 * len(scene.surfels) if most is None else most)
        own = sf.effective_areas(scene.objects[1])
        areas = np.concatenate([scene.objects[0].areas, own])
        np.testing.assert_allclose(np.bincount(parents, s.areas), areas, rtol=1e-12)
        edges = np.cross(s.triangles[:, 1] - s.triangles[:, 0], s.triangles[:, 2] - s.triangles[:, 0])
        of_triangles = np.bincount(s.triangle_surfel, 0.5 * np.linalg.norm(edges, axis=1), len(s))
        patches = of_triangles > 0
        assert np.array_equal(patches, parents < len(scene.objects[0]))
        np.testing.assert_allclose(of_triangles[patches], s.areas[patches], rtol=1e-9)
        assert np.array_equal(solution.objects, (parents >= len(scene.objects[0])).astype(int))
        np.testing.assert_allclose(np.linalg.norm(s.normals, axis=1), 1.0, rtol=1e-12)
        np.testing.assert_allclose(s.reflectance, scene.surfels.reflectance[parents], rtol=1e-9)
        if most == len(scene.surfels):
            assert np.array_equal(parents, np.arange(most))


@pytest.mark.slow
def test_more_surfels_where_they_are_allowed():
    scene = floor_and_ball()
    counts = [len(sf.solve(scene, max_surfels=most).surfels) for most in (len(scene.surfels) + 60, 1400, 5000)]
    assert counts[0] < counts[1] < counts[2]
    loose = sf.solve(scene, max_surfels=5000, zeta=0.1)
    assert len(scene.surfels) < len(loose.surfels) < counts[2]


@pytest.mark.parametrize("transport", ["pairs", "rays"])
@pytest.mark.slow
def test_insertion_sharpens_a_shadow(transport):
    """Interpolated direct light against the traced one, at random points of a floor with a ball's shadow."""
    at = on_the_floor(2000)

    def error(**options):
        solution = sf.solve(floor_and_ball(), transport=transport, **options)
        truth = solution.irradiance_at(at, up(at), direct="traced")
        return rms(solution.irradiance_at(at, up(at), "interpolated"), truth, np.ones(len(at)))

    # All that is off is a step of the width of a leaf: sizes halve as often as there is room, and errors fall by their
    # square root, down to 1 / sqrt(8).
    without, twice, many = error(insert=False), error(), error(max_surfels=5000)
    assert twice < 0.9 * without
    assert many < 0.6 * without


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"max_surfels": 10}, r"^max_surfels: wanted at least the 700 surfels of the scene, got 10$"),
        ({"max_surfels": 0}, r"^max_surfels: "),
        ({"max_surfels": 1000.0}, r"^max_surfels: wanted a whole number"),
        ({"max_surfels": True}, r"^max_surfels: "),
        ({"max_surfels": "many", "insert": False}, r"^max_surfels: "),
        ({"max_surfels": -3, "insert": False}, r"^max_surfels: "),
        ({"insert": 1}, r"^insert: "),
        ({"insert": None}, r"^insert: "),
        ({"transport": "all"}, r"^transport: "),
        ({"transport": None}, r"^transport: "),
        ({"zeta": 0.0}, r"^zeta: "),
        ({"zeta": np.nan}, r"^zeta: "),
        ({"zeta": np.inf}, r"^zeta: "),
        ({"zeta": -1}, r"^zeta: "),
        ({"tolerance": 1.0}, r"^tolerance: "),
        ({"rays": 15}, r"^rays: "),
        ({"rays": 65536}, r"^rays: "),
        ({"epsilon": 1.0}, r"^epsilon: "),
    ],
    ids=str,
)
def test_refusals(options, message):
    with pytest.raises(ValueError, match=message):
        sf.solve(floor_and_ball(), **options)


@pytest.mark.parametrize("direct", ["interpolated", "traced"])
def test_it_reports_and_can_be_cancelled(direct):
    solution = solve_own(floor_and_ball())
    at = on_the_floor(300)
    calls = []
    found = solution.irradiance_at(at, up(at), direct=direct, progress=lambda done, total: calls.append((done, total)))
    assert calls
    assert all(0 < done <= total for done, total in calls)
    np.testing.assert_array_equal(found, solution.irradiance_at(at, up(at), direct=direct))
    with pytest.raises(sf.Cancelled):
        solution.irradiance_at(at, up(at), direct=direct, progress=lambda done, total: False)


@pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
def test_points_in_mid_air_are_warned_of_once_with_their_number(solver):
    """A disk that leaves no gap reaches half the diagonal of its cell: on a plane 3 of them up nothing is known."""
    solution = solver(floor_and_ball())
    floor = on_the_floor(50)
    spacing = 2 / 20
    desk = np.add(floor, [0.0, 0.0, 3.0 * spacing])
    off = np.linalg.norm(desk - [0, 0, 0.4], axis=1) > 0.5  # else the ball is near
    with pytest.warns(UserWarning, match=rf"points: {off.sum()} of {50 + off.sum()} points are on no surface") as said:
        solution.irradiance_at(np.vstack([floor, desk[off]]), up(np.zeros(50 + off.sum())))
    assert len(said) == 1
    first = r'mid-air; indirect="gathered" finds that, or reference_irradiance\(\) of the scene$'
    with pytest.warns(UserWarning, match=f"points: 50 of 50 points are on no surface.*{first}"):
        solution.irradiance_at(floor, -up(floor))  # from below


def test_light_gathered_under_surfels_that_shine_is_as_good_as_what_is_interpolated():
    """By rays that meet them by chance, nine of a thousand, it was off by 3.5 to 7 %."""
    corners, faces, _ = shapes.box(patches=1, inward=True)
    room = sf.Surfels.from_mesh((np.asarray(corners) * [4.0, 5.0, 3.0], faces), 0.04)
    lamp = [[1.7, 1.9, 2.9], [1.7, 3.1, 2.9], [2.3, 3.1, 2.9], [2.3, 1.9, 2.9]], [[0, 1, 2, 3]]
    scene = sf.Scene([room, sf.Surfels.from_mesh(lamp, 0.02, emission=100.0)])
    at = np.stack(np.meshgrid(np.linspace(0.5, 3.5, 8), np.linspace(0.5, 4.5, 8), [0.0]), axis=-1).reshape(-1, 3)
    expected = sf.reference_irradiance(scene, at, up(at))[0]
    solution = sf.solve(scene)

    def off(**how):
        return np.sqrt(np.mean((solution.irradiance_at(at, up(at), **how) / expected - 1.0) ** 2))

    assert off() < 0.013
    for seed in range(3):
        assert off(indirect="gathered", seed=seed) < 0.013


def test_mid_air_of_a_file_is_not_gathered(tmp_path):
    path = sf.solve(floor_and_ball()).save(tmp_path / "lit.ply")
    floor = on_the_floor(50)
    with pytest.warns(UserWarning, match=r"is not that of mid-air; reference_irradiance\(\) of the scene$"):
        sf.load_solution(path).irradiance_at(floor, -up(floor))


def test_no_point_of_a_surface_is_taken_for_mid_air(solved):
    """Places drawn on the shapes themselves: on disks that bend away from them, on patches and what was inserted."""
    on_ball = shapes.sphere(3000).points
    coarse = shapes.sphere(50)
    ball = sf.solve(sf.Scene([surfels_of(coarse.points, coarse.normals, 0.5)], [SUN]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solved.irradiance_at(on_the_floor(3000), up(np.zeros(3000)))
        solved.irradiance_at(0.3 * on_ball + [0, 0, 0.4], on_ball)
        ball.irradiance_at(on_ball, on_ball)
        solved.irradiance_at(solved.surfels.points, solved.surfels.normals)
