"""The window in which lamps are moved: what the mouse, keys and sliders do to the lamps, judged by light and pixels."""

import numpy as np
import pytest
from test_view_controls import drag_slider

import surflux as sf
from interactor import click_pixel, press, shot
from surflux.drawing import plots
from surflux.viewing import relit_controls
from surflux.viewing.lamp_controls import KEYS, LampControls
from surflux.viewing.lamp_place import lamp_in_view
from surflux.viewing.lamp_window import LampView
from surflux.viewing.lamps import Lamp, lamps_text

FRONT = sf.Camera([0.5, -1.5, 0.5], [0.5, 0.5, 0.5], fov=40)
WHITE, BLUE = sf.PointLight([0.3, 0.3, 0.6], 1.0), sf.PointLight([0.7, 0.3, 0.6], [0.1, 0.2, 1.0])


@pytest.fixture(scope="module")
def transfer():
    """Of a room of 600 patches that is open towards the camera."""
    walls = ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],)
    faces = [[0, 1, 2, 3], [4, 7, 6, 5], [3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]]
    room = sf.Surfels.from_mesh((*walls, faces), patch_area=0.01, reflectance=0.5)
    return sf.precompute_transfer(sf.Scene([room], camera=FRONT))


@pytest.fixture
def window(transfer):
    views = []

    def make(lights, **options):
        with plots.quiet_vtk():
            view = LampView(transfer, lights, **({"size": (600, 450), "off_screen": True} | options))
            views.append(view)
            view.frame(FRONT)
            controls = LampControls(view, FRONT)
        shot(view)  # until it is drawn it takes no events
        return view, controls

    yield make
    for view in views:
        view.plotter.close()


def pixel(view, place):
    """Where a place of the scene is seen, from the lower left."""
    renderer = view.plotter.renderer
    renderer.SetWorldPoint(*(np.asarray(place) - view.subject.origin()), 1.0)
    renderer.WorldToDisplay()
    return [round(v) for v in renderer.GetDisplayPoint()[:2]]


def shown_radiosity(view):
    return view.subject.solution.radiosity


def test_a_lamp_is_dragged_and_the_light_follows(window, transfer):
    view, _ = window([WHITE, BLUE])
    before, picture = shown_radiosity(view), shot(view)
    x, y = pixel(view, BLUE.position)
    assert picture[449 - y, x, 2] > picture[449 - y, x, 0] + 100  # a blue sphere
    click_pixel(view, x, y, drag=-60)
    moved = np.array(view.lamps[1].light.position)
    assert view.chosen == 1
    # Parallel to the picture, by as much as 60 pixels are at its depth of 1.8.
    np.testing.assert_allclose(moved - BLUE.position, [-60 * 1.8 * 2 * np.tan(np.radians(20)) / 450, 0, 0], atol=0.006)
    assert view.lamps[0].light == WHITE
    # Let go, it is what relight gives.
    wanted = transfer.relight([WHITE, sf.PointLight(moved, BLUE.intensity)])
    assert np.array_equal(shown_radiosity(view), wanted.radiosity)
    assert not np.array_equal(before, wanted.radiosity)
    after = shot(view)
    assert (np.abs(after - picture).max(axis=2) > 3).mean() > 0.2
    assert after[449 - y, x - 60, 2] > after[449 - y, x - 60, 0] + 100
    assert f"{moved[0]:.3g}" in view.note


def test_while_it_is_dragged_light_is_quick_and_near(window, transfer):
    view, _ = window([WHITE])
    view.move(0, np.array([0.6, 0.4, 0.5]) - view.subject.origin())
    lamp = sf.PointLight([0.6, 0.4, 0.5], 1.0)
    np.testing.assert_allclose(view.lamps[0].light.position, lamp.position)
    quick, full = shown_radiosity(view), transfer.relight(lamp).radiosity
    assert np.sqrt(np.mean((quick - full) ** 2) / np.mean(full**2)) < 0.1
    coloured = shot(view)
    view.relight()
    assert np.array_equal(shown_radiosity(view), full)
    assert np.abs(shot(view) - coloured).mean() < 2


