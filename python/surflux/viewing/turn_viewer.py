"""Turning the environment of a scene: a window, a picture of it, or a page in a notebook."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.types import FilePath, Size
from surflux.drawing.plots import camera_or_none, destination, in_notebook, window_size
from surflux.pictures.camera import Camera
from surflux.scenes.lights import Environment
from surflux.solving.distant_transfer import DistantTransfer
from surflux.solving.turning_light import TurningLight
from surflux.viewing.page import Page


def turn_environment(
    transfer: DistantTransfer,
    environment: Environment | ArrayLike,
    *,
    axis: ArrayLike | None = None,
    style: Literal["disks", "splats", "points"] | None = None,
    stops: float = 0.0,
    camera: Camera | None = None,
    size: Size = (1000, 700),
    screenshot: FilePath | None = None,
) -> Path | Page | None:
    """Opens a window in which a slider turns the environment, and the light of the scene follows; `h` lists its keys.

    `.` and `,` turn it by 5 degrees. Glossy surfels are shown as the camera sees them. While the slider is dragged,
    their lobes stay as they were; when it is let go, or the camera has moved, they follow (where that takes longer
    than .3 s, when `e` is pressed). What is white stays from light to light until `a` adapts it; `d` shows direct or
    indirect light alone, `x` exports a page whose slider does the same. The environment itself is behind the scene, and
    turns with its light.

    Without a display, or with `screenshot`, a picture is saved instead. In a Jupyter notebook a Page is returned, which
    the notebook shows in the cell; it has no gloss.

    Args:
        transfer: DistantTransfer, as precompute_transfer finds it.
        environment: see DistantTransfer.relight.
        axis: (3,), the direction that it turns around, counter-clockwise seen from the tip; None for what is up in an
            Environment, of harmonics for z.
        style: "disks", "splats" (colours run into each other) or "points"; None for splats, of more than 100 000
            surfels disks.
        stops: of exposure; 0 shows the brightest percent of the light of the beginning as white.
        camera: Camera; None for the scene's own, or one that has all surfels in view.
        size: (width, height) in pixels.
        screenshot: path of a PNG or JPEG to write instead of opening a window. Where there is no display, a picture is
            saved in a new temporary folder (stderr says where).

    Returns:
        The path of the picture; None after a window was closed; in a Jupyter notebook a Page.

    Raises:
        ValueError: an argument, by name.
        FileError: a picture that cannot be written.

    >>> import surflux as sf
    >>> ball = sf.Surfels.from_mesh(([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[0, 1, 3], [1, 2, 3]]), 0.1)
    >>> transfer = sf.precompute_transfer(sf.Scene([ball.replace(specular=0.3)]), "distant")
    >>> sky = sf.Environment([[[3.0, 2, 1], [1, 1, 1], [0, 0, 0], [1, 1, 1]]])
    >>> sf.turn_environment(transfer, sky, screenshot="turned.png", size=(400, 300)).name
    'turned.png'
    """
    turning = TurningLight(transfer, environment, axis)
    size = window_size(size)
    camera_or_none(camera)
    stops = check.number("stops", stops, -20.0, 20.0)
    if screenshot is None and in_notebook():
        return Page(transfer, environment=environment, axis=axis, camera=camera)
    path = destination(screenshot)
    from surflux.viewing.relit_window import show_window
    from surflux.viewing.turn_controls import TurnControls
    from surflux.viewing.turn_window import TurnView

    def make(off_screen):
        return TurnView(turning, camera, style=style, stops=stops, size=size, off_screen=off_screen)

    return show_window(make, TurnControls, camera, path)
