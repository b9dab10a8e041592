"""Mouse, keys and sliders of windows whose light changes: what they have in common."""

from surflux.viewing.controls import Panel
from surflux.viewing.properties import LIGHTS

WIDTH = 0.2  # of a slider
KEYS = {
    "d": "all light, direct alone, indirect alone",
    "+": "brighter by half a stop (-: darker)",
    "a": "adapt the exposure to the light that there is now",
    "s": "disks, splats, points",
    "b": "backs",
    "0": "camera of the beginning",
    "h": "these keys",
    "q": "close",
}


class RelitControls(Panel):
    """What a person does in a RelitView; `keys` may be added to.

    Args:
        view: RelitView.
        own: {key: what it does}, beside KEYS; mouse: what the mouse does, beside picking and turning.
        start: Camera to come back to.
    """

    def __init__(self, view, own, mouse, start):
        common = "click: pick a surfel    drag: turn    wheel: closer"
        super().__init__(view, own | KEYS, "    ".join(filter(None, (mouse, common))))
        self.keys = {
            "d": lambda: view.set_light(LIGHTS[(LIGHTS.index(view.light) + 1) % len(LIGHTS)]),
            "+": lambda: self.expose(view.stops + 0.5),
            "-": lambda: self.expose(view.stops - 0.5),
            "a": view.adapt,
            "s": self.next_style,
            "b": lambda: view.show_backs(view.culling),
            "0": lambda: view.frame(start),
            "h": self.list_keys,
        }
        self.take_mouse()
        self.slider(
            "exposure", 0.02, (-6.0, 6.0), view.stops, view.set_exposure, "exposure, stops", "always", width=WIDTH
        )

    def in_full(self):
        """Finds the light as well as can be, when the mouse lets something go."""
        self.view.relight()
        self.view.plotter.render()
