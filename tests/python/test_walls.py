"""Thin, doubled and open walls in one mesh hold the light, and take none from what stands beside them."""

import numpy as np
import pytest

import surflux as sf
from cases import church

# A patch has one value, also where a wall divides it: those of the church end with its dark rooms.
DARK = 0.01  # of the mean over all surfels
LOST = 0.05  # of what indirect light there is


def faces_a_dark_room(surfels):
    before = surfels.points + 1e-3 * surfels.normals
    inside = np.zeros(len(surfels), dtype=bool)
    for low, high in church.DARK_ROOMS.values():
        inside |= np.all((before > low) & (before < high), axis=1)
    return inside


@pytest.fixture(scope="module")
def lit_church():
    scene = church.scene()
    black = church.scene(reflectance=0.0)
    surfels = scene.surfels
    inside = faces_a_dark_room(surfels)
    others = np.flatnonzero(~inside)
    places = surfels.points[others], surfels.normals[others]
    total, error = sf.reference_irradiance(scene, *places, samples=192, seed=1)
    direct, _ = sf.reference_irradiance(black, *places, samples=64, seed=2)
    dark = surfels.points[inside], surfels.normals[inside]
    assert sf.reference_irradiance(scene, *dark, samples=64, seed=3)[0].max() == 0.0
    return scene, inside, others, total[:, 0], error[:, 0], direct[:, 0]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_church_keeps_its_rooms_dark_and_its_walls_lit(lit_church, seed):
    scene, inside, others, total, error, direct = lit_church
    solution = sf.solve(scene, seed=seed)
    areas = solution.surfels.areas
    mean = np.average(solution.irradiance[:, 0], weights=areas)
    own = inside[solution.parents]
    assert own.sum() >= 500
    assert solution.irradiance[own].max() < DARK * mean

    share = np.bincount(solution.parents, areas * (solution.irradiance - solution.direct)[:, 0], len(scene.surfels))
    found = (share / np.bincount(solution.parents, areas, len(scene.surfels)))[others]
    indirect = total - direct
    lit = indirect - 4 * error > 0.3 * np.mean(indirect)
    assert lit.sum() >= 200
    assert (found[lit] > LOST * indirect[lit]).all()

    points, normals = scene.surfels.points[inside], scene.surfels.normals[inside]
    assert solution.irradiance_at(points, normals, direct="traced").max() < DARK * mean


def panelled(gap):
    """A wall 2 x 2 at y = 0 that faces -y, and before it a panel that covers its lower half and faces the same way."""
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    quads = [([0, 0, 0], 2 * x, 2 * z), ([0, -gap, 0], 2 * x, z)]
    # The panel ends at the wall on all sides.
    y = np.array([0, gap, 0])
    quads += [([0, -gap, 1], 2 * x, y), ([0, -gap, 0], z, y), ([2, -gap, 0], y, z), ([0, -gap, 0], y, 2 * x)]
    corners = np.array([[c, c + u, c + u + v, c + v] for c, u, v in ((np.array(c), u, v) for c, u, v in quads)])
    floor = np.array([[[-1, -3, 0], [3, -3, 0], [3, -1, 0], [-1, -1, 0]]], dtype=float)
    corners = np.concatenate([corners, floor]).reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 4)


@pytest.mark.parametrize("gap", [0.01, 0.003])
def test_what_a_panel_covers_has_nothing_of_its_light(gap):
    mesh = sf.Surfels.from_mesh(panelled(gap), patch_area=0.01, reflectance=0.6)  # they end with it
    solution = sf.solve(sf.Scene([mesh], [sf.DirectionalLight([0, 0.6, -0.8], 10.0)]))
    x, z = (axis.ravel() for axis in np.meshgrid(np.linspace(0.1, 1.9, 10), np.linspace(0.1, 0.9, 9)))
    facing = np.tile([0.0, -1, 0], (len(x), 1))
    covered = solution.irradiance_at(np.stack([x, 0 * x, z], axis=1), facing)
    before = solution.irradiance_at(np.stack([x, 0 * x - gap, z], axis=1), facing)
    assert before.min() > 1.0
    assert covered.max() < DARK * before.mean()


def cell(low, high):
    """A box that faces in."""
    low, edges = np.array(low), np.diag(np.subtract(high, low))
    for k in range(3):
        u, v, w = edges[(k + 1) % 3], edges[(k + 2) % 3], edges[k]
        yield from ([low, low + u, low + u + v, low + v], [low + w, low + w + v, low + w + u + v, low + w + u])


def test_no_group_spans_a_wall():
    """Two cells of one mesh, 3 cm apart, and a lamp in one: the other has exactly nothing, where groups of floor on
    both sides of the wall would send across."""
    quads = [*cell([0, 0, 0], [0.985, 1, 1]), *cell([1.015, 0, 0], [2, 1, 1])]
    mesh = np.array(quads).reshape(-1, 3), np.arange(4 * len(quads)).reshape(-1, 4)
    cells = sf.Surfels.from_mesh(mesh, patch_area=0.002, reflectance=0.7)
    solution = sf.solve(sf.Scene([cells], [sf.PointLight([0.5, 0.5, 0.5], 1.0)]), zeta=0.1, insert=False)
    beyond = solution.surfels.points[:, 0] > 1
    assert beyond.sum() > 1000
    assert solution.irradiance[beyond].max() == 0.0
