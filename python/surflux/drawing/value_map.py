"""A picture of numbers on surfaces, beside their scale: what is not known is grey, and light shows the shapes."""

import numpy as np

from surflux.drawing.colors import label_digits, trimmed_range
from surflux.drawing.glyphs import text_actor
from surflux.drawing.plots import disks, look_through, picture_path, quiet_vtk, window_size
from surflux.geometry.cores import disks_among

_MAP, _UNKNOWN = "inferno", (160, 166, 168)
# A lamp over the camera's left shoulder: what faces away keeps so much of its colour, so that it can be read still.
_LEAST, _LAMP = 0.6, (-0.45, 0.45, 0.77)
_WIDE = 4.0  # medians of the radii: wider disks are of points that stand alone
_LETTERS = 0.022  # height, over that of the picture
_STEPS = 10  # of the scale, at most
SCALE = 0.13  # of the width, on the right: what is looked at stands in the middle of the rest


def value_map(s, values, path, *, unit, title, camera, size=(1200, 900)):
    """Writes a picture of values (n,) on Surfels; where they are NaN, surfels are grey.

    Args:
        s: Surfels.
        values: (n,).
        path: of a PNG or JPEG.
        unit: above the scale.
        title: a line on top.
        camera: Camera; what it has in the middle is left of there, beside the scale.
        size: (width, height) in pixels.

    Raises:
        ValueError: size or path, by name.
        FileError: a picture that cannot be written.
    """
    import pyvista

    width, height = window_size(size)
    path = picture_path("image", path)
    mesh = disks(_narrowed(s))
    origin = np.array(mesh.center)
    mesh.points -= origin
    low, high, steps = scale_of(values)
    table = pyvista.LookupTable(_MAP, n_values=256, scalar_range=(low, high))
    shown = shaded(np.array(table.values)[:, :3], (values - low) / (high - low), s.normals, camera)
    mesh.cell_data["shown"] = shown[mesh.cell_data["surfel"]]
    letters = max(6, round(_LETTERS * height))
    with quiet_vtk():
        plotter = pyvista.Plotter(off_screen=True, window_size=(width, height))
        try:
            plotter.set_background("white")
            plotter.add_mesh(mesh, scalars="shown", rgb=True, lighting=False, culling="back")
            scale = pyvista.DataSetMapper()
            scale.lookup_table = table
            plotter.add_scalar_bar(
                f"{unit}\n",  # and an empty line, so that it stands clear of the highest label
                mapper=scale,
                vertical=True,
                n_labels=steps + 1,
                fmt=f"%.{label_digits(low, high, steps)}g",
                color="black",
                title_font_size=letters,
                label_font_size=letters,
                unconstrained_font_size=True,
                width=0.06,
                height=0.5,
                position_x=0.9,
                position_y=0.06,
            )
            plotter.add_actor(text_actor(title, letters, (0.015, 0.98), top=True), render=False)
            look_through(plotter.camera, camera, origin)
            plotter.camera.SetWindowCenter(SCALE, 0.0)
            plotter.renderer.ResetCameraClippingRange()
            plotter.screenshot(path)
        finally:
            plotter.close()
    return path


def scale_of(values):
    """(low, high, steps) of a scale of round numbers, around all but the outermost percent of what is known."""
    low, high, _ = trimmed_range(values)
    step = 10.0 ** np.floor(np.log10((high - low) / _STEPS))
    # One step more than the range takes may be needed for round ends on both sides.
    for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0):
        first, last = np.floor(low / (factor * step) + 1e-9), np.ceil(high / (factor * step) - 1e-9)
        if last - first <= _STEPS:
            break
    return factor * step * first, factor * step * last, int(last - first)


def shaded(colors, fraction, normals, camera):
    """(n, 3) uint8: of fractions (n,) of the scale whose colours (k, 3) are given, lit for the camera."""
    known = np.isfinite(fraction)
    place = np.rint((len(colors) - 1) * np.where(known, fraction, 0.0).clip(0.0, 1.0)).astype(int)
    rgb = np.where(known[:, None], colors[place], _UNKNOWN)
    right, down, forward = camera._axes()
    lamp = np.array(_LAMP) @ (right, -down, -forward)
    cosine = (normals @ (lamp / np.linalg.norm(lamp))).clip(0.0, 1.0)
    return np.rint(rgb * (_LEAST + (1.0 - _LEAST) * cosine)[:, None]).astype(np.uint8)


def _narrowed(s):
    """Surfels without the width of disks that stand alone, which would hide what is around them."""
    round_ones = disks_among(s)
    if len(round_ones) == 0:
        return s
    radii = s.radii.copy()
    radii[round_ones] = np.minimum(radii[round_ones], _WIDE * np.median(radii[round_ones]))
    return s.replace(radii=radii)
