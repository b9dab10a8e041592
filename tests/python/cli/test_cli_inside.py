"""Pictures of rooms, from the place of the scanner that stood in them."""

import logging

import numpy as np
import pytest

import surflux as sf
from surflux.cli.commands import main
from surflux.pictures.inside import camera_inside, clearance, is_room_around, lies_around
from surflux.scenes.studio import room_light

SIZE = np.array([8.0, 4.0, 3.0])
PLACE = np.array([2.0, 1.0, 1.2])


def room(n=6000):
    rng = np.random.default_rng(0)
    points = rng.uniform(0.0, 1.0, (n, 3))
    side = rng.choice(6, n, p=np.repeat([12.0, 24.0, 32.0], 2) / 136.0)
    points[np.arange(n), side // 2] = side % 2
    return points * SIZE


def test_a_room_lies_around_a_place_in_it_alone():
    assert lies_around(room(), PLACE)
    assert not lies_around(room(), [20.0, 1.0, 1.0])
    assert not lies_around(room()[room()[:, 2] < 0.1], PLACE)  # the floor


def test_a_room_has_a_ceiling():
    above = SIZE[2] - PLACE[2]
    assert is_room_around(room(), PLACE, (0, 0, 1))
    assert clearance(room(), PLACE, (0, 0, 1)) == pytest.approx(above, rel=0.1)
    skylight = room()[np.linalg.norm((room() - PLACE)[:, :2], axis=1) > 1.5]
    assert clearance(skylight, PLACE, (0, 0, 1)) == pytest.approx(above, rel=0.1)
    court = room()[room()[:, 2] < 2.0]
    assert not is_room_around(court, PLACE, (0, 0, 1))
    assert clearance(court[court[:, 2] < 1.0], PLACE, (0, 0, 1)) == 0.0


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_the_lamp_of_a_room_is_as_bright_whichever_way_normals_face(turned):
    points = room()
    sides = np.argmin(np.minimum(points, SIZE - points), axis=1)
    inward = np.where(points < 0.5 * SIZE, 1.0, -1.0) * (sides[:, None] == np.arange(3))
    walls = sf.Surfels(points, turned * inward, radii=0.1)
    _, down, up = room_light(walls, sf.Camera(PLACE, [7.0, 2.0, 1.2]), (0.0, 0.0, 1.0))
    assert down.exitance == up.exitance
    height = PLACE[2] + 0.5 * (SIZE[2] - PLACE[2])
    assert np.asarray(down.corner)[2] == pytest.approx(height, abs=0.1)
    assert 1.0 < np.max(down.exitance) < 1e5


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("where", [["--viewpoint", "2,1,1.2"], ["--eye", "2,1,1.2", "--target", "5,1,1.2"]])
def test_a_room_is_lit_from_within(where, seed, tmp_path, monkeypatch, caplog):
    """Its lamp stood outside: light came through the cracks alone, a hundredth of that of a body."""
    monkeypatch.chdir(tmp_path)
    sf.Scan(room()).save("room.ply")
    flip = [] if "--viewpoint" in where else ["--normals", "flip"]
    with caplog.at_level(logging.INFO, "surflux"):
        assert main(["solve", "room.ply", *where, *flip, "--rays", "64", "--seed", str(seed), "-q"]) == 0
    light = sf.read_scan("room_solved.ply").attributes["irradiance_g"]
    assert np.quantile(light, 0.05) > 0.3 * np.median(light)
    assert np.median(light) > 0.5


@pytest.mark.parametrize("up", [[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
def test_the_camera_looks_level_and_far(up):
    turned = np.roll(np.eye(3), {0: 1, 1: -1, 2: 0}[int(np.argmax(np.abs(up)))], axis=0)
    camera = camera_inside(room() @ turned, PLACE @ turned, up)
    ahead = camera.target - camera.eye
    assert camera.eye == pytest.approx(PLACE @ turned)
    assert ahead @ up == pytest.approx(0.0, abs=1e-9)


def test_it_looks_to_the_wall_that_is_farthest():
    camera = camera_inside(room(), PLACE, (0, 0, 1))
    assert (camera.target - camera.eye)[0] > 0.9


@pytest.mark.parametrize("more", [[], ["--eye", "-9,2,1"]])
def test_solve_draws_a_room_from_the_scanner(more, tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    sf.Scan(room()).save("room.ply")
    command = ["solve", "room.ply", "--viewpoint", "2,1,1.2", "--rays", "16", "--size", "80x60", "--image", "room.exr"]
    with caplog.at_level(logging.INFO, "surflux"):
        assert main([*command, *more]) == 0
    assert ("from the scanner's place" in caplog.text) == (not more)
    alpha = sf.read_image("room.exr", "alpha")
    assert (alpha.mean() > 0.99) == (not more)
