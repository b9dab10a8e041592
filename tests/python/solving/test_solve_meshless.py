"""sf.solve_meshless: bounces against closed forms, what its options do, and what it is free of: the mesh, threads."""

import numpy as np
import pytest

import surflux as sf
from cases.builders import ball
from scenes import ball_inside, cube_inside, rms, surfels_of
from surflux.scenes import shapes

UP = [0.0, 0.0, 1.0]
LAMP = sf.AreaLight([0.35, 0.35, 0.99], [0, 0.3, 0], [0.3, 0, 0], [6.0, 5.0, 4.0])
SMALL = {"levels": 2, "rays": 64}


def lit_box(n=1, rho=(0.7, 0.5, 0.3), light=LAMP):
    """The unit cube from inside, n x n patches a wall."""
    return sf.Scene([cube_inside(n, rho)], [light])


def furnished():
    """Patches and disks that glow in part, two objects, and two kinds of lamps."""
    unit = shapes.sphere(150)
    emission = np.where(unit.points[:, 2:] > 0.8, [[2.0, 1.0, 0.5]], 0.0)
    ball = surfels_of(0.2 * unit.points + np.array([0.5, 0.5, 0.3]), unit.normals, [0.3, 0.6, 0.3], emission)
    return sf.Scene([cube_inside(3, [0.7, 0.6, 0.5]), ball], [LAMP, sf.PointLight([0.2, 0.3, 0.8], 0.3)])


def on_the_floor(count, seed=0):
    at = np.column_stack([np.random.default_rng(seed).uniform(0.05, 0.95, (count, 2)), np.zeros(count)])
    return at, np.tile(UP, (count, 1))


def indirect_at(solution, at, normals):
    """What is in the basis of a scene where nothing but lamps glows, without what is interpolated of direct light."""
    lamps = solution.irradiance_at(at, normals, direct="traced")
    return lamps - sf.solve_meshless(solution._scene, bounces=0, **SMALL).irradiance_at(at, normals, direct="traced")


@pytest.fixture(scope="module")
def solved():
    return sf.solve_meshless(furnished(), **SMALL)


@pytest.mark.slow
def test_bounces_of_a_furnace():
    """Each surfel sees E all around: after n bounces H = E (1 + rho + ... + rho^n), at last E / (1 - rho)."""
    for room in (cube_inside(3, 0.5, 2.0), ball(1, sign=-1, kind="patches", rho=0.5, emission=2.0)):
        scene = sf.Scene([room])
        for bounces in range(3):
            for indirect_only in (True, False):
                found = sf.solve_meshless(scene, bounces=bounces, indirect_only=indirect_only, **SMALL)
                expected = 2.0 * sum(0.5**k for k in range(bounces + 1))
                np.testing.assert_allclose(found.irradiance, expected, rtol=1e-6)
                assert np.all(found.direct == 0.0)
        np.testing.assert_allclose(sf.solve_meshless(scene, **SMALL).irradiance, 4.0, rtol=1e-5)


@pytest.mark.filterwarnings("error")
def test_bounces_that_were_not_asked_for_are_not_called_lost():
    room = cube_inside(3, 0.7, 1.0)
    for bounces in (0, 1):
        sf.solve_meshless(sf.Scene([room]), bounces=bounces, **SMALL)


def test_rounding_is_no_light():
    """A tilted floor alone sends itself 1e-34 of its light, of which a quarter million points told."""
    corners = np.array([[-0.955, -1, 0.296], [0.955, -1, -0.296], [0.955, 1, -0.296], [-0.955, 1, 0.296]])
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.02, reflectance=0.5)
    found = sf.solve_meshless(sf.Scene([floor], [sf.PointLight([0, 0, 3], 10.0)]), levels=4)
    assert found.history[-1]["points"] < 1000


@pytest.mark.parametrize("indirect_only", [True, False])
@pytest.mark.slow
def test_bounces_in_a_sphere_with_a_light(indirect_only):
    """What a sphere reflects is the same all over: H = D + mean(D) (rho + ... + rho^n)."""
    room = ball(3, sign=-1, kind="patches", rho=0.6)
    scene = sf.Scene([room], [sf.PointLight([0.2, 0.3, 0.1], 1.0)])
    for bounces, share in ((0, 0.0), (1, 0.6), (2, 0.96), (None, 1.5)):
        found = sf.solve_meshless(scene, bounces=bounces, levels=3, indirect_only=indirect_only)
        direct, areas = found.direct[:, 0], found.surfels.areas
        expected = direct + share * np.average(direct, weights=areas)
        error = np.sqrt(np.average((found.irradiance[:, 0] - expected) ** 2, weights=areas)) / expected.mean()
        assert error < 0.01, (bounces, error)
        if bounces == 0:
            np.testing.assert_allclose(found.irradiance, found.direct, rtol=1e-9)


