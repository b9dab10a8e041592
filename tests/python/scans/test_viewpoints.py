"""Where points were seen from goes along with them into files, and comes back."""

import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.cli import commands

EYE = [2.0, 2.0, 1.5]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def box(corner=(0.0, 0.0, 0.0), n=400):
    """Points on the walls, the floor and the ceiling of a room of 4 x 4 x 3 m."""
    rng, walls = np.random.default_rng(2), []
    for axis, size in enumerate((4.0, 4.0, 3.0)):
        for place in (0.0, size):
            wall = rng.random((n, 3)) * [4.0, 4.0, 3.0]
            wall[:, axis] = place
            walls.append(wall)
    return np.vstack(walls) + corner


def inward(surfels, eye):
    return np.mean(np.sum(surfels.normals * (eye - surfels.points), axis=1) > 0.0)


@pytest.mark.parametrize("name", ["room.ply", "room.npz"])
def test_a_room_is_seen_from_inside_again(name):
    scan = sf.Scan(box(), viewpoints=[EYE])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path = scan.save(name, comments=["viewpoint unknown", "viewpoint 1 2"] if name == "room.ply" else ())
    again = sf.read_scan(path)
    assert again.viewpoint.tolist() == EYE
    assert not again.attributes
    for surfels in (scan.surfels(), again.surfels(), sf.read(path)):
        assert inward(surfels, EYE) == 1.0


def test_none_that_is_known_is_not_written():
    path = sf.Scan(box(), viewpoints=[[np.nan] * 3]).save("room.ply")
    assert b"viewpoint" not in path.read_bytes()[:400]


@pytest.mark.parametrize("name", ["two.ply", "two.npz"])
def test_each_scan_has_its_own(name):
    places = np.array([EYE, [np.nan] * 3, [12.0, 2.0, 1.5]])
    points = np.vstack([box(), box((10.0, 0.0, 0.0))])
    of = np.repeat([0, 2], len(points) // 2)
    path = sf.Scan(points, viewpoints=places, attributes={"scan": of}).save(name)
    again = sf.read_scan(path)
    np.testing.assert_array_equal(again.viewpoints, places)
    np.testing.assert_array_equal(again.attributes["scan"], of)
    for surfels in (again.surfels(), sf.read(path)):
        assert inward(surfels, places[of]) == 1.0


def test_a_column_scan_may_be_anything():
    """A number that no place has says nothing of its points, and is no error."""
    points = box()
    scan = sf.Scan(
        points, viewpoints=[EYE, [9.0, 9.0, 9.0]], attributes={"scan": np.r_[7.0, -1.0, np.nan, points[3:, 0] * 0]}
    )
    assert inward(scan.surfels()[3:], EYE) == 1.0
    path = scan.save("any.ply")
    assert inward(sf.read(path)[3:], EYE) == 1.0


def test_texts_and_vertices_behind_others_have_them_too():
    header = "ply\nformat ascii 1.0\ncomment viewpoint 1 2 3\n"
    first = "element first 1\nproperty int k\n"
    vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    for name, text in (
        ("a.ply", f"{header}{vertex}end_header\n0 0 0\n"),
        ("b.ply", f"{header}{first}{vertex}end_header\n5\n0 0 0\n"),
    ):
        with open(name, "w") as file:
            file.write(text)
        assert sf.read_scan(name).viewpoint.tolist() == [1.0, 2.0, 3.0]


def test_an_array_with_a_row_for_each_point_is_an_attribute():
    np.savez("a.npz", points=box(n=1), viewpoints=np.ones((6, 3)))
    scan = sf.read_scan("a.npz")
    assert scan.attributes["viewpoints"].shape == (6, 3)
    assert scan.viewpoints.shape == (0, 3)
    sf.Scan([[0, 0, 0]], viewpoints=[EYE]).save("one.npz")
    assert sf.read_scan("one.npz").viewpoint.tolist() == EYE


def test_where_they_are_lost_it_is_said():
    scan = sf.Scan(box(), viewpoints=[EYE])
    with pytest.warns(UserWarning, match=r"room\.csv: where the points were seen from is left out"):
        scan.save("room.csv")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scan.save("room.csv", normals=scan.surfels().normals)  # which say it
        sf.Scan(box(), viewpoints=[[np.nan] * 3]).save("room.csv")


def test_what_is_lit_keeps_them():
    sf.Scan(box(), viewpoints=[EYE]).save("room.ply")
    assert commands.main(["solve", "room.ply", "--light", "sky", "--no-image", "-q"]) == 0
    assert sf.read_scan("room_solved.ply").viewpoint.tolist() == EYE
    assert inward(sf.load_solution("room_solved.ply").surfels, EYE) == 1.0
