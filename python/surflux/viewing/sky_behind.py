"""What is seen behind the surfels of a window: the Environments that light them, as pictures have them."""

import numpy as np

from surflux import _core
from surflux._base.color import display_bytes
from surflux.viewing.image_behind import ImageBehind

_WHILE_MOVING = 2  # pixels along each side of a block that has one colour while the mouse moves the camera


class SkyBehind:
    """The Environments behind a SceneView, which follow its camera and its size whenever it is drawn.

    Args:
        view: SceneView.
    """

    def __init__(self, view):
        self._view, self._image = view, ImageBehind(view.plotter, "sky")
        self._environments, self._exposure, self._drawn = [], 1.0, None
        self._lights = []  # of the core, of the environments
        view.plotter.renderer.AddObserver("StartEvent", lambda *_: self._follow())

    def show(self, environments, exposure):
        """Shows their radiance times exposure, 1 as white; no environments: the plain background."""
        if not environments:
            self._image.hide()
        elif not self._environments:
            self._image.show()
        if environments != self._environments:
            self._lights = [environment._to_core() for environment in environments]
        self._environments, self._exposure, self._drawn = list(environments), exposure, None

    def _follow(self):
        """Before the window is drawn: where it looks another way than before, so does the sky."""
        if not self._environments:
            return
        side = _WHILE_MOVING if self._view.plotter.iren.style.GetState() != 0 else 1
        (width, height), camera = self._view.plotter.window_size, self._view.camera()
        key = camera.to_dict(), width, height, side
        if key == self._drawn:
            return
        open_pixels = np.zeros((-(-height // side), -(-width // side)))
        picture = display_bytes(
            self._exposure * _core.environment_image(self._lights, camera._to_core(), open_pixels, 1)
        ).astype(np.uint8)
        self._image.put(picture.repeat(side, axis=0).repeat(side, axis=1)[:height, :width])
        self._drawn = key
