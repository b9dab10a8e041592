"""Light transport of a scene, found once, for lamps that move."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from quick import quick
from scenes import surfels_of
from surflux.scenes import shapes

DATA = Path(__file__).parents[3] / "data"


def sphere_inside(points, rho):
    unit = shapes.sphere(points)
    return surfels_of(unit.points, -unit.normals, rho)


def relative_rms(found, true, areas):
    return np.sqrt((areas[:, None] * (found - true) ** 2).sum() / (areas[:, None] * true**2).sum())


@pytest.fixture(scope="module")
def room():
    return sf.load_scene(DATA / "cornell.toml")


@pytest.fixture(scope="module")
def transfer(room):
    return sf.precompute_transfer(room)


LAMP = sf.PointLight([0.3, 0.25, 0.35], [1.0, 2.0, 0.5])
LAMPS = {
    "point": LAMP,
    "spot": sf.SpotLight([0.2, 0.3, 0.5], [0.2, -0.1, -1], 3.0, cone=70),
    "area": sf.AreaLight([0.2, 0.2, 0.54], [0, 0.1, 0], [0.1, 0, 0], 20.0),
    "directional": sf.DirectionalLight([0.1, 1.0, -0.3], 4.0),
}


@pytest.mark.parametrize("bounces", quick(0, 3, None, of=[0, 1, 2, 3, None]))
def test_sphere_has_the_geometric_series(bounces):
    """From the centre all of a sphere has H = I / R^2, and each bounce brings rho times the one before."""
    rho, intensity = 0.6, 2.0
    sphere = sphere_inside(1000, rho)
    found = sf.precompute_transfer(sf.Scene([sphere]), bounces=bounces).indirect(sf.PointLight([0, 0, 0], intensity))
    powers = rho ** np.arange(1, 100 if bounces is None else bounces + 1)
    np.testing.assert_allclose(found, intensity * powers.sum(), rtol=3e-3 if bounces is None else 2e-3, atol=1e-12)


def box_inside(side, rho, at=(0.0, 0.0, 0.0)):
    vertices, faces, _ = shapes.box(side, 8, inward=True)
    return sf.Surfels.from_mesh((np.asarray(vertices) + at, faces), reflectance=rho)


def indirect_over_direct(transfer, lamp):
    """Of all light in a room; rho / (1 - rho) where it is closed and of one colour."""
    solution = transfer.relight(lamp)
    areas = solution.surfels.areas
    direct = areas @ solution.direct[:, 0]
    return (areas @ solution.irradiance[:, 0] - direct) / direct


@pytest.mark.parametrize("rho", [0.3, 0.95, 0.99, 0.999])
def test_all_reflections_are_all_however_bright_walls_are(rho):
    """Ended where another one brought a thousandth, .99 was 9 % too dark."""
    transfer = sf.precompute_transfer(sf.Scene([box_inside(2.0, rho)]))
    found = indirect_over_direct(transfer, sf.PointLight([1.0, 1.0, 1.3], 5.0))
    assert found == pytest.approx(rho / (1 - rho), rel=2e-3)


def test_a_dim_room_has_all_its_reflections_beside_a_bright_one():
    """Solved with it, a room 1e6 times dimmer ended where the bright one did."""
    bright, dim = box_inside(2.0, 0.2), box_inside([6.0, 1.0, 1.0], 0.9, at=[0.0, 5.0, 0.0])
    transfer = sf.precompute_transfer(sf.Scene([bright, dim]))
    lamp = sf.PointLight([0.5, 5.5, 0.6], 1.0)
    alone, beside = (transfer.indirect(lamps) for lamps in (lamp, [lamp, sf.PointLight([1.0, 1.0, 1.3], 1e6)]))
    np.testing.assert_allclose(beside[len(bright) :], alone[len(bright) :], rtol=1e-4)


def test_a_color_is_reflected_to_its_end_beside_a_brighter_one():
    transfer = sf.precompute_transfer(sf.Scene([box_inside(2.0, [0.9, 0.3, 0.3])]))
    dim, alone = (transfer.indirect(sf.PointLight([1.0, 1.0, 1.3], [5.0, g, g]))[:, 0] for g in (100.0, 0.0))
    assert dim.mean() == pytest.approx(alone.mean(), rel=5e-3)


@pytest.mark.parametrize("place", [[1, 1, 0.02], [1, 1, 0.01], [1.07, 1.03, 0.01], [1.3, 0.2, 0.002]])
def test_a_lamp_close_to_coarse_patches_lights_them_as_they_are_lit(place):
    """On patches of .25: of the light of four points in each, groups sent half of it to eight times as much."""
    transfer = sf.precompute_transfer(sf.Scene([box_inside(2.0, 0.5)]))
    assert indirect_over_direct(transfer, sf.PointLight(place, 5.0)) == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("lamp", [{"height": 0.02}, {"height": 0.003}, {"cone": 2.0}, {"cone": 5.0}], ids=str)
def test_disks_share_what_is_narrower_than_they_are(lamp):
    """Centres alone tell, of a beam between them, that there is none."""
    transfer = sf.precompute_transfer(sf.Scene([sphere_inside(4000, 0.5)]))
    if "height" in lamp:
        lamps = [sf.PointLight([0, 0, 1 - lamp["height"]], 5.0)]
    else:
        axes = np.random.default_rng(0).normal(size=(8, 3))
        lamps = [sf.SpotLight([0, 0, 0], axis, 5.0, cone=lamp["cone"], penumbra=1.0) for axis in axes]
    assert np.mean([indirect_over_direct(transfer, each) for each in lamps]) == pytest.approx(1.0, rel=0.1)


def test_a_panel_that_hardly_rises_over_a_table_lights_it():
    """Rays went to points of it below the table, which hides them."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    top = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.02, 0.5)
    under = sf.Surfels.from_mesh((np.array(corners) - [0, 0, 0.02], [[3, 2, 1, 0]]), 0.02, 0.0)
    sky = sf.Surfels.from_mesh((3.0 * np.array(corners) + [-1, -1, 2], [[3, 2, 1, 0]]), 0.1, 0.0)
    scene = sf.Scene([top, under, sky], [sf.AreaLight([1.02, 0, -1.5], [0, 0, 1.6], [0, 1, 0], 1.0)])
    found = sf.precompute_transfer(scene).indirect(scene.lights, bounces=1)
    wanted = sf.solve_meshless(scene, bounces=1)
    above = slice(len(top) + len(under), None)
    reflected = (wanted.irradiance - wanted.direct)[above, 0].mean()
    assert found[above, 0].mean() == pytest.approx(reflected, rel=0.15)


