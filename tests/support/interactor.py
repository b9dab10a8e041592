"""What a person does with the mouse and the keyboard, told to the interactor of a window that nobody sees, and what it
shows then.
"""

from surflux.drawing import plots


def shot(view):
    """(h, w, 3) ints: the window, drawn anew."""
    with plots.quiet_vtk():
        view.plotter.render()
        return view.plotter.screenshot(return_img=True).astype(int)


def press(view, key):
    keys = view.plotter.iren.interactor
    keys.SetKeyCode(key)
    keys.SetKeySym(key)
    keys.KeyPressEvent()
    keys.CharEvent()


def click_pixel(view, column, row, drag=0):
    """At a pixel, from the lower left; dragged so many columns before the button is let go."""
    mouse = view.plotter.iren.interactor
    mouse.SetEventInformation(column, row, 0, 0, "\0", 0, None)
    mouse.LeftButtonPressEvent()
    if drag:
        mouse.SetEventInformation(column + drag, row, 0, 0, "\0", 0, None)
        mouse.MouseMoveEvent()
    mouse.LeftButtonReleaseEvent()
