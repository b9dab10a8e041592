"""What picking a surfel shows, judged by the pixels, and what a mouse and keys do."""

import numpy as np
import pytest

import surflux as sf
from area_pictures import (
    ABOVE,
    BRIGHT,
    DARK,
    DOWN,
    PICKED,
    UNIT,
    at,
    grid,
    is_color,
    pair,
    part,
    picture,
    share_at,
)
from interactor import click_pixel, press
from surflux.drawing import area_window, plots, sharing


def test_a_picked_surfel_and_its_neighbours_have_their_colours(tmp_path):
    s = grid()
    picked = sharing.pick(s, 24, "curved")
    image = picture(tmp_path, s, 24)
    assert at(image, 0, 0) == PICKED
    place = dict(zip(picked.members.tolist(), picked.colors.tolist(), strict=True))
    assert place[24] == PICKED
    for index in (23, 25, 17, 31, 16, 18, 30, 32):  # the ring around it, above the numbers
        x, y, _ = s.points[index]
        assert at(image, x, y + 0.13) == pytest.approx(place[index], abs=2)
    before = picture(tmp_path, s)
    assert at(before, 0, 0) not in (PICKED, [255, 255, 255])
    assert at(image, -1.2, -1.2) == at(before, -1.2, -1.2)  # a surfel that shares nothing of it
    # The rim of its disk, between the directions of the numbers.
    a = np.radians(22.5)
    rim = part(image, "main")[round(263.5 - UNIT * 0.6 * np.sin(a)) - 3 :][:7]
    assert is_color(rim[:, round(247.5 + UNIT * 0.6 * np.cos(a)) - 6 :][:, :12], PICKED).any()


def test_numbers_of_the_neighbours_are_written(tmp_path):
    image, plain = picture(tmp_path, grid(), 24), picture(tmp_path, grid())
    box = (slice(255, 272), slice(round(247.5 + 0.4 * UNIT) - 15, round(247.5 + 0.4 * UNIT) + 15))
    assert (image[box].max(axis=2) < 60).sum() > 20
    assert (plain[box].max(axis=2) < 60).sum() == 0


@pytest.mark.parametrize("up", [(0, 1, 0), (1, 0, 0), (0.6, -0.8, 0)])
def test_the_pictures_of_a_picked_surfel(tmp_path, up):
    from matplotlib import colormaps

    s = grid()
    picked = sharing.pick(s, 24, "curved")
    color = dict(zip(picked.members.tolist(), picked.colors.tolist(), strict=True))
    xi = picked.shares.shares[0]
    image = picture(tmp_path, s, 24, view=ABOVE | {"up": up})
    viridis = np.array(colormaps["viridis"](xi[15:17, 15:17].mean())[:3]) * 255
    assert share_at(image, "own", 0, 0) == pytest.approx(viridis, abs=6)
    assert share_at(image, "leaders", 0, 0) == PICKED
    # A step towards each neighbour, as the view is turned: there the neighbour leads.
    up, right = np.array(up), np.cross(up, [0, 0, 1])
    for index in (23, 25, 17, 31):
        step = (s.points[index] - s.points[24]) / picked.shares.extent
        assert share_at(image, "leaders", step @ right, step @ up) == pytest.approx(color[index], abs=2)
        seen = share_at(image, "own", step @ right, step @ up)
        assert sum(seen[:2]) < sum(viridis[:2]) - 30  # less of it there
    assert share_at(image, "own", 1.15, 0) == [255, 255, 255]
    assert share_at(image, "leaders", 0.75, 0.75) == [255, 255, 255]


def test_shares_are_parts_of_one():
    s = grid()
    picked = sharing.pick(s, 24, "paper")
    assert picked.members[0] == 24
    assert picked.parts.sum() == pytest.approx(1.0)
    assert picked.parts[0] == picked.parts.max()
    ring = [picked.parts[picked.members == i].item() for i in (23, 25, 17, 31)]
    assert ring == pytest.approx([ring[0]] * 4, rel=1e-6)


def test_without_a_camera_a_picked_surfel_is_looked_at_through_all_that_covers_it(tmp_path):
    low = np.array([[x, y, 0.0] for x in range(9) for y in range(9)])
    s = sf.Surfels(np.vstack([low, np.add(low, [0, 0, 6])]), [DOWN] * 162, radii=1.3)
    image = picture(tmp_path, s, 40, view=None)
    assert image[263, 247].tolist() == PICKED
    assert image[263, 127].tolist() not in (PICKED, [255, 255, 255])


