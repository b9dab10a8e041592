"""Pictures of patches that coincide: the later is seen, as it is the one that light comes to."""

import numpy as np
import pytest

import surflux as sf

FLOOR, RUG = [0.7, 0.5, 0.3], [0.1, 0.8, 0.1]
CAMERAS = [sf.Camera([0.1, 0.2, 3.0], [0.0, 0.0, 0.0]), sf.Camera([0.1, 0.2, 3.0], [0.0, 0.0, 0.0], height=2.0)]


def square(half, patch_area, **material):
    corners = [[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]]
    return sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area, **material)


@pytest.mark.parametrize("camera", CAMERAS, ids=["perspective", "parallel"])
@pytest.mark.parametrize("rug_is_later", [True, False])
def test_the_later_of_two_patches_in_one_place_is_seen(tmp_path, camera, rug_is_later):
    """The first that was drawn was seen, in pictures of all solvers: a rug on a floor was missing."""
    objects = [square(2.0, 0.3, reflectance=FLOOR), square(0.8, 0.037, reflectance=RUG)]
    scene = sf.Scene(objects if rug_is_later else objects[::-1], [sf.PointLight([0.0, 0.0, 3.0], 9.0)])
    seen = RUG if rug_is_later else FLOOR
    solved = sf.solve(scene)
    solved.save(tmp_path / "rug.ply")
    solutions = [solved, sf.load_solution(tmp_path / "rug.ply"), sf.precompute_transfer(scene).relight(scene.lights)]
    if camera.height is None:
        solutions.append(sf.solve_meshless(scene))
    for solution in solutions:
        found = solution.render(camera, (120, 90), layers=["albedo", "radiance"], samples=1)
        middle = np.s_[30:60, 40:80]
        np.testing.assert_allclose(found["albedo"][middle].reshape(-1, 3), np.tile(seen, (1200, 1)), atol=1e-3)
        assert found["radiance"][45, 60] == pytest.approx(np.array(seen) / np.pi, rel=0.05)


def test_a_lamp_that_is_let_flush_into_a_ceiling_is_seen():
    ceiling = square(1.0, 0.05, reflectance=0.5)
    lamp = square(0.3, 0.01, reflectance=0.2, emission=50.0)
    solution = sf.solve(sf.Scene([ceiling, lamp]))
    found = solution.render(CAMERAS[1], (81, 61), samples=1)
    np.testing.assert_allclose(found[25:35, 35:45], 50.0 / np.pi, rtol=0.01)


def test_of_three_layers_the_topmost_is_seen_everywhere():
    """A mat on a part of a rug on a floor: beside the mat floor and rug were drawn as far off."""
    mat = [0.2, 0.2, 0.9]
    objects = [
        square(2.0, 0.3, reflectance=FLOOR),
        square(0.8, 0.037, reflectance=RUG),
        square(0.3, 1.0, reflectance=mat),
    ]
    solution = sf.solve(sf.Scene(objects, [sf.PointLight([0.0, 0.0, 3.0], 9.0)]))
    found = solution.render(CAMERAS[1], (200, 200), layers=["albedo"], samples=1)["albedo"]
    share = [np.mean(np.abs(found - color).max(axis=2) < 0.02) for color in (mat, RUG, FLOOR)]
    assert share == pytest.approx([0.09, 0.64 - 0.09, 0.36], abs=0.02)
