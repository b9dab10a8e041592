"""Daylight coefficients: what each patch of the sky brings, bounces included."""

import warnings

import numpy as np
import pytest

import surflux as sf
from cases.builders import cube_inside
from scenes import room_with_a_window
from surflux.scenes import shapes

SKY = np.random.default_rng(1).uniform(0.2, 3.0, (146, 3))


def steps(rho=0.6, area=0.004):
    """A stair of two steps beside a wall: shadows, edges, and reflections between them."""
    profile = [(0, 0), (0.6, 0), (0.6, 0.4), (1.0, 0.4), (1.0, 1.0)]
    corners = [(x, y, z) for y in (0.0, 1.0) for x, z in profile]
    return sf.Surfels.from_mesh((corners, [[k, k + 1, k + 6, k + 5] for k in range(4)]), area, rho)


def plane(turned=False):
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    return sf.Surfels.from_mesh((corners[::-1] if turned else corners, [[0, 1, 2, 3]]), 0.1, 0.5)


@pytest.fixture(scope="module")
def stair():
    return sf.Scene([steps([0.7, 0.5, 0.3])])


@pytest.fixture(scope="module")
def transfer(stair):
    return sf.precompute_transfer(stair, "sky", bounces=None)


def relative_rms(found, true, areas):
    return np.sqrt((areas[:, None] * (found - true) ** 2).sum() / (areas[:, None] * true**2).sum())


def test_an_open_floor_has_the_cosine_of_each_patch():
    transfer = sf.precompute_transfer(sf.Scene([plane()]), "sky")
    found = transfer.coefficients([3])[0, :, 0]
    patches = transfer.patches
    assert found[0] == 0.0  # the ground is below
    expected = patches.solid_angles[1:] * patches.directions[1:, 2]
    np.testing.assert_allclose(found[1:-1], expected[:-1], rtol=0.01)
    assert found[-1] == pytest.approx(
        np.pi * np.sin(np.arccos(1 - patches.solid_angles[-1] / (2 * np.pi))) ** 2, rel=2e-3
    )
    assert found.sum() == pytest.approx(np.pi, rel=1e-3)


