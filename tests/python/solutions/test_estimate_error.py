"""Solution.estimate_error: what of a solution nobody has checked, such as a relit one, is off by."""

import copy

import numpy as np
import pytest

import surflux as sf
from scenes import cell, rms
from surflux.scenes import shapes

LAMP = sf.PointLight([0.5, 0.3, 0.8], 1.0)


def room_with_a_ball(reflectance=0.5):
    unit = shapes.sphere(162)
    ball = sf.Surfels(0.2 * unit.points + [0.5, 0.5, 0.3], unit.normals, reflectance=reflectance)
    return sf.Scene([room([*cell([0, 0, 0], [1, 1, 1])], reflectance), ball])


def room(quads, reflectance=0.5):
    return sf.Surfels.from_mesh(
        (np.reshape(quads, (-1, 3)), np.arange(4 * len(quads)).reshape(-1, 4)), 0.01, reflectance
    )


@pytest.fixture(scope="module")
def transfer():
    return sf.precompute_transfer(room_with_a_ball())


def test_a_relit_solution_learns_its_error(transfer):
    solution = transfer.relight(LAMP)
    assert np.isnan(solution.error)
    assert solution.estimate_error() == solution.error
    last = solution.history[-1]
    assert last["error"] == solution.error
    assert 0.0 < last["error_uncertainty"] < 0.5 * solution.error
    assert 0.0 < last["local_error"] <= last["local_error_p90"]
    assert last["rays"] <= 1 << 20
    twin = copy.copy(solution)
    twin.estimate_error(seed=7)
    assert solution.history[-1] is last
    assert twin.history[-1]["rays"] > 1.5 * last["rays"]
    true = sf.solve(sf.Scene(transfer.scene.objects, [LAMP]), rays=4096, zeta=0.002, insert=False).irradiance
    wrong = rms(solution.irradiance, true, solution.surfels.areas)
    assert 0.6 * wrong < solution.error < 1.6 * wrong


@pytest.mark.parametrize("factor", [0.5, 0.9, 1.2])
def test_it_goes_by_what_the_irradiance_is(transfer, factor):
    """H that is all too low or too high by a share, beside light that is right to a hundredth."""
    solution = sf.solve(sf.Scene(transfer.scene.objects, [LAMP]), insert=False)
    before = solution.error
    solution.irradiance = factor * solution.irradiance
    assert before < 0.02
    assert solution.estimate_error(seed=3) == pytest.approx(abs(1.0 - factor), rel=0.15)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_light_that_is_wrong_in_a_dim_room_is_local(seed):
    """Beside a bright room, through a gap: twice the light there is nothing to the RMS of all."""
    # The first two quads of `cell` are its sides at low and high x.
    bright, dim = [*cell([0, 0, 0], [1, 1, 1])], [*cell([1, 0, 0], [1.7, 1, 1])]
    wall = [[1, 0, 0], [1, 1, 0], [1, 1, 0.95], [1, 0, 0.95]]
    del bright[1], dim[0]
    scene = sf.Scene([room([*bright, wall[::-1]]), room([*dim, wall])], [sf.PointLight([0.8, 0.5, 0.5], 1.0)])
    solution = sf.solve(scene, insert=False, seed=seed)
    right = solution.history[-1]
    assert right["local_error_p90"] < 0.2
    there = np.asarray(solution.objects) == 1
    solution.irradiance = np.where(there[:, None], 2.0, 1.0) * solution.irradiance
    assert solution.estimate_error(seed=seed) < 0.1
    assert solution.history[-1]["local_error_p90"] > 0.4


def test_other_reflectances_are_those_of_the_solution(transfer):
    solution = transfer.relight(LAMP, reflectance=0.9)
    assert solution.estimate_error() < 0.05
    assert transfer.relight(LAMP, reflectance=0.2).estimate_error() < 0.02


def test_a_sky_with_its_sun(transfer):
    hole = sf.Scene([room([*cell([0, 0, 0], [1, 1, 1])][:-1])])
    sky = sf.Sky(47.4, 8.5, "2025-06-21 12:00+02:00")
    assert sf.precompute_transfer(hole, "sky").relight(sky).estimate_error() < 0.2


def test_where_no_light_is_there_is_no_error(transfer):
    assert np.isnan(transfer.relight([]).estimate_error())


def test_it_wants_a_scene_and_numbers(transfer, tmp_path):
    solution = transfer.relight(LAMP)
    solution.save(tmp_path / "a.ply")
    loaded = sf.load_solution(tmp_path / "a.ply")
    with pytest.raises(ValueError, match=r"^estimate_error: wanted a solution with its scene, which a file does not"):
        loaded.estimate_error()
    with pytest.raises(ValueError, match=r"^rays: wanted "):
        solution.estimate_error(rays=0)
    with pytest.raises(ValueError, match=r"^seed: wanted "):
        solution.estimate_error(seed=-1)
    solution.irradiance = np.full_like(solution.irradiance, np.nan)
    with pytest.raises(ValueError, match=r"^irradiance: wanted finite"):
        solution.estimate_error()


def test_threads_do_not_matter_and_cancelling_leaves_all_as_it_was(transfer):
    one, two = transfer.relight(LAMP), transfer.relight(LAMP)
    assert one.estimate_error(threads=1) == two.estimate_error(threads=2)
    fresh = transfer.relight(LAMP)
    with pytest.raises(sf.Cancelled):
        fresh.estimate_error(progress=lambda done, total: False)
    assert np.isnan(fresh.error)
