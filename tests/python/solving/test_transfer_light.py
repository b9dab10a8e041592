"""Light that a transfer cannot take, or that lights nothing: what is said of it, for all three kinds of lighting."""

import re
import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes

CORNER = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
LIGHTS = {
    "local": lambda power: sf.PointLight([0.5, 0.5, 0.5], power),
    "distant": sf.Environment,
    "sky": sf.Environment,
}
SIDE = [0.4, 0.4, 0.9], [0, 0.2, 0], [0.2, 0, 0]


@pytest.fixture(scope="module")
def corner():
    return sf.Surfels.from_mesh(CORNER, 0.05, reflectance=0.5)


@pytest.fixture(scope="module")
def transfers(corner):
    return {lighting: sf.precompute_transfer(sf.Scene([corner]), lighting) for lighting in LIGHTS}


@pytest.mark.parametrize("lighting", LIGHTS)
def test_light_up_to_1e30_is_linear(transfers, lighting):
    one, most = (transfers[lighting].relight(LIGHTS[lighting](power)).irradiance for power in (1.0, 1e30))
    assert one.min() > 0.0
    np.testing.assert_allclose(most / 1e30, one, rtol=1e-5)  # by sums of some 100 float32


@pytest.mark.parametrize(
    ("lighting", "light", "said"),
    [
        (
            "local",
            sf.PointLight([0.5, 0.5, 0.5], 1e36),
            "lights: wanted intensity of at most 1e+30, got 1e+36 at index 0",
        ),
        ("local", [sf.SpotLight([0, 0, 1], [0, 0, -1], 1e31)], "lights: wanted intensity of at most 1e+30, got 1e+31"),
        (
            "local",
            [sf.AreaLight(*SIDE, 1.0), sf.AreaLight(*SIDE, [0, 1e37, 0])],
            "lights: wanted exitance .* at index 1",
        ),
        ("local", sf.DirectionalLight([0, 0, -1], 1e300), "lights: wanted irradiance of at most 1e+30, got 1e+300"),
        ("distant", sf.Environment(1e38), "environment: wanted values at most 1e+30, got 1e+38 at index 0"),
        ("distant", sf.Environment(np.full((2, 4, 3), 1e308)), "environment: wanted values at most 1e+30, got 1e+308"),
        ("distant", [0, 0, -1e31, 0], "environment: wanted values in [-1e+30, 1e+30], got -1e+31 at index (2, 0)"),
        ("sky", sf.Environment(1e37), "sky: wanted values in [0, 1e+30], got 1e+37 at index (0, 0)"),
        ("sky", sf.Environment(np.full((2, 4, 3), 1e308)), "sky: wanted values in [0, 1e+30], got "),
        ("sky", np.full((146, 3), 1e31), "sky: wanted values in [0, 1e+30], got 1e+31"),
    ],
)
def test_more_light_than_sums_hold_is_refused(transfers, lighting, light, said):
    said = said.replace("+", "\\+").replace("[", "\\[").replace("(", "\\(").replace(")", "\\)")
    with pytest.raises(ValueError, match=f"^{said}"):
        transfers[lighting].relight(light)
    if lighting == "local":
        with pytest.raises(ValueError, match=f"^{said}"):
            transfers[lighting].indirect(light)
        with pytest.raises(ValueError, match=f"^{said}"):
            sf.LampRenderer(transfers[lighting], size=(40, 30)).frame(light)


@pytest.mark.parametrize("lighting", LIGHTS)
def test_more_emission_than_sums_hold_is_refused(corner, lighting):
    scene = sf.Scene([corner, corner.replace(emission=1e36)])
    with pytest.raises(
        ValueError, match=r"^scene: emission: wanted values at most 1e\+30, got 1e\+36 at index \(0, 0\)"
    ):
        sf.precompute_transfer(scene, lighting)


def said_of(relit, *arguments):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return relit(*arguments), [str(w.message) for w in said]


def room(inward=True, patches=6):
    return sf.Surfels.from_mesh(shapes.box(patches=patches, inward=inward)[:2], reflectance=0.5)


@pytest.fixture(scope="module")
def closed():
    return {lighting: sf.precompute_transfer(sf.Scene([room()]), lighting, levels=2) for lighting in LIGHTS}


BACKS = "the scene's lights shine on backs of surfels, and none of it reaches fronts"
NONE = "none of the light reaches the front of a surfel"
MISSES = "they shine past all of them"


@pytest.mark.parametrize(
    ("lighting", "light", "why"),
    [
        ("local", sf.PointLight([4, 4, 4], 1.0), BACKS),
        ("local", [sf.DirectionalLight([0, 1, -1], 1.0), sf.PointLight([0.5, 0.5, 0.5], 0.0)], BACKS),
        ("local", sf.SpotLight([4, 4, 4], [1, 1, 1], 9.0), MISSES),
        ("distant", sf.Environment(1.0), BACKS),
        ("distant", sf.Environment.from_harmonics([1.0, 0.0, 5.0, 0.0]), BACKS),
        ("distant", [1.0, 0.0, 5.0, 0.0], NONE),
        ("sky", sf.Environment(1.0), BACKS),
        ("sky", sf.Sky.from_sun(45.0, 150.0, direct_normal=800.0, diffuse=100.0), BACKS),
        ("sky", np.ones(146), NONE),
    ],
)
def test_light_that_stays_outside_is_said_once(closed, lighting, light, why):
    solution, said = said_of(closed[lighting].relight, light)
    assert not solution.irradiance.any()
    assert len(said) == 1
    assert why in said[0]


