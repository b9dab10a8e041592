"""Direct light against closed forms, through solve: black surfaces, so that H is what the lights send."""

import dataclasses

import numpy as np
import pytest

import surflux as sf
from scenes import patch, solve_own, surfels_of

POINT = [0, 0, 0]


def surfel(normal=(0, 0, 1), at=POINT):
    """A disk, which takes light at its centre."""
    return sf.Surfels([at], [normal], radii=0.01, areas=1e-4 * np.pi, reflectance=0.0)


def received(light, s=None, *obstacles, **options):
    """H (3,) of the first surfel."""
    s = surfel() if s is None else s
    return solve_own(sf.Scene([s, *obstacles], [light]), **options).direct[0]


def degrees(angle):
    return np.sin(np.radians(angle)), np.cos(np.radians(angle))


def test_point_light():
    """I cos / r^2: at (0, 3, 4) r = 5 and cos = .8. From below, nothing."""
    np.testing.assert_allclose(received(sf.PointLight([0, 3, 4], [100, 50, 25])), [3.2, 1.6, 0.8], rtol=1e-12)
    assert np.all(received(sf.PointLight([0, 3, -4], 100)) == 0)
    # On a patch it is the mean: E = I h / r^3 integrated over a square of half side a is the solid angle, I Omega / A,
    # Omega = 4 atan(a^2 / (h sqrt(2 a^2 + h^2))): for a = h = 1, 4 atan(1 / sqrt(3)) = 2 pi / 3.
    square = patch([-1, -1, 0], [2, 0, 0], [0, 2, 0])
    assert received(sf.PointLight([0, 0, 1], 6.0), square, probes=256, shadow_rays=256)[0] == pytest.approx(
        6.0 * (2 * np.pi / 3) / 4, rel=5e-3
    )


@pytest.mark.parametrize(
    ("angle", "share"),
    # cone 40, penumbra 20 (full angles): full up to 10 degrees, 0 from 20, between them smoothstep in the angle:
    # a quarter of the way down, x = .75, x^2 (3 - 2 x) = .84375.
    [(0, 1.0), (9.99, 1.0), (12.5, 0.84375), (15, 0.5), (17.5, 0.15625), (20.01, 0.0), (90, 0.0), (180, 0.0)],
)
def test_spot_light(angle, share):
    sine, cosine = degrees(angle)
    spot = sf.SpotLight([0, 0, 2], [sine, 0, -cosine], 8.0, cone=40, penumbra=20)
    np.testing.assert_allclose(received(spot), 8.0 / 4.0 * share, atol=1e-12)


def test_spot_light_with_a_sharp_edge():
    for angle, share in ((22.4, 1.0), (22.6, 0.0)):
        sine, cosine = degrees(angle)
        spot = sf.SpotLight([0, 0, 2], [sine, 0, -cosine], 8.0, cone=45, penumbra=0)
        assert received(spot)[0] == pytest.approx(2.0 * share)


def test_directional_light():
    """E cos: the light comes from (0, -3, 4) / 5, cos = .8; a patch takes the same."""
    sun = sf.DirectionalLight([0, 3, -4], [5, 1, 0])
    np.testing.assert_allclose(received(sun), [4.0, 0.8, 0.0], rtol=1e-12)
    np.testing.assert_allclose(received(sun, patch(POINT, [3, 0, 0], [0, 3, 0])), [4.0, 0.8, 0.0], rtol=1e-12)
    assert np.all(received(sf.DirectionalLight([0, 3, 4], 5)) == 0)


def test_area_light_over_an_element():
    """Unit square from its corner at distance 1 (DESIGN section 7): parallel .1385316060, perpendicular .0557341970."""
    parallel = sf.AreaLight([0, 1, 1], [1, 0, 0], [0, -1, 0], 2.0)
    np.testing.assert_allclose(received(parallel), 2 * 0.1385316060, rtol=1e-9)
    upright = sf.AreaLight([1, 0, 0], [0, 0, 1], [0, 1, 0], [1.0, 2.0, 3.0])
    np.testing.assert_allclose(received(upright), [0.0557341970 * k for k in (1, 2, 3)], rtol=1e-8)
    # It shines along edge_u x edge_v alone.
    assert np.all(received(sf.AreaLight([0, 0, 1], [1, 0, 0], [0, 1, 0], 2.0)) == 0)


