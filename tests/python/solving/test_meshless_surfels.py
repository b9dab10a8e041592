"""sf.solve_meshless at surfels finer than its last level: they have light of their own."""

import itertools

import numpy as np
import pytest

import surflux as sf
from scenes import rms
from surflux.scenes import shapes


def slotted_plate(slots=8, depth=0.06):
    """The unit square from above, half of it lands, half bottoms of slots between them."""
    corners, quads = [], []

    def quad(a, b, c, d):
        quads.append(np.arange(4) + len(corners))
        corners.extend([a, b, c, d])

    edges = np.arange(2 * slots + 1) / (2 * slots)
    for k, (x, end) in enumerate(itertools.pairwise(edges)):
        z = 0.0 if k % 2 else -depth
        for y in np.arange(4) / 4:
            quad([x, y, z], [end, y, z], [end, y + 0.25, z], [x, y + 0.25, z])
        if k % 2 == 0:
            quad([end, 1, -depth], [end, 0, -depth], [end, 0, 0], [end, 1, 0])
            if k > 0:
                quad([x, 0, -depth], [x, 1, -depth], [x, 1, 0], [x, 0, 0])
    return sf.Surfels.from_mesh((corners, quads), reflectance=0.8)


def test_surfels_finer_than_the_last_level_have_light_of_their_own():
    """Lands and bottoms face the same way, closer together than points are: the basis has what is between."""
    scene = sf.Scene([slotted_plate()], [sf.Environment(1.0)])
    solution = sf.solve_meshless(scene, levels=2, radius=0.5)
    flat = solution.surfels.normals[:, 2] > 0.9
    at, normals, areas = (getattr(solution.surfels, name)[flat] for name in ("points", "normals", "areas"))
    land, found, basis = (
        at[:, 2] > -0.01,
        solution.irradiance[flat],
        solution.irradiance_at(at, normals, "interpolated"),
    )
    true, _ = sf.reference_irradiance(scene, at, normals, samples=4096)
    assert rms(basis, true, areas) > 0.1
    np.testing.assert_allclose(found[land], np.pi, rtol=1e-9)
    assert rms(found[~land], true[~land], areas[~land]) < 0.04
    assert np.all(solution.levels[flat] == 2)
    assert solution.history[-1]["surfels_gathered"] == np.sum(solution.levels == 2)
    # With a number of bounces, too, it is the same light as one more of what there was before.
    last, before = (sf.solve_meshless(scene, levels=2, radius=0.5, bounces=n).irradiance[flat] for n in (4, 3))
    assert np.all(last[~land] >= before[~land])
    assert rms(last, found, areas) < 0.02


@pytest.mark.parametrize("rays", [16, 64, 256])
@pytest.mark.slow
def test_noise_does_not_choose_surfels(rays):
    """However few the rays, surfels are nearer to the light of many than the basis is at their centres."""
    walls, faces, _ = shapes.box(1.0, 20, inward=True)
    block, sides, _ = shapes.box(0.3, 6)
    objects = [
        sf.Surfels.from_mesh(mesh, reflectance=0.6)
        for mesh in ((walls, faces), (block + np.array([0.55, 0.2, 0.0]), sides))
    ]
    scene = sf.Scene(objects, [sf.AreaLight([0.4, 0.4, 0.99], [0, 0.2, 0], [0.2, 0, 0], 10.0)])
    true = sf.solve_meshless(scene, rays=4096, levels=4, epsilon_e=0.02)
    solution = sf.solve_meshless(scene, rays=rays)
    s = solution.surfels
    indirect, wanted = solution.irradiance - solution.direct, true.irradiance - true.direct
    basis = solution.irradiance_at(s.points, s.normals, "interpolated") - solution.direct
    assert solution.history[-1]["surfels_gathered"] < 0.2 * len(s)
    assert rms(indirect, wanted, s.areas) < rms(basis, wanted, s.areas) < 0.04
