"""The window in which an environment is turned: its slider and keys, and what is glossy, judged by light and pixels."""

from pathlib import Path

import numpy as np
import pytest
from test_view_controls import drag_slider

import surflux as sf
from interactor import click_pixel, press, shot
from surflux._base.color import white_of
from surflux.drawing import plots
from surflux.geometry.rotation import rotation_about
from surflux.scenes import shapes
from surflux.solving.turning_light import TurningLight
from surflux.viewing import relit_controls, turn_window
from surflux.viewing.turn_controls import KEYS, TurnControls
from surflux.viewing.turn_window import TurnView

FRONT = sf.Camera([0.0, -3.0, 0.8], [0.0, 0.0, 0.0], fov=40)
# A red half, a blue half, and dark between: nowhere below 0 by much.
IMAGE = np.full((8, 16, 3), 0.5)
IMAGE[:, 2:6], IMAGE[:, 10:14] = [4.0, 1.0, 0.5], [0.5, 1.0, 3.0]
SKY = sf.Environment(IMAGE)


def transfer_of(**material):
    return sf.precompute_transfer(sf.Scene([shapes.sphere(700, 0.8).replace(**material)], camera=FRONT), "distant")


@pytest.fixture(scope="module")
def dull():
    return transfer_of(reflectance=0.5)


@pytest.fixture(scope="module")
def glossy():
    return transfer_of(reflectance=0.1, specular=0.6, exponent=12.0)


@pytest.fixture
def window():
    views = []

    def make(transfer, **options):
        with plots.quiet_vtk():
            view = TurnView(TurningLight(transfer, SKY), **({"size": (600, 450), "off_screen": True} | options))
            views.append(view)
            view.frame(FRONT)
            controls = TurnControls(view, FRONT)
        shot(view)  # until it is drawn it takes no events
        return view, controls

    yield make
    for view in views:
        view.plotter.close()


def relit(transfer, degrees):
    return transfer.relight(SKY, rotation=rotation_about([0, 0, 1], np.radians(degrees)))


def shown_radiosity(view):
    return view.subject.solution.radiosity


@pytest.mark.slow
def test_the_slider_turns_it_and_the_light_follows(window, dull):
    view, controls = window(dull)
    before = shot(view)
    ball = before[100:350, 200:400].reshape(-1, 3).mean(axis=0)
    drag_slider(view, controls.sliders["turn"], 180.0)
    assert view.degrees == pytest.approx(180, abs=40)
    assert np.array_equal(
        shown_radiosity(view), relit(dull, view.degrees).radiosity
    )  # let go, it is what relight gives
    assert f"turned by {view.degrees:.4g} degrees" in view.note
    turned = shot(view)[100:350, 200:400].reshape(-1, 3).mean(axis=0)
    assert abs(ball[0] - turned[0]) + abs(ball[2] - turned[2]) > 30


def test_while_it_is_dragged_light_is_that_of_waves(window, dull):
    view, _ = window(dull)
    view.turn(75.0, quick=True)
    quick, full = shown_radiosity(view), relit(dull, 75.0).radiosity
    assert not np.array_equal(quick, full)
    np.testing.assert_allclose(quick, full, atol=1e-5 * full.max())
    coloured = shot(view)
    view.turn(75.0)
    assert np.abs(shot(view)[60:] - coloured[60:]).max() <= 1  # but for the words above


@pytest.mark.slow
def test_keys_turn_it(window, dull):
    view, controls = window(dull)
    for key, degrees in ((".", 5.0), (".", 10.0), (",", 5.0), (",", 0.0), (",", 355.0)):
        press(view, key)
        assert view.degrees == degrees
        assert controls.sliders["turn"].GetRepresentation().GetValue() == pytest.approx(degrees)
        assert np.array_equal(shown_radiosity(view), relit(dull, degrees).radiosity)
    press(view, ".")
    assert np.array_equal(shown_radiosity(view), dull.relight(SKY).radiosity)
    assert set(controls.keys) | {"q"} == set(KEYS) | set(relit_controls.KEYS) | {",", "-"}
    press(view, "h")


def test_white_stays_until_it_adapts(window, dull):
    view, _ = window(dull)
    white = view.white()
    assert white == white_of(dull.relight(SKY).radiosity)
    view.turn(90.0)
    assert view.white() == white
    press(view, "a")
    assert view.white() == white_of(relit(dull, 90.0).radiosity)


def as_seen(transfer, degrees, camera):
    """What is shown of glossy surfels: their radiance towards the camera times pi, from behind the diffuse part."""
    solution = relit(transfer, degrees)
    towards = camera.eye - solution.surfels.points
    front = (towards * solution.surfels.normals).sum(axis=1) > 0
    return np.where(front[:, None], np.pi * solution.radiance_towards(towards), solution.radiosity)


