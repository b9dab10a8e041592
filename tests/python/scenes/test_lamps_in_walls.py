"""Lamps that lie in a wall, up to the rounding of a room that is turned: nothing of them goes into that wall."""

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

POWER = 120.0  # of a window
ANGLES = [0, 10, 37, 50]


def turned(angle, shift):
    """(points, directions) -> where they are in the room of that angle."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return lambda p: np.asarray(p, float) @ turn.T + shift, lambda d: np.asarray(d, float) @ turn.T


def room(at):
    vertices, faces = shapes.box((4, 5, 3), 1, inward=True)[:2]
    return sf.Surfels.from_mesh((at(vertices), faces), 0.1, reflectance=0.5)


def window(at, along):
    return sf.AreaLight(at([1, 0, 0.9]), along([0, 0, 1.2]), along([2.0, 0, 0]), POWER / 2.4)


@pytest.mark.parametrize("shift", [0.0, 100.0])
@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
def test_a_window_flush_in_a_wall(solve, angle, shift):
    """It shone on its own wall (a tenth too much power), or the process ended, for rays had no direction."""
    at, along = turned(angle, shift)
    solution = solve(sf.Scene([room(at)], [window(at, along)]))
    assert solution.surfels.areas @ solution.direct[:, 0] == pytest.approx(POWER, rel=2e-3)
    assert solution.error < 0.02
    places = solution.irradiance_at(
        at([[2, 0, 1.5], [0.5, 0, 1.5]]), along([[0, 1, 0], [0, 1, 0]]), indirect="gathered"
    )
    assert places[0, 0] == pytest.approx(places[1, 0], rel=0.3)  # what comes back from the room


@pytest.mark.parametrize("angle", ANGLES)
def test_a_window_flush_in_a_wall_that_is_relit(angle):
    at, along = turned(angle, 0.0)
    transfer = sf.precompute_transfer(sf.Scene([room(at)]), lighting="local")
    solution = transfer.relight([window(at, along)])
    assert solution.surfels.areas @ solution.direct[:, 0] == pytest.approx(POWER, rel=2e-3)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("kind", ["point", "spot"])
def test_a_lamp_on_a_wall(kind, angle):
    """Half of its power went into the patch that it is on, or all of a spot's."""
    at, along = turned(angle, 0.0)
    place = at([1.3, 0, 2])
    lamp = sf.PointLight(place, 100) if kind == "point" else sf.SpotLight(place, along([0, 1, -0.3]), 100, cone=120)
    solution = sf.solve(sf.Scene([room(at)], [lamp]))
    straight = sf.solve(sf.Scene([room(turned(0, 0.0)[0])], [type(lamp)(*arguments(lamp, [1.3, 0, 2], [0, 1, -0.3]))]))
    power, wanted = (s.surfels.areas @ s.direct[:, 0] for s in (solution, straight))
    assert power == pytest.approx(wanted, rel=1e-3)
    if kind == "point":
        assert power == pytest.approx(200 * np.pi, rel=1e-3)


def arguments(lamp, place, direction):
    return (place, 100) if isinstance(lamp, sf.PointLight) else (place, direction, 100, 120)


TOUCHING = {  # corner, edges, in the room of 4 x 5 x 3; all send 1 W
    "shelf in a corner, upwards": ([3, 4, 1], [1, 0, 0], [0, 1, 0], 1.0),
    "strip along a wall, upwards": ([0, 0, 2.5], [0.1, 0, 0], [0, 5, 0], 2.0),
    "strip along a wall, downwards": ([0, 0, 2.5], [0, 5, 0], [0.1, 0, 0], 2.0),
    "panel that stands on the floor": ([1, 1, 0], [0, 0, 1], [1, 0, 0], 1.0),
}


@pytest.mark.parametrize("angle", [0, 37])
@pytest.mark.parametrize("name", TOUCHING)
def test_a_lamp_that_touches_walls_sends_all_that_it_has(name, angle):
    """2 to 4 % were missing, or 1 % too much: of patches that its plane cuts some points are before it, some behind."""
    at, along = turned(angle, 0.0)
    corner, u, v, exitance = TOUCHING[name]
    scene = sf.Scene([room(at)], [sf.AreaLight(at(corner), along(u), along(v), exitance)])
    for solution in (sf.solve(scene, insert=False), sf.solve_meshless(scene, levels=2, rays=64)):
        assert solution.surfels.areas @ solution.direct[:, 0] == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize("angle", [0, 10, 30])
def test_a_radiator_does_not_shine_on_itself(angle):
    """Single places of a hot plate that is turned had the light of a place before it, up to 3 times what it sends."""
    at, along = turned(angle, 0.0)
    plate = np.array([[1.0, 0.05, 0.2], [1.0, 0.05, 0.8], [2.5, 0.05, 0.8], [2.5, 0.05, 0.2]])
    hot = sf.Surfels.from_mesh((at(plate), [[0, 1, 2, 3]]), 0.01, reflectance=0.2, emission=1000.0)
    scene = sf.Scene([room(at), hot])
    places = plate[0] + np.random.default_rng(angle).random((400, 3)) * [1.5, 0, 0.6]
    front = np.tile(along([0, 1, 0]), (400, 1))
    wanted, _ = sf.reference_irradiance(scene, at(places), front, samples=256)
    for solve in (sf.solve, sf.solve_meshless):
        solution = solve(scene)
        found = solution.irradiance_at(at(places), front)[:, 0]
        assert found.mean() == pytest.approx(wanted[:, 0].mean(), rel=0.1)
        assert found.max() < 2.0 * np.median(found)


@pytest.mark.parametrize("inside", [0.05, 0.15])
@pytest.mark.parametrize("solve", [sf.solve, sf.solve_meshless])
def test_a_lamp_that_goes_into_a_wall_sends_what_is_before_it(solve, inside):
    """On patches larger than the lamp it was 17 % too little."""
    patches = sf.Surfels.from_mesh(shapes.box((4, 5, 3), 1, inward=True)[:2], 0.25, reflectance=0.5)
    lamp = sf.AreaLight([2, 5.0 + inside - 0.3, 2.0], [0, 0.3, 0], [0.3, 0, 0], 1.0)
    options = {"insert": False} if solve is sf.solve else {"levels": 2, "rays": 64}
    solution = solve(sf.Scene([patches], [lamp]), **options)
    assert solution.surfels.areas @ solution.direct[:, 0] == pytest.approx(0.3 * (0.3 - inside), rel=0.005)
