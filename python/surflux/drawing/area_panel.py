"""The window that inspects areas: where its parts stand, and what stands beside the surfels."""

import numpy as np

from surflux.drawing import sharing
from surflux.drawing.colors import coverage
from surflux.drawing.glyphs import polylines, text_actor

MAIN, SCALE, TEXT, OWN, LEADERS, HISTOGRAM = range(6)
# Of the window: where the panel begins; above what the surfels, the pictures of a pick and the words stand; how high
# the histogram reaches without those pictures.
_LEFT, _FOOT, _BOTTOM, _MIDDLE, _TALL = 0.62, 0.12, 0.4, 0.69, 0.6
_BINS = 40
_OWN_BAR = "share"


class Panel:
    """A plotter in six parts: the surfels and their colour bar; words, two pictures of a pick and a histogram.

    Args:
        s: Surfels.
        areas: (n,) of theirs.
        size: (width, height) in pixels.
        off_screen: True to draw without a window.
    """

    def __init__(self, s, areas, size, off_screen):
        import pyvista

        self.surfels, self.areas, self.size = s, areas, size
        self.plotter = pyvista.Plotter(shape=(1, 6), off_screen=off_screen, window_size=size, border=False)
        self.plotter.set_background("white")
        # Pixels a letter is high: 36 of the fixed-width font fit beside the surfels.
        self.font = max(5, round(min(size[1] / 46, size[0] * (1 - _LEFT) / (36 * 0.62))))
        self.line = max(2.0, self.font / 5)
        middle = (1 + _LEFT) / 2
        self._place(MAIN, 0, _FOOT, _LEFT, 1)
        self._place(SCALE, 0, 0, _LEFT, _FOOT)
        self._place(OWN, _LEFT, _BOTTOM, middle, _MIDDLE)
        self._place(LEADERS, middle, _BOTTOM, 1, _MIDDLE)
        for renderer in self.plotter.renderers[1:]:
            renderer.InteractiveOff()
        self._chart, self._mark = self._histogram(), None
        self.show(None)

    def show(self, picked):
        """What there is to know of a sharing.Picked; None for all surfels together."""
        pictures = picked is not None and picked.shares is not None
        for part in (OWN, LEADERS):
            self.plotter.renderers[part].SetDraw(pictures)
        self._place(TEXT, _LEFT, _MIDDLE if pictures else _TALL, 1, 1)
        self._place(HISTOGRAM, _LEFT, 0, 1, _BOTTOM if pictures else _TALL)
        if self._mark is not None:
            self._chart.remove_plot(self._mark)
            self._mark = None
        if picked is None:
            lines = sharing.summary(self.surfels, self.areas)
        else:
            lines = sharing.words(self.surfels, self.areas, picked)
            if picked.index in sharing.disks_of(self.surfels):
                ratio = coverage(self.surfels, self.areas)[picked.index]
                self._mark = self._chart.line([ratio] * 2, [*self._chart.y_range], color=sharing.PICKED, width=3)
        self.write(TEXT, "words", "\n".join(lines), (0.04, 0.95), top=True, fixed_width=True)
        if pictures:
            self._pictures(picked)

    def show_scale(self, title, mapper):
        """The colours of the surfels: a bar for those of a mapper, or the title alone."""
        self._drop_bar("scale")
        if mapper is not None:
            low, high = mapper.scalar_range
            self._bar(SCALE, "scale", mapper, labels=5 if low < high else 1, left=0.1, bottom=0.3, height=0.4)
        self.write(SCALE, "title", title, (0.5, 0.04), centered=True)

    def draw(self, part, mesh, name, **look):
        """Adds a mesh to a part of the window, in place of what had that name there; the actor."""
        fixed = {"lighting": False, "show_scalar_bar": False, "reset_camera": False, "pickable": False}
        self.plotter.subplot(0, part)
        actor = self.plotter.add_mesh(mesh, name=name, **fixed, **look)
        self.plotter.subplot(0, MAIN)
        return actor

    def write(self, part, name, text, place, *, top=False, centered=False, fixed_width=False, grey=0.0):
        """Text at a place in a part of the window, in fractions of it, instead of what had that name."""
        side = "centered" if centered else "left"
        actor = text_actor(text, self.font, place, side=side, top=top, fixed=fixed_width, grey=grey)
        self.plotter.subplot(0, part)
        self.plotter.add_actor(actor, name=name, reset_camera=False, pickable=False)
        self.plotter.subplot(0, MAIN)

    def _place(self, part, *sides):
        # At whole pixels: between them, letters are blurred.
        pixels = np.round(np.array(sides) * np.tile(self.size, 2))
        self.plotter.renderers[part].SetViewport(*(pixels / np.tile(self.size, 2)))

    def _histogram(self):
        import pyvista

        ratio = coverage(self.surfels, self.areas)[sharing.disks_of(self.surfels)]
        top = np.ceil(10 * ratio.max() - 1e-9) / 10 or 1.0
        count, edges = np.histogram(ratio, _BINS, (0.0, top))
        chart = pyvista.Chart2D()
        bars = chart.bar((edges[1:] + edges[:-1]) / 2, count, color=(0.35, 0.5, 0.65))
        bars.pen.style = None
        chart.x_range, chart.y_range = (0.0, top), (0.0, 1.05 * count.max())
        chart.border_color = "white"
        chart.x_label, chart.y_label = "area / disk area", "surfels"
        for axis in (chart.x_axis, chart.y_axis):
            # Odd: of letters 16 pixels high VTK smears the upper edge below them.
            axis.label_size = axis.tick_label_size = self.font | 1
            axis.GetTitleProperties().BoldOff()
        self.plotter.renderers[HISTOGRAM].add_chart(chart)
        return chart

    def _pictures(self, picked):
        """The picked surfel's own share over its disk, and who has the largest, turned as the view is."""
        import pyvista

        found = picked.shares
        rows, columns = found.shares.shape[1:]
        up = found.frame[:2] @ np.array(self.plotter.renderers[MAIN].camera.up)
        up = np.array([0.0, 1.0]) if np.linalg.norm(up) < 1e-3 else up / np.linalg.norm(up)
        rim = ring_around(self.surfels.radii[picked.index] / found.extent)
        for part, title in ((OWN, "its share"), (LEADERS, "largest share")):
            image = pyvista.ImageData(dimensions=(columns + 1, rows + 1, 1), origin=(-1, -1, 0))
            image.spacing = (2 / columns, 2 / rows, 1)
            if part == OWN:
                image.cell_data["share"] = found.shares[0].ravel()
                look = {"cmap": "viridis", "clim": (0, 1), "nan_color": "white"}
            else:
                image.cell_data["share"] = picked.leaders().reshape(-1, 3)
                look = {"rgb": True}
            actor = self.draw(part, image, "image", scalars="share", **look)
            self.draw(part, rim, "rim", color=(0.3, 0.3, 0.3), line_width=1)
            self.write(part, "title", title, (0.5, 0.97), top=True, centered=True)
            if part == OWN:
                self._drop_bar(_OWN_BAR)
                self._bar(OWN, _OWN_BAR, actor.mapper, labels=3, left=0.15, bottom=0.02, height=0.13, fmt="%.1f")
            renderer = self.plotter.renderers[part]
            view, center = renderer.camera, -0.1 * up
            view.parallel_projection, view.parallel_scale = True, 1.5
            view.position, view.focal_point, view.up = (*center, 5.0), (*center, 0.0), (*up, 0.0)
            renderer.ResetCameraClippingRange()

    def _bar(self, part, name, mapper, *, labels, left, bottom, height, fmt=None):
        self.plotter.subplot(0, part)
        bar = self.plotter.add_scalar_bar(
            title=name,
            mapper=mapper,
            n_labels=labels,
            fmt=fmt,
            label_font_size=self.font,
            unconstrained_font_size=True,
            position_x=left,
            position_y=bottom,
            width=1 - 2 * left,
            height=height,
            vertical=False,
            color="black",
        )
        bar.SetTitle("")  # it would stand among the labels
        self.plotter.subplot(0, MAIN)

    def _drop_bar(self, name):
        if name in self.plotter.scalar_bars:
            self.plotter.remove_scalar_bar(name)


def ring_around(radius):
    """A circle around the origin as a line, a little above the plane z = 0."""
    angle = 2 * np.pi * np.arange(128) / 128
    return closed_line(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(128, 0.01)]))


def closed_line(points):
    """pyvista.PolyData of one line through points (n, 3), from the last back to the first."""
    return polylines(np.concatenate([points, points[:1]])[None])
