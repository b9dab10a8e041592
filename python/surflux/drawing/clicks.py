"""Clicks in a window: told from drags, and as the ray of sight that they mean."""

import numpy as np

_CLICK = 3  # pixels that the mouse may move between press and release


def sight_ray(renderer, x, y):
    """(start (3,), direction (3,)) of the line of sight through pixel (x, y), counted from the lower left corner."""
    ends = []
    for depth in (0.0, 1.0):
        renderer.SetDisplayPoint(x, y, depth)
        renderer.DisplayToWorld()
        point = np.array(renderer.GetWorldPoint())
        ends.append(point[:3] / point[3])
    return ends[0], ends[1] - ends[0]


def take_mouse(plotter, clicked, within=None):
    """Lets drags turn the view and calls clicked(x, y) where the left button was pressed and let go in one place.

    Args:
        plotter: pyvista.Plotter.
        clicked: function of a pixel, counted from the lower left corner.
        within: renderer that alone takes drags and clicks; None for the whole window.

    Returns:
        vtkInteractorStyleTrackballCamera, which may be given further observers.
    """
    from vtkmodules.vtkInteractionStyle import vtkInteractorStyleTrackballCamera

    style = vtkInteractorStyleTrackballCamera()
    pressed = [(-9, -9)]

    def inside(at):
        return within is None or within.IsInViewport(*at)

    def press(*_):
        pressed[0] = plotter.iren.get_event_position()
        if inside(pressed[0]):
            style.OnLeftButtonDown()

    def release(*_):
        style.OnLeftButtonUp()
        at = plotter.iren.get_event_position()
        if np.max(np.abs(np.subtract(at, pressed[0]))) <= _CLICK and inside(at):
            clicked(*at)

    style.AddObserver("LeftButtonPressEvent", press)
    style.AddObserver("LeftButtonReleaseEvent", release)
    plotter.iren.style = style
    return style