@pytest.mark.parametrize("lighting", LIGHTS)
def test_of_light_without_power_and_of_light_that_arrives_nothing_is_said(closed, transfers, lighting):
    assert said_of(closed[lighting].relight, LIGHTS[lighting](0.0))[1] == []
    assert said_of(transfers[lighting].relight, LIGHTS[lighting](1.0))[1] == []


@pytest.mark.parametrize("rise", [0.0, 0.3])
def test_a_lamp_in_a_body_is_said(rise):
    """On the floor the body is open below: in its middle the sixth of the sphere there is floor, and all else backs."""
    body = sf.Surfels.from_mesh(shapes.box(0.5, 4)[:2], reflectance=0.5)
    body = body.transformed([[1, 0, 0, 0.25], [0, 1, 0, 0.25], [0, 0, 1, rise], [0, 0, 0, 1]])
    faces = len(body) // 6
    if rise == 0.0:
        body = body[body.points[:, 2] > 1e-6]
        assert len(body) == 5 * faces
    transfer = sf.precompute_transfer(sf.Scene([room(patches=4), body]), levels=1)
    inside = [0.5, 0.5, 0.25 + rise]
    for lamp, on_floor in (  # the area light shines downwards, into half of the sphere
        (sf.PointLight(inside, 1.0), 1 / 6),
        (sf.SpotLight(inside, [1, 0, 0], 1.0, cone=20.0), 0.0),
        (sf.AreaLight(inside, [0, 0.01, 0], [0.01, 0, 0], 1.0), 1 / 3),
    ):
        _, said = said_of(transfer.relight, [sf.PointLight([0.5, 0.5, 0.9], 1.0), lamp])
        (said,) = [text for text in said if text.startswith("lights")]  # of few levels some is made, too
        share = re.search(r"^lights: of what light 1 shines on (\d+)% are backs of surfels", said)
        wanted = 100 if rise else 100 * (1 - on_floor)
        assert abs(int(share[1]) - wanted) < 3  # some of 128 or 256 rays are along the borders of a face
    _, said = said_of(transfer.relight, sf.PointLight([0.1, 0.1, 0.9], 1.0))
    assert [text for text in said if text.startswith("lights")] == []


@pytest.mark.parametrize("lighting", LIGHTS)
def test_bounces_can_be_set_to_what_they_can_be(transfers, lighting):
    transfer, light = transfers[lighting], LIGHTS[lighting](1.0)
    assert transfer.bounces is None
    try:
        transfer.bounces = 1
        assert np.array_equal(transfer.relight(light).irradiance, transfer.relight(light, bounces=1).irradiance)
        for bounces in ("all", -1, 1.5, True):
            with pytest.raises(ValueError, match=r"^bounces: wanted a whole number"):
                transfer.bounces = bounces
        assert transfer.bounces == 1
    finally:
        transfer.bounces = None


CEILING = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]


@pytest.mark.parametrize("lighting", LIGHTS)
def test_backs_that_take_much_of_the_light_are_warned_of(lighting):
    """A plate over the floor faces up: what the floor sends upwards meets its back."""
    floor = sf.Surfels.from_mesh((CORNER[0][:4], CORNER[1][:1]), 0.1, reflectance=0.5)
    plate = sf.Surfels.from_mesh((CEILING, [[0, 1, 2, 3]]), 0.1, reflectance=0.5)
    light = sf.Environment(1.0)
    if lighting == "local":
        light = sf.SpotLight([0.5, -0.5, 0.5], [0.0, 1.0, -0.5], 1.0, cone=30.0)
    for above, warned in ((plate, True), (plate.flipped(), False)):
        _, said = said_of(sf.precompute_transfer(sf.Scene([floor, above]), lighting).relight, light)
        assert [text for text in said if re.match(r"backs of surfaces absorb \d+% of the light", text)] == said
        assert len(said) == warned


def test_where_the_power_of_a_relit_scene_goes_is_told_as_of_a_solved_one():
    """Of a corner more than half of what is sent leaves; the plate over it takes some with its back."""
    plate = sf.Surfels.from_mesh((CEILING, [[0, 1, 2, 3]]), 0.05, reflectance=0.5)
    scene = sf.Scene([sf.Surfels.from_mesh(CORNER, 0.05, reflectance=0.5), plate], [LIGHTS["local"](1.0)])
    with pytest.warns(UserWarning, match="backs of surfaces absorb"):
        solved, relit = sf.solve(scene), sf.precompute_transfer(scene).relight(scene.lights)
    wanted, found = solved.history[-1], relit.history[-1]
    for name in ("power_in", "power_absorbed", "power_escaped", "power_into_backs"):
        assert wanted[name] > 0.05 * wanted["power_in"], name
        assert found[name] == pytest.approx(wanted[name], rel=0.02), name
    assert abs(found["power_lost"]) < 0.02 * found["power_in"]
    assert "into backs" in str(relit)
    assert "into backs" in relit._repr_html_()