def test_area_light_over_a_patch():
    """Opposite squares of the unit cube exchange .1998248957, adjacent ones .2000437761 of M (DESIGN section 7)."""
    floor = patch(POINT, [1, 0, 0], [0, 1, 0], rho=0.0, patch_area=0.04)
    opposite = sf.AreaLight([0, 1, 1], [1, 0, 0], [0, -1, 0], 3.0)
    adjacent = sf.AreaLight([0, 0, 0], [0, 1, 0], [0, 0, 1], 3.0)
    for light, wanted in ((opposite, 0.1998248957), (adjacent, 0.2000437761)):
        direct = solve_own(sf.Scene([floor], [light])).direct
        assert direct.mean() == pytest.approx(3.0 * wanted, rel=5e-3)


def test_area_light_cut_by_the_horizon():
    """A wall that goes down below the element's plane lights it as if it ended there."""
    whole = sf.AreaLight([1, 0, 0], [0, 0, 1], [0, 1, 0], 1.0)
    deeper = sf.AreaLight([1, 0, -5], [0, 0, 6], [0, 1, 0], 1.0)
    np.testing.assert_allclose(received(deeper), received(whole), rtol=1e-12)


def sky(of_elevation, height=64):
    """A latitude-longitude image from the cosine of the angle to `up`, at the rows' middle."""
    cosine = np.cos(np.pi * (np.arange(height) + 0.5) / height)
    return np.tile(of_elevation(cosine)[:, None, None], (1, 2 * height, 3)).astype(float)


def test_constant_environment():
    np.testing.assert_allclose(received(sf.Environment([1.0, 2.0, 3.0])), [np.pi, 2 * np.pi, 3 * np.pi], rtol=1e-12)


@pytest.mark.slow
def test_environment_as_an_image():
    """H of a sky that depends on the elevation alone, on a level surfel: 2 pi times the integral of L(c) c dc, c 0..1.

    In closed form, but for cells that the horizon crosses: some 1e-3 of what the sky brings (here 8e-4).
    """
    for of_elevation, wanted in (
        (lambda c: np.ones_like(c), np.pi),  # all around
        (lambda c: c > 0, np.pi),  # above the horizon
        (lambda c: c < 0, 0.0),
        (lambda c: np.maximum(c, 0), 2 * np.pi / 3),
        (lambda c: 1 + 2 * np.maximum(c, 0), np.pi + 4 * np.pi / 3),  # the CIE overcast sky, times 3
    ):
        assert received(sf.Environment(sky(of_elevation)), rays=1024)[0] == pytest.approx(wanted, abs=6e-3)


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [0, 30, 60, 90, 150])
def test_a_tilted_plane_under_half_a_sky(tilt):
    """(1 + cos b) / 2 of pi L (DESIGN section 7), no ground."""
    sine, cosine = degrees(tilt)
    upper = sf.Environment(sky(lambda c: c > 0))
    wanted = 0.5 * (1 + cosine) * np.pi
    assert received(upper, surfel((sine, 0, cosine)), rays=1024)[0] == pytest.approx(wanted, abs=0.01 * np.pi)
    # Turned with the surfel, it is whole again.
    turned = sf.Environment(sky(lambda c: c > 0), up=(sine, 0, cosine))
    assert received(turned, surfel((sine, 0, cosine)), rays=1024)[0] == pytest.approx(np.pi, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("row", "column"), [(5, 8), (3, 0), (7, 20)])
def test_one_pixel_of_the_environment(row, column):
    """A pixel of solid angle dphi (cos t0 - cos t1) stands where the docstring says; a patch of it is like a sun."""
    image = np.zeros((16, 32, 3))
    image[row, column] = 100.0
    edges = np.cos(np.pi * np.array([row, row + 1]) / 16)
    solid_angle = (edges[0] - edges[1]) * 2 * np.pi / 32
    theta, phi = np.pi * (row + 0.5) / 16, np.pi - 2 * np.pi * (column + 0.5) / 32
    direction = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    # Facing it, the cosine over 11 degrees is 1 within 1 %.
    facing = received(sf.Environment(image), surfel(direction))[0]
    assert facing == pytest.approx(100.0 * solid_angle, rel=0.02)
    assert received(sf.Environment(image), surfel(-direction))[0] == 0.0
    # 60 degrees off, half of it; the edge of the pixel is 5.6 degrees away: cos(60 +- 5.6) averages to .5 within 1 %.
    aside = np.cross(direction, [0.6, 0.0, 0.8])
    tilted = 0.5 * direction + np.sqrt(0.75) * aside / np.linalg.norm(aside)
    assert received(sf.Environment(image), surfel(tilted), rays=1024)[0] == pytest.approx(50.0 * solid_angle, rel=0.03)


