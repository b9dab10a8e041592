"""Moving the lamps of a scene: a window, or a picture of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from surflux._base import check
from surflux._base.types import FilePath, Size
from surflux.drawing.plots import Picture, camera_or_none, destination, in_a_cell, in_notebook, window_size
from surflux.pictures.camera import Camera
from surflux.scenes.lights import LIGHTS, Light
from surflux.solving.local_transfer import LocalTransfer


def move_lamps(
    transfer: LocalTransfer,
    lights: Light | Sequence[Light] | None = None,
    *,
    style: Literal["disks", "splats", "points"] | None = None,
    stops: float = 0.0,
    camera: Camera | None = None,
    size: Size = (1000, 700),
    screenshot: FilePath | None = None,
) -> Path | Picture | None:
    """Opens a window in which the mouse drags lamps, and the light of the scene follows; `h` lists its keys.

    Lamps are spheres, the chosen one a larger one. They move parallel to the picture; `,` and `.` bring the chosen one
    nearer and farther. Sliders set its power and its colour, which keeps its luminance. While something is dragged,
    direct light is found by one ray to each surfel; when it is let go, by as many as `LocalTransfer.relight` takes.
    `t` shows direct light at every pixel, as LampRenderer draws it, also while lamps are dragged. What is white stays
    from light to light until `a` adapts it; `d` shows direct or indirect light alone, `w` writes the lamps into a file
    that load_lamps reads.

    Without a display, or with `screenshot`, a picture is saved instead.

    Args:
        transfer: LocalTransfer, as precompute_transfer finds it.
        lights: one or a list of PointLight, SpotLight, PhotometricLight, AreaLight and DirectionalLight, to begin with.
            None for a point light in the air that the camera sees, from where it lights most of what is seen.
        style: "disks", "splats" (colours run into each other) or "points"; None for splats, of more than 100 000
            surfels disks.
        stops: of exposure; 0 shows the brightest percent of the light of the beginning as white.
        camera: Camera; None for the scene's own, or one that has all surfels in view.
        size: (width, height) in pixels.
        screenshot: path of a PNG or JPEG to write instead of opening a window. Where there is no display, a picture is
            saved in a new temporary folder (stderr says where).

    Returns:
        The path of the picture; None after a window was closed; in a Jupyter notebook a Picture, which it shows.

    Raises:
        ValueError: an argument, by name.
        FileError: a picture that cannot be written.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
    >>> sf.move_lamps(transfer, sf.PointLight([0.5, 0.5, 0.5], 1.0), screenshot="lamps.png", size=(400, 300)).name
    'lamps.png'
    """
    if not isinstance(transfer, LocalTransfer):
        raise ValueError(f"transfer: wanted a LocalTransfer, got {type(transfer).__name__}")
    size = window_size(size)
    camera_or_none(camera)
    if lights is not None:
        lights = [lights] if isinstance(lights, LIGHTS) else lights
        if not isinstance(lights, (list, tuple)):
            raise ValueError(f"lights: wanted a light or a list of lights, got {type(lights).__name__}")
    stops = check.number("stops", stops, -20.0, 20.0)
    if screenshot is None and in_notebook():
        return in_a_cell(move_lamps, transfer, lights, style=style, stops=stops, camera=camera, size=size)
    path = destination(screenshot)
    from surflux.viewing.lamp_controls import LampControls
    from surflux.viewing.lamp_window import LampView
    from surflux.viewing.relit_window import show_window

    def make(off_screen):
        return LampView(transfer, lights, camera, style=style, stops=stops, size=size, off_screen=off_screen)

    return show_window(make, LampControls, camera, path)