@pytest.mark.slow
def test_with_direct_light_in_the_basis_it_is_the_same_light():
    scene = lit_box(4)
    outside, inside = (sf.solve_meshless(scene, levels=4, indirect_only=flag) for flag in (True, False))
    areas = outside.surfels.areas
    assert rms(inside.direct, outside.direct, areas) < 0.02
    # What the basis makes of the sum of direct light is bounced on.
    assert rms(inside.irradiance, outside.irradiance, areas) < 0.03
    assert rms(*(s.irradiance - s.direct for s in (inside, outside)), areas) < 0.05


def test_at_disks_it_is_their_own(solved):
    disks = solved.objects == 1
    at, normals = solved.surfels.points[disks], solved.surfels.normals[disks]
    np.testing.assert_allclose(
        solved.irradiance_at(at, normals, "interpolated"), solved.irradiance[disks], rtol=1e-6, atol=1e-9
    )
    # Traced: the same but for the seed of shadow rays.
    traced = solved.irradiance_at(at, normals, direct="traced")
    assert rms(traced, solved.irradiance[disks], solved.surfels.areas[disks]) < 0.05
    everywhere = sf.solve_meshless(furnished(), indirect_only=False, **SMALL)
    found = everywhere.irradiance_at(at, normals, "interpolated")
    np.testing.assert_allclose(found, everywhere.irradiance[disks], rtol=1e-6, atol=1e-9)


@pytest.mark.slow
def test_of_patches_it_is_the_mean():
    """Of one patch a wall, what 400 points of the floor have on average."""
    solution = sf.solve_meshless(lit_box(), levels=3)
    floor = solution.surfels.normals[:, 2] > 0.9
    at, normals = on_the_floor(400)
    at[:, :2] = (np.stack(np.meshgrid(*[np.arange(20)] * 2), axis=-1).reshape(-1, 2) + 0.5) / 20
    indirect = indirect_at(solution, at, normals).mean(axis=0)
    np.testing.assert_allclose(indirect, (solution.irradiance - solution.direct)[floor][0], rtol=0.03)


@pytest.mark.slow
def test_the_mesh_does_not_matter():
    """A box of six patches has the light of one of 384, and of the path tracer: points are placed on surfaces."""
    rng = np.random.default_rng(1)
    walls = np.repeat(np.arange(3), 20)
    at, normals = rng.uniform(0.05, 0.95, (60, 3)), np.eye(3)[walls]
    at[np.arange(60), walls] = 0.0
    coarse, fine = (sf.solve_meshless(lit_box(n), levels=4) for n in (1, 8))
    assert len(coarse.surfels) == 6
    one, many = (s.irradiance_at(at, normals, direct="traced") for s in (coarse, fine))
    truth, error = sf.reference_irradiance(lit_box(), at, normals, samples=8192)
    direct = sf.solve_meshless(lit_box(), bounces=0, **SMALL).irradiance_at(at, normals, direct="traced")
    size = np.sqrt(((truth - direct) ** 2).mean())
    for found in (one, many):
        off = np.sqrt(((found - truth) ** 2).mean() - (error**2).mean()) / size
        assert np.sqrt((error**2).mean()) / size < 0.01
        assert off < 0.04
    # To what the noise of their own rays is, it is one solution.
    assert np.sqrt(((one - many) ** 2).mean()) / size < 0.04


@pytest.mark.slow
def test_many_objects_are_as_good_as_one():
    """Walls that are objects of their own share no functions, nor need they."""
    vertices, faces, _ = shapes.box(1.0, 3, inward=True)
    one = sf.Surfels.from_mesh((vertices, faces), reflectance=0.6)
    walls = [one[9 * k : 9 * k + 9] for k in range(6)]
    together, apart = (sf.solve_meshless(sf.Scene(objects, [LAMP]), levels=3) for objects in ([one], walls))
    np.testing.assert_allclose(apart.direct, together.direct, rtol=1e-9, atol=1e-12)
    assert np.array_equal(apart.objects, np.repeat(np.arange(6), 9))
    assert rms(*(s.irradiance - s.direct for s in (apart, together)), together.surfels.areas) < 0.03