def test_a_click_on_a_lamp_chooses_it_and_elsewhere_picks_a_surfel(window):
    view, controls = window([WHITE, BLUE])
    click_pixel(view, *pixel(view, BLUE.position))
    assert (view.chosen, view.picked) == (1, None)
    assert controls.sliders["hue"].GetRepresentation().GetValue() == pytest.approx(view.lamps[1].hue)
    assert [lamp.light for lamp in view.lamps] == [WHITE, BLUE]
    click_pixel(view, *pixel(view, [0.5, 1.0, 0.5]))
    assert view.subject.surfels.points[view.picked] == pytest.approx([0.5, 1.0, 0.5], abs=0.1)
    view.relight(quick=True)
    assert view.picked is None  # what it said is no longer so


def test_sliders_change_the_chosen_lamp(window, transfer):
    view, controls = window([WHITE, BLUE])
    drag_slider(view, controls.sliders["stops"], 2.0)
    lamp = view.lamps[0]
    assert lamp.stops == pytest.approx(2.0, abs=0.8)
    np.testing.assert_allclose(lamp.light.intensity, 2.0**lamp.stops, rtol=1e-12)
    drag_slider(view, controls.sliders["saturation"], 1.0)
    drag_slider(view, controls.sliders["hue"], 0.33)
    red, green, blue = lamp.light.intensity
    assert green > 3 * max(red, blue)
    luminance = np.array([0.2126, 0.7152, 0.0722])
    assert lamp.light.intensity @ luminance == pytest.approx(2.0**lamp.stops)
    assert view.lamps[1].light == BLUE
    assert np.array_equal(shown_radiosity(view), transfer.relight(view.lights()).radiosity)


@pytest.mark.slow
def test_keys_change_lamps(window, transfer):
    view, controls = window([WHITE, BLUE])
    press(view, "n")
    assert view.chosen == 1
    press(view, "n")
    assert view.chosen == 0
    press(view, "N")
    assert view.chosen == 1
    press(view, ",")
    near = np.add(FRONT.eye, 0.9 * np.subtract(BLUE.position, FRONT.eye))
    np.testing.assert_allclose(view.lamps[1].light.position, near, atol=1e-6)
    press(view, ".")
    np.testing.assert_allclose(view.lamps[1].light.position, BLUE.position, atol=1e-6)
    press(view, "l")
    assert len(view.lamps) == 3
    np.testing.assert_allclose(view.lamps[2].light.position, [0.5, 0.5, 0.5])
    assert view.lamp() is view.lamps[2]
    for left in (2, 1, 0):
        press(view, "r")
        assert len(view.lamps) == len(view.handles) == left
    assert not shown_radiosity(view).any()
    for key in "nN,.r":  # without a lamp
        press(view, key)
    controls.sliders["hue"].GetRepresentation().SetValue(0.5)
    press(view, "l")
    assert shown_radiosity(view).any()
    assert set(controls.keys) | {"q"} == set(KEYS) | set(relit_controls.KEYS) | {"N", ".", "-"}


def test_white_stays_until_it_adapts(window):
    view, _ = window([WHITE])
    white, dim = view.white(), shot(view).mean()
    view.lamps[0].shine(stops=2.0)
    view.relight()
    assert view.white() == white
    bright = shot(view).mean()
    assert bright > dim + 20
    press(view, "a")
    assert view.white() == pytest.approx(4 * white, rel=1e-9)
    assert shot(view).mean() == pytest.approx(dim, abs=1.0)


def test_d_shows_parts_of_the_light(window):
    view, _ = window([WHITE])
    for light in ("direct", "indirect"):
        before = shot(view)
        press(view, "d")
        assert view.light == light
        assert (np.abs(shot(view) - before).max(axis=2) > 8).mean() > 0.1
    view.move(0, [0.0, 0.0, 0.0])  # and what is dragged then, too
    expected = view.subject.solution.irradiance - view.subject.solution.direct
    np.testing.assert_allclose(view.shown().values, 0.5 * expected)


def wanted_bytes(view, transfer, layer="radiance"):
    """(h, w, 3) what LampRenderer draws of the view, in the exposure of the window."""
    renderer = sf.LampRenderer(transfer, view.camera(), tuple(view.plotter.window_size))
    image = renderer.frame(view.lights(), layers=[layer, "index"])
    shown = sf.tone_map(image[layer], exposure=np.pi * 2.0**view.stops / view.white(), filmic=False)
    shown[image["index"] == -1] = 1.0
    return np.rint(255 * shown).astype(int)


