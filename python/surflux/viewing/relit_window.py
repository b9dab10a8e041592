"""Windows of a scene whose light changes: what they have in common, without the mouse and the keys."""

from time import perf_counter

from surflux.drawing.plots import quiet_vtk
from surflux.viewing.subject import Subject
from surflux.viewing.window import SceneView

_SMOOTH_UP_TO = 100_000  # surfels whose colours run into each other, unless a style is chosen


class RelitView(SceneView):
    """A view of a scene under light that can be changed; a subclass says how it is found, and what is written of it.

    Args:
        solution: Solution of the light of the beginning.
        style, stops, size, off_screen: see SceneView; style None for what is quick enough.

    Attributes:
        seconds: that the last relighting took.
    """

    def __init__(self, solution, *, style=None, stops=0.0, size=(800, 600), off_screen=False):
        self._shown_white = None
        subject = Subject(solution)
        if style is None:
            style = "splats" if len(subject) <= _SMOOTH_UP_TO else "disks"
        super().__init__(subject, color="radiosity", style=style, stops=stops, size=size, off_screen=off_screen)
        self.say_light()
        self.describe(self.shown())

    def found(self, quick):
        """The Solution of the light that there is now. quick: to do for what is being dragged."""
        raise NotImplementedError

    def say_light(self):
        """Sets `note`, which the caption ends with."""
        raise NotImplementedError

    def white(self):
        """Stays from one light to the next, until `adapt`: what becomes brighter is to look brighter."""
        if self._shown_white is None:
            self._shown_white = super().white()
        return self._shown_white

    def adapt(self):
        """Shows the brightest percent of the light that there is now as white."""
        self._shown_white = None
        self.redraw()

    def relight(self, quick=False):
        """Finds the light and shows it. quick: what is found sooner, for what is being dragged."""
        if self.picked is not None:
            self.pick(None)
        solution = self.timed(self.found, quick)
        self.subject.solution, self.subject.lamps = solution, list(solution._lamps)
        self._draw_lamps()
        self.say_light()
        if quick:
            self.recolor()
        else:
            self._kept = None
            self.redraw()

    def recolor(self):
        """Shows other light in place: nothing but colours changes."""
        self._kept = None
        mesh, shown = self._shape.mesh, self.shown()
        (mesh.point_data if self._shape.by_point else mesh.cell_data)["shown"][:] = self.spread(shown)
        self.draw_sky()
        self.describe(shown)

    def timed(self, function, *arguments):
        """What a function returns; `seconds` are those that it took."""
        start = perf_counter()
        found = function(*arguments)
        self.seconds = perf_counter() - start
        return found


def show_window(make, listen, camera, path):
    """Opens a window, or writes a picture of it.

    Args:
        make: function (off_screen) of the RelitView.
        listen: function (view, start) that makes its controls; start is the Camera to come back to.
        camera: Camera or None.
        path: of the picture, or None for a window.

    Returns:
        path.
    """
    with quiet_vtk():
        view = make(path is not None)
        try:
            view.frame(camera)
            if path is None:
                listen(view, view.subject.framed(view.size) if camera is None else camera)
                view.plotter.show()
            else:
                view.plotter.render()
                view.plotter.screenshot(path)
        finally:
            view.plotter.close()
    return path