@pytest.mark.parametrize("cone", [1.5, 5.0, 10.0, 20.0])
def test_groups_have_all_the_light_of_narrow_beams(cone):
    """What one patch sends is met by few rays of the others, so that single beams are off; many are not."""
    rng = np.random.default_rng(0)
    transfer = sf.precompute_transfer(sf.Scene([box_inside(2.0, 0.5)]))
    found = []
    for place, towards in zip(rng.uniform(0.3, 1.7, (16, 3)), rng.normal(size=(16, 3)), strict=True):
        spot = sf.SpotLight(place, towards / np.linalg.norm(towards), 5.0, cone=cone, penumbra=1.0)
        found.append(indirect_over_direct(transfer, spot))
    assert np.mean(found) == pytest.approx(1.0, rel=0.03)
    assert np.std(found) < 0.08


def test_reflectance_may_change_as_lights_may():
    sphere = sphere_inside(1000, 0.3)
    transfer = sf.precompute_transfer(sf.Scene([sphere]), bounces=2)
    rho = np.array([0.2, 0.5, 0.8])
    solution = transfer.relight(sf.PointLight([0, 0, 0], 1.0), reflectance=rho)
    np.testing.assert_allclose(solution.irradiance - solution.direct, np.tile(rho + rho**2, (1000, 1)), rtol=2e-3)
    np.testing.assert_allclose(solution.radiosity, rho * solution.irradiance)
    np.testing.assert_allclose(solution.surfels.reflectance, np.tile(rho, (1000, 1)))


def test_convex_bodies_and_the_dark_have_no_indirect_light():
    unit = shapes.sphere(500)
    ball = sf.precompute_transfer(sf.Scene([surfels_of(unit.points, unit.normals, 0.8)]))
    assert ball.indirect(sf.PointLight([2, 0, 0], 5.0)).max() == 0.0
    assert ball.relight(sf.PointLight([2, 0, 0], 5.0)).direct.max() > 0.0
    assert sf.precompute_transfer(sf.Scene([cube_inside(4, 0.5)])).indirect([]).max() == 0.0


@pytest.mark.slow
def test_lamps_that_light_nothing_are_warned_of(transfer):
    with pytest.warns(UserWarning, match="shine on backs of surfels, and none of it reaches fronts"):
        assert transfer.relight(sf.PointLight([0.5, 0.5, 9.0], 1.0)).irradiance.max() == 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert transfer.relight([]).irradiance.max() == 0.0
        assert transfer.relight(sf.PointLight([0.5, 0.5, 9.0], 0.0)).irradiance.max() == 0.0


def test_light_is_additive_and_linear(transfer):
    one, other = LAMPS["point"], LAMPS["spot"]
    together = transfer.indirect([one, other])
    apart = transfer.indirect(one) + transfer.indirect(other)
    np.testing.assert_allclose(together, apart, rtol=1e-5, atol=1e-5 * together.max())
    twice = transfer.indirect(sf.PointLight(one.position, 2 * np.array(one.intensity)))
    np.testing.assert_allclose(twice, 2 * transfer.indirect(one), rtol=1e-5)


