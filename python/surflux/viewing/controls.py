"""Mouse, keys and sliders of a window."""

import numpy as np

from surflux.drawing.clicks import take_mouse
from surflux.drawing.glyphs import STYLES
from surflux.viewing.properties import LIGHTS, names_of

KEYS = {
    "c": "next colour (C: the one before)",
    "s": "disks, splats, points",
    "d": "all light, direct alone, indirect alone",
    "+": "brighter by half a stop (-: darker)",
    "]": "groups: next coarser level ([: finer)",
    "g": "groups of the hierarchy",
    "k": "the cut: nodes that light was solved for",
    "i": "mark inserted surfels",
    "b": "backs",
    "f": "fly to the picked surfel",
    "0": "camera of the beginning",
    "w": "write the camera into the file",
    "x": "export a page",
    "h": "these keys",
    "q": "close",
}
_BOTTOM = 0.075


def listen(view, *, start=None, write=None, export=None):
    """Mouse, keys and sliders for a SceneView; Controls, which a test may use as well.

    Args:
        view: SceneView.
        start: Camera to come back to.
        write: function of a Camera that puts it into a file and returns what to say, or None.
        export: function of a Camera that writes a page and returns what to say, or None.
    """
    return Controls(view, start, write, export)


class Panel:
    """Keys, the mouse and sliders of a SceneView. `keys` is {key: function}; `sliders` {name: slider}.

    Args:
        view: SceneView.
        listed: {key: what it does}, for `h`; mouse: what the mouse does.
    """

    def __init__(self, view, listed, mouse):
        self.view, self._words, self._mouse, self._listed = view, listed, mouse, False
        self.keys, self.sliders = {}, {}
        view.write("hint", "h: keys", (0.015, 0.135), grey=0.45)

    def press(self, key):
        """Does what a key does, and draws."""
        if key in self.keys:
            self.keys[key]()
            self.view.plotter.render()

    def say(self, text):
        """A line above the sliders; what was there goes."""
        self.view.write("said", text, (0.5, 0.135), right=False)

    def list_keys(self):
        """Shows what the keys do, or hides it again."""
        self._listed = not self._listed
        lines = [self._mouse, "", *(f"{key}   {what}" for key, what in self._words.items())]
        self.view.write("keys", "\n".join(lines) if self._listed else "", (0.1, 0.85), top=True, fixed=True)

    def expose(self, stops):
        """Sets the exposure, and the slider that says so."""
        stops = float(np.clip(stops, -6.0, 6.0))
        if "exposure" in self.sliders:
            self.sliders["exposure"].GetRepresentation().SetValue(stops)
        self.view.set_exposure(stops)

    def next_style(self):
        """Disks, splats, points."""
        self.view.set_style(STYLES[(STYLES.index(self.view.style) + 1) % len(STYLES)])

    def hand(self, function, otherwise):
        """Calls a function of the camera that writes something and returns what to say; says `otherwise` without."""
        if function is None:
            self.say(otherwise)
            return
        try:
            self.say(function(self.view.camera()))
        except (OSError, ValueError) as error:  # it is told; the window stays
            self.say(str(error))

    def slider(self, name, left, limits, value, changed, title, when, fmt="%.2f", width=0.27):
        """Adds a slider that calls changed(number)."""

        def call(number):
            changed(number)
            self.view.plotter.render()

        # pyvista calls once while it makes the slider: nothing has been asked for yet.
        ready = []
        slider = self.view.plotter.add_slider_widget(
            lambda number: call(number) if ready else None,
            limits,
            value=value,
            title=title,
            pointa=(left, _BOTTOM),
            pointb=(left + width, _BOTTOM),
            color="black",
            interaction_event=when,
            style="modern",
            fmt=fmt,
            title_height=0.02,
            slider_width=0.02,
            tube_width=0.004,
        )
        shape = slider.GetRepresentation()
        shape.SetLabelHeight(0.018)
        shape.SetTitleHeight(0.02)
        for text in (shape.GetTitleProperty(), shape.GetLabelProperty()):  # before a sky
            text.SetBackgroundColor(1.0, 1.0, 1.0)
            text.SetBackgroundOpacity(0.8)
        self.sliders[name] = slider
        ready.append(True)

    def take_mouse(self):
        """Clicks and keys go to the view and to `keys`, instead of VTK's own."""
        view = self.view

        def clicked(x, y):
            view.pick_at(x, y)
            view.plotter.render()

        def char(*_):
            self.press(view.plotter.iren.interactor.GetKeyCode())

        take_mouse(view.plotter, clicked).AddObserver("CharEvent", char)
        view.plotter.iren.clear_key_event_callbacks()
        view.plotter.add_key_event("q", view.plotter.iren.terminate_app)


class Controls(Panel):
    """What listen makes."""

    def __init__(self, view, start, write, export):
        super().__init__(view, KEYS, "click: pick a surfel    drag: turn    wheel: closer    shift drag: move")
        self.start, self.write, self.export = start, write, export
        self.keys = {
            "c": lambda: view.next_color(1),
            "C": lambda: view.next_color(-1),
            "s": self.next_style,
            "d": self._next_light,
            "+": lambda: self.expose(view.stops + 0.5),
            "-": lambda: self.expose(view.stops - 0.5),
            "]": lambda: self._set_level(view.level + (view.color == "group")),
            "[": lambda: self._set_level(view.level - (view.color == "group")),
            "g": lambda: self._set_level(view.level),
            "k": lambda: self._show_if_there("cut", "no cut: this solution has none"),
            "i": lambda: view.mark_inserted(not view.marked),
            "b": lambda: view.show_backs(view.culling),
            "f": view.fly_to_picked,
            "0": lambda: view.frame(start),
            "w": lambda: self.hand(write, "there is no file to write the camera into"),
            "x": lambda: self.hand(export, "there is nowhere to export to"),
            "h": self.list_keys,
        }
        self.take_mouse()
        self._make_sliders()

    def _next_light(self):
        if self.view.subject.solution is None:
            self.say("nothing here is solved, so there is no light")
            return
        self.view.set_light(LIGHTS[(LIGHTS.index(self.view.light) + 1) % len(LIGHTS)])

    def _show_if_there(self, color, otherwise):
        if color in names_of(self.view.subject):
            self.view.set_color(color)
        else:
            self.say(otherwise)

    def _set_level(self, level):
        self.view.set_level(level)
        if "level" in self.sliders:
            self.sliders["level"].GetRepresentation().SetValue(self.view.level)

    def _make_sliders(self):
        view = self.view
        if view.subject.solution is not None or view.subject.surfels.emission.any():
            self.slider("exposure", 0.03, (-6.0, 6.0), view.stops, view.set_exposure, "exposure, stops", "always")
        coarsest = len(view.subject.tree()) - 1
        if coarsest > 0:

            def at_level(value):
                self._set_level(round(value))

            self.slider("level", 0.36, (0, coarsest), view.level, at_level, "level of groups", "end", "%.0f")
        if view.can_solve():
            zeta = view.subject.scene.solve_options.get("zeta", 0.02)

            def at_zeta(value):
                if abs(value - np.log10(view.zeta or zeta)) > 1e-6:
                    self.say(f"solves again with zeta {10**value:.3g} ...")
                    view.plotter.render()
                    view.solve_again(10**value)
                    self.say("")

            self.slider("zeta", 0.69, (-3.0, -0.3), np.log10(zeta), at_zeta, "log10 zeta: solves again", "end")
