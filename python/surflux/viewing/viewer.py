"""Looking at surfels, scenes and solutions: a window, a picture of it, or a page in a notebook."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from pathlib import Path
from typing import Literal

from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.types import FilePath, Integer, Size
from surflux.drawing.plots import camera_or_none, destination, in_notebook, quiet_vtk, window_size
from surflux.pictures.camera import Camera
from surflux.scenes.camera_file import save_camera
from surflux.solutions.kept_camera import write_camera
from surflux.viewing.page import Page
from surflux.viewing.subject import Subject, Thing


def view(
    thing: Thing,
    *,
    color: str | None = None,
    style: Literal["disks", "splats", "points"] = "disks",
    light: Literal["all", "direct", "indirect"] = "all",
    stops: float = 0.0,
    level: int = 0,
    inserted: bool = False,
    pick: Integer | None = None,
    values: Mapping[str, ArrayLike] | None = None,
    camera: Camera | None = None,
    size: Size = (1000, 700),
    screenshot: FilePath | None = None,
    file: FilePath | None = None,
) -> Path | Page | None:
    """Opens a window on surfels, a scene or a solution; `h` lists its keys.

    In the window c goes through the colours, s through disks, splats and points, d through all, direct and indirect
    light. A click shows the values of a surfel, those that share its disk, and lines to where its light comes from: as
    wide and as bright as their part of it, found by 4096 rays, added up by groups of the hierarchy. Sliders set the
    exposure, the level of the hierarchy whose groups are shown (D03 fig. 6b), and zeta, where the scene is there: it is
    solved again when the slider is let go, which takes as long as solving takes; what is shown is that solution, with
    its cut. Surfels have one side here as they have in the light: from behind they are not drawn, until b is pressed.
    Behind radiosity stands the sky of the Environments that the solution was lit by, as in pictures (Solution.render),
    in coarser pixels while the camera moves; behind all else is white.

    Without a display, or with `screenshot`, a picture is saved instead. In a Jupyter notebook a Page is returned,
    which the notebook shows in the cell, whether there is a display or not: the kernel may be anywhere.

    Args:
        thing: Surfels, Scene or Solution.
        color: what to begin with: "radiosity", "irradiance", "direct", "indirect", "emission", "reflectance", "normal",
            "radius", "area", "coverage" (area / disk area), "level" and "parent" (of inserted surfels), "object",
            "group" (of the hierarchy), "cut" (nodes that light was solved for), or a name in values; those that there
            are. None for radiosity, or reflectance where nothing is solved.
        style: "disks", "splats" (colours run into each other) or "points".
        light: "all", "direct" or "indirect": what radiosity and irradiance show.
        stops: of exposure; 0 shows the brightest percent of all surfels as white. (write_image exposes a picture by
            what it shows: see tone_map.)
        level: of the hierarchy, 0 the finest.
        inserted: True marks inserted surfels.
        pick: index of a surfel to pick, or None.
        values: dict of further arrays by name: (n, 3) is exposed as light is, whatever its unit, (n,) numbers, such as
            errors.
        camera: Camera; None for the one that comes with the thing, or one that has all in view.
        size: (width, height) in pixels.
        screenshot: path of a PNG or JPEG to write instead of opening a window.
        file: of a scene (.toml) or a solution (.ply): where w writes the camera, and changes nothing else in it. A
            solution that is not there yet is saved.

    Returns:
        The path of the picture, None after a window was closed, or a Page in a notebook.

    Raises:
        ValueError: an argument, by name.
        FileError: a picture that cannot be written.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[x, y, 0] for y in range(9) for x in range(9)], normals=[[0, 0, 1]] * 81)
    >>> sf.view(floor, color="area", screenshot="areas.png", size=(400, 300)).name
    'areas.png'
    """
    subject = Subject(thing, values)
    size = window_size(size)
    camera_or_none(camera)
    check.flag("inserted", inserted)
    if pick is not None:
        pick = check.count("pick", pick, 0, len(subject) - 1)
    if screenshot is None and in_notebook():
        return Page(thing, values=values, camera=camera)
    path = destination(screenshot)
    from surflux.viewing.window import SceneView

    with quiet_vtk():
        window = SceneView(
            subject,
            color=color,
            style=style,
            light=light,
            stops=stops,
            level=level,
            size=size,
            off_screen=path is not None,
        )
        try:
            if inserted:
                window.mark_inserted(True)
            window.frame(camera)
            if pick is not None:
                window.pick(pick)
            if path is None:
                from surflux.viewing.controls import listen

                start = subject.framed(size) if camera is None else camera
                listen(window, start=start, write=camera_writer(window, file), export=page_writer(window, file))
                window.plotter.show()
            else:
                window.plotter.render()
                window.plotter.screenshot(path)
        finally:
            window.plotter.close()
    return path


def camera_writer(window, file):
    """Writes a Camera into a scene file, or the file of the solution that a SceneView shows, and says so; or None."""
    if file is None:
        return None
    path = Path(check.path("file", file))

    def write(camera):
        if path.suffix.lower() == ".toml":
            save_camera(path, camera)
        elif window.subject.solution is None:
            return f"{path.name} holds neither a scene nor a solution, so it has no camera"
        elif path.exists():
            write_camera(path, camera)
        else:
            window.subject.solution.camera = camera
            window.subject.solution.save(path)
        return f"the camera is in {path} now"

    return write


def page_writer(window, file):
    """Writes a page of what a SceneView shows, and says where."""
    stem = "surflux" if file is None else Path(file).stem

    def write(camera):
        subject = window.subject
        thing = subject.solution or subject.scene or subject.surfels
        return save_page(Page(thing, values=subject.values, camera=camera, title=stem), stem)

    return write


def save_page(page, stem):
    """Writes a Page into the working folder, beside those that are there, and says so."""
    names = (f"{stem}.html" if k == 1 else f"{stem}-{k}.html" for k in count(1))
    path = page.save(next(path for path in map(Path, names) if not path.exists()))
    return f"{path.resolve()}: {path.stat().st_size / 1e6:.1f} MB"
