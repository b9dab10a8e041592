"""Looking at surfels with pyvista: each disk as an oriented polygon, each mesh patch as its triangles."""

import contextlib
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

from surflux._base import check
from surflux._base.files import require_place
from surflux._base.passes import LOG
from surflux.drawing.colors import label_digits, screen_bytes, surface_property
from surflux.drawing.glyphs import disk_corners, polygon_cells, polygons, rings
from surflux.geometry.cores import disks_among
from surflux.pictures.camera import Camera

_LETTERS = 0.03  # height, over that of the picture

_DOT, _LIFT = 0.0015, 0.0005  # radius and height of marks, over the diagonal of all


KINDS = ("points", "disks", "patches")
UNITS = {"radius": "length", "area": "length^2", "emission": "W/m2"}


def to_polydata(s, kind="points", values=None, units=None):
    """Surfels as pyvista.PolyData with normals, radius, area (where known), reflectance and emission.

    Args:
        s: Surfels.
        kind: "points": their places, with point arrays. "disks": what they look like, polygons for disks and triangles
            for patches of a mesh; "patches": these triangles alone. Both with cell arrays, and "surfel" beside them;
            "area" is shared out among the cells of a surfel, so that it adds up.
        values: dict of further arrays by name, (n,) or (n, k).
        units: dict of theirs, by name. The field array "units" has a line for each array that has one.

    Raises:
        ValueError: kind, or "patches" of surfels without any; no surfels.
    """
    import pyvista

    check.some_surfels("surfels", s)
    check.choice("kind", kind, KINDS)
    if kind == "patches" and not len(s.triangles):
        raise ValueError('kind: wanted "points" or "disks", for none of these surfels is a patch of a mesh')
    arrays = {"normals": s.normals, "radius": s.radii, "reflectance": s.reflectance, "emission": s.emission}
    if s.areas is not None:
        arrays["area"] = s.areas
    arrays |= {name: check.per_row(name, value, len(s)) for name, value in (values or {}).items()}
    if kind == "points":
        found = pyvista.PolyData(s.points)
        for name, value in arrays.items():
            found.point_data[name] = value
    else:
        found = disks(s)
        if kind == "patches":
            found = polygons(s.triangles)
            found.cell_data["surfel"] = s.triangle_surfel.astype(np.int64)
        surfel = found.cell_data["surfel"]
        cells = {name: value[surfel] for name, value in arrays.items()}
        if s.areas is not None:
            sizes = found.compute_cell_sizes(length=False, volume=False).cell_data["Area"]
            cells["area"] = _shared_areas(s.areas, surfel, sizes)
        for name, value in cells.items():
            found.cell_data[name] = value
    known = UNITS | (units or {})
    found.field_data["units"] = [f"{name}: {known[name]}" for name in arrays if name in known]
    return found


def _shared_areas(areas, surfel, sizes):
    """(cells,) areas of surfels, (n,), shared out among the cells of each by their sizes."""
    of_surfel, alike = np.bincount(surfel, sizes, len(areas)), 1.0 / np.bincount(surfel, minlength=len(areas))[surfel]
    return areas[surfel] * np.divide(sizes, of_surfel[surfel], out=alike, where=of_surfel[surfel] > 0.0)


def disks(s, corners=None):
    """What the surfels look like, as pyvista.PolyData: polygons for disks, triangles for patches of a mesh.

    Cell array "surfel" says which surfel each cell belongs to. corners: of a disk; None for 16, or 6 where there are
    more than 100 000.
    """
    import pyvista

    round_ones = disks_among(s)
    if corners is None:
        corners = disk_corners(len(round_ones))
    rims = rings(s.points[round_ones], s.normals[round_ones], s.radii[round_ones], corners).reshape(-1, 3)
    triangles = s.triangles.reshape(-1, 3)
    cells = polygon_cells(len(round_ones), corners, 0), polygon_cells(len(s.triangles), 3, len(rims))
    mesh = pyvista.PolyData(np.concatenate([rims, triangles]), faces=np.concatenate(cells))
    mesh.cell_data["surfel"] = np.concatenate([round_ones, s.triangle_surfel.astype(np.int64)])
    return mesh


