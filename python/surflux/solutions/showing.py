"""What shows a solution, as a plot or a film, or hands it to pyvista: methods of Solution."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import NDArray

from surflux._base import check
from surflux._base.types import FilePath, Progress, Size
from surflux.drawing.plots import Picture, to_polydata
from surflux.drawing.plots import plot as plot_surfels
from surflux.pictures.animation import animate as film
from surflux.pictures.camera import Camera
from surflux.solutions.fields import BasisField

if TYPE_CHECKING:
    import pyvista


def animate(
    self,
    cameras: list[Camera] | tuple[Camera, ...],
    path: FilePath,
    size: Size = (800, 600),
    *,
    fps: float = 25,
    exposure: float | Literal["auto"] | None = None,
    stops: float = 0.0,
    filmic: bool = True,
    progress: Progress = False,
    **options: Any,
) -> list[Path]:
    """Pictures from one camera after another, as a film or as numbered pictures.

    Args:
        cameras: list of Camera, one for each frame; see turntable and camera_path.
        path: a name that ends in .mp4 or .gif, for a film (`pip install 'surflux[video]'`), or a pattern for
            numbered pictures, such as "frames/%04d.png" (.png, .exr or .hdr): 0001 is the first.
        size: (width, height) in pixels; .mp4 takes even numbers alone.
        fps: frames of a film in a second.
        exposure, stops, filmic: as of write_image, one for all frames: None chooses it from the first.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.
        options: all else goes to `render`. With layers=True, .exr files hold all layers.

    Returns:
        list of the Paths written: of one film, or of all pictures.

    Raises:
        ValueError: an argument, by name.
        ImportError: a film, and the extra `video` is not there.
        FileError: what cannot be written, by path.
        Cancelled: the callback returned False; a film is not written then.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))
    >>> cameras = sf.turntable(sf.Camera([0.5, -1, 1], [0.5, 0.5, 0]), 3)
    >>> [path.name for path in solution.animate(cameras, "turn%02d.png", (40, 30))]
    ['turn01.png', 'turn02.png', 'turn03.png']
    """
    tone = {"exposure": exposure, "stops": stops, "filmic": filmic}
    return film(self, cameras, path, size, fps=fps, progress=progress, **tone, **options)


def plot(self, color: str = "radiosity", *, receivers: bool = False, **options: Any) -> Path | Picture | None:
    """Shows the surfels in a window; without a display, or with screenshot, saves a picture instead.

    Args:
        color: "radiosity", "irradiance", "direct", "level", "reflectance", "emission", "area", "radius" or
            "normal".
        receivers: True marks where solve_meshless gathered light, by black dots (L07 Fig. 4).
        screenshot: path of a PNG or JPEG to write; None for a window; where there is no display, for one in
            a new temporary folder (stderr says which).
        camera: Camera to look from; unless given the scene's own, or one that frames everything.
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
    marks = None
    if check.flag("receivers", receivers):
        if not isinstance(self._field, BasisField):
            raise ValueError("receivers: wanted False, for only what solve_meshless found has some")
        marks = self._field.receivers()
    options.setdefault("camera", self.camera)
    return plot_surfels(self.surfels, color=color, values=self.values(), marks=marks, **options)


def to_pyvista(self, kind: Literal["points", "disks", "patches"] = "points") -> pyvista.PolyData:
    """The surfels as Surfels.to_pyvista has them, with radiosity, irradiance, direct, level, parent, object and cut.

    Light is in W/m2, the unit of the lights; the field array "units" says so. Of kind "patches" cells are triangles,
    several of a patch: their "surfel" is the row of the solution that they belong to.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    >>> mesh = sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)])).to_pyvista("patches")
    >>> print(mesh.cell_data["irradiance"].mean().round(4))
    3.1416
    """
    values = self.values() | {"parent": self.parents, "object": self.objects}
    values |= {} if self.cut is None else {"cut": self.cut}
    units = dict.fromkeys(("radiosity", "irradiance", "direct"), "W/m2")
    return to_polydata(self.surfels, kind, values, units)


def values(self) -> dict[str, NDArray[Any]]:
    """What there is to colour surfels by beyond their own properties: a dict of arrays (n, 3) or (n,)."""
    return {"radiosity": self.radiosity, "irradiance": self.irradiance, "direct": self.direct, "level": self.levels}