def two_rooms(thickness):
    """Two closed rooms side by side, of one object: their floors go on in one plane behind the wall between them."""
    width = 1 - thickness / 2
    vertices, faces, _ = shapes.box((width, 1, 1), 1, inward=True)
    both = np.concatenate([vertices, np.add(vertices, [1 + thickness / 2, 0, 0])])
    faces = [list(face) for face in faces]
    mesh = (both, faces + [[k + len(vertices) for k in face] for face in faces])
    return sf.Surfels.from_mesh(mesh, reflectance=0.7)


@pytest.mark.slow
def test_nothing_leaks_through_a_wall_thinner_than_the_coarse_support():
    """On no level, where a function of the lit room is as near as one of the dark."""
    thickness = 1e-2
    scene = sf.Scene([two_rooms(thickness)], [sf.AreaLight([0.4, 0.4, 0.99], [0, 0.2, 0], [0.2, 0, 0], 5.0)])
    for levels in (1, 2, 4):
        found = sf.solve_meshless(scene, levels=levels, rays=256)
        light, areas = found.irradiance[:, 0], found.surfels.areas
        dark = found.surfels.points[:, 0] > 1
        assert np.all(found.direct[dark] == 0.0)
        assert np.all(light[dark] == 0.0)
        assert np.average(light[~dark], weights=areas[~dark]) > 0.0


@pytest.mark.slow
def test_smooth_walls_have_no_seams():
    """Along a line over the floor: continuous, and bent by no more than twice what the path tracer's light is."""
    solution = sf.solve_meshless(lit_box(), levels=4)

    def along(count):
        x = np.linspace(0.1, 0.9, count)
        at = np.column_stack([x, 0.3 + 0.2 * x, 0 * x])
        return at, np.tile(UP, (count, 1))

    def luminance(values):
        return values @ [0.2126, 0.7152, 0.0722]

    def indirect(count):
        return luminance(indirect_at(solution, *along(count)))

    at, normals = along(17)
    truth, error = (luminance(v) for v in sf.reference_irradiance(lit_box(), at, normals, samples=1 << 15))
    direct = sf.solve_meshless(lit_box(), bounces=0, **SMALL).irradiance_at(at, normals, direct="traced")
    truth -= luminance(direct)
    assert error.max() < 0.005 * truth.mean()
    bent = np.abs(np.diff(indirect(17), 2)).max()
    assert bent <= 2 * (np.abs(np.diff(truth, 2)).max() + error.max())
    # No jump: an eighth of the step, about an eighth of the largest difference.
    jumps = [np.abs(np.diff(indirect(count))).max() for count in (1001, 8001)]
    assert jumps[1] < 0.25 * jumps[0]


@pytest.mark.slow
def test_the_same_on_any_number_of_threads_and_other_noise_for_another_seed(solved):
    again, one = (sf.solve_meshless(furnished(), threads=threads, **SMALL) for threads in (None, 1))
    other = sf.solve_meshless(furnished(), seed=7, **SMALL)
    at, normals = on_the_floor(50)
    for same in (again, one):
        for name in ("irradiance", "radiosity", "direct", "error"):
            np.testing.assert_array_equal(getattr(same, name), getattr(solved, name))
        assert [f["links"] for f in same.history] == [f["links"] for f in solved.history]
        np.testing.assert_array_equal(same.irradiance_at(at, normals), solved.irradiance_at(at, normals))
    assert not np.array_equal(other.irradiance, solved.irradiance)
    assert rms(other.irradiance, solved.irradiance, solved.surfels.areas) < 0.1


def test_the_scene_stays_as_it_is():
    scene = furnished()
    names = ("points", "normals", "radii", "reflectance", "emission", "triangles", "triangle_surfel")
    before = [np.array(getattr(s, name)) for s in scene.objects for name in names]
    solution = sf.solve_meshless(scene, **SMALL)
    after = [getattr(s, name) for s in scene.objects for name in names]
    assert all(np.array_equal(a, b) for a, b in zip(before, after, strict=True))
    assert scene.objects[1].areas is None
    # The surfels are the scene's own.
    assert np.array_equal(solution.surfels.points, scene.surfels.points)
    assert np.array_equal(solution.parents, np.arange(len(scene.surfels)))
    emission, rho = scene.surfels.emission, scene.surfels.reflectance
    np.testing.assert_allclose(solution.radiosity, emission + rho * solution.irradiance, rtol=1e-12)


