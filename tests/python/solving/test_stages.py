"""The scenes of figures, data/sponza.toml and data/statue.toml: what stands where, and what the light reaches."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf

pytestmark = pytest.mark.scans
DATA = Path(__file__).parents[3] / "data"


@pytest.fixture(scope="module")
def sponza():
    with pytest.warns(UserWarning, match=r"^mesh: 422 degenerate faces dropped \(no area\)$"):
        return sf.load_scene(DATA / "sponza.toml")


@pytest.mark.slow
def test_sponza_stands_upright_in_metres(sponza):
    s = sponza.surfels
    assert len(s) > 262_267
    assert s.areas.max() <= 0.25 * (1 + 1e-9)
    low, high = s.triangles.min(axis=(0, 1)), s.triangles.max(axis=(0, 1))
    assert high - low == pytest.approx([37.2, 22.9, 15.6], abs=0.1)
    floor = (np.abs(s.points[:, 2] + 0.03) < 0.02) & (s.normals[:, 2] > 0.99)
    assert s.areas[floor].sum() == pytest.approx(332, abs=10)
    assert np.all(s.reflectance < 1)


@pytest.mark.slow
def test_sponza_s_leaves_have_backs_and_its_curtains_need_none(sponza):
    s = sponza.surfels
    twins = len(s) - len(np.unique(np.hstack([s.points, np.abs(s.normals)]), axis=0))
    assert 60_000 < twins < 70_000  # of 262 267 faces
    # A red curtain of the arcade, from 5.33 to 8.2 along it: closed, and no patch twice.
    inside = (s.points > [5.3, -2.2, 0.3]) & (s.points < [8.3, -1.85, 2.6])
    curtain = np.all(inside, axis=1) & (s.reflectance[:, 0] > 2 * s.reflectance[:, 1])
    assert curtain.sum() > 2500
    assert len(np.unique(s.points[curtain], axis=0)) == curtain.sum()
    red, green, blue = np.average(s.reflectance[curtain], axis=0, weights=s.areas[curtain])
    assert red > 4 * max(green, blue)
    closed = np.linalg.norm(s.areas[curtain] @ s.normals[curtain]) / s.areas[curtain].sum()
    assert closed < 0.1


@pytest.mark.slow
def test_the_sun_reaches_sponza_s_floor(sponza):
    """Across the court, some places in the sun and some in the shade; the aisles behind the curtains are dim."""
    y = np.linspace(-2.0, 2.2, 22)
    points = np.column_stack([np.full(22, -2.0), y, np.full(22, -0.025)])
    aisle = [[-2.0, -5.0, -0.025], [-2.0, 4.5, -0.025]]
    up = np.tile([0, 0, 1.0], (24, 1))
    irradiance, _ = sf.reference_irradiance(sponza, np.vstack([points, aisle]), up, samples=1024)
    lit = irradiance[:22, 0] > 0.9 * 40.0 * 0.9 / np.linalg.norm([0.4, 0.16, 0.9])
    assert 3 < lit.sum() < 19
    assert 0.0 < irradiance[22:, 0].max() < 0.2 * irradiance[:22, 0].max()


@pytest.mark.slow
def test_the_statue_stands_on_its_plinth():
    scene = sf.load_scene(DATA / "statue.toml")
    room, plinth, statue = scene.objects
    assert 99_000 < len(np.unique(statue.faces)) <= 100_000
    assert 100_000 <= len(statue.triangles) < 100_100  # some are cut where the plinth stands on them
    low, high = statue.triangles.min(axis=(0, 1)), statue.triangles.max(axis=(0, 1))
    top = plinth.points[:, 2].max()
    assert 0.0 < low[2] - top < 0.01  # neither floating nor sunk
    feet = statue.points[statue.points[:, 2] < top + 0.1, :2]
    assert len(feet) > 1000
    edge = 0.01  # a claw reaches over by 5 mm
    assert np.all(feet > plinth.triangles.min(axis=(0, 1))[:2] - edge)
    assert np.all(feet < plinth.triangles.max(axis=(0, 1))[:2] + edge)
    assert np.all(low > room.triangles.min(axis=(0, 1)))
    assert np.all(high < room.triangles.max(axis=(0, 1)))
    cells = plinth.triangles[:, :, :2] / 0.2
    assert cells == pytest.approx(np.round(cells), abs=1e-6)  # whole cells of the floor
    (lamp,) = scene.lights
    assert np.cross(lamp.edge_u, lamp.edge_v)[2] < 0
    assert 3.1 < lamp.corner[2] < 3.2
    colours = {tuple(np.round(row, 2)) for row in room.reflectance}
    assert len(colours) == 3