def test_a_ceiling_has_the_light_of_the_ground():
    transfer = sf.precompute_transfer(sf.Scene([plane(turned=True)]), "sky")
    found = transfer.coefficients()[:, :, 0]
    np.testing.assert_allclose(found[:, 0], np.pi, rtol=1e-3)
    assert found[:, 1:].max() == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("count", [145, 577, 2305])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_all_patches_together_are_an_even_sky(stair, count, seed):
    """As `solve` of all pairs has it, within .7 % surfel by surfel and .2 % in the mean."""
    light = sf.Environment([1.0, 2.0, 0.5])
    true = sf.solve(sf.Scene(stair.objects, lights=[light]), transport="pairs", insert=False)
    found = sf.precompute_transfer(stair, "sky", bounces=None, patches=count, seed=seed).relight(light)
    areas = true.surfels.areas
    assert relative_rms(found.irradiance, true.irradiance, areas) < 0.007
    assert relative_rms(found.direct, true.direct, areas) < 0.007
    means = (np.average(s.irradiance, axis=0, weights=areas) for s in (found, true))
    np.testing.assert_allclose(*means, rtol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_room_with_a_window_is_lit_through_it(seed):
    """All that comes through a hole of area a, pi a of an even sky, falls on the walls: within 1.5 %."""
    cube = cube_inside(12, 0.7)
    hole = (cube.normals[:, 2] < 0) & (np.abs(cube.points[:, :2] - 0.5).max(axis=1) < 0.2)
    scene = sf.Scene([cube[~hole]])
    light = sf.Environment(1.0)
    found = sf.precompute_transfer(scene, "sky", bounces=None, patches=577, seed=seed).relight(light)
    areas = found.surfels.areas
    assert (areas * found.direct[:, 0]).sum() == pytest.approx(np.pi * cube.areas[hole].sum(), rel=0.015)
    true = sf.solve(sf.Scene(scene.objects, lights=[light]), insert=False)
    assert (areas * found.irradiance[:, 0]).sum() == pytest.approx((areas * true.irradiance[:, 0]).sum(), rel=0.015)
    assert relative_rms(found.irradiance, true.irradiance, areas) < 0.05


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_sun_of_a_sky_is_no_part_of_its_patch(seed):
    """Through a window a patch of 12 degrees falls somewhere else: it was off by 35 % of the RMS."""
    room, _ = room_with_a_window(0.06, 0.6)
    sky = sf.Sky.from_sun(40.0, 190.0, direct_normal=700.0, diffuse=100.0)
    scene = sf.Scene([room], lights=[sky])
    found = sf.precompute_transfer(scene, "sky", bounces=None, seed=seed).relight(sky)
    true = sf.solve(scene, insert=False, seed=seed)
    assert relative_rms(found.direct, true.direct, room.areas) < 0.03
    assert relative_rms(found.irradiance, true.irradiance, room.areas) < 0.03
    reflected = found.irradiance - found.direct, true.irradiance - true.direct
    assert relative_rms(*reflected, room.areas) < 0.08
    means = (np.average(part[:, 0], weights=room.areas) for part in reflected)
    assert next(means) == pytest.approx(next(means), rel=0.02)
    assert abs(found.history[0]["power_lost"]) < 0.02 * found.history[0]["power_in"]
    assert set(found.timings) == {"irradiance", "sun"}


def test_relight_is_linear_in_sun_and_sky(transfer):
    sky = sf.Sky.from_sun(30.0, 150.0, direct_normal=600.0, diffuse=90.0)
    sun = sf.Sky.from_sun(30.0, 150.0, direct_normal=600.0, diffuse=0.0, albedo=0.0)  # the ground is in the sky's
    parts = transfer.relight(sky.patch_radiances(transfer.patches)), transfer.relight(sun)
    np.testing.assert_allclose(sum(part.irradiance for part in parts), transfer.relight(sky).irradiance, rtol=1e-4)
    np.testing.assert_allclose(sum(part.direct for part in parts), transfer.relight(sky).direct, rtol=1e-5)
    once = transfer.relight(sun, bounces=0)
    np.testing.assert_array_equal(once.irradiance, once.direct)


def test_the_sun_comes_back_with_a_file(transfer, tmp_path):
    sky = sf.Sky.from_sun(30.0, 150.0, direct_normal=600.0, diffuse=90.0)
    again = sf.load_transfer(transfer.save(tmp_path / "stair.transfer"))
    np.testing.assert_array_equal(again.relight(sky).irradiance, transfer.relight(sky).irradiance)


def test_relight_can_be_cancelled(transfer):
    sky = sf.Sky.from_sun(30.0, 150.0, direct_normal=600.0, diffuse=90.0)
    for light in (sky, sf.Environment(1.0), SKY):
        with pytest.raises(sf.Cancelled):
            transfer.relight(light, progress=lambda *_: False)
    with pytest.raises(sf.Cancelled):  # at the sun
        transfer.relight(sky, progress=lambda done, total: total == 1)


@pytest.mark.parametrize("azimuth", [0.0, 30.0])
def test_a_sun_in_an_image_is_told(transfer, azimuth):
    """A hundredth of a per cent of the directions with a third of the light; an even or a smooth sky has none of it."""
    image = np.ones((64, 128, 3))
    image[10, 40] = 5000.0
    with pytest.warns(UserWarning, match=r"^sky: \d\d% of this environment's light is narrower .* of 12 degrees"):
        transfer.relight(sf.Environment(image, azimuth=azimuth))
    smooth = np.linspace(3.0, 0.1, 64)[:, None, None] * np.ones((1, 128, 3))
    assert transfer.patches.narrow_light(sf.Environment(smooth)) == 0.0
    assert transfer.patches.narrow_light(sf.Environment(2.0)) == 0.0
    assert transfer.patches.narrow_light(sf.Environment(0.0 * image)) == 0.0
    ground = np.ones((64, 128, 3))
    ground[50, 40] = 5000.0  # one patch, whose width more patches do not change
    assert transfer.patches.narrow_light(sf.Environment(ground)) == 0.0
    few = sf.Environment(np.where(image > 1, 1.0, 0.0), azimuth=azimuth)
    assert transfer.patches.narrow_light(few) > 0.8


@pytest.mark.slow
def test_one_light_by_harmonics_by_patches_and_by_the_solver(stair):
    """Smooth light, so that patches of 12 degrees cost little and five bands nothing, on floors: walls see the ground,
    which is one patch."""
    harmonics = np.zeros((25, 3))
    harmonics[:4] = [[4, 3, 2], [0.5, -0.4, 0.2], [0.9, 0.8, 0.7], [-0.6, 0.1, 0.3]]
    light = sf.Environment.from_harmonics(harmonics)
    true = sf.solve(sf.Scene(stair.objects, lights=[light]), transport="pairs", insert=False)
    floors = true.surfels.normals[:, 2] > 0.5
    for lighting in ("sky", "distant"):
        found = sf.precompute_transfer(stair, lighting, bounces=None, epsilon_t=0.1).relight(light)
        assert relative_rms(found.irradiance[floors], true.irradiance[floors], true.surfels.areas[floors]) < 0.02


@pytest.mark.slow
def test_coefficients_times_a_sky_are_its_light(stair, transfer):
    coefficients = transfer.coefficients()
    assert coefficients.dtype == np.float32
    assert coefficients.shape == (len(stair.surfels), 146, 3)
    found = np.einsum("npc,pc->nc", coefficients, SKY)
    np.testing.assert_allclose(found, transfer.relight(SKY).irradiance, rtol=2e-3)  # both up to the last thousandth
    few = transfer.coefficients([5, 2], bounces=3)
    np.testing.assert_allclose(np.einsum("npc,pc->nc", few, SKY), transfer.relight(SKY, bounces=3).irradiance[[5, 2]],
                               rtol=1e-4)  # fmt: skip


def test_grey_skies_and_other_reflectances(stair, transfer):
    grey = transfer.relight(SKY[:, 0], reflectance=0.0)
    np.testing.assert_allclose(grey.irradiance, grey.direct)
    np.testing.assert_allclose(grey.irradiance[:, 0], grey.irradiance[:, 2])
    brighter = transfer.relight(SKY, reflectance=0.9)
    assert (brighter.irradiance >= transfer.relight(SKY).irradiance - 1e-9).all()


def test_light_between_surfels_is_that_of_the_sky(stair, transfer):
    """Radiances alone are a light, too, that rays from the points find."""
    places = stair.surfels.points, stair.surfels.normals
    for sky in (SKY, SKY[:, 1], sf.Environment(1.0)):
        found = transfer.relight(sky)
        traced = found.irradiance_at(*places)
        assert np.array_equal(traced, found.irradiance_at(*places, direct="traced"))
        assert relative_rms(traced, found.irradiance, stair.surfels.areas) < 0.1


def test_what_surfels_emit_is_part_of_relight_and_not_of_coefficients():
    """In a closed uniform furnace, which sees nothing of the sky, H = E (1 + rho + rho^2) after two reflections."""
    furnace = sf.precompute_transfer(sf.Scene([cube_inside(6, 0.5, 2.0)]), "sky", bounces=2)
    np.testing.assert_allclose(furnace.relight(SKY).irradiance, 2.0 * (1 + 0.5 + 0.25), rtol=1e-5)
    assert furnace.coefficients([0]).max() == 0.0


@pytest.mark.slow
def test_same_for_any_number_of_threads(stair):
    one, two = (
        sf.precompute_transfer(stair, "sky", threads=n, levels=3).relight(SKY, threads=n).irradiance for n in (1, 2)
    )
    np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            {"sky": np.ones(145)},
            ValueError,
            r"sky: wanted shape \(146,\) or \(146, 3\), of which the first radiance is the ground's, got \(145,\)",
        ),
        ({"sky": np.ones((145, 3))}, ValueError, r"ground's, got \(145, 3\)$"),
        ({"sky": -SKY}, ValueError, "sky: "),
        ({"sky": "clear"}, ValueError, "sky: "),
        (
            {"sky": sf.PointLight([0, 0, 1], 1.0)},
            ValueError,
            r"^sky: wanted a Sky, an Environment or radiances \(146, 3\), got PointLight; this is a transfer of "
            r"lighting 'sky', lamps go with precompute_transfer\(scene, 'local'\)$",
        ),
        (
            {"sky": [sf.Environment(1.0)]},
            ValueError,
            "sky: wanted a Sky, .*, got a list of Environment; wanted one by itself$",
        ),
        ({"sky": [sf.Sky.from_sun(30, 180, 700, 100)]}, ValueError, "got a list of Sky; wanted one by itself$"),
        ({"sky": SKY, "reflectance": 1.0}, ValueError, "reflectance: "),
        ({"sky": SKY, "bounces": -1}, ValueError, "bounces: "),
    ],
)
def test_skies_that_are_none_are_refused(transfer, arguments, error, message):
    with pytest.raises(error, match=message):
        transfer.relight(**arguments)


