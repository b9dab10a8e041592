"""What a window draws for a picked surfel: itself, its neighbours, and links to where its light comes from."""

import numpy as np

from surflux.drawing import sharing
from surflux.drawing.glyphs import polygons, polylines, rings

LINKS = 24  # drawn
PARTS = ("members", "rims", "links", "shares-labels", "shares-points")  # names of what is drawn
_NAMED = 5  # links with a number
_WIDEST = 0.006  # over the extent


def draw_members(view, picked):
    """A sharing.Picked: the surfel in its colour, and the rims of those that share its disk in theirs."""
    s, centers = view.subject.surfels, view.centers
    i, members = picked.index, picked.members
    lift = 0.03 * s.radii[i] * s.normals[i]
    flat = s.triangles[s.triangle_surfel == i] - view.subject.origin()
    if len(flat):
        view.draw("members", polygons(flat + lift), color=sharing.PICKED)
        return
    disk = rings(centers[i : i + 1], s.normals[i : i + 1], 0.5 * s.radii[i : i + 1], 32) + lift
    view.draw("members", polygons(disk), color=sharing.PICKED)
    around = rings(centers[members], s.normals[members], s.radii[members], 32) + lift
    lines = polylines(np.concatenate([around, around[:, :1]], axis=1))
    lines.cell_data["color"] = picked.colors
    view.draw("rims", lines, scalars="color", rgb=True, line_width=max(2.0, view.font / 6))


def draw_links(view, links):
    """The strongest Links, as wide as the root of their share and coloured by it; the mapper of that, or None."""
    count = min(LINKS, len(links.shares))
    if not count:
        return None
    s, i, origin = view.subject.surfels, links.index, view.subject.origin()
    start = links.start + 0.1 * s.radii[i] * s.normals[i] - origin
    ends, share = links.ends[:count] - origin, links.shares[:count]
    lines = polylines(np.stack([np.broadcast_to(start, ends.shape), ends], axis=1))
    width = _WIDEST * view.extent * np.sqrt(share / share.max())
    lines.point_data["width"] = np.repeat(width, 2)
    tubes = lines.tube(scalars="width", absolute=True, n_sides=8)
    # Of the same width is the same share.
    tubes.point_data["percent"] = 100 * share.max() * (tubes.point_data["width"] / width.max()) ** 2
    actor = view.draw("links", tubes, scalars="percent", cmap="plasma", clim=(0.0, 100 * float(share.max())))
    named = slice(0, min(_NAMED, count))
    view.plotter.add_point_labels(
        ends[named],
        [f"{100 * v:.1f}%" for v in share[named]],
        font_size=view.font,
        text_color="black",
        shape_color="white",
        shape_opacity=0.6,
        show_points=False,
        always_visible=True,
        reset_camera=False,
        pickable=False,
        name="shares",
    )
    return actor.mapper
