"""An environment that turns: what surfels have of it by waves, and films of it, against single relightings."""

import numpy as np
import pytest

import surflux as sf
from surflux import _core
from surflux.geometry.rotation import rotation_about
from surflux.scenes import shapes
from surflux.solving.turning_light import WAVES, TurningLight, waves_at

CAMERA = sf.Camera([0.4, -3.0, 1.4], [0.0, 0.0, 0.0], fov=40)
SIZE = (60, 40)
UP = [0.2, -0.3, 0.9]
# Of a small lamp and a dim sky: its five bands are below 0 on the far side.
LAMP = np.full((16, 32, 3), 0.1)
LAMP[5, 6] = [300.0, 200.0, 100.0]
GIVEN = {"reflectance": [0.3, 0.4, 0.5], "specular": 0.3, "exponent": 15.0}


@pytest.fixture(scope="module")
def sky():
    return sf.Environment(LAMP, up=UP)


@pytest.fixture(scope="module")
def transfer():
    """Of a ball of disks over a glowing plate of patches, one object each."""
    ball = shapes.sphere(500, 0.5)
    square = ([[-1, -1, -0.6], [1, -1, -0.6], [1, 1, -0.6], [-1, 1, -0.6]], [[0, 1, 2, 3]])
    plate = sf.Surfels.from_mesh(square, patch_area=0.02, reflectance=0.6, emission=[0.0, 0.1, 0.2])
    return sf.precompute_transfer(sf.Scene([ball, plate], camera=CAMERA), "distant")


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def test_waves_are_those_of_the_angle():
    a = 0.7
    waves = [1.0, *(f(k * a) for k in (1, 2, 3, 4) for f in (np.cos, np.sin))]
    np.testing.assert_allclose(waves_at(a), waves, rtol=1e-15)


@pytest.mark.parametrize("given", [{}, GIVEN | {"bounces": 1}], ids=["own", "given"])
def test_nine_waves_say_all_of_the_light(transfer, sky, given):
    """At angles that none of the nine relightings had, to the precision of float32, of all reflections to that of their
    sum; below 0, where both are cut off.
    """
    light = TurningLight(transfer, sky, **given)
    precision = 5e-6 if "bounces" in given else 2e-5
    assert (transfer._unclipped(sky.harmonics(5), None, None)[0] < 0).any()
    for degrees in (0.0, 13.0, 100.0, 222.0, 339.5):
        turn = rotation_about(sky.up, np.radians(degrees))
        exact, found = transfer.relight(sky, rotation=turn, **given), light.diffuse(degrees)
        for name in ("irradiance", "direct", "radiosity"):
            wanted = getattr(exact, name)
            assert np.abs(getattr(found, name) - wanted).max() < precision * rms(wanted)
        assert (found.direct == 0).any()


def test_a_full_turn_gives_the_same(transfer, sky):
    light = TurningLight(transfer, sky)
    plain = transfer.relight(sky)
    for degrees in (0.0, 360.0, -720.0):
        assert np.array_equal(light.relight(degrees).irradiance, plain.irradiance)
    for one, other in ((40.0, 400.0), (-90.0, 270.0)):
        assert np.array_equal(light.relight(one).irradiance, light.relight(other).irradiance)
        assert np.array_equal(light.diffuse(one).irradiance, light.diffuse(other).irradiance)


def test_it_turns_as_the_azimuth_of_an_environment_does(transfer, sky):
    light = TurningLight(transfer, sky)
    for degrees in (25.0, 90.0, 200.0):
        turned = transfer.relight(sf.Environment(LAMP, up=UP, azimuth=degrees)).irradiance
        np.testing.assert_allclose(light.relight(degrees).irradiance, turned, atol=1e-6 * turned.max())