def test_patches_have_their_exact_area_and_share_nothing(tmp_path):
    s = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), patch_area=1.0)
    index = int(np.argmax(s.points @ [1, 1, 0]))
    image = picture(tmp_path, s, index, color="normal")
    red = is_color(part(image, "main"), PICKED)
    assert red.sum() == pytest.approx(UNIT**2, rel=0.05)
    assert at(image, 0.95, 0.05) == PICKED
    assert at(image, -0.5, 0.5) == pytest.approx([128, 128, 255], abs=1)
    for which in ("own", "leaders"):
        assert not is_color(part(image, which), DARK).any()
    words = sharing.words(s, s.areas, sharing.pick(s, index, "curved"))
    assert words[1] == "a patch of a mesh: exact area"
    assert words[3] == "area         1"
    assert "4 of them patches, exact" in sharing.summary(s, s.areas)


def test_among_patches_the_disks_have_the_colours(tmp_path):
    disks = pair(areas=[0.2 * np.pi * 0.25, 0.6 * np.pi * 0.64])
    corners = [[-1.9, -1.9, -1], [1.9, -1.9, -1], [1.9, 1.9, -1], [-1.9, 1.9, -1]]
    patches = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3]]), patch_area=0.1)
    s = sf.Scene([disks, patches]).surfels
    s.areas = np.concatenate([disks.areas, patches.areas])
    image = picture(tmp_path, s)
    assert at(image, -1, 0) == pytest.approx(DARK, abs=3)
    assert at(image, 1, 0) == pytest.approx(BRIGHT, abs=3)
    assert at(image, 0, 1.2) == [211] * 3
    assert at(picture(tmp_path, s, color="area"), 0, 1.2) == pytest.approx(DARK, abs=3)
    assert sharing.summary(s, s.areas)[-3:] == ["  median     0.4000", "  from       0.2000", "  to         0.6000"]
    assert not is_color(part(picture(tmp_path, s, 5), "tall histogram"), PICKED).any()


def test_a_picked_surfel_is_marked_under_its_neighbours_too(tmp_path):
    """One that lies a little deeper than those around it, as in a noisy scan."""
    s = grid()
    points = np.array(s.points)
    points[24, 2] -= 0.3
    image = picture(tmp_path, sf.Surfels(points, s.normals, radii=s.radii), 24)
    assert at(image, 0, 0) == PICKED


def test_a_surfel_alone_keeps_its_disk(tmp_path):
    s = sf.Surfels([[0, 0, 0]], [DOWN], radii=1.0)
    image = picture(tmp_path, s, 0)
    assert at(image, 0.5, 0) == PICKED
    for x in (-0.8, 0, 0.8):
        assert share_at(image, "own", x, 0) == pytest.approx(BRIGHT, abs=3)
        assert share_at(image, "leaders", x, 0) == PICKED


def test_the_words():
    s = sf.Surfels([[5.1e6, 4.3e5, 800.25], [5.1e6 + 0.4, 4.3e5, 800.25]], [DOWN] * 2, radii=0.5, areas=[0.5, 0.25])
    words = sharing.words(s, s.areas, sharing.pick(s, 1, "curved"))
    assert words == [
        "surfel 1",
        "disk shared with 1 neighbour",
        "",
        "area         0.25",
        "radius R     0.5",
        "area/disk    0.3183",
        "keeps 75% of its disk",
        "",
        "          position     normal",
        "x     5100000.4000     0.0000",
        "y      430000.0000     0.0000",
        "z         800.2500     1.0000",
    ]
    assert sharing.summary(s, s.areas)[2:5] == ["total area   0.75", "smallest     0.25", "largest      0.5"]
    assert sharing.summary(s, s.areas)[-3:] == ["  median     0.4775", "  from       0.3183", "  to         0.6366"]


def test_the_words_are_written(tmp_path):
    assert (part(picture(tmp_path, grid(), 24), "words").max(axis=2) < 100).sum() > 500
    assert (part(picture(tmp_path, grid()), "words").max(axis=2) < 100).sum() > 500


def test_colours_of_neighbours_tell_them_apart():
    angle = np.linspace(0, 6, 30)
    colors = sharing.colors_around(np.vstack([[0, 0], np.column_stack([np.cos(angle), np.sin(angle)])])).astype(int)
    apart = np.abs(colors[:, None] - colors).max(axis=2) + 255 * np.eye(31, dtype=int)
    assert apart.min() > 5
    assert apart[0].min() > 60
    assert np.abs(np.diff(colors[1:], axis=0)).max(axis=1).min() > 60  # side by side