LIGHTS = [
    sf.PointLight([0, 0, 2], 8.0),
    sf.SpotLight([0, 0, 2], [0, 0, -1], 8.0),
    sf.DirectionalLight([0, 0, -1], 5.0),
    sf.AreaLight([-0.1, 0.1, 2], [0.2, 0, 0], [0, -0.2, 0], 1.0),
]


@pytest.mark.parametrize("light", LIGHTS, ids=lambda light: type(light).__name__)
def test_shadows(light):
    """Patches and disks cast shadows whichever way they face; what stands beside or behind the light casts none."""
    open_air = received(light)
    assert np.all(open_air > 0)
    size = [[2.0, 0, 0], [0, 2.0, 0]]
    sheet = [[x, y, 1.0] for x in np.arange(-0.5, 0.6, 0.1) for y in np.arange(-0.5, 0.6, 0.1)]
    for above in (
        patch([-1, -1, 1], *size),
        patch([-1, -1, 1], *size[::-1]),
        surfels_of(sheet, [[0, 0, 1]] * 121),
        surfels_of(sheet, [[0, 0, -1]] * 121),
    ):
        assert np.all(received(light, surfel(), above) == 0)
    assert np.array_equal(received(light, surfel(), patch([1.2, -1, 1], *size)), open_air)
    assert np.array_equal(received(light, surfel(), patch([-1, -1, -0.1], *size)), open_air)
    if not isinstance(light, sf.DirectionalLight):
        assert np.array_equal(received(light, surfel(), patch([-1, -1, 2.1], *size)), open_air)


@pytest.mark.slow
def test_half_a_light():
    """A half plane over x > 0 hides half of a light that is symmetric about it."""
    roof = patch([0, -50, 1], [50, 0, 0], [0, 100, 0], rho=0.0)
    lamp = sf.AreaLight([-1, 1, 2], [2, 0, 0], [0, -2, 0], 1.0)
    for seed in range(5):
        share = received(lamp, surfel(), roof, seed=seed) / received(lamp)
        # 64 stratified rays: the edge crosses 8 of 8 x 8 cells, of which each is decided for or against.
        np.testing.assert_allclose(share, 0.5, atol=8 / 64)
    shares = [received(lamp, surfel(), roof, seed=seed)[0] / received(lamp)[0] for seed in range(40)]
    # Unbiased: their mean over seeds is better by the square root of their number.
    assert np.mean(shares) == pytest.approx(0.5, abs=8 / 64 / np.sqrt(40))
    # Half of a uniform sky; to a sheet at x = 0 upright, the half space x < 0 is the whole sky of what faces it.
    half = received(sf.Environment(1.0), surfel(), roof)
    np.testing.assert_allclose(half, 0.5 * np.pi, rtol=0.02)


def test_a_light_does_not_occlude():
    lamp = sf.AreaLight([-1, 1, 1], [2, 0, 0], [0, -2, 0], 0.0)
    scene = sf.Scene([surfel()], [lamp, sf.PointLight([0, 0, 2], 8.0)])
    np.testing.assert_allclose(solve_own(scene).direct, 2.0, rtol=1e-12)