def test_any_two_lamps_add_up(transfer):
    """But for what is below 0, which is cut off after the sum."""
    rng, tried = np.random.default_rng(0), 0
    for _ in range(8):
        pair = [sf.PointLight(place, rng.uniform(0.5, 3.0, 3)) for place in rng.uniform(0.05, 0.5, (2, 3))]
        one, other = (transfer.indirect(lamp) for lamp in pair)
        together = transfer.indirect(pair)
        above = (one > 0) & (other > 0)
        tried += above.mean() > 0.7  # a lamp may be in one of the boxes
        np.testing.assert_allclose(together[above], (one + other)[above], atol=1e-5 * together.max())
    assert tried >= 3


@pytest.mark.parametrize("kind", quick("point", of=LAMPS))
def test_agrees_with_the_solver(room, transfer, kind):
    """In mean light within 2 %, surfel by surfel within 6 %: both have noise of their own."""
    found = transfer.relight(LAMPS[kind], bounces=4)
    true = sf.solve_meshless(sf.Scene(room.objects, lights=[LAMPS[kind]]), bounces=4)
    indirect, expected = (s.irradiance - s.direct for s in (found, true))
    areas = true.surfels.areas
    assert np.average(indirect.sum(axis=1), weights=areas) == pytest.approx(
        np.average(expected.sum(axis=1), weights=areas), rel=0.02
    )
    assert relative_rms(indirect, expected, areas) < 0.06
    np.testing.assert_allclose(found.direct, true.direct)


@pytest.mark.slow
def test_finer_operators_agree_with_the_solver_within_two_per_cent(room):
    transfer = sf.precompute_transfer(room, epsilon_t=0.05, rays=2048, bounces=None)
    for lamp in (LAMPS["point"], LAMPS["area"]):
        true = sf.solve_meshless(sf.Scene(room.objects, lights=[lamp]), rays=2048)
        found = transfer.indirect(lamp, shadow_rays=1 << 18)
        assert relative_rms(found, true.irradiance - true.direct, true.surfels.areas) < 0.02


def test_emission_is_part_of_indirect_light():
    """In a closed uniform furnace H = E (1 + rho + rho^2) after two reflections of what is emitted."""
    furnace = sf.precompute_transfer(sf.Scene([cube_inside(6, 0.5, 2.0)]), bounces=2)
    np.testing.assert_allclose(furnace.indirect([]), 2.0 * (1 + 0.5 + 0.25), rtol=1e-5)