def test_counts_of_patches_and_surfels_are_checked(stair, transfer):
    with pytest.raises(ValueError, match="patches: wanted one of 145, 577"):
        sf.precompute_transfer(stair, "sky", patches=146)
    with pytest.raises(IndexError, match="surfels: index 9999"):
        transfer.coefficients([9999])


def test_coefficients_can_be_cancelled(transfer):
    with pytest.raises(sf.Cancelled):
        transfer.coefficients(progress=lambda done, total: False)


@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.8])
def test_a_patch_of_very_many_functions_has_its_light(tilt):
    """Each has less than a hundredth of it."""
    corners = [[0, 0, 0], [1, 0, 0], [1, np.cos(tilt), np.sin(tilt)], [0, np.cos(tilt), np.sin(tilt)]]
    transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]))]), "sky")
    assert len(transfer.receivers[0]) > 300
    found = transfer.relight(np.ones(146)).irradiance  # even, the ground as the sky
    np.testing.assert_allclose(found, np.pi, rtol=0.02)


def test_ground_that_is_not_even_is_told():
    """Patches have one radiance for all of it: a ball had its light evened out there, by 41 %, without a word."""
    image = np.ones((32, 64, 3))
    image[16:, :32] = [8.0, 4.0, 1.0]
    image[16:, 32:] = 0.1
    transfer = sf.precompute_transfer(sf.Scene([shapes.sphere(200)]), "sky", levels=2, rays=64)
    with pytest.warns(UserWarning, match=r"3[1-4]% of the light that arrives of this environment would come"):
        transfer.relight(sf.Environment(image))
    image[16:] = image[16:].mean(axis=(0, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        transfer.relight(sf.Environment(image))


def test_of_the_ground_what_the_scene_sees_counts():
    """Of a room whose window looks at its brighter part 15 % of all light were missing, for 8 % of all round it."""
    harmonics = np.zeros((25, 3))
    harmonics[0], harmonics[1], harmonics[2] = 3.5, -1.2, 0.9  # brighter to the south
    environment = sf.Environment(np.maximum(sf.Environment.from_harmonics(harmonics).image, 0.0))
    walls, _ = room_with_a_window(0.1, 0.5)
    transfer = sf.precompute_transfer(sf.Scene([walls]), "sky", levels=2)
    with pytest.warns(UserWarning, match="of the light that arrives of this environment") as told:
        lit = transfer.relight(environment)
    share = float(str(told[0].message).split("%")[0].split()[-1]) / 100
    solved = sf.solve(sf.Scene([walls], [environment]), insert=False)
    found, true = (solution.surfels.areas @ solution.direct[:, 0] for solution in (lit, solved))
    assert 1 - found / true == pytest.approx(share, abs=0.04)
    with warnings.catch_warnings():  # an open floor sees none of it
        warnings.simplefilter("error")
        sf.precompute_transfer(sf.Scene([plane()]), "sky").relight(environment)


def test_the_middle_of_a_street_has_its_sky():
    """Of a street as wide as high, endless: 5 % were missing, hidden by noise in bands that have little power."""
    sides = [-0.5, 0.5]
    corners = [(x, y, z) for x in sides for y in (-30, 30) for z in (0, 1)]
    street = sf.Surfels.from_mesh((corners, [[0, 4, 6, 2], [1, 0, 2, 3], [4, 5, 7, 6]]), 0.015, 0.5)
    middle = (street.normals[:, 2] > 0.5) & (np.abs(street.points[:, 0]) < 0.1) & (np.abs(street.points[:, 1]) < 20)
    x = street.points[middle, 0]
    true = np.pi * sum((0.5 - side * x) / np.hypot(1, 0.5 - side * x) for side in (-1, 1)) / 2
    for seed in range(3):
        lit = sf.precompute_transfer(sf.Scene([street]), "sky", seed=seed).relight(np.r_[0.0, np.ones(145)])
        assert lit.direct[middle, 0].mean() == pytest.approx(true.mean(), rel=0.03)
