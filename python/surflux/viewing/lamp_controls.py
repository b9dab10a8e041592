"""Mouse, keys and sliders of the window in which lamps are moved."""

from itertools import count
from pathlib import Path

from surflux.viewing.lamps import STOPS, lamps_text
from surflux.viewing.relit_controls import WIDTH, RelitControls

KEYS = {
    "n": "choose the next lamp (N: the one before)",
    ",": "bring the lamp nearer (.: put it farther away)",
    "l": "a lamp more, where it lights what is seen",
    "r": "remove the lamp",
    "w": "write the lamps into a file",
    "t": "direct light at every pixel, with sharp shadows, or at every surfel",
}
_NEARER = 0.9
_SLIDERS = {  # of the chosen lamp: where each begins, its limits and its title
    "stops": (0.27, (-STOPS, STOPS), "lamp: power, stops"),
    "hue": (0.52, (0.0, 1.0), "lamp: hue"),
    "saturation": (0.77, (0.0, 1.0), "lamp: saturation"),
}


class LampControls(RelitControls):
    """What a person does in a LampView.

    Args:
        view: LampView.
        start: Camera to come back to.
        path: of the file that `w` writes; None for lamps.toml in the working folder, lamps-2.toml where that is there.
    """

    def __init__(self, view, start=None, path=None):
        super().__init__(view, KEYS, "drag a lamp: move it", start)
        self._path = path
        self.keys |= {
            "n": lambda: self._change(view.choose, view.chosen + 1),
            "N": lambda: self._change(view.choose, view.chosen - 1),
            ",": lambda: view.nearer(_NEARER),
            ".": lambda: view.nearer(1.0 / _NEARER),
            "l": lambda: self._change(view.add),
            "r": lambda: self._change(view.remove),
            "w": lambda: self.hand(self._write, ""),
            "t": lambda: view.trace(not view.traced),
        }
        for name, (left, limits, title) in _SLIDERS.items():
            self._lamp_slider(name, left, limits, title)
        view.hold(self._dragged, self._dropped)
        style = view.plotter.iren.interactor.GetInteractorStyle()
        style.AddObserver("StartInteractionEvent", lambda *_: view.turning(True))
        style.AddObserver("EndInteractionEvent", lambda *_: view.turning(False))

    def _lamp_slider(self, name, left, limits, title):
        def changed(value):
            lamp = self.view.lamp()
            if lamp is not None:
                lamp.shine(**{name: value})
                self.view.relight(quick=True)

        lamp = self.view.lamp()
        value = 0.0 if lamp is None else getattr(lamp, name)
        self.slider(name, left, limits, value, changed, title, "always", width=WIDTH)
        self.sliders[name].AddObserver("EndInteractionEvent", lambda *_: self.in_full())

    def _change(self, function, *arguments):
        """Calls a function after which another lamp may be the chosen one, whose the sliders are then."""
        function(*arguments)
        self._follow()

    def _follow(self):
        lamp = self.view.lamp()
        for name in _SLIDERS if lamp is not None else ():
            self.sliders[name].GetRepresentation().SetValue(getattr(lamp, name))

    def _dragged(self, index, center):
        other = index != self.view.chosen
        self.view.move(index, center)
        if other:
            self._follow()
        self.view.plotter.render()

    def _dropped(self, index):
        if index != self.view.chosen:  # clicked, and not moved
            self._change(self.view.choose, index)
        self.in_full()

    def _write(self, _camera):
        """Writes the lamps, as load_lamps and scene files have them; what to say."""
        names = (f"lamps{'' if k == 1 else f'-{k}'}.toml" for k in count(1))
        path = self._path or next(path for path in map(Path, names) if not path.exists())
        try:
            text = lamps_text(self.view.lights())
        except ValueError as fault:
            return str(fault)
        Path(path).write_text(text)
        return f"the lamps are in {Path(path).resolve()} now"