def test_about_another_axis(transfer, sky):
    """A quarter turn about x takes light from z to -y; what comes along the axis stays."""
    along_z, along_y, along_x = (np.eye(4)[k] for k in (2, 1, 3))
    light = TurningLight(transfer, along_z, axis=[5, 0, 0])
    np.testing.assert_allclose(light.harmonics(90.0)[:4, 0], -along_y, atol=1e-12)
    np.testing.assert_allclose(TurningLight(transfer, along_z).harmonics(77.0)[:4, 0], along_z, atol=1e-12)
    np.testing.assert_allclose(TurningLight(transfer, along_x).harmonics(90.0)[:4, 0], along_y, atol=1e-12)


def pictures(transfer, sky, folder, **options):
    written = sf.animate_environment(transfer, sky, folder / "a%02d.exr", SIZE, **options)
    assert [path.name for path in written] == [f"a{k:02d}.exr" for k in range(1, options["frames"] + 1)]
    return [sf.read_image(path) for path in written]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frames", "turns", "given"),
    [(3, 1.0, {}), (WAVES + 1, -0.5, {}), (WAVES + 1, 2.0, GIVEN)],
    ids=["few", "by waves", "glossy"],
)
def test_frames_are_what_render_draws(transfer, tmp_path, monkeypatch, frames, turns, given):
    # Nowhere below 0, so that no surfel is dark in one frame alone.
    even = sf.Environment(np.where(np.arange(32)[:, None] < 16, [2.0, 1.5, 1.0], 0.5) * np.ones((16, 1, 1)), up=UP)
    made = []
    matrix = _core.FlatImage
    monkeypatch.setattr("surflux.solutions.painting._core.FlatImage", lambda *of: made.append(1) or matrix(*of))
    found = pictures(transfer, even, tmp_path, frames=frames, turns=turns, background=0.2, **given)
    for k, picture in enumerate(found):
        turn = rotation_about(UP, 2 * np.pi * turns * k / frames)
        wanted = transfer.relight(even, rotation=turn, **given).render(size=SIZE, background=0.2)
        np.testing.assert_allclose(picture, wanted, rtol=5e-5, atol=1e-5)
    assert np.abs(found[0] - found[1]).max() > 0.01
    assert len(made) == 1


def test_turns_end_where_they_began(transfer, sky, tmp_path):
    found = pictures(transfer, sky, tmp_path, frames=4, turns=2.0)
    for first, again in zip(found[:2], found[2:], strict=True):
        np.testing.assert_allclose(again, first, atol=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"transfer": 3}, "transfer: wanted a DistantTransfer, got int"),
        ({"environment": sf.PointLight([0, 0, 1], 1.0)}, "environment: "),
        ({"environment": np.zeros((3, 3))}, "environment: wanted an Environment or 1, 4, 9, 16 or 25 harmonics, got 3"),
        ({"axis": [0, 0, 0]}, "axis: wanted vectors of non-zero length"),
        ({"frames": 0}, "frames: wanted a whole number"),
        ({"turns": np.nan}, "turns: wanted a finite number"),
        ({"specular": 0.9}, "specular: wanted reflectance"),
        ({"reflectance": 1.0}, "reflectance: wanted"),
        ({"bounces": -1}, "bounces: wanted"),
        ({"path": "a.png"}, "path: wanted a pattern"),
        ({"size": 3}, "size: wanted"),
        ({"camera": 3}, "camera: wanted"),
        ({"fps": 0}, "fps: wanted"),
        ({"layers": True}, "layers: a .png file has none"),
    ],
)
def test_what_is_refused(transfer, tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    given = {"transfer": transfer, "environment": [1.0], "path": "a%d.png", "size": SIZE} | options
    with pytest.raises(ValueError, match=said):
        sf.animate_environment(**given)


def test_a_film_can_be_cancelled(transfer, sky, tmp_path):
    with pytest.raises(sf.Cancelled):
        sf.animate_environment(transfer, sky, tmp_path / "a.gif", SIZE, progress=lambda done, total: done < 2)
    assert not list(tmp_path.iterdir())
