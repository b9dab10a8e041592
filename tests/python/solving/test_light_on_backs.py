"""Light that falls on backs straight from lamps and suns: its share, the objects, lamps in bodies."""

import json
import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.cli import commands
from surflux.scenes import shapes
from surflux.solving.lamp_rays import met_by

SOLVERS = pytest.mark.parametrize("solver", [sf.solve, sf.solve_meshless])
LAMP = sf.PointLight([0, 0, 5], 10.0)
SHINE = "backs take much of what lamps and suns shine on objects: "


def solved(scene, solver=sf.solve, **options):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return solver(scene, **options), [str(w.message) for w in said]


def ball(turned_above, n=2000):
    """Of radius 1, upside down where z is above that."""
    whole = shapes.sphere(n)
    return whole.flipped(whole.points[:, 2] > turned_above)


def on_cap(above):
    """Of the light of LAMP on the ball, what falls where z > above: the flux goes by the solid angle from the lamp."""
    tangent = np.sqrt(1.0 - 1.0 / 25.0)

    def beyond(z):
        return 1.0 - (5.0 - z) / np.sqrt((5.0 - z) ** 2 + 1.0 - z * z)

    return beyond(above) / (1.0 - tangent)


def furnished_room(height=0.3):
    """A room of 1, of one object with the body that stands in it."""
    body = sf.Surfels.from_mesh(shapes.box(0.3, 3)[:2], reflectance=0.5)
    body = body.transformed([[1, 0, 0, 0.35], [0, 1, 0, 0.35], [0, 0, 1, height], [0, 0, 0, 1]])
    return [sf.Surfels.from_mesh(shapes.box(patches=6, inward=True)[:2], reflectance=0.5), body]


@SOLVERS
@pytest.mark.parametrize("above", [0.5, 0.9])
def test_a_cap_that_is_upside_down_is_counted_and_said(solver, above):
    """Of its light that falls on backs "into backs" of reflected light said .00 %."""
    wanted = on_cap(above)
    solution, said = solved(sf.Scene([ball(above)], [LAMP]), solver)
    assert solution.history[-1]["direct_on_backs"] == pytest.approx(wanted, abs=0.03)
    counted = solution.history[-1]["direct_on_backs"]
    assert f"of the light of lamps and suns {counted:.2%} fell on backs" in str(solution)
    assert "of lamps and suns, on backs" in solution._repr_html_()
    (text,) = [text for text in said if "are backs of surfels of object 0" in text or text.startswith(SHINE)]
    assert f"{solution.history[-1]['direct_on_backs']:.0%} " in text
    assert "`surflux check`" in text
    # What is counted is what does not arrive.
    whole = sf.solve(sf.Scene([ball(2.0)], [LAMP])).history[-1]
    assert whole["direct_on_backs"] < 1e-3
    share = 1.0 - solution.history[-1]["power_in"] / whole["power_in"]
    assert share == pytest.approx(solution.history[-1]["direct_on_backs"], abs=0.04)


def test_it_comes_back_from_a_file(tmp_path):
    solution, _ = solved(sf.Scene([ball(0.5)], [LAMP]))
    again = sf.load_solution(solution.save(tmp_path / "a.ply"))
    assert str(again) == str(solution)


@SOLVERS
def test_a_statue_that_is_upside_down_in_a_lit_room_is_named(solver):
    room, _ = furnished_room()
    statue = shapes.sphere(600)
    statue = statue.transformed([[0.1, 0, 0, 0.3], [0, 0.1, 0, 0.6], [0, 0, 0.1, 0.5], [0, 0, 0, 1]])
    lamps = [
        sf.PointLight([0.8, 0.3, 0.8], 1.0),
        sf.AreaLight([0.4, 0.4, 0.99], [0, 0.2, 0], [0.2, 0, 0], 5.0),
    ]
    _, said = solved(sf.Scene([room, statue.flipped()], lamps), solver)
    assert sum(f"{SHINE}100% on object 1: " in text for text in said) == 1
    solution, said = solved(sf.Scene([room, statue], lamps), solver)
    assert solution.history[-1]["direct_on_backs"] < 1e-3
    assert not any(text.startswith((SHINE, "lights: ")) for text in said)