def expect_traced(view, transfer, layer="radiance"):
    """The picture is shown but where words, sliders and lamps are."""
    same = np.abs(shot(view) - wanted_bytes(view, transfer, layer)).max(axis=2) <= 1
    assert same[60:330, 150:450].mean() > 0.96
    assert same.mean() > 0.8


@pytest.mark.slow
def test_direct_light_at_every_pixel_follows_a_lamp(window, transfer):
    view, _ = window([WHITE, BLUE])
    surfels = shot(view)
    press(view, "t")
    assert view.traced
    expect_traced(view, transfer)
    picture = shot(view)
    assert (np.abs(picture - surfels).max(axis=2) > 3).mean() > 0.05
    x, y = pixel(view, BLUE.position)
    assert picture[449 - y, x, 2] > picture[449 - y, x, 0] + 100  # the sphere is before it
    before = shown_radiosity(view)
    view.move(1, np.array([0.6, 0.4, 0.5]) - view.subject.origin())
    assert shown_radiosity(view) is before  # of surfels, which nobody sees while it is dragged
    expect_traced(view, transfer)
    view.relight()
    assert not np.array_equal(shown_radiosity(view), before)
    expect_traced(view, transfer)
    press(view, "+")
    press(view, "+")
    expect_traced(view, transfer)
    press(view, "d")
    expect_traced(view, transfer, "direct")
    press(view, "d")
    expect_traced(view, transfer, "indirect")
    press(view, "d")
    press(view, "t")
    assert not view.traced
    view.set_exposure(0.0)
    untraced = shot(view)
    press(view, "t")
    press(view, "t")
    assert np.array_equal(shot(view)[100:], untraced[100:])  # below the words, which tell milliseconds


@pytest.mark.slow
def test_while_the_camera_turns_surfels_are_shown(window, transfer):
    view, _ = window([WHITE])
    press(view, "t")
    mouse = view.plotter.iren.interactor
    mouse.SetEventInformation(300, 100, 0, 0, "\0", 0, None)
    mouse.LeftButtonPressEvent()
    mouse.SetEventInformation(310, 104, 0, 0, "\0", 0, None)
    mouse.MouseMoveEvent()
    assert "traced" not in view.plotter.actors
    assert view.plotter.actors["surfels"].GetVisibility()
    mouse.LeftButtonReleaseEvent()
    assert not np.allclose(view.camera().eye, FRONT.eye, atol=0.01)
    expect_traced(view, transfer)
    press(view, "0")
    assert np.allclose(view.camera().eye, FRONT.eye, atol=1e-6)
    expect_traced(view, transfer)
    press(view, "b")  # and with both sides, which from inside is the same
    expect_traced(view, transfer)


def test_area_lights_move_in_the_picture(window, transfer):
    view, _ = window([sf.AreaLight([0.4, 0.5, 0.8], [0, 0, 0.1], [-0.2, 0, 0], 20.0)])  # towards the camera
    press(view, "t")
    expect_traced(view, transfer)
    view.move(0, np.array([0.4, 0.5, 0.3]) - view.subject.origin())
    expect_traced(view, transfer)
    x, y = pixel(view, [0.45, 0.5, 0.33])
    assert shot(view)[449 - y, x].min() > 250