def plot(s, *, color="reflectance", values=None, marks=None, screenshot=None, camera=None, size=(800, 600), **options):
    """Shows surfels in a window; without a display, or with screenshot, saves a picture instead and says where.

    Surfels and patches have one side here as they do in the light: from behind they are not drawn, so that a room
    can be looked into through its walls. culling=False draws both sides.

    Args:
        s: Surfels.
        color: "reflectance", "emission", "radius", "normal", "area", "coverage" (area / disk area) or a name in
            values. Areas that nobody has given are computed for the picture.
        values: dict of further arrays (n,) or (n, 3); those with three columns are taken as linear RGB.
        marks: (points, normals) of black dots on the surfaces, or None.
        screenshot: path of a PNG or JPEG to write; None for a window; where there is no display, one in a new
            temporary folder.
        camera: Camera to look from; None to frame everything.
        size: (width, height) in pixels.
        options: go to pyvista.Plotter.add_mesh.

    Returns:
        The path of the picture, None after a window was closed; in a Jupyter notebook a Picture, which the
        notebook shows.

    Raises:
        ValueError: an argument, by name.
        FileError: a picture that cannot be written.
    """
    width, height = window_size(size)
    check.some_surfels("surfels", s)
    shown = surface_property(s, color, values)
    camera_or_none(camera)
    if screenshot is None and in_notebook():
        return in_a_cell(plot, s, color=color, values=values, marks=marks, camera=camera, size=size, **options)
    path = destination(screenshot)

    import pyvista

    mesh = disks(s)
    # The display works in single precision: around the origin it draws survey coordinates as well as any other.
    origin = np.array(mesh.center)
    mesh.points -= origin
    value = shown.values if shown.kind == "number" else screen_bytes(shown)
    mesh.cell_data[color] = value[mesh.cell_data["surfel"]]
    settings = {"scalars": color, "rgb": shown.kind != "number", "lighting": False, "culling": "back"}
    if shown.kind == "number":
        settings |= {"cmap": "viridis", "scalar_bar_args": _bar(color, value, height)}
    settings |= options
    if not settings["culling"]:
        settings["culling"] = None
    with quiet_vtk():
        plotter = pyvista.Plotter(off_screen=path is not None, window_size=(width, height))
        try:
            plotter.set_background("white")
            plotter.add_mesh(mesh, **settings)
            if marks is not None:
                plotter.add_mesh(_dots(*marks, origin, mesh.length), color="black", lighting=False, culling="back")
            if camera is not None:
                look_through(plotter.camera, camera, origin)
                plotter.renderer.ResetCameraClippingRange()
            if path is None:
                plotter.show()
            else:
                plotter.screenshot(path)
        finally:
            plotter.close()
    return path


def _dots(points, normals, origin, extent):
    """Small disks a little above a surface: from behind they are hidden, as it is."""
    radii = np.full(len(points), _DOT * extent)
    return polygons(rings(points - origin + _LIFT * extent * normals, normals, radii, disk_corners(len(points))))


def look_through(view, camera, origin):
    """Makes a camera of pyvista see what a Camera does, in a scene that is moved by -origin."""
    view.position, view.focal_point = camera.eye - origin, camera.target - origin
    view.up, view.view_angle = camera.up, camera.fov
    view.parallel_projection = camera.height is not None
    if camera.height is not None:
        view.parallel_scale = camera.height / 2.0


def seen_through(view, origin):
    """The Camera that sees what a camera of pyvista does, in a scene that is moved by -origin: undoes look_through."""
    found = Camera.from_pyvista(view)
    return Camera(origin + found.eye, origin + found.target, found.up, found.fov, height=found.height)


def camera_or_none(camera):
    """Refuses what is neither."""
    if not isinstance(camera, (Camera, type(None))):
        raise ValueError(f"camera: wanted a Camera or None, got {camera!r}")


def destination(screenshot):
    """The path of the picture to write, checked; None for a window, where there is a display."""
    if screenshot is None and not has_display():
        screenshot = Path(tempfile.mkdtemp(prefix="surflux-")) / "surflux_view.png"
        LOG.warning("there is no display, so the picture goes to %s", screenshot)
    return None if screenshot is None else picture_path("screenshot", screenshot)


def has_display():
    """Whether a window can be opened."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def in_notebook():
    """Whether this runs in a Jupyter kernel: what is shown belongs in the cell, wherever a display may be."""
    shell = sys.modules.get("IPython")
    shell = shell and shell.get_ipython()
    return shell is not None and hasattr(shell, "kernel")


class Picture:
    """A picture in a cell of a notebook; `png` has its bytes."""

    def __init__(self, png):
        self.png = png

    def _repr_png_(self):
        return self.png


def in_a_cell(draw, *arguments, **options):
    """The Picture that draw(..., screenshot=path) writes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plot.png"
        draw(*arguments, screenshot=file, **options)
        return Picture(file.read_bytes())


@contextlib.contextmanager
def quiet_vtk():
    """Without VTK's warning that it found no X server before it took EGL."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    if not has_display():
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)


def window_size(size):
    """(width, height), checked."""
    if not isinstance(size, (tuple, list)) or len(size) != 2:
        raise ValueError(f"size: wanted (width, height), got {size!r}")
    return tuple(check.count("size", side, 1, 16384) for side in size)


def picture_path(name, path):
    """The path of a picture to write, as a Path; refused by `name` where it has another suffix."""
    path = Path(check.path(name, path))
    if path.suffix.lower() not in (".png", ".jpg", ".jpeg"):
        raise ValueError(f"{name}: wanted a name ending in .png or .jpg, got {str(path)!r}")
    require_place(path)
    return path


def _bar(title, values, height):
    """Arguments of pyvista's scale below the picture, with digits enough to tell values at its marks apart."""
    letters = max(6, round(_LETTERS * height))
    values = values[np.isfinite(values)]
    low, high = (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 0.0)
    fonts = {"title_font_size": letters, "label_font_size": letters, "unconstrained_font_size": True}
    # And an empty line, so that the title stands clear of the marks.
    return {"title": f"{title}\n", "fmt": f"%.{label_digits(low, high)}g", "n_labels": 5, "color": "black"} | fonts