@pytest.mark.parametrize("above", [0.3, 0.5])
def test_a_body_that_is_turned_in_part_is_told_in_the_sun(above):
    sun = sf.DirectionalLight([0.2, 0.1, -1], 800.0)
    solution, said = solved(sf.Scene([ball(above)], [sun, sf.Environment(10.0)]))
    assert sum(text.startswith(SHINE) for text in said) == 1
    assert solution.history[-1]["direct_on_backs"] > 0.2
    assert not any(text.startswith(SHINE) for text in solved(sf.Scene([ball(2.0)], [sun]))[1])


def test_skies_and_suns_behind_what_has_one_side_are_nothing_to_tell():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[0, 1, 2, 3]]), 0.5)
    wall = sf.Surfels.from_mesh(([[0, 0, 0], [0, 4, 0], [0, 4, 3], [0, 0, 3]], [[0, 1, 2, 3]]), 0.5)
    above, below = sf.DirectionalLight([-1, 0, -1], 500.0), sf.DirectionalLight([0, 0, 1], 5.0)
    behind = sf.DirectionalLight([1, 0, -0.5], 500.0)
    sky = sf.Environment(1.0)
    for objects, lights in (([floor], [sky]), ([floor, wall], [sky, behind]), ([floor, wall], [above, below, sky])):
        solution, said = solved(sf.Scene(objects, lights))
        assert not any(text.startswith((SHINE, "lights: ")) for text in said)
    assert "direct_on_backs" not in sf.solve(sf.Scene([floor], [sky])).history[-1]
    assert solution.history[-1]["direct_on_backs"] > 0.0  # but counted


@SOLVERS
def test_a_lamp_in_a_body_beside_one_that_works_is_named(solver):
    scene = sf.Scene(furnished_room(), [sf.PointLight([0.2, 0.2, 0.8], 1.0), sf.PointLight([0.5, 0.5, 0.45], 10.0)])
    _, said = solved(scene, solver)
    (text,) = [text for text in said if "lights: " in text or SHINE in text]
    assert text.startswith("lights: of what light 1 shines on 100% are backs of surfels of object 1: it stands inside")
    assert not any("lights: " in text for text in solved(sf.Scene(scene.objects, scene.lights[:1]), solver)[1])


def test_check_names_a_lamp_in_a_body(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    room = '[[object]]\nshape = "room"\nkind = "mesh"\npatch_area = 0.1\n'
    body = '[[object]]\nshape = "box"\nsize = 0.3\npatches = 3\ntranslate = [0.3, 0.3, 0.3]\n'
    lamps = [f'[[light]]\ntype = "point"\nposition = {p}\nintensity = 1\n' for p in ([0.2, 0.2, 0.8], [0.5, 0.4, 0.45])]
    (tmp_path / "room.toml").write_text(room + body + "".join(lamps))
    assert commands.main(["check", "room.toml"]) == 0
    out = capsys.readouterr().out
    assert "\nlights: of what light 1 shines on 100% are backs of surfels of object 1: it" in "\n" + out
    assert commands.main(["check", "room.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["lamps_on_backs"] == [{"light": 1, "share": 1.0}]
    (tmp_path / "room.toml").write_text(room + body + lamps[0])
    assert commands.main(["check", "room.toml"]) == 0
    assert "lights: " not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("light", "power"),
    [
        (sf.PointLight([0.5, 0.4, 0.6], [1, 2, 3]), 4 * np.pi * 6),
        (sf.SpotLight([0.5, 0.4, 0.6], [1, 2, -2], 2.0, cone=60.0, penumbra=0.0), 12 * np.pi * (1 - np.sqrt(0.75))),
        (sf.AreaLight([0.4, 0.4, 0.7], [0, 0.2, 0], [0.1, 0, 0], 5.0), 15 * 0.02),
    ],
)
def test_rays_carry_the_power_of_their_lamp(light, power):
    core = sf.Scene([furnished_room()[0]])._to_core()
    met = met_by(light, core, 4096)
    assert met.power.sum() == pytest.approx(power, rel=2e-3)
    assert not met.on_backs.any()


def test_rays_of_a_sun_carry_what_falls_on_a_floor():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[0, 1, 2, 3]]))
    assert len(floor) == 1
    met = met_by(sf.DirectionalLight([1, 0, -1], 2.0), sf.Scene([floor])._to_core(), 16384)
    assert met.power.sum() == pytest.approx(3 * 2.0 * 16 * np.sqrt(0.5), rel=0.01)
    assert not met.on_backs.any()
