"""Looking at effective areas: disks in colours, a histogram, and who shares the disk of a picked surfel."""

import numpy as np

from surflux._base import check
from surflux.drawing import sharing
from surflux.drawing.area_panel import MAIN, Panel, closed_line
from surflux.drawing.clicks import sight_ray, take_mouse
from surflux.drawing.colors import screen_bytes, surface_property, trimmed_range
from surflux.drawing.glyphs import cones, disk_corners, polygons, rings
from surflux.drawing.plots import (
    camera_or_none,
    destination,
    in_a_cell,
    in_notebook,
    look_through,
    quiet_vtk,
    window_size,
)
from surflux.geometry.areas import METHODS, effective_areas
from surflux.pictures.camera import facing

COLORS = {"c": "coverage", "a": "area", "d": "radius", "n": "normal"}  # by key: VTK itself takes r
# Shorter than of a view: the range of the colours stands behind them.
TITLES = {"area": "effective area", "radius": "disk radius"}
KEYS = "click or p: pick   f: fly there\n" + "   ".join(f"{key}: {color}" for key, color in COLORS.items())
_LEAST = 0.015  # part of the disk that is worth a number


def plot_areas(
    s,
    pick=None,
    *,
    color="coverage",
    method=None,
    threads=None,
    progress=False,
    screenshot=None,
    camera=None,
    up=None,
    size=(800, 600),
):
    """See Surfels.plot_areas.

    >>> import surflux as sf
    >>> s = sf.Surfels([[x, y, 0] for y in range(9) for x in range(9)], normals=[[0, 0, 1]] * 81)
    >>> s.plot_areas(pick=40, screenshot="areas.png", size=(400, 300)).name
    'areas.png'
    """
    size = window_size(size)
    check.some_surfels("surfels", s)
    check.choice("color", color, tuple(COLORS.values()))
    if method is not None:
        check.choice("method", method, METHODS)
    if pick is not None:
        pick = check.count("pick", pick, 0, len(s) - 1)
    camera_or_none(camera)
    if screenshot is None and in_notebook():
        more = {"threads": threads, "progress": progress, "camera": camera, "up": up, "size": size}
        return in_a_cell(plot_areas, s, pick, color=color, method=method, **more)
    path = destination(screenshot)
    areas = s.areas if method is None else None
    method = method or "curved"
    if areas is None:
        areas = effective_areas(s, method=method, threads=threads, progress=progress)
    with quiet_vtk():
        view = AreaView(s, areas, method, size, off_screen=path is not None)
        try:
            view.show_color(color)
            view.pick(pick)
            view.frame(camera, (0.0, 0.0, 1.0) if up is None else check.direction("up", up))
            if path is None:
                view.listen()
                view.plotter.show()
            else:
                view.plotter.screenshot(path)
        finally:
            view.plotter.close()
    return path