def test_history_tells_what_was_done(solved):
    assert [figures["iteration"] for figures in solved.history] == list(range(1, len(solved.history) + 1))
    kept = {"level", "points", "cut", "refined", "links", "rays", "applications", "residual", "seconds"}
    for figures in solved.history:
        assert set(figures) >= kept
        assert figures["cut"] <= figures["points"]
        assert figures["level"] < SMALL["levels"] + 2  # clouds have their last points twice more
    for name in ("level", "points", "cut", "links", "rays", "seconds"):
        values = [figures[name] for figures in solved.history]
        assert values == sorted(values), name
    last = solved.history[-1]
    assert last["residual"] <= 1e-4
    assert last["error"] == solved.error < 0.2
    assert last["seconds"] <= sum(solved.timings.values())
    assert {"areas", "direct", "placement", "gathering", "solve", "evaluation", "self-check"} <= set(solved.timings)
    # Closed, but for what slips between disks.
    assert last["power_absorbed"] == pytest.approx(last["power_in"], rel=0.1)


@pytest.mark.slow
def test_finer_where_light_changes_and_no_finer_than_asked():
    counts = {e: sf.solve_meshless(lit_box(), levels=3, epsilon_e=e).history[-1]["cut"] for e in (0.2, 0.05, 0.02)}
    assert counts[0.2] < counts[0.05] < counts[0.02]
    wide, narrow = (sf.solve_meshless(lit_box(), levels=1, radius=r).history[-1] for r in (0.4, 0.1))
    assert narrow["points"] > 8 * wide["points"]
    assert (wide["level"], wide["rays"] > 512 * wide["cut"]) == (0, True)
    # A furnace has nothing to refine.
    even = sf.solve_meshless(sf.Scene([cube_inside(2, 0.5, 1.0)]), levels=6)
    assert [figures["refined"] for figures in even.history] == [0] * len(even.history)


def test_all_of_it_comes_back(solved, tmp_path):
    """And a loaded one interpolates between surfels, for a file does not hold the basis."""
    solved.save(tmp_path / "room.ply")
    back = sf.load_solution(tmp_path / "room.ply")
    for name in ("irradiance", "radiosity", "direct"):
        np.testing.assert_allclose(getattr(back, name), getattr(solved, name), rtol=6e-8, atol=1e-30)
    assert np.array_equal(back.parents, solved.parents)
    assert np.array_equal(back.objects, solved.objects)
    assert (back.error, back.timings, back.history) == (solved.error, solved.timings, solved.history)
    own = back.irradiance_at(back.surfels.points, back.surfels.normals, "interpolated")
    np.testing.assert_allclose(own, back.irradiance, rtol=1e-6, atol=1e-9)
    with pytest.raises(ValueError, match=r"^direct: wanted \"interpolated\""):
        back.irradiance_at([[0.5, 0.5, 0]], [UP], direct="traced")


@pytest.mark.slow
def test_progress_is_told_and_false_cancels_anywhere(solved):
    told = []
    sf.solve_meshless(furnished(), progress=lambda done, total: told.append((done, total)) or True, **SMALL)
    assert len(told) > 10
    assert all(isinstance(done, int) and isinstance(total, int) and 0 <= done <= total for done, total in told)
    assert sum(done == total for done, total in told) >= 3  # several stages
    for share in (0.0, 0.1, 0.25, 0.4, 0.6, 0.75, 0.9):
        after, count = int(share * len(told)), 0

        def stop(done, total):
            nonlocal count
            count += 1
            return count <= after  # noqa: B023

        with pytest.raises(sf.Cancelled):
            sf.solve_meshless(furnished(), progress=stop, **SMALL)
        assert count == after + 1
    np.testing.assert_array_equal(sf.solve_meshless(furnished(), **SMALL).irradiance, solved.irradiance)


def test_what_a_callback_raises_comes_out():
    class Broken(Exception):
        pass

    def raises(done, total):
        raise Broken("on purpose")

    with pytest.raises(Broken, match="on purpose"):
        sf.solve_meshless(furnished(), progress=raises, **SMALL)


def test_stages_are_logged(caplog):
    with caplog.at_level("INFO", "surflux"):
        sf.solve_meshless(furnished(), progress=True, **SMALL)
    assert {"placement", "gathering", "solve", "evaluation", "self-check"} <= {r.message for r in caplog.records}


