"""What is up of bodies."""

import numpy as np
import pytest

import surflux as sf
from surflux.points.standing import (
    furniture_stands_along_y,
    is_modelled_on_y,
    lamps_hang_along_y,
    stands_along_y,
    why_y_is_up,
)

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


def box_of(low, high, faces):
    corners = [[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    return corners, faces


def room(furnished):
    """A room 4 x 5 x 3, z up, open at one side, with two blocks on its floor or none."""
    inwards = [[0, 1, 3, 2], [4, 6, 7, 5], [1, 5, 7, 3], [2, 3, 7, 6], [0, 2, 6, 4]]
    sides = [[4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    parts = [box_of((0, 0, 0), (4, 5, 3), inwards)]
    if furnished:
        parts += [box_of((0.5, 2, 0), (1.5, 3.5, 0.8), sides), box_of((2.4, 1, 0), (3.2, 1.7, 1.6), sides)]
    corners = np.concatenate([np.asarray(c, float) for c, _ in parts])
    faces = [[k + 8 * part for k in face] for part, (_, of) in enumerate(parts) for face in of]
    return corners, faces


@pytest.mark.parametrize("furnished", [True, False])
def test_a_room_stands_along_y_where_its_furniture_does(furnished):
    """Floor and ceiling look like two walls: without anything on the floor, nothing is said."""
    corners, faces = room(furnished)
    found = []
    for up, turn in TURNS.items():
        surfels = sf.Surfels.from_mesh((corners @ turn.T, faces), patch_area=0.02)
        assert not stands_along_y(surfels)
        found += [up] if furniture_stands_along_y(surfels) else []
    assert found == (["y"] if furnished else [])


@pytest.mark.parametrize("shines", [True, False])
def test_an_empty_room_stands_along_y_where_its_lamp_hangs(shines):
    corners, faces = room(furnished=False)
    lamp = [[1.5, 2, 2.98], [1.5, 3, 2.98], [2.5, 3, 2.98], [2.5, 2, 2.98]]
    corners, faces = np.concatenate([corners, lamp]), [*faces, [8, 9, 10, 11]]
    found = []
    for up, turn in TURNS.items():
        emission = [0.0] * 5 + [float(shines)]
        surfels = sf.Surfels.from_mesh((corners @ turn.T, faces), patch_area=0.02, emission=emission)
        found += [up] if lamps_hang_along_y(surfels) else []
        assert (why_y_is_up(surfels) is not None) == (up in found)
    assert found == (["y"] if shines else [])


def test_a_model_whose_origin_is_beneath_its_middle_stands_along_y():
    """A table: no side of it is a base, and a floor that it stands on it has none."""
    parts = [box_of((-1, -0.5, 0.7), (1, 0.5, 0.75), None)[0]]
    parts += [box_of((x, y, 0), (x + 0.1, y + 0.1, 0.7), None)[0] for x in (-1, 0.9) for y in (-0.5, 0.4)]
    sides = [[4, 5, 7, 6], [0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    corners = np.concatenate(np.asarray(parts, float))
    faces = [[k + 8 * part for k in face] for part in range(5) for face in sides]
    for shift, wanted in (([0, 0, 0], ["y"]), ([0, 0, 0.1], []), ([0.1, 0, 0], [])):
        moved = corners + shift
        found = [up for up, turn in TURNS.items() if is_modelled_on_y(sf.Surfels.from_mesh((moved @ turn.T, faces)))]
        assert found == wanted


@pytest.mark.scans
def test_a_sofa_stands_along_y(scans):
    assert why_y_is_up(sf.Surfels.from_mesh(scans / "hard" / "sofa.ply")) is not None


@pytest.mark.scans
@pytest.mark.parametrize("name", ["Original", "Sphere", "Water", "Empty-CO", "Empty-RG", "Empty-Squashed"])
def test_cornells_box_stands_along_y(scans, name):
    path = scans / "scenes" / "cornell_mcguire" / f"CornellBox-{name}.obj"
    assert why_y_is_up(sf.Surfels.from_mesh(path, patch_area=0.002)) is not None


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