class AreaView:
    """The window of plot_areas.

    Args:
        s: Surfels.
        areas: (n,) of theirs, in the square of the unit of the points.
        method: how the shares of a picked surfel are made, as effective_areas takes it.
        size: (width, height) in pixels.
        off_screen: True to draw without a window.
    """

    def __init__(self, s, areas, method, size, off_screen):
        self.surfels, self.areas, self.method = s, areas, method
        self.picked = None
        # As in viewer.plot: around the origin single precision serves survey coordinates too.
        self.origin = (s.points.min(axis=0) + s.points.max(axis=0)) / 2
        self._centers = s.points - self.origin
        self._mesh = self._cones(np.arange(len(s)))
        self._panel = Panel(s, areas, size, off_screen)
        self.plotter = self._panel.plotter
        self._renderer = self.plotter.renderers[MAIN]
        self._close_up = None
        self._up = np.array([0.0, 0.0, 1.0])
        self._renderer.AddObserver("ResetCameraClippingRangeEvent", self._cut)

    def show_color(self, color):
        """Colours the disks by "coverage", "area", "radius" or "normal"."""
        shown = surface_property(self.surfels, color, {"area": self.areas})
        is_number, value = shown.kind == "number", shown.values
        title, look = TITLES.get(color, shown.title), {"rgb": True}
        if is_number:
            disks = sharing.disks_of(self.surfels)
            if color == "coverage" and len(disks) < len(value):
                title, value = f"{title}, patches grey", np.where(np.isin(np.arange(len(value)), disks), value, np.nan)
            low, high, trimmed = trimmed_range(value)
            if trimmed:
                title = f"{title} (colours: 1st to 99th percentile)"
            look = {"cmap": "viridis", "clim": (low, high), "nan_color": "lightgrey"}
        else:
            value = screen_bytes(shown)
        self._mesh.cell_data["shown"] = value[self._mesh.cell_data["surfel"]]
        actor = self._panel.draw(MAIN, self._mesh, "surfels", scalars="shown", culling="back", **look)
        self._panel.show_scale(title, actor.mapper if is_number else None)

    def frame(self, camera, up=(0.0, 0.0, 1.0)):
        """Looks through camera; without one, at the picked surfel, or at everything, with `up` up where it can be."""
        self._up = np.array(up)
        view = self._renderer.camera
        if camera is None and self.picked is not None:
            self.fly_to_picked()
        elif camera is None:
            mean = self.surfels.normals.mean(axis=0)
            # A sheet is looked at from its front, for from behind nothing is drawn.
            aside = np.roll(self._up, 1) - self._up * np.dot(np.roll(self._up, 1), self._up)
            towards = mean if np.linalg.norm(mean) > 0.5 else self._up + aside + np.cross(self._up, aside)
            reach = np.max(np.linalg.norm(self._centers, axis=1) + self.surfels.radii)
            self._look(np.zeros(3), towards / np.linalg.norm(towards), reach)
        else:
            look_through(view, camera, self.origin)
            self._renderer.ResetCameraClippingRange()
            self._panel.show(self.picked)

    def fly_to_picked(self):
        """Looks at the picked surfel from its front, so close that its neighbours fill much of the picture."""
        if self.picked is None:
            return
        index, radii = self.picked.index, self.surfels.radii
        center, members = self._centers[index], self.picked.members
        reach = np.max(np.linalg.norm(self._centers[members] - center, axis=1) + radii[members])
        reach = max(reach, 3 * radii[index])
        self._close_up = (center, reach)
        self._look(center, self.surfels.normals[index], 1.5 * reach)
        self._panel.show(self.picked)

    def pick(self, index):
        """Shows who shares the disk of surfel `index`; None shows all surfels together."""
        for name in ("members", "dot", "rim", "labels"):
            self._renderer.remove_actor(name, render=False)
        self.picked = None if index is None else sharing.pick(self.surfels, index, self.method)
        if self.picked is not None:
            self._highlight()
        self._panel.show(self.picked)

    def pick_at(self, x, y):
        """Picks what is seen at pixel (x, y), counted from the lower left corner; where nothing is, nothing."""
        start, direction = sight_ray(self._renderer, x, y)
        self.pick(sharing.surfel_under(self.surfels, start + self.origin, direction))

    def listen(self):
        """Takes keys and clicks from now on, and says which."""
        self._panel.write(MAIN, "keys", KEYS, (0.02, 0.98), top=True, grey=0.35)
        for key, color in COLORS.items():
            self.plotter.add_key_event(key, lambda color=color: (self.show_color(color), self.plotter.render()))
        self.plotter.add_key_event("p", self._pick_under_mouse)
        self.plotter.add_key_event("f", lambda: (self.fly_to_picked(), self.plotter.render()))
        take_mouse(self.plotter, self._clicked, self._renderer)

    def _clicked(self, x, y):
        self.pick_at(x, y)
        self.plotter.render()

    def _pick_under_mouse(self):
        at = self.plotter.iren.get_event_position()
        if self._renderer.IsInViewport(*at):
            self._clicked(*at)

    def _look(self, target, towards, reach):
        """Looks at target from the direction towards, so far away that a ball of radius reach is in view."""
        view = self._renderer.camera
        camera = facing(target, towards, reach, self._up, view.view_angle, self._renderer.GetSize())
        look_through(view, camera, np.zeros(3))
        self._renderer.ResetCameraClippingRange()

    def _cut(self, *_):
        """As long as the view turns around the surfel that it flew to, what stands before that is cut away."""
        if self._close_up is None:
            return
        target, reach = self._close_up
        view = self._renderer.camera
        if np.linalg.norm(np.subtract(view.focal_point, target)) < 1e-3 * reach:
            near, far = view.clipping_range
            view.clipping_range = (max(near, view.distance - reach), far)

    def _cones(self, members, lift=0.0):
        """The surfels as shallow cones, whose tips stand where the disks do: each is seen where it is the nearest.

        Flat disks overlap, and would hide each other at random. Patches are drawn as they are. Cell array "surfel" is
        the place in members of the surfel that a cell belongs to. lift: how far to stand out, in radii.
        """
        s = self.surfels
        out = lift * s.radii[members, None] * s.normals[members]
        place = np.full(len(s), -1)
        place[members] = np.arange(len(members))
        ours = place[s.triangle_surfel] >= 0
        patch = place[s.triangle_surfel][ours]
        flat = (s.triangles - self.origin)[ours] + out[patch][:, None]
        disk = np.setdiff1d(np.arange(len(members)), patch)
        tips = (self._centers[members] + out)[disk]
        mesh = cones(tips, s.normals[members][disk], s.radii[members][disk], flat)
        mesh.cell_data["surfel"] = np.concatenate([np.repeat(disk, disk_corners(len(disk))), patch])
        return mesh

    def _highlight(self):
        """The picked surfel and its neighbours in their colours, the parts of its disk that fall to them, its rim."""
        picked, s = self.picked, self.surfels
        members = picked.members
        mesh = self._cones(members, lift=0.02)
        mesh.cell_data["color"] = picked.colors[mesh.cell_data["surfel"]]
        self._panel.draw(MAIN, mesh, "members", scalars="color", rgb=True, culling="back")
        if picked.shares is None:
            return
        center, n, r = self._centers[members], s.normals[members], s.radii[members]
        dot, rim = (rings(center[:1], n[:1], size * r[:1], 64)[0] for size in (0.1, 1.0))
        self._panel.draw(MAIN, polygons(self._risen(dot)[None]), "dot", color=sharing.PICKED)
        line = closed_line(self._risen(rim))
        self._panel.draw(MAIN, line, "rim", color=sharing.PICKED, line_width=self._panel.line)
        named = np.flatnonzero((picked.parts >= _LEAST) & (np.arange(len(members)) > 0))
        if len(named):
            self.plotter.add_point_labels(
                center[named] + 0.1 * r[0] * n[named],
                [f"{100 * part:.0f}%" for part in picked.parts[named]],
                font_size=self._panel.font,
                text_color="black",
                shape=None,
                show_points=False,
                always_visible=True,
                justification_horizontal="center",
                justification_vertical="center",
                reset_camera=False,
                pickable=False,
                name="labels",
            )

    def _risen(self, points):
        """Points of the picked surfel's disk, on top of the disks of neighbours that stand above them there."""
        members = self.picked.members
        center, n, r = self._centers[members], self.surfels.normals[members], self.surfels.radii[members]
        away = points[:, None] - center
        above = -np.einsum("ijk,jk->ij", away, n) / (n @ n[0])
        over = np.linalg.norm(away + above[..., None] * n[0], axis=2) <= r
        rise = np.max(np.where(over, above, 0.0), axis=1, initial=0.0) + 0.05 * r[0]
        return points + rise[:, None] * n[0]