@pytest.mark.slow
def test_glossy_surfels_are_shown_as_the_camera_sees_them(window, glossy):
    view, _ = window(glossy)
    seen = as_seen(glossy, 0.0, FRONT)
    np.testing.assert_allclose(view.shown().values, seen, rtol=1e-6)
    assert (seen > 2 * shown_radiosity(view)).any()
    assert view.white() == pytest.approx(white_of(seen))
    assert "radiance towards the eye times pi" in view.shown().title
    view.turn(40.0, quick=True)  # the diffuse part turns, lobes stay
    part = relit(glossy, 40.0).radiosity - relit(glossy, 0.0).radiosity
    np.testing.assert_allclose(view.shown().values, seen + part, atol=1e-5 * seen.max())
    view.turn(40.0)
    np.testing.assert_allclose(view.shown().values, as_seen(glossy, 40.0, FRONT), rtol=1e-6)
    for light in ("direct", "indirect"):
        press(view, "d")
        assert view.shown().values.max() < seen.max() / 2  # of diffuse light alone
        assert f"by {light} light alone" in view.shown().title


@pytest.mark.slow
def test_gloss_follows_the_camera(window, glossy, monkeypatch):
    monkeypatch.setattr(turn_window, "_PATIENCE", 1e9)
    view, _ = window(glossy)
    before = view.shown().values
    click_pixel(view, 300, 100, drag=80)  # a drag turns the camera
    here = view.camera()
    assert np.linalg.norm(here.eye - FRONT.eye) > 0.3
    np.testing.assert_allclose(view.shown().values, as_seen(glossy, 0.0, here), rtol=1e-4, atol=1e-6)
    assert np.abs(view.shown().values - before).max() > 0.1
    press(view, "0")
    np.testing.assert_allclose(view.shown().values, before, rtol=1e-6)


def test_where_gloss_takes_long_a_key_asks_for_it(window, glossy, monkeypatch):
    monkeypatch.setattr(turn_window, "_PATIENCE", 0.0)
    view, _ = window(glossy)
    before = view.shown().values
    click_pixel(view, 300, 100, drag=80)
    assert np.array_equal(view.shown().values, before)
    assert "gloss is that of another place; e: as seen from here" in view.note
    press(view, "e")
    assert "e:" not in view.note
    np.testing.assert_allclose(view.shown().values, as_seen(glossy, 0.0, view.camera()), rtol=1e-4, atol=1e-6)


@pytest.mark.slow
def test_a_click_picks_a_surfel_until_light_changes(window, glossy):
    view, _ = window(glossy)
    click_pixel(view, 300, 225)
    assert view.picked is not None
    press(view, ".")
    assert view.picked is None


def test_x_exports_a_page_that_begins_as_the_window_is(window, dull, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    view, _ = window(dull)
    view.turn(90.0)
    press(view, "x")
    turned = sf.rotate_harmonics(SKY.harmonics(5), rotation_about([0, 0, 1], np.pi / 2))
    wanted = sf.Page(dull, environment=turned, camera=view.camera()).html()
    assert Path("surflux.html").read_text("utf-8") == wanted


def test_a_picture_without_a_display(glossy, tmp_path, monkeypatch):
    from PIL import Image

    path = sf.turn_environment(glossy, SKY, size=(300, 200), screenshot=tmp_path / "a.png")
    picture = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert picture.shape == (200, 300, 3)
    assert (picture[60:] < 250).any(axis=2).mean() > 0.1
    darker = sf.turn_environment(glossy, SKY, size=(300, 200), stops=-3, screenshot=tmp_path / "b.png")
    assert np.asarray(Image.open(darker).convert("RGB"))[60:].mean() < picture[60:].mean() - 5
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert sf.turn_environment(glossy, SKY, size=(300, 200)).name == "surflux_view.png"


def test_in_a_notebook_it_is_a_page(dull, monkeypatch):
    monkeypatch.setattr("surflux.viewing.turn_viewer.in_notebook", lambda: True)
    page = sf.turn_environment(dull, SKY, camera=FRONT)
    assert page.html() == sf.Page(dull, environment=SKY, camera=FRONT).html()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"transfer": 3}, "transfer: wanted a DistantTransfer, got int"),
        ({"environment": 3}, "environment: "),
        ({"environment": sf.PointLight([0, 0, 1], 1.0)}, "environment: "),
        ({"axis": [0, 0, 0]}, "axis: wanted vectors of non-zero length"),
        ({"camera": 3}, "camera: wanted a Camera or None"),
        ({"stops": 99}, "stops: wanted"),
        ({"style": "cubes"}, "style: wanted one of"),
        ({"size": 3}, "size: wanted"),
        ({"screenshot": "a.exr"}, "screenshot: wanted a name ending in .png or .jpg"),
    ],
)
def test_what_is_refused(dull, tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=said):
        sf.turn_environment(**({"transfer": dull, "environment": SKY, "screenshot": "a.png"} | options))