def half_sky(width=64):
    """Radiance 1 where phi is in (0, pi): in the half of all directions around phi = pi / 2."""
    image = np.zeros((width // 2, width, 3))
    image[:, : width // 2] = 1.0
    return image


@pytest.mark.slow
@pytest.mark.parametrize("azimuth", [30, 0, 90, 180, -45, 270])
@pytest.mark.parametrize("up", [(0.6, 0, 0.8), (0, 0, 1), (0, 0, -1)])
def test_a_turned_environment_lights_what_faces_its_bright_half(azimuth, up):
    """pi (1 + cos b) / 2, b between the normal and the middle of the bright half: as a tilted plane under half a sky.

    That middle is phi = 90 degrees, by the docstring the image of +y, turned about `up` by the azimuth (Rodrigues).
    """
    light = sf.Environment(half_sky(), up=up, azimuth=azimuth)
    middle = np.array([0, -1 if up[2] < 0 else 1, 0])  # +y stays where `up` leans towards x; up = -z turns it about x
    sine, cosine = degrees(azimuth)
    middle = cosine * middle + sine * np.cross(up, middle)
    across = np.cross(middle, up)
    for b in (0, 60, 90, 180):
        sine, cosine = degrees(b)
        wanted = 0.5 * (1 + cosine) * np.pi
        found = received(light, surfel(cosine * middle + sine * across), rays=1024)[0]
        assert found == pytest.approx(wanted, abs=0.01 * np.pi)


@pytest.mark.slow
def test_whole_turns_of_an_environment_change_no_bit():
    rng = np.random.default_rng(0)
    image = rng.uniform(size=(16, 32, 3))
    tilted = surfel((0.3, 0.5, 0.4))

    def light(**azimuth):
        return received(sf.Environment(image, up=(0, 0.6, 0.8), **azimuth), tilted)

    for azimuth in (360, 720, -360):
        np.testing.assert_array_equal(light(azimuth=azimuth), light())
    np.testing.assert_array_equal(light(azimuth=390), light(azimuth=30))
    np.testing.assert_array_equal(light(azimuth=-330), light(azimuth=30))
    assert np.any(light(azimuth=30) != light())


def test_the_azimuth_of_an_environment_is_checked_and_shown():
    with pytest.raises(ValueError, match=r"^azimuth: wanted one number"):
        sf.Environment(half_sky(), azimuth=[1, 2])
    assert "azimuth=30" in repr(sf.Environment(half_sky(), azimuth=30))
    assert "azimuth" not in repr(sf.Environment(half_sky()))


def test_an_environment_by_the_names_of_scene_files(tmp_path):
    """As load_scene promises: the keys are the arguments of the light."""
    pixels = np.arange(24.0).reshape(2, 4, 3)
    path = sf.write_image(tmp_path / "sky.exr", pixels)
    assert sf.Environment(radiance=[1, 2, 3], up=[0, 1, 0]) == sf.Environment([1, 2, 3], up=[0, 1, 0])
    assert sf.Environment(image=pixels, azimuth=30) == sf.Environment(pixels, azimuth=30)
    assert sf.Environment(image=path) == sf.Environment(image=str(path)) == sf.Environment(path)
    light = sf.Environment(radiance=(1.0, 2.0, 3.0), up=(0.0, 1.0, 0.0))
    assert eval(repr(light), {"Environment": sf.Environment}) == light
    turned = dataclasses.replace(sf.Environment(image=path), azimuth=90.0)
    assert (turned.azimuth, turned.image.tolist()) == (90.0, pixels.tolist())
    for given, reason in (
        ({}, "image_or_rgb: wanted radiance, an image or a path, by one of its names; got none"),
        ({"radiance": 1, "image": pixels}, "by one of its names; got radiance and image"),
        ({"radiance": pixels}, r"^radiance: wanted a number or RGB"),
        ({"radiance": "sky.exr"}, "^radiance: wanted"),
        ({"image": 1.0}, r"^image: wanted an image \(h, w, 3\) or a path"),
        ({"image": -pixels}, "^image: wanted"),
    ):
        with pytest.raises(ValueError, match=reason):
            sf.Environment(**given)


def test_a_penumbra_that_a_narrow_cone_does_not_have_is_told_beside_the_cone():
    for given, said in (({}, "5, as is usual"), ({"penumbra": 6}, "6")):
        with pytest.raises(ValueError, match=rf"^penumbra: wanted at most the cone, 1 degrees, got {said}$"):
            sf.SpotLight([0, 0, 1], [0, 0, -1], 1.0, cone=1, **given)
    assert sf.SpotLight([0, 0, 1], [0, 0, -1], 1.0, cone=1, penumbra=1).penumbra == 1.0
