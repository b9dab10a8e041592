"""Shadow borders with insertion and without (D04 7.2), on the three spheres of D04 8.1 under one point light."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from scenes import up

LIGHT = [1.8, 1.1, 2.5]


@pytest.fixture(scope="module")
def scene():
    room = sf.load_scene(Path(__file__).parents[3] / "data" / "three_spheres.toml")
    return sf.Scene(room.objects, [sf.PointLight(LIGHT, 10.0)])


@pytest.fixture(scope="module")
def borders(scene):
    """Random places of the floor within .1 m of a border of the shadows: direct light is traced around each."""
    random = np.random.default_rng(0)
    at = np.column_stack([random.uniform(0.1, 3.4, (2000, 2)), np.zeros(2000)])
    angle = np.arange(8) * np.pi / 4
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    around = np.concatenate([at[:, None], at[:, None] + 0.05 * ring, at[:, None] + 0.1 * ring], axis=1)
    lit = direct(scene, around.reshape(-1, 3)).reshape(len(at), -1) > 0
    return at[lit.any(axis=1) & ~lit.all(axis=1)][:300]


def direct(scene, points):
    """Of the point light, by rays: the whole irradiance less what bounces, which a black scene has none of."""
    objects = [
        sf.Surfels(s.points, s.normals, radii=s.radii, reflectance=0.0)
        if not len(s.triangles)
        else sf.Surfels.from_mesh(
            (s.triangles.reshape(-1, 3), np.arange(3 * len(s.triangles)).reshape(-1, 3)), reflectance=0.0
        )
        for s in scene.objects
    ]
    found, _ = sf.reference_irradiance(sf.Scene(objects, scene.lights), points, up(points), samples=16)
    return found[:, 0]


@pytest.mark.slow
def test_insertion_halves_the_error_at_shadow_borders(scene, borders):
    """Interpolated, not traced, for at most twice the surfels; without noise of the reference in it."""
    truth, spread = sf.reference_irradiance(scene, borders, up(borders), samples=4096)
    error = {}
    for insert in (False, True):
        solution = sf.solve(scene, insert=insert)
        assert len(solution.surfels) <= (2 if insert else 1) * len(scene.surfels)
        found = solution.irradiance_at(borders, up(borders), "interpolated")
        off = ((found - truth) ** 2).sum() - (spread**2).sum()
        error[insert] = np.sqrt(off / (truth**2).sum())
    assert np.sqrt((spread**2).sum() / (truth**2).sum()) < error[True] / 4
    assert error[True] <= 0.5 * error[False]