@pytest.fixture
def window(monkeypatch):
    """A view that listens, without a window."""
    views = []

    def make(s, **camera):
        with plots.quiet_vtk():
            areas = sf.effective_areas(s) if s.areas is None else s.areas
            view = area_window.AreaView(s, areas, "curved", (800, 600), off_screen=True)
            views.append(view)
            view.show_color("coverage")
            view.frame(sf.Camera(**(ABOVE | camera)))
            view.listen()
        return view

    yield make
    for view in views:
        view.plotter.close()


def seen(view):
    with plots.quiet_vtk():
        return view.plotter.screenshot(return_img=True).astype(int)


def click(view, x, y, drag=0):
    click_pixel(view, round(247.5 + UNIT * x), round(600 - 1 - (263.5 - UNIT * y)), drag)


@pytest.mark.slow
def test_a_click_picks_and_a_drag_turns(window):
    view = window(grid())
    seen(view)
    click(view, 0.4, 0.05)
    assert view.picked.index == 25
    assert at(seen(view), 0.4, 0.05) == PICKED
    click(view, 1.75, 1.7)
    assert view.picked is None
    assert not is_color(seen(view), PICKED).any()
    click(view, 0, 0)
    assert view.picked.index == 24
    before = view.plotter.camera.position
    click(view, -0.8, 0, drag=40)
    assert view.picked.index == 24
    assert view.plotter.camera.position != pytest.approx(before, abs=0.01)


def test_clicks_and_drags_beside_the_surfels_change_nothing(window):
    view = window(grid())
    view.pick(24)
    before = seen(view)
    for drag in (0, 40):
        click(view, 2.46, 0, drag)  # on the picture of its share
        assert view.picked.index == 24
        assert (seen(view) == before).all()


@pytest.mark.slow
def test_a_pick_taken_back_leaves_nothing(window):
    view = window(grid())
    before = seen(view)
    view.pick(24)
    assert (seen(view) != before).any()
    view.pick(None)
    assert (seen(view) == before).all()


@pytest.mark.slow
def test_keys(window):
    s = pair(areas=[0.5 * np.pi * 0.25, 0.3 * np.pi * 0.64])
    view = window(s)
    assert at(seen(view), 1, 0) == pytest.approx(DARK, abs=3)
    for key, color in (("d", BRIGHT), ("n", [128, 128, 255]), ("a", BRIGHT), ("c", DARK)):
        press(view, key)
        assert at(seen(view), 1, 0) == pytest.approx(color, abs=3), key
    view.plotter.iren.interactor.SetEventInformation(round(247.5 - UNIT), 599 - 264, 0, 0, "\0", 0, None)
    press(view, "p")
    assert view.picked.index == 0
    press(view, "f")
    assert seen(view)[263, 247].tolist() == PICKED
    grey = (np.abs(seen(view)[:45, :300] - 89).max(axis=2) < 25).sum()
    assert grey > 100  # what the keys are for
    assert all(f"{key}: {color}" in area_window.KEYS for key, color in area_window.COLORS.items())


def test_which_surfel_a_ray_meets():
    s = sf.Surfels([[0, 0, 0], [0.5, 0, 0], [0, 0, -2]], [DOWN] * 3, radii=1.0)
    down = np.array([0.0, 0, -1])
    assert sharing.surfel_under(s, np.array([0.1, 0, 5]), down) == 0
    assert sharing.surfel_under(s, np.array([0.4, 0, 5]), 7 * down) == 1
    assert sharing.surfel_under(s, np.array([-0.9, 0, -1]), down) == 2
    assert sharing.surfel_under(s, np.array([3.0, 0, 5]), down) is None
    assert sharing.surfel_under(s, np.array([0.0, 0, -5]), -down) is None  # from behind
    assert sharing.surfel_under(s, np.array([0.0, 0, -3]), down) is None  # behind the eye
    mesh = sf.Surfels.from_mesh(([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), patch_area=1.0)
    for i, point in enumerate(mesh.points):
        assert sharing.surfel_under(mesh, np.add(point, [0.1, 0.2, 1]), down) == i
        assert sharing.surfel_under(mesh, point - [0, 0, 1], -down) is None
    assert sharing.surfel_under(mesh, np.array([1.1, 0, 1]), down) is None  # beside it, within its disks
