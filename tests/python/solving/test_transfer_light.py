"""Light that a transfer cannot take, or that lights nothing: what is said of it, for all three kinds of lighting."""

import numpy as np
import pytest

import surflux as sf

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
