"""Direct light at every pixel of a window: a picture in place of the surfels, behind all else."""

import numpy as np

from surflux.pictures.images import tone_map
from surflux.solving.lamp_renderer import LampRenderer
from surflux.viewing.image_behind import ImageBehind

_LAYERS = {"all": "radiance", "direct": "direct", "indirect": "indirect"}
_BEYOND = 1e6  # times what is white: what lies behind the scene is white however it is exposed
_HIDDEN = ("surfels", "lamps")  # actors


class TracedLight:
    """A picture of a LampRenderer as large as the window.

    Args:
        view: LampView.
    """

    def __init__(self, view):
        self._view, self._renderer = view, None
        self._image = ImageBehind(view.plotter, "traced")

    def draw(self):
        """Shows the light that there is now, as the camera sees it."""
        self._image.put(self._picture())
        self._image.show()
        self._hide_surfels(True)

    def remove(self):
        """Shows the surfels again."""
        self._image.hide()
        self._hide_surfels(False)

    def _picture(self):
        """(h, w, 3) uint8."""
        view = self._view
        camera, size = view.camera(), tuple(view.plotter.window_size)
        if self._renderer is None or self._renderer.culling != view.culling:
            self._renderer = LampRenderer(view.transfer, camera, size, culling=view.culling)
        if self._renderer.camera != camera:
            self._renderer.camera = camera
        if self._renderer.size != size:
            self._renderer.size = size
        layer, white = _LAYERS[view.light], view.white() or 1.0
        names = [layer] if layer != "indirect" else [layer, "index"]
        found = self._renderer.frame(view.lights(), layers=names, background=_BEYOND * white)
        image = found[layer]
        if layer == "indirect":
            image[found["index"] == -1] = _BEYOND * white
        shown = tone_map(image, exposure=np.pi * 2.0**view.stops / white, filmic=False)
        return np.rint(255.0 * shown).astype(np.uint8)

    def _hide_surfels(self, hidden):
        for name in _HIDDEN:
            if name in self._view.plotter.actors:
                self._view.plotter.actors[name].SetVisibility(not hidden)
