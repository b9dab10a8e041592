"""Every pass gives the same to the last bit on 1, 2 and 4 threads.

Form factors and the reference are held to it in their own files.
"""

import numpy as np
import pytest

import surflux as sf
from scenes import cube_inside, surfels_of
from surflux._base.passes import thread_limit
from surflux.scenes import shapes


def noisy_sphere(n=1500):
    points = np.random.default_rng(4).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return points * np.random.default_rng(5).uniform(0.995, 1.005, (n, 1))


def scene():
    room = cube_inside(5, [0.7, 0.5, 0.3], 0.01)
    unit = shapes.sphere(300)
    ball = surfels_of(0.2 * unit.points + np.array([0.5, 0.5, 0.4]), unit.normals, 0.6)
    sky = sf.Environment(np.random.default_rng(0).uniform(size=(8, 16, 3)))
    lamp = sf.AreaLight([0.4, 0.4, 0.99], [0.2, 0, 0], [0, -0.2, 0], 3.0)
    return sf.Scene([room, ball], [lamp, sf.PointLight([0.2, 0.3, 0.8], 1.0), sky])


def estimated():
    s = sf.Surfels(noisy_sphere())
    return s.points, s.normals, s.radii


def thinned():
    s = surfels_of(noisy_sphere(), noisy_sphere()).thinned(400)
    return s.points, s.radii


def sampled():
    s = sf.Surfels.sample_mesh(shapes.box((1, 1, 1), 2)[:2], 500)
    return s.points, s.normals, s.radii


def solved():
    s = sf.solve(scene(), seed=5)
    return s.radiosity, s.irradiance, s.direct, s.error, s.surfels.areas


def solved_meshless():
    s = sf.solve_meshless(scene(), levels=3, rays=64, seed=5)
    at = np.random.default_rng(1).uniform(size=(200, 3)) * [1, 1, 0]
    return s.radiosity, s.irradiance, s.direct, s.error, s.irradiance_at(at, np.tile([0.0, 0, 1], (200, 1)))


def picture():
    s = sf.solve(scene(), seed=5)
    return (s.render(sf.Camera([0.5, 0.1, 0.5], [0.5, 1, 0.4], fov=60), size=(64, 48)),)


def turned():
    normals = noisy_sphere()
    normals[normals[:, 2] > 0.7] *= -1
    s = surfels_of(noisy_sphere(), normals)
    return (sf.inward_patches(s),)


PASSES = {
    "normals and radii": estimated,
    "thinned": thinned,
    "sample_mesh": sampled,
    "areas": lambda: (sf.effective_areas(surfels_of(noisy_sphere(), noisy_sphere())),),
    "areas of the paper": lambda: (sf.effective_areas(surfels_of(noisy_sphere(), noisy_sphere()), method="paper"),),
    "areas by GL": lambda: (sf.effective_areas(surfels_of(noisy_sphere(), noisy_sphere()), backend="gl"),),
    "inward patches": turned,
    "solve": solved,
    "solve_meshless": solved_meshless,
    "render": picture,
}


@pytest.mark.parametrize("name", PASSES)
@pytest.mark.slow
def test_same_on_1_2_and_4_threads(name):
    with thread_limit(1):
        first = PASSES[name]()
    for threads in (2, 4):
        with thread_limit(threads):
            again = PASSES[name]()
        for one, other in zip(first, again, strict=True):
            np.testing.assert_array_equal(one, other)
