"""What a click in a window means."""

import numpy as np
import pytest

import surflux as sf
from surflux.drawing.clicks import sight_ray, take_mouse
from surflux.drawing.plots import look_through, quiet_vtk, seen_through


@pytest.fixture
def plotter():
    import pyvista

    with quiet_vtk():
        window = pyvista.Plotter(off_screen=True, window_size=(400, 300))
        yield window
        window.close()


@pytest.mark.parametrize("height", [None, 2.5])
def test_the_line_of_sight_goes_through_what_the_camera_projects_there(plotter, height):
    import pyvista

    camera, point = sf.Camera([1, -4, 1.5], [0.2, 0, 0.3], height=height), np.array([0.4, 0.3, -0.2])
    plotter.add_mesh(pyvista.Sphere())
    look_through(plotter.camera, camera, np.zeros(3))
    plotter.renderer.ResetCameraClippingRange()
    plotter.render()
    column, row, _ = camera.project(point[None], (400, 300))[0]
    # Display coordinates count pixel centres from the lower left corner, columns and rows their upper left corners.
    start, direction = sight_ray(plotter.renderer, column - 0.5, 299.5 - row)
    away = np.linalg.norm(np.cross(point - start, direction)) / np.linalg.norm(direction)
    pixel = 2 * 4.5 * np.tan(np.radians(22.5)) / 300  # at most, at the distance of the point
    assert away < pixel


@pytest.mark.parametrize(
    ("pressed", "released", "expected"),
    [((40, 50), (43, 47), [(43, 47)]), ((40, 50), (44, 50), []), ((250, 50), (250, 50), [])],
)
def test_a_click_is_no_drag_and_stays_in_its_part(plotter, pressed, released, expected):
    class Left:
        def IsInViewport(self, x, y):
            return x < 200

    clicks, mouse = [], plotter.iren.interactor
    plotter.iren.initialize()
    take_mouse(plotter, lambda *at: clicks.append(at), within=Left())
    for at, event in ((pressed, mouse.LeftButtonPressEvent), (released, mouse.LeftButtonReleaseEvent)):
        mouse.SetEventInformation(*at, 0, 0, "\0", 0, None)
        event()
    assert clicks == expected


@pytest.mark.parametrize("height", [None, 2.5])
def test_a_camera_comes_back_from_the_window_that_it_was_put_into(plotter, height):
    camera, origin = sf.Camera([5e6, -4, 1], [5e6, 0, 0.3], (0, 0, 2), 40, height=height), np.array([5e6, 0, 0])
    look_through(plotter.camera, camera, origin)
    found = seen_through(plotter.camera, origin)
    for name in ("eye", "target", "fov", "height"):
        np.testing.assert_array_equal(getattr(found, name), getattr(camera, name))
    np.testing.assert_array_equal(found.up, [0, 0, 1])
