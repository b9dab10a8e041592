"""Scenes that stay dark, and the one warning that says why."""

import json
import math
import re
import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

SOLVERS = pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])


def ball(facing, n=800):
    """Directions on a Fibonacci lattice, with normals outwards (1) or inwards (-1)."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    phi = np.pi * (1.0 + np.sqrt(5.0)) * k
    d = np.c_[np.sqrt(1.0 - z * z) * np.cos(phi), np.sqrt(1.0 - z * z) * np.sin(phi), z]
    return sf.Surfels(d, normals=facing * d)


def room(inward, patches=4):
    return sf.Surfels.from_mesh(shapes.box(patches=patches, inward=inward)[:2])


OUTSIDE, INSIDE = sf.PointLight([4, 4, 4], 100.0), sf.PointLight([0.5, 0.5, 0.5], 1.0)
FLOOR = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
BACKS = r"shine on backs of surfels, and none of it reaches fronts.*Surfels\.flipped\(\).*viewpoint=.*`surflux check`"
DARK = {
    "a scan turned inside out": (lambda: ball(-1), OUTSIDE, BACKS),
    "a lamp in a scan that faces outwards": (lambda: ball(1), sf.PointLight([0, 0, 0], 1.0), BACKS),
    "a room with its faces reversed": (lambda: room(False), INSIDE, BACKS),
    "a closed room under the sky": (lambda: room(True), sf.Environment(1.0), BACKS),
    "a sun below the floor": (lambda: FLOOR, sf.DirectionalLight([0, 0, 1], 1.0), BACKS),
    "a lamp in millimetres": (lambda: room(True), sf.PointLight([500, 500, 500], 1e6), BACKS),
    "a lamp without power": (lambda: ball(1), sf.PointLight([2, 2, 2], 0.0), "lights have no power"),
    "a spot that misses": (lambda: ball(1), sf.SpotLight([4, 4, 4], [1, 1, 1], 9.0), "shine past all of them"),
    "no lamp": (lambda: ball(1), None, "the scene has no lights and nothing in it emits"),
}


def solved(solver, scene):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return solver(scene), [str(w.message) for w in said]


@SOLVERS
@pytest.mark.parametrize("name", DARK)
def test_a_dark_scene_says_why_once_and_claims_no_precision(name, solver):
    surfels, light, why = DARK[name]
    solution, said = solved(solver, sf.Scene([surfels()], [] if light is None else [light]))
    assert not solution.irradiance.any()
    assert len(said) == 1
    assert re.search(why, said[0])
    units = re.search(r", or are in other units: (\d+) times as far away as the scene is wide$", said[0])
    assert (int(units[1]) > 100 if units else False) == (name == "a lamp in millimetres")
    assert math.isnan(solution.error)
    assert "error unknown" in repr(solution)


@pytest.mark.slow
@SOLVERS
def test_a_little_light_that_leaks_in_is_no_sign_of_the_right_side(solver):
    """The sun meets three sides of a cube, 100 patches each, of which one is a hole: 1/300 of its light gets in."""
    sun = sf.DirectionalLight([-1, -1, -1], 1.0)

    def holed(inward):
        walls = room(inward, 10)
        top = np.flatnonzero(walls.points[:, 2] > 1.0 - 1e-9)
        return walls[np.arange(len(walls)) != top[55]]

    dark, said = solved(solver, sf.Scene([holed(True)], [sun]))
    assert dark.direct.any()
    assert len(said) == 1
    assert re.search(r"only 0\.3\d% of it reaches fronts", said[0])
    assert solved(solver, sf.Scene([holed(False)], [sun]))[1] == []


@SOLVERS
def test_lit_scenes_and_lamps_that_light_nothing_but_themselves_are_not_warned_of(solver):
    glowing = ball(1).replace(emission=1.0)
    solution, said = solved(solver, sf.Scene([glowing]))  # convex: nothing receives
    assert said == []
    assert math.isnan(solution.error)
    narrow = sf.SpotLight([0.5, 0.5, 0.9], [0, 0, -1], 1.0, cone=6.0)  # a thousandth of a black room
    black = sf.Scene([room(True).replace(reflectance=0.0)], [narrow])
    assert not any("backs" in text for text in solved(solver, black)[1])


@SOLVERS
def test_a_lamp_that_a_sky_hides_the_lack_of_is_named(solver):
    """Of a floor that faces down half the light of an environment is left, and nothing of the sun."""
    sun, lamp = sf.DirectionalLight([0, 0, -1], 5.0), sf.PointLight([0.5, 0.5, 1.0], 5.0)
    lights = [sf.Environment(1.0), sun, lamp]
    _, said = solved(solver, sf.Scene([FLOOR.flipped()], lights))
    assert [text.split(" shines on backs of surfels alone: ")[0] for text in said] == [repr(sun), repr(lamp)]
    assert solved(solver, sf.Scene([FLOOR], lights))[1] == []


@SOLVERS
@pytest.mark.parametrize("lights", [1, 2])
def test_a_floor_that_faces_down_beneath_lit_tops_is_told(solver, lights):
    """Of the sun 2.5 % met fronts, tops of a table and a box, and nothing was said."""
    floor = sf.Surfels.from_mesh(([[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], [[0, 1, 2, 3]]), 0.05)
    top = sf.Surfels.from_mesh(([[0, 0, 0.5], [0.6, 0, 0.5], [0.6, 0.6, 0.5], [0, 0.6, 0.5]], [[0, 1, 2, 3]]), 0.05)
    suns = [sf.DirectionalLight([-0.5, 0.3, -0.8], 3.0), sf.DirectionalLight([0.5, 0.3, -0.8], 3.0)][:lights]
    _, said = solved(solver, sf.Scene([floor.flipped(), top], suns))
    assert sum("shines on backs of surfels nearly alone: normals face away" in text for text in said) == lights
    assert not any("shines on backs" in text for text in solved(solver, sf.Scene([floor, top], suns))[1])


@pytest.mark.parametrize("elevation", [15.0, 40.0, 70.0])
def test_a_sun_on_the_outsides_of_a_room_with_a_window_is_nothing_to_tell(elevation):
    walls = room(True, 10)
    window = (walls.points[:, 1] < 1e-9) & (np.abs(walls.points[:, [0, 2]] - 0.5) < 0.11).all(axis=1)
    sky = sf.Sky.from_sun(elevation, 180.0, direct_normal=800.0, diffuse=0.0)
    assert window.sum() == 4
    for lights in ([sky], sky.lights[:1]):
        _, said = solved(sf.solve, sf.Scene([walls[~window]], lights))
        assert not any("nearly alone" in text or "backs of surfels alone" in text for text in said)


@pytest.mark.parametrize("height", [0.05, 0.5])
def test_steep_terrain_that_is_wound_downwards_is_told(height):
    """Slopes whose fronts the sun would meet, were nothing in the way."""
    x, y = np.meshgrid(np.linspace(0, 10, 41), np.linspace(0, 10, 41))
    corners = np.stack([x, y, height * np.sin(2 * x) * np.sin(2 * y)], axis=2).reshape(-1, 3)
    quads = [[k, k + 41, k + 42, k + 1] for j in range(40) for k in range(41 * j, 41 * j + 40)]
    hills = sf.Surfels.from_mesh((corners, quads))
    sky = sf.Sky.from_sun(40.0, 160.0, direct_normal=800.0, diffuse=100.0)
    _, said = solved(sf.solve, sf.Scene([hills], [sky]))
    assert any("shines on backs of surfels alone" in text for text in said)
    assert solved(sf.solve, sf.Scene([hills.flipped()], [sky]))[1] == []


def test_a_sun_behind_a_facade_or_a_roof_side_is_nothing_to_tell():
    facade = sf.Surfels.from_mesh(([[0, 0, 0], [9, 0, 0], [9, 0, 5], [0, 0, 5]], [[0, 1, 2, 3]]), 0.5)
    roof = sf.Surfels.from_mesh(([[0, 0, 0], [9, 0, 0], [9, 4, 4], [0, 4, 4]], [[0, 1, 2, 3]]), 0.5)
    behind = sf.Sky.from_sun(20.0, 20.0, direct_normal=500.0, diffuse=80.0)
    for surfels in (facade, roof):
        assert solved(sf.solve, sf.Scene([surfels], [behind]))[1] == []


@SOLVERS
def test_a_lamp_between_floors_and_the_back_of_the_ceiling_beneath(solver):
    """A beam that few surfels are in: the floor is in its way, whoever is asked."""
    offset = np.eye(4)
    offset[2, 3] = -0.5
    below = FLOOR.flipped().transformed(offset)
    beam = sf.SpotLight([0.5, 0.5, 0.5], [0, 0, -1], 5.0, cone=20.0)
    assert solved(solver, sf.Scene([FLOOR, below], [sf.Environment(1.0), beam]))[1] == []


def test_an_unknown_error_comes_back_from_a_file(tmp_path):
    dark, _ = solved(sf.solve, sf.Scene([ball(-1)], [OUTSIDE]))
    dark.save(tmp_path / "dark.ply")
    again = sf.load_solution(tmp_path / "dark.ply")
    assert math.isnan(again.error)
    assert math.isnan(again.history[-1]["error"])
    assert again.history[-1]["power_in"] == 0


def test_the_command_prints_json_of_a_dark_scene(tmp_path, monkeypatch, capsys):
    from surflux.cli import commands

    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.toml").write_text(
        '[[object]]\nshape = "room"\nkind = "mesh"\npatch_area = 0.1\n[[light]]\ntype = "environment"\nradiance = 1.0\n'
    )
    assert commands.main(["solve", "room.toml", "--json", "--no-image"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["error"] is None
    assert err.count("warning:") == 1
    assert "shine on backs" in err