def test_two_sides_of_a_sheet_do_not_share_their_light():
    """Between floor and ceiling hangs a sheet of two faces; a lamp over it leaves its underside in the dark."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    sheet = sf.Surfels.from_mesh((np.vstack([corners, corners]), [[0, 1, 2, 3], [7, 6, 5, 4]]), 0.02, 0.8)
    floor = sf.Surfels.from_mesh((0.9 * corners - [0, 0, 0.3], [[0, 1, 2, 3]]), 0.02, 0.8)
    transfer = sf.precompute_transfer(sf.Scene([sheet, floor]), senders=500)
    found = transfer.relight(sf.PointLight([0, 0, 0.2], 1.0))
    up = found.surfels.points[:, 2] > -0.1
    underside = up & (found.surfels.normals[:, 2] < 0)
    assert found.direct[underside].max() == 0.0
    below = found.irradiance[(underside | ~up), 0]
    assert below.mean() < 1e-3 * found.irradiance[:, 0].mean()


@pytest.mark.slow
def test_same_for_any_number_of_threads(room):
    scene = sf.Scene(room.objects)
    one, many = (sf.precompute_transfer(scene, threads=n, levels=3).indirect(LAMP, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one, many)


def test_solution_of_relight_is_whole(room, transfer):
    solution = transfer.relight([LAMPS["area"]])
    assert len(solution.surfels) == len(room.surfels)
    assert np.isnan(solution.error)
    assert set(solution.timings) == {"indirect", "direct"}
    at = solution.irradiance_at(solution.surfels.points[:5], solution.surfels.normals[:5])
    np.testing.assert_allclose(at, solution.irradiance[:5], rtol=0.2)
    points, normals = transfer.receivers
    assert points.shape == normals.shape
    assert len(points) > 500
    assert transfer.nbytes > 1e5
    assert transfer.links > len(points)
    assert transfer.rays > 128 * len(points) / 2
    assert "receivers" in repr(transfer)


REFUSED = {
    "lighting": ({"lighting": "moon"}, "lighting: wanted"),
    "epsilon": ({"epsilon_t": 0.0}, "epsilon_t: wanted"),
    "bounces": ({"bounces": -1}, "bounces: wanted"),
    "rays": ({"rays": 8}, "rays: wanted"),
    "senders": ({"senders": 0}, "senders: wanted"),
    "patches": ({"patches": 577}, "patches: is for lighting 'sky', not 'local'"),
    "patches of distant": ({"patches": 145, "lighting": "distant"}, "patches: is for lighting 'sky', not 'distant'"),
    "other patches": ({"patches": 100, "lighting": "sky"}, "^patches: wanted one of 145, 577, .*, got 100"),
    "text for patches": ({"patches": "145", "lighting": "sky"}, "^patches: wanted a whole number, got '145'"),
}


@pytest.mark.parametrize(("options", "message"), REFUSED.values(), ids=REFUSED)
def test_options_out_of_range_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        sf.precompute_transfer(sf.Scene([cube_inside(2, 0.5)]), **options)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lights": sf.Environment(1.0)}, "got Environment at index 0; precompute_transfer"),
        (
            {"lights": sf.Sky.from_sun(40.0, 150.0, 800.0, 100.0)},
            'got Sky at index 0; precompute_transfer.scene, "sky"',
        ),
        ({"lights": 3}, "lights: wanted point, spot, photometric, area or directional lights, got int at index 0"),
        ({"lights": [LAMP, None]}, "lights: wanted point, .*, got NoneType at index 1"),
        ({"lights": LAMP, "reflectance": 1.0}, "reflectance: "),
        ({"lights": LAMP, "reflectance": [0.1, 0.2]}, "reflectance: "),
        ({"lights": LAMP, "bounces": -1}, "bounces: wanted"),
        ({"lights": LAMP, "shadow_rays": 0}, "shadow_rays: wanted"),
        ({"lights": LAMP, "penumbra_rays": 4}, "penumbra_rays: wanted at least the 16 probes"),
    ],
)
def test_lights_that_are_none_are_refused(transfer, arguments, message):
    with pytest.raises(ValueError, match=message):
        transfer.relight(**arguments)


def test_can_be_cancelled(room):
    with pytest.raises(sf.Cancelled):
        sf.precompute_transfer(room, progress=lambda done, total: False)


def test_areas_that_are_set_later_are_refused():
    """Old light would stand beside new areas, in what is saved, too."""
    ball = surfels_of(shapes.sphere(200).points, shapes.sphere(200).normals, 0.5)
    transfer = sf.precompute_transfer(sf.Scene([ball]))
    lamp = sf.PointLight([0, 0, 3], 1.0)
    transfer.relight(lamp)
    ball.areas = np.full(len(ball), 0.1)
    for call in (lambda: transfer.relight(lamp), lambda: transfer.save("a.transfer")):
        with pytest.raises(ValueError, match=r"^scene: areas of its surfels were set after precompute_transfer, which"):
            call()


def test_light_that_a_transfer_makes_is_warned_of():
    """Of a coarse ball that glows in a room: its disks reach beyond it. With some bounces others are missing."""
    unit = shapes.sphere(100)
    ball = surfels_of(0.25 * unit.points + 0.5, unit.normals, 0.5, 1.0)
    room = sf.Surfels.from_mesh(shapes.box((1.0, 1.0, 1.0), inward=True)[:2], 0.02, reflectance=0.5)
    transfer = sf.precompute_transfer(sf.Scene([ball, room]))
    with pytest.warns(UserWarning, match=r"^[\d.]+% of the light is made by the transfer: more rays help, more points"):
        figures = transfer.relight([]).history[-1]
    assert figures["power_lost"] < -0.03 * figures["power_in"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        transfer.relight([], bounces=1)


def test_lamps_may_be_above_an_open_scene():
    """Where rays that leave the scene go through the region; it was refused as if nothing saw it."""
    floor = sf.Surfels.from_mesh(([[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], [[0, 1, 2, 3]]), 1.0)
    wall = sf.Surfels.from_mesh(([[-5, 5, 0], [5, 5, 0], [5, 5, 2], [-5, 5, 2]], [[0, 1, 2, 3]]), 1.0)
    lamp = sf.PointLight([0, 0, 5.5], 100.0)
    region = [[-1, -1, 5], [1, 1, 6]]
    transfer = sf.precompute_transfer(sf.Scene([floor, wall]), region=region)
    found = transfer.indirect(lamp)
    solution = sf.solve(sf.Scene([floor, wall], [lamp]), insert=False, zeta=1e-9, rays=1024)
    true = solution.irradiance - solution.direct
    assert relative_rms(found, true, solution.surfels.areas) < 0.05
    with pytest.raises(
        ValueError, match=r"^region: no surface of the scene sees air in it; wanted where lamps will be"
    ):
        sf.precompute_transfer(sf.Scene([floor, wall]), region=[[-1, -1, -6], [1, 1, -5]])
