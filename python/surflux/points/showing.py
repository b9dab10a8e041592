"""Windows and pictures of Surfels: methods of theirs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from surflux._base.types import Integer, SomeSurfels
from surflux.drawing import area_window, plots
from surflux.drawing.plots import Picture


def plot(self: SomeSurfels, color: str = "reflectance", **options: Any) -> Path | Picture | None:
    """Shows the disks and patches in a window; without a display, or with screenshot, saves a picture instead.

    Surfels have one side here as they do in the light: from behind they are not drawn, so that a room can be
    looked into through its walls.

    Args:
        color: "reflectance", "emission", "radius", "normal", "area", "coverage" (area / (pi R^2); above 1 where
            few points stand far apart) or a name in values. Areas left open are computed for the picture.
        values: dict of further arrays (n,) or (n, 3) by name; three columns are linear RGB.
        screenshot: path of a PNG or JPEG to write; None for a window; where there is no display, for one in
            a new temporary folder (stderr says which).
        camera: Camera to look from; None to frame everything.
        size: (width, height) in pixels, (800, 600) unless given.
        culling: False draws both sides.
        options: all else goes to pyvista.Plotter.add_mesh.

    Returns:
        The path of the picture, None after a window was closed; in a Jupyter notebook a Picture, which the notebook
        shows.

    Raises:
        ValueError: an argument, by name.
        FileError: a picture that cannot be written.
    """
    return plots.plot(self, color=color, **options)


def plot_areas(self: SomeSurfels, pick: Integer | None = None, **options: Any) -> Path | Picture | None:
    """Shows how the area is shared out: disks in colours, a histogram, and what a picked surfel shares.

    Picking, with a click or `pick`, shows the neighbours with their parts of the surfel's disk, as pictures its
    share xi over that disk (D04 eq. 5) and who has the largest where, and its numbers. Of overlapping disks each
    is drawn where it is nearest. Patches of a mesh share nothing.

    Args:
        pick: index of a surfel to pick, and to look at.
        color: "coverage" (area / (pi R^2)), "area", "radius" or "normal"; in the window keys switch.
        method: makes the areas anew, as effective_areas takes it; None keeps them, or "curved" where left open.
        threads, progress: of the areas, as effective_areas takes it.
        screenshot, camera, size: as plot takes them; so are what is returned and raised.
        up: (3,) what is up in the picture where no camera is given; None for z.
    """
    return area_window.plot_areas(self, pick, **options)
