"""Solution.estimate_error: what of a solution nobody has checked, such as a relit one, is off by."""

import copy
import warnings

import numpy as np
import pytest

import surflux as sf
from quick import quick
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


def boxes_on_a_floor(reflectance, raised):
    """Six of them in a closed room; what is beneath them is hidden, or, raised, dim."""
    mesh = [cell([0, 0, 0], [4, 3, 3])]
    for x in (0.25, 1.5, 2.75):
        for y in (0.25, 1.625):
            inwards = np.array([*cell([x, y, raised], [x + 1, y + 1.125, raised + 0.5])])
            mesh.append(inwards[:, ::-1])
    quads = np.concatenate([np.array([*part]) for part in mesh])
    faces = np.arange(4 * len(quads)).reshape(-1, 4)
    surfels = sf.Surfels.from_mesh((quads.reshape(-1, 3), faces), 0.25, reflectance)
    return sf.Scene([surfels], [sf.PointLight([2, 1.5, 2.6], 10.0)])


@pytest.mark.parametrize("seed", quick(0, of=[0, 1, 2]))
@pytest.mark.parametrize("raised", [0.0, 0.2])
@pytest.mark.parametrize("reflectance", [0.9, 0.98])
def test_what_is_hidden_takes_nothing_from_the_error(reflectance, raised, seed):
    """On the floor it was 1.3 % at .98: what nothing reaches was in the means that rays found of what is lit."""
    solution = sf.solve(boxes_on_a_floor(reflectance, raised), transport="pairs", insert=False, tolerance=1e-7)
    solution.irradiance = 1.05 * solution.irradiance
    assert solution.estimate_error(rays=300000, seed=seed) == pytest.approx(0.05, rel=0.1)


def rooms(door):
    """Two with a wall of 2 cm between them and a lamp in one, and a door that is so wide."""
    quads = []
    for low, high, there in ([0, 3, 3], [3.02, 6.02, 3.02]):
        walls = [*cell([low, 0, 0], [high, 4, 3])]
        del walls[1 if high == there else 0]
        # The wall with its door, which reaches up to the ceiling.
        for y, end in ((0, 2 - door / 2), (2 + door / 2, 4)):
            quad = [[there, y, 0], [there, end, 0], [there, end, 3], [there, y, 3]]
            walls.append(quad[::-1] if high == there else quad)
        quads += walls
    for y, turn in ((2 - door / 2, 1), (2 + door / 2, -1)):
        quads.append([[3, y, 0], [3, y, 3], [3.02, y, 3], [3.02, y, 0]][::turn])
    for z, turn in ((0, 1), (3, -1)):
        y, end = 2 - door / 2, 2 + door / 2
        quads.append([[3, y, z], [3.02, y, z], [3.02, end, z], [3, end, z]][::turn])
    return quads


@pytest.mark.parametrize("seed", quick(0, of=[0, 1, 2]))
@pytest.mark.parametrize("door", [0.0, 0.4])
def test_a_dark_room_takes_nothing_from_the_error_of_a_lit_one(door, seed):
    quads = [quad for quad in rooms(door) if np.ptp(quad, axis=0).astype(bool).sum() == 2]
    faces = np.arange(4 * len(quads)).reshape(-1, 4)
    surfels = sf.Surfels.from_mesh((np.reshape(quads, (-1, 3)), faces), 0.15, 0.95)
    scene = sf.Scene([surfels], [sf.PointLight([1.5, 2, 2.5], 10.0)])
    solution = sf.solve(scene, transport="pairs", insert=False, tolerance=1e-9)
    assert solution.history[-1]["power_escaped"] < 1e-3 * solution.history[-1]["power_in"]
    solution.irradiance = 1.05 * solution.irradiance
    assert solution.estimate_error(rays=300000, seed=seed) == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize("height", quick(0.001, of=[0.01, 0.005, 0.002, 0.001]))
def test_a_lamp_close_to_a_coarse_patch_is_exact(height):
    """The light of a patch of .2 m comes within millimetres of its foot, in closed form: it was said to be 74 % off."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    floor = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), 0.04, reflectance=0.5)
    scene = sf.Scene([floor], [sf.PointLight([0.53, 0.31, height], 10.0)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sf.solve(scene, insert=False).error < 1e-6
        assert len(sf.solve(scene, error=0.02).attempts) == 1


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
