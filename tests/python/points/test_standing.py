"""What is up of bodies."""

import numpy as np
import pytest

import surflux as sf
from surflux.points.standing import stands_along_y

# z up becomes: itself, y up, and x up, y and z down.
TURNS = {
    "z": np.eye(3),
    "y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "-z": np.diag([1, -1, -1]),
    "x": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    "-y": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
}


def drop(seed, closed):
    """A body with a round top, on a flat base or open there, z up."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(4000, 3))
    points = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    normals = points.copy()
    below = points[:, 2] < -0.7
    points[below, 2], normals[below] = -0.7, [0, 0, -1]
    kept = ~below | closed
    return points[kept] * [1.0, 1.0, 1.5], normals[kept]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("closed", [True, False])
def test_a_body_stands_along_y_where_its_base_is_there(seed, closed):
    points, normals = drop(seed, closed)
    found = [up for up, turn in TURNS.items() if stands_along_y(sf.Surfels(points @ turn.T, normals @ turn.T))]
    assert found == ["y"]


def test_what_has_no_base_does_not_stand_along_y():
    directions = np.random.default_rng(0).normal(size=(3000, 3))
    ball = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    assert not stands_along_y(sf.Surfels(ball, ball))
    sheet = np.random.default_rng(0).uniform(size=(3000, 3)) * [1, 0, 1]
    assert not stands_along_y(sf.Surfels(sheet, np.tile([0.0, 1, 0], (3000, 1))))


@pytest.mark.scans
@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("buddha_50k.ply", True),
        ("lion_takanawa_342k_surfels.ply", False),
        pytest.param("armadillo_43k.ply", True, marks=pytest.mark.slow),
        pytest.param("bunny_34834.ply", True, marks=pytest.mark.slow),
        pytest.param("bun_zipper.ply", True, marks=pytest.mark.slow),
        pytest.param("dragon_50k.ply", True, marks=pytest.mark.slow),
    ],
)
def test_statues(scans, name, wanted):
    statue = sf.read(scans / "statues" / name)
    for turn, as_it_is in ((TURNS["z"], True), (np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), False)):
        turned = sf.Surfels(statue.points @ turn.T, statue.normals @ turn.T)
        assert stands_along_y(turned) == (wanted and as_it_is)
