"""Mouse, keys and sliders of the window in which an environment is turned."""

from surflux.viewing.page import Page
from surflux.viewing.relit_controls import RelitControls
from surflux.viewing.viewer import save_page

KEYS = {
    ".": "turn the environment by 5 degrees (,: back)",
    "e": "gloss as it is seen from here",
    "x": "export a page, which turns the environment in any browser",
}
_STEP = 5.0


class TurnControls(RelitControls):
    """What a person does in a TurnView.

    Args:
        view: TurnView.
        start: Camera to come back to.
    """

    def __init__(self, view, start=None):
        super().__init__(view, KEYS, "", start)
        self.keys |= {
            ".": lambda: self._turn(_STEP),
            ",": lambda: self._turn(-_STEP),
            "e": view.look_again,
            "x": lambda: self.hand(self._export, ""),
        }
        view.prepare()

        def changed(degrees):
            view.turn(degrees, quick=True)

        self.slider("turn", 0.27, (0.0, 360.0), view.degrees, changed, "environment, degrees", "always", "%.0f", 0.7)
        self.sliders["turn"].AddObserver("EndInteractionEvent", lambda *_: self.in_full())
        view.plotter.iren.style.AddObserver("EndInteractionEvent", lambda *_: self._moved())

    def _turn(self, step):
        self.view.turn(self.view.degrees + step)
        self.sliders["turn"].GetRepresentation().SetValue(self.view.degrees)

    def _moved(self):
        self.view.moved()
        self.view.plotter.render()

    def _export(self, camera):
        """Writes a page that begins as the window is; what to say."""
        turning = self.view.turning
        light = turning.harmonics(self.view.degrees)
        return save_page(Page(turning.transfer, environment=light, axis=turning.axis, camera=camera), "surflux")