@pytest.mark.filterwarnings("error")
def test_nothing_comes_of_nothing():
    with pytest.warns(UserWarning, match="stays black"):
        solution = sf.solve_meshless(sf.Scene([cube_inside(2), ball_inside(50, 0.2, [0.5] * 3, sign=1)]), **SMALL)
    for values in (solution.radiosity, solution.irradiance, solution.direct):
        assert np.all(values == 0.0)
    assert np.isnan(solution.error)
    # Lone surfels, black walls, copies.
    sun, sky = sf.DirectionalLight([0, 0, -1], 2.0), sf.Environment(1.0)
    one = sf.Surfels([[0, 0, 0]], [UP], radii=0.1, reflectance=0.25, emission=3.0)
    np.testing.assert_allclose(sf.solve_meshless(sf.Scene([one], [sun])).radiosity, 3.5, rtol=1e-12)
    copies = sf.Surfels([[0, 0, 0]] * 5, [UP] * 5, radii=1.0, areas=1.0)
    np.testing.assert_allclose(sf.solve_meshless(sf.Scene([copies], [sky])).irradiance, np.pi, rtol=1e-6)
    black = sf.solve_meshless(sf.Scene([cube_inside(3, 0.0, 1.0)]), **SMALL)
    np.testing.assert_allclose(black.irradiance, 1.0, rtol=1e-6)


@pytest.mark.parametrize("offset", [[1e6, -1e6, 1e6]])
@pytest.mark.slow
def test_far_from_the_origin_it_is_the_same(offset):
    def light(at):
        vertices, faces, _ = shapes.box(1.0, 3, inward=True)
        room = sf.Surfels.from_mesh((np.add(vertices, at), faces), reflectance=0.6)
        return sf.solve_meshless(sf.Scene([room], [sf.PointLight(np.add([0.3, 0.4, 0.7], at), 1.0)]), levels=3)

    here, there = light([0, 0, 0]), light(offset)
    np.testing.assert_allclose(there.direct, here.direct, rtol=1e-6)
    assert rms(there.irradiance, here.irradiance, here.surfels.areas) < 0.01


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.slow
def test_the_unit_does_not_matter(scale):
    def light(unit):
        vertices, faces, _ = shapes.box(unit, 3, inward=True)
        room = sf.Surfels.from_mesh((vertices, faces), reflectance=0.6)
        light = sf.PointLight(np.multiply([0.3, 0.4, 0.7], unit), unit**2)
        return sf.solve_meshless(sf.Scene([room], [light]), levels=3)

    here, there = light(1.0), light(scale)
    assert rms(there.irradiance, here.irradiance, here.surfels.areas) < 0.01


@pytest.mark.parametrize(("rho", "within"), [(0.99, 1e-4), (0.999, 1e-3), ([0.5, 0.99, 0.999], 1e-3)], ids=str)
def test_furnaces_of_nearly_white_walls(rho, within):
    """B = E / (1 - rho), for each colour, in a room without gaps."""
    solution = sf.solve_meshless(sf.Scene([cube_inside(6, rho, 2.0)]))
    expected = np.broadcast_to(2.0 / (1 - np.array(rho)), solution.radiosity.shape)
    np.testing.assert_allclose(solution.radiosity, expected, rtol=within)


@pytest.mark.parametrize("whiteness", [1 - 1e-6, 1 - 1e-9, np.nextafter(1.0, 0.0)])
@pytest.mark.filterwarnings("ignore:the linear solver stopped")
def test_the_last_step_to_white_never_diverges(whiteness):
    """Finite, and at least what the walls emit; within 2 % of the furnace as far as single precision bears."""
    # Where the digits end, what the basis is refined by is noise: two levels of it are enough.
    solution = sf.solve_meshless(sf.Scene([cube_inside(6, whiteness, 1.0)]), levels=2)
    assert np.all(np.isfinite(solution.radiosity))
    assert solution.radiosity.min() >= 1.0
    if whiteness == 1 - 1e-6:
        np.testing.assert_allclose(solution.radiosity, 1 / (1 - whiteness), rtol=0.02)


def test_points_beyond_all_floats_are_refused():
    scene = lit_box(1)
    solution = sf.solve_meshless(scene, levels=1)
    far, up = [[1e19, 0.0, 0.0]], [[0.0, 0.0, 1.0]]
    for asked in (
        lambda: solution.irradiance_at(far, up),
        lambda: solution.irradiance_at(far, up, direct="traced"),
        lambda: sf.reference_irradiance(scene, far, up, samples=16),
    ):
        with pytest.raises(ValueError, match=r"^points: number 0 is more than 1e\+15 away from the scene"):
            asked()
