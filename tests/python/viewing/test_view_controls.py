"""What the keys and sliders of a window do, judged by the pixels; what w and x write."""

import numpy as np
import pytest
from test_view import ABOVE, SIZE, SQUARE, is_color, lit, pair, window

import surflux as sf
from interactor import press, shot
from surflux.drawing import plots
from surflux.viewing import controls, viewer

__all__ = ["lit", "window"]  # fixtures


@pytest.fixture
def listening(window):
    def make(thing, **options):
        given = {name: options.pop(name, None) for name in ("start", "write", "export")}
        view = window(thing, **options)
        with plots.quiet_vtk():
            heard = controls.listen(view, **given)
        shot(view)  # until it is drawn it takes no events
        return view, heard

    return make


@pytest.mark.slow
def test_every_key_changes_the_picture_or_says_why_not(listening, lit):
    view, _ = listening(lit, start=ABOVE)
    view.pick(3)
    for key in "cCsd+-g][kfx0wh":
        before = shot(view)
        press(view, key)
        if key == "-":  # back from +
            assert view.stops == 0.0
        assert (np.abs(shot(view) - before).max(axis=2) > 8).sum() > 20, key
    view.set_color("radiosity")


def test_keys_are_listed(listening, lit):
    view, heard = listening(lit)
    before = shot(view)
    press(view, "h")
    assert (np.abs(shot(view) - before).max(axis=2) > 60).sum() > 2000
    press(view, "h")
    assert np.abs(shot(view) - before).max() <= 1
    named = set(controls.KEYS) | {"C", "-", "["}
    assert named == set(heard.keys) | {"q"}


@pytest.mark.slow
def test_keys_go_through_colours_styles_and_light(listening, lit):
    view, _ = listening(lit)
    press(view, "c")
    assert view.color == "irradiance"
    press(view, "C")
    press(view, "C")
    assert view.color == "cut"
    for style in ("splats", "points", "disks"):
        press(view, "s")
        assert view.style == style
    for light in ("direct", "indirect", "all"):
        press(view, "d")
        assert (view.light, view.color) == (light, "radiosity")
    press(view, "g")
    assert (view.color, view.level) == ("group", 0)
    press(view, "]")
    assert view.level == 1
    press(view, "[")
    press(view, "[")
    assert view.level == 0
    press(view, "k")
    assert view.color == "cut"


def test_without_a_solution_keys_of_light_say_so(listening):
    view, heard = listening(pair())
    before = shot(view)
    for key in "dk":
        press(view, key)
        assert (np.abs(shot(view) - before).max(axis=2) > 60)[480:540].sum() > 50  # words
    assert "exposure" not in heard.sliders
    assert "zeta" not in heard.sliders


def drag_slider(view, slider, value):
    """As the mouse does: from the knob to the place of a value."""
    shape, mouse = slider.GetRepresentation(), view.plotter.iren.interactor
    low, high = shape.GetMinimumValue(), shape.GetMaximumValue()
    ends = [
        np.array(p.GetComputedDisplayValue(view.plotter.renderer))
        for p in (shape.GetPoint1Coordinate(), shape.GetPoint2Coordinate())
    ]

    def place(v):
        return np.round(ends[0] + (v - low) / (high - low) * (ends[1] - ends[0])).astype(int)

    for event, v in (("LeftButtonPress", shape.GetValue()), ("MouseMove", value), ("LeftButtonRelease", value)):
        x, y = (int(c) for c in place(v))
        # At its end the knob lies over the end of the bar.
        mouse.SetEventInformation(x + 6 * (v == low), y, 0, 0, "\0", 0, None)
        getattr(mouse, f"{event}Event")()


@pytest.mark.slow
def test_sliders_are_dragged(listening, lit):
    view, heard = listening(lit)
    drag_slider(view, heard.sliders["exposure"], -3.0)
    assert view.stops == pytest.approx(-3.0, abs=0.8)  # its knob has a width
    dark = shot(view)[250:350, 250:350].mean()
    press(view, "+")
    assert shot(view)[250:350, 250:350].mean() > dark + 5
    drag_slider(view, heard.sliders["level"], 2)
    assert (view.color, view.level) == ("group", 2)
    view.set_color("cut")
    cut = view.subject.solution.history[-1]["cut"]
    drag_slider(view, heard.sliders["zeta"], -1.0)
    assert view.zeta == pytest.approx(0.1, rel=0.7)
    assert view.note.startswith("solved with zeta 0.")
    assert view.subject.solution.history[-1]["cut"] <= cut
    assert view.subject.solution is not lit


def test_the_camera_is_written_into_the_scene(listening, tmp_path):
    path = tmp_path / "room.toml"
    text = '# A room.\n[[object]]\nshape = "room"  # six walls\n\n[[light]]\ntype = "environment"\nradiance = 1.0\n'
    path.write_text(text)
    scene = sf.load_scene(path)
    view, _ = listening(scene, write=viewer.camera_writer(None, path))
    view.frame(sf.Camera([0.5, -2.0, 0.5], [0.5, 0.5, 0.5], fov=40))
    press(view, "w")
    assert path.read_text().startswith(text)
    camera = sf.load_scene(path).camera
    assert camera.eye == pytest.approx([0.5, -2.0, 0.5])
    assert camera.fov == pytest.approx(40)


def test_the_camera_is_written_into_a_solution(listening, lit, tmp_path):
    lit.save(tmp_path / "a.ply")
    solution = sf.load_solution(tmp_path / "a.ply")
    view, _ = listening(solution)
    view.frame(sf.Camera([1, 2, 3], [0, 0, 0], fov=33))
    said = viewer.camera_writer(view, tmp_path / "a.ply")(view.camera())
    assert said == f"the camera is in {tmp_path / 'a.ply'} now"
    back = sf.load_solution(tmp_path / "a.ply")
    assert back.camera.eye == pytest.approx([1, 2, 3])
    assert np.array_equal(back.radiosity, solution.radiosity)
    view, _ = listening(pair())
    assert "holds neither a scene nor a solution" in viewer.camera_writer(view, "b.ply")(ABOVE)
    assert viewer.camera_writer(view, None) is None


def test_a_camera_that_cannot_be_written_is_said(listening, tmp_path):
    view, _ = listening(pair(), write=viewer.camera_writer(None, tmp_path / "none.toml"))
    before = shot(view)
    press(view, "w")
    assert (np.abs(shot(view) - before).max(axis=2) > 60)[480:540].sum() > 50


def test_x_exports_what_is_shown(listening, lit, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    view, _ = listening(lit)
    said = viewer.page_writer(view, "room.toml")(view.camera())
    assert (tmp_path / "room.html").is_file()
    assert said.startswith(f"{tmp_path}/room.html: ")
    assert '"radiosity"' in (tmp_path / "room.html").read_text()
    (tmp_path / "room.html").write_text("kept")
    assert "room-2.html" in viewer.page_writer(view, "room.toml")(view.camera())
    assert (tmp_path / "room.html").read_text() == "kept"


def test_the_size_of_the_window_is_the_picture(tmp_path):
    from PIL import Image

    path = sf.view(
        sf.Surfels.from_mesh(SQUARE, reflectance=[0.8, 0, 0]), camera=ABOVE, size=SIZE, screenshot=tmp_path / "a.png"
    )
    image = np.asarray(Image.open(path).convert("RGB")).astype(int)
    assert image.shape == (600, 600, 3)
    assert is_color(image, [231, 0, 0]).sum() == pytest.approx(90000, rel=0.02)