def test_written_lamps_are_read_again(window, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lights = [
        WHITE,
        sf.SpotLight([0.5, 0.5, 0.9], [0, 0, -1], [1, 2, 3], 60.0, 10.0),
        sf.AreaLight([0.4, 0.4, 0.99], [0, 0.2, 0], [0.2, 0, 0], 5.0),
        sf.DirectionalLight([0.1, 0.2, -1.0], 2.0),
    ]
    view, _ = window(lights)
    press(view, "w")
    assert sf.load_lamps("lamps.toml") == [lights]
    press(view, "w")
    assert sf.load_lamps("lamps-2.toml") == [lights]
    assert len(view.handles) == 3  # parallel light has no place
    view.choose(3)
    press(view, ",")
    assert view.lights() == lights
    view.move(2, np.array([0.5, 0.6, 0.7]) - view.subject.origin())
    np.testing.assert_allclose(view.lamps[2].light.corner, [0.4, 0.5, 0.7])


def test_without_lights_one_stands_in_the_middle_of_a_room(window):
    view, _ = window(None)
    assert len(view.lamps) == 1
    np.testing.assert_allclose(view.lamps[0].light.position, [0.5, 0.5, 0.5])
    assert shown_radiosity(view).min() > 0


def test_without_lights_one_stands_before_a_body(window, tmp_path):
    """Its middle, where a lamp lights nothing, is inside. Of a sphere of radius 1, seen from the distance d, the cap
    with points . towards the eye > 1 / d is seen.
    """
    (tmp_path / "ball.toml").write_text('[[object]]\nshape = "sphere"\npoints = 2562\nreflectance = 0.7\n')
    transfer = sf.precompute_transfer(sf.load_scene(tmp_path / "ball.toml"))
    for camera in (None, sf.Camera([0.3, 2.0, 4.0], [0.0, 0.0, 0.1]), sf.Camera([0, -4.0, 0], [0, 0, 0], height=3.0)):
        with plots.quiet_vtk():
            view = LampView(transfer, None, camera, size=(400, 300), off_screen=True)
        try:
            view.frame(camera)
            looks = view.camera()
            eye = looks.eye / np.linalg.norm(looks.eye)
            edge = 0.0 if looks.height is not None else 1.0 / np.linalg.norm(looks.eye)
            seen = transfer.scene.surfels.points @ eye > edge + 0.05
            direct = view.subject.solution.direct[seen, 0]
            assert (direct > 0).mean() > 0.5  # most
            assert 0.2 < direct.mean() < 5.0  # about 1, times cosines
            column, row, depth = looks.project([view.lamps[0].place], (400, 300))[0]
            assert depth > 0
            assert 0 < column < 400
            assert 0 < row < 300
            view.frame(sf.Camera([0.0, 5.0, 0.0], [0.0, 0.0, 0.0]))
            view.add()  # for what is seen from there
            lit = transfer.relight(view.lamps[1].light).direct[:, 0] > 0
            assert lit[transfer.scene.surfels.points[:, 1] > 0.25].mean() > 0.5
        finally:
            view.plotter.close()


def test_no_lamp_is_placed_by_what_is_not_seen(transfer):
    away = sf.Camera([0.5, -1.5, 0.5], [0.5, -3.0, 0.5])
    place = lamp_in_view(transfer.scene, away, (40, 30)).position
    np.testing.assert_allclose(place, [0.5, 0.5, 0.5])  # the middle, for want of better


def test_a_lamp_without_power_can_be_given_some():
    lamp = Lamp.of(sf.PointLight([0, 0, 0], 0.0))
    lamp.shine(stops=1.0, saturation=0.0)
    np.testing.assert_allclose(lamp.light.intensity, 2.0)


def test_text_of_lamps_is_of_scene_files(tmp_path):
    text = '[[object]]\nshape = "box"\n' + lamps_text([WHITE, BLUE])
    (tmp_path / "a.toml").write_text(text)
    assert sf.load_scene(tmp_path / "a.toml").lights == (WHITE, BLUE)


def test_a_picture_without_a_display(transfer, tmp_path, monkeypatch):
    from PIL import Image

    path = sf.move_lamps(transfer, BLUE, size=(300, 200), screenshot=tmp_path / "a.png")
    picture = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert picture.shape == (200, 300, 3)
    assert picture[100, 150, 2] > picture[100, 150, 0] + 20
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert sf.move_lamps(transfer, size=(300, 200)).name == "surflux_view.png"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"transfer": 3}, "transfer: wanted a LocalTransfer, got int"),
        ({"lights": 3}, "lights: wanted a light or a list of lights, got int"),
        (
            {"lights": [sf.Environment(1.0)]},
            "lights: wanted point, spot, photometric, area .* got Environment",
        ),
        ({"camera": 3}, "camera: wanted a Camera or None"),
        ({"stops": 99}, "stops: wanted"),
        ({"style": "cubes"}, "style: wanted one of"),
        ({"size": 3}, "size: wanted"),
        ({"screenshot": "a.exr"}, "screenshot: wanted a name ending in .png or .jpg"),
    ],
)
def test_what_is_refused(transfer, tmp_path, monkeypatch, options, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=said):
        sf.move_lamps(**({"transfer": transfer, "screenshot": "a.png"} | options))
