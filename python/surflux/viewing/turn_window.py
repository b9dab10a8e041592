"""The window in which an environment is turned: what it shows, without the mouse and the keys."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from surflux.pictures.framing import own_or_framing
from surflux.solutions.towards import glossy, towards_eye
from surflux.viewing.relit_window import RelitView

_PATIENCE = 0.3  # seconds that gloss may take to follow the camera by itself


class TurnView(RelitView):
    """A view of a scene under an environment that can be turned, glossy surfels as the camera sees them.

    While it is dragged, light is that of the waves of a TurningLight, and gloss stays as it was.

    Args:
        turning: TurningLight.
        camera: Camera that it is to look through; None for the scene's own, or one that has all in view.
        size: (width, height) in pixels.
        options: see RelitView.

    Attributes:
        degrees: that the environment is turned by.
    """

    def __init__(self, turning, camera=None, *, size=(800, 600), **options):
        self.turning, self.degrees = turning, 0.0
        scene = turning.transfer.scene
        self._looks = own_or_framing(scene.camera if camera is None else camera, scene.surfels, size)
        self._lit = self._gloss = None
        self._patient, self._stale = True, False
        super().__init__(self.timed(self.found, False), size=size, **options)

    def turn(self, degrees, quick=False):
        """Turns the environment, and shows its light."""
        self.degrees = degrees % 360.0
        self.relight(quick)

    def prepare(self):
        """Finds what light while dragging is made of, which takes as long as nine relightings."""
        self.turning.diffuse(self.degrees)

    def found(self, quick):
        if quick:
            return self.turning.diffuse(self.degrees)
        self._lit = self.turning.relight(self.degrees)
        self._mirror()
        return self._lit

    def say_light(self):
        self.note = f"environment turned by {self.degrees:.4g} degrees\nrelit in {1000 * self.seconds:.0f} ms"
        if self._stale:
            self.note += "\ngloss is that of another place; e: as seen from here"

    def whole(self):
        shown = super().whole()
        if self._gloss is None or shown.name != "radiosity":
            return shown
        title = "radiance towards the eye times pi, W/m2"
        return replace(shown, title=title, values=shown.values + np.pi * self._gloss)

    def shown(self):
        """Of lobes only where all light is on: they do not tell direct light from other."""
        return self.whole() if self.light == "all" else super().shown()

    def frame(self, camera=None):
        super().frame(camera)
        self.look_again()

    def look_again(self):
        """Shows gloss as it is seen from where the camera stands now."""
        before, self._looks = self._looks, self.camera()
        if not self.turning.glossy or (np.allclose(before.eye, self._looks.eye, 1e-9) and not self._stale):
            return
        self._mirror()
        self.say_light()
        self.recolor()

    def moved(self):
        """The camera was moved: gloss follows at once, unless that takes long, which is told."""
        if self._patient:
            self.look_again()
        elif self.turning.glossy and not self._stale:
            self._stale = True
            self.say_light()
            self.describe(self.shown())

    def _mirror(self):
        """Finds what lobes send to the eye."""
        if self.turning.glossy:
            start = perf_counter()
            self._gloss = glossy(self._lit, towards_eye(self._lit.surfels.points, self._looks))
            self._patient, self._stale = perf_counter() - start < _PATIENCE, False
