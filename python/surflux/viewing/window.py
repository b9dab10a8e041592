"""The window in which surfels, scenes and solutions are looked at: what it shows, without the mouse and the keys."""

import numpy as np

from surflux._base import check
from surflux._base.color import white_of
from surflux.drawing import sharing
from surflux.drawing.clicks import sight_ray
from surflux.drawing.colors import Shown, label_digits, screen_bytes, trimmed_range
from surflux.drawing.glyphs import STYLES, Shape, polygons, rings, text_actor
from surflux.drawing.plots import look_through, seen_through
from surflux.pictures.camera import Camera, upright
from surflux.viewing.links import LinkFinder
from surflux.viewing.picks import PARTS, draw_links, draw_members
from surflux.viewing.properties import LIGHTS, names_of, property_of
from surflux.viewing.sky_behind import SkyBehind
from surflux.viewing.words import caption, values_of

INSERTED = (255, 140, 0)
_MARKS = 5  # of a scale
_LETTER = 0.55  # width of a digit, over the height of its font


class SceneView:
    """A view of a Subject.

    Args:
        subject: Subject.
        color: one of names_of(subject); None for radiosity, or reflectance where nothing is solved.
        style: "disks", "splats" or "points".
        light: "all", "direct" or "indirect".
        stops: of exposure; 0 shows the brightest percent as white.
        level: of the hierarchy whose groups "group" shows, 0 the finest.
        size: (width, height) in pixels.
        off_screen: True to draw without a window.

    Attributes:
        plotter: pyvista.Plotter.
        subject, color, style, light, stops, level: what is shown; set by the methods.
        picked: index of the picked surfel, or None. links: its Links, or None.
        centers: (n, 3) of the surfels around subject.origin(); extent: how far they reach from there.
    """

    def __init__(
        self,
        subject,
        *,
        color=None,
        style="disks",
        light="all",
        stops=0.0,
        level=0,
        size=(800, 600),
        off_screen=False,
    ):
        import pyvista

        names = names_of(subject)
        color = ("radiosity" if "radiosity" in names else "reflectance") if color is None else color
        self.subject, self.size = subject, size
        self.color, self.light = (
            check.choice("color", color, (*names, "emission")),
            check.choice("light", light, LIGHTS),
        )
        self.style = check.choice("style", style, STYLES)
        self.stops = check.number("stops", stops, -20.0, 20.0)
        self.level = check.count("level", level, 0)
        self.picked = self.links = None
        self.zeta, self.culling, self.marked = None, True, False
        self.note = ""  # what the last solving came to
        self._kept, self._left = None, 0.9
        self.plotter = pyvista.Plotter(off_screen=off_screen, window_size=size)
        self.plotter.set_background("white")
        self.font = max(6, round(min(size[1] / 46, size[0] / 62)))
        self._sky = SkyBehind(self)
        self._take(subject)
        self.redraw()

    def redraw(self):
        """Draws the surfels anew, as everything says now."""
        shown = self.shown()
        look, title = {"rgb": True}, shown.name
        if shown.kind == "number":
            low, high, trimmed = trimmed_range(shown.values)
            look = {"cmap": "viridis", "clim": (low, high), "nan_color": "lightgrey"}
            if trimmed:
                title += "\n(1st to 99th\npercentile)"
        mesh = self._shape.mesh
        (mesh.point_data if self._shape.by_point else mesh.cell_data)["shown"] = self.spread(shown)
        if self.style == "points":
            look |= {"style": "points", "point_size": max(2.0, min(8.0, self.size[1] / 150))}
        elif self.culling:
            look |= {"culling": "back"}
        preference = "point" if self._shape.by_point else "cell"
        self._bar(None)
        actor = self.draw("surfels", mesh, scalars="shown", preference=preference, **look)
        self._bar(actor.mapper if shown.kind == "number" else None, title)
        self.draw_sky()
        self.describe(shown)

    def draw_sky(self):
        """Shows the sky behind what leaves surfaces, as pictures do; what is not seen so stands before white."""
        solution = self.subject.solution
        seen = solution is not None and self.color == "radiosity" and self.light != "indirect"
        environments = solution._environments if seen else []
        self._sky.show(environments, np.pi * 2.0**self.stops / self.white() if environments else 1.0)

    def spread(self, shown):
        """Numbers, or bytes of colours, of the parts of the mesh that stands for the surfels."""
        if shown.kind == "number":
            return self._shape.spread(shown.values)
        if self.style == "splats" and shown.kind in ("light", "surface"):  # linear ones run into each other
            return screen_bytes(self._blended(shown), 2.0**self.stops, self._white(shown))
        return self._shape.spread(screen_bytes(shown, 2.0**self.stops, self._white(shown))).astype(np.uint8)

    def describe(self, shown):
        """Writes what is shown."""
        self.write("caption", caption(self, shown), (0.985, 0.985), top=True, right=True)

    def shown(self):
        """The Shown of the colour that is chosen."""
        groups = None
        if self.color == "group":
            levels = self.subject.tree().levels
            groups = levels[min(self.level, len(levels) - 1)]
        return property_of(self.subject, self.color, self.light, groups)

    def white(self):
        """What is shown as white at 0 stops, whatever part of the light is on."""
        return white_of(self.whole().values)

    def whole(self):
        """The Shown of the colour that is chosen, in all light, whatever part of it is on."""
        return property_of(self.subject, self.color)

    def _white(self, shown):
        return self.white() if shown.kind == "light" else None

    def _blended(self, shown):
        """A Shown at the points of the shape; kept, for only the exposure may change."""
        key = (self._shape, self.color, self.light)
        if self._kept is None or self._kept[0] != key:
            self._kept = key, Shown(shown.name, shown.kind, shown.title, self._shape.spread(np.asarray(shown.values)))
        return self._kept[1]

    def set_color(self, color):
        self.color = check.choice("color", color, names_of(self.subject))
        self.redraw()

    def next_color(self, step=1):
        names = names_of(self.subject)
        place = names.index(self.color) + step if self.color in names else 0
        self.set_color(names[place % len(names)])

    def set_style(self, style):
        self.style = check.choice("style", style, STYLES)
        self._shape = shape_of(self.subject, style)
        self.plotter.remove_actor("surfels", render=False)
        self.redraw()

    def set_light(self, light):
        """Which light radiosity and irradiance show."""
        self.light = check.choice("light", light, LIGHTS)
        if self.subject.solution is not None and self.color not in ("radiosity", "irradiance"):
            self.color = "radiosity"
        self.redraw()

    def set_exposure(self, stops):
        self.stops = float(stops)
        self.redraw()

    def set_level(self, level):
        """Shows the groups of that level of the hierarchy (D03 fig. 6b)."""
        self.level, self.color = int(np.clip(level, 0, len(self.subject.tree()) - 1)), "group"
        self.redraw()

    def show_backs(self, backs):
        """Draws both sides of everything, or the fronts alone, as light sees them."""
        self.culling = not backs
        self.plotter.remove_actor("surfels", render=False)
        self.redraw()

    def mark_inserted(self, marked):
        """Marks the surfels that were inserted with an orange disk each."""
        self.marked = marked
        self.plotter.remove_actor("inserted", render=False)
        there = np.flatnonzero(self.subject.inserted()) if marked else []
        if len(there):
            s = self.subject.surfels
            place = self.centers[there] + 0.05 * s.radii[there, None] * s.normals[there]
            dots = polygons(rings(place, s.normals[there], 0.25 * s.radii[there], 8))
            self.draw("inserted", dots, color=INSERTED, culling="back")

    def solve_again(self, zeta, progress=True):
        """Solves the scene with another zeta and shows that; takes as long as solving takes.

        What the new solution has nothing of, such as levels where nothing was inserted, gives way to radiosity.
        """
        from surflux.solving.radiosity import solve

        solution = solve(self.subject.scene, zeta=zeta, progress=progress)
        solution.camera = self.subject.camera
        seconds = sum(solution.timings.values())
        self.zeta, self.note = zeta, f"solved with zeta {zeta:.3g} in {seconds:.2g} s"
        marked, camera = self.marked, self.camera()
        self.pick(None)
        self.mark_inserted(False)
        self._take(self.subject.solved_again(solution))
        if self.color not in (*names_of(self.subject), "emission"):
            self.note += f"\nthat has no {self.color}: radiosity is shown"
            self.color = "radiosity"
        self.plotter.remove_actor("surfels", render=False)
        self.redraw()
        self.frame(camera)  # inserted surfels may have moved the origin
        self.mark_inserted(marked)

    def can_solve(self):
        """Whether another zeta can be tried: the scene is there, and was solved with a cut."""
        solution = self.subject.solution
        return self.subject.scene is not None and solution is not None and solution.cut is not None

    # --- one surfel

    def pick(self, index):
        """Shows the values of a surfel, its neighbours and where its light comes from; None shows no more of that."""
        for name in PARTS:
            self.plotter.remove_actor(name, render=False)
        self._link_bar(None)
        self.picked, self.links = index, None
        if index is None:
            self.write("values", "", (0.015, 0.985), top=True)
            return
        picked = sharing.pick(self.subject.surfels, index, "curved")
        if self.subject.solution is not None:
            self.links = self._find_links(index)
            self._link_bar(draw_links(self, self.links))
        draw_members(self, picked)
        self.write(
            "values", "\n".join(values_of(self.subject, picked, self.links)), (0.015, 0.985), top=True, fixed=True
        )

    def pick_at(self, x, y):
        """Picks what is seen at pixel (x, y), counted from the lower left corner; where nothing is, nothing."""
        start, direction = sight_ray(self.plotter.renderer, x, y)
        self.pick(sharing.surfel_under(self.subject.surfels, start + self.subject.origin(), direction))

    # --- the camera

    def frame(self, camera=None):
        """Looks through a Camera; None for the one that comes with what is shown, or one that has all in view."""
        camera = self.subject.framed(self.size) if camera is None else camera
        look_through(self.plotter.camera, camera, self.subject.origin())
        self.plotter.renderer.ResetCameraClippingRange()

    def camera(self):
        """The Camera that the window looks through."""
        return seen_through(self.plotter.camera, self.subject.origin())

    def fly_to_picked(self):
        """Looks at the picked surfel from its front."""
        if self.picked is None:
            return
        s, i = self.subject.surfels, self.picked
        n, view = s.normals[i], self.plotter.camera
        self.frame(Camera(s.points[i] + 12 * s.radii[i] * n, s.points[i], upright(view.up, n), view.view_angle))

    # --- what all of it is made with

    def write(self, name, text, place, *, top=False, right=False, fixed=False, grey=0.0):
        """Text at a place of the window, in fractions of it, in place of what had that name."""
        self.plotter.remove_actor(name, render=False)
        if not text:
            return
        actor = text_actor(text, self.font, place, side="right" if right else "left", top=top, fixed=fixed, grey=grey)
        self.plotter.add_actor(actor, name=name, reset_camera=False, pickable=False)

    def _take(self, subject):
        self.subject = subject
        self._shape = shape_of(subject, self.style)
        self.centers = subject.surfels.points - subject.origin()
        self.extent = float(np.max(np.linalg.norm(self.centers, axis=1) + subject.surfels.radii))
        self._find_links = LinkFinder(subject)
        self._draw_lamps()

    def _draw_lamps(self):
        if self.subject.lamps:
            self.draw("lamps", polygons(self.subject.lamp_quads()), color="white", culling="back")
        else:
            self.plotter.remove_actor("lamps", render=False)

    def draw(self, name, mesh, **look):
        """Adds a mesh in place of what had that name; the actor."""
        fixed = {"lighting": False, "show_scalar_bar": False, "reset_camera": False, "pickable": False}
        return self.plotter.add_mesh(mesh, name=name, **fixed, **look)

    def _bar(self, mapper, title=""):
        labels = [] if mapper is None else [_label(mapper) % x for x in np.linspace(*mapper.scalar_range, _MARKS)]
        # Beside the bar itself there is room for labels of this length, and no more.
        longest = max(map(len, labels), default=0) * _LETTER * self.font / self.size[0]
        self._left = min(0.9, 0.95 - longest)
        self._scale("colours", mapper, title, self._left)

    def _link_bar(self, mapper):
        self._scale("links", mapper, "link, %", self._left - 0.1)

    def _scale(self, name, mapper, title, left):
        if name in self.plotter.scalar_bars:
            self.plotter.remove_scalar_bar(name)
        if mapper is None:
            return
        bar = self.plotter.add_scalar_bar(
            title=name,
            mapper=mapper,
            n_labels=_MARKS,
            vertical=True,
            position_x=left,
            position_y=0.3,
            width=0.08,
            height=0.4,
            label_font_size=self.font,
            title_font_size=self.font,
            unconstrained_font_size=True,
            color="black",
            fmt=_label(mapper),
        )
        bar.SetTitle(title)
        bar.DrawBackgroundOn()
        bar.GetBackgroundProperty().SetColor(1.0, 1.0, 1.0)
        bar.GetBackgroundProperty().SetOpacity(0.8)
        bar.SetVerticalTitleSeparation(self.font)


def _label(mapper):
    """The format of the labels of a scale."""
    return f"%.{label_digits(*mapper.scalar_range, _MARKS - 1)}g"


def shape_of(subject, style):
    """The Shape of a Subject."""
    return Shape(subject.surfels, style, subject.origin(), *subject.drawn())
