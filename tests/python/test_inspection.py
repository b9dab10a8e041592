"""What the view of areas shows, judged by the pixels."""

import numpy as np
import pytest

import surflux as sf
from surflux import inspection, inspection_panel, sharing, viewer

# Of a picture of 800 x 600 the surfels take 496 x 528 pixels. Looking down, 132 of them make one unit at z = 0.
ABOVE = {"eye": (0, 0, 4), "target": (0, 0, 0), "up": (0, 1, 0), "fov": 2 * np.degrees(np.arctan(0.5))}
UNIT = 132
DARK, BRIGHT = [68, 1, 84], [253, 231, 37]  # the two ends of viridis
PICKED = list(sharing.PICKED)
BARS = [89, 128, 166]
DOWN = [0.0, 0, 1]


def read(path):
    from PIL import Image

    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def picture(tmp_path, s, pick=None, *, view=ABOVE, **options):
    camera = None if view is None else sf.Camera(**view)
    return read(s.plot_areas(pick, screenshot=tmp_path / "a.png", camera=camera, **options))


def at(image, x, y):
    """The pixel where the point (x, y, 0) is seen."""
    return image[round(263.5 - UNIT * y), round(247.5 + UNIT * x)].tolist()


def is_color(image, rgb):
    return (np.abs(image - np.array(rgb)) <= 3).all(axis=-1)


def part(image, which):
    """The pixels of a part of the window while a disk is picked."""
    sides = {
        "main": (0, 528, 0, 496),
        "words": (0, 186, 496, 800),
        "own": (186, 360, 496, 648),
        "leaders": (186, 360, 648, 800),
        "histogram": (360, 600, 496, 800),
        "tall histogram": (240, 600, 496, 800),
    }[which]
    return image[sides[0] : sides[1], sides[2] : sides[3]]


def share_at(image, which, x, y):
    """The pixel of a picture of shares at (x, y), in units of half its side: 174 pixels show 3 of them."""
    return part(image, which)[round(87 - 0.1 * 58 - 58 * y), round(75.5 + 58 * x)].tolist()


def pair(**options):
    return sf.Surfels([[-1, 0, 0], [1, 0, 0]], [DOWN] * 2, radii=[0.5, 0.8], **options)


def grid(n=7, spacing=0.4, **options):
    x = spacing * (np.arange(n) - (n - 1) / 2)
    points = np.array([[a, b, 0] for b in x for a in x])
    return sf.Surfels(points, [DOWN] * len(points), radii=1.5 * spacing, **options)


def axis(image):
    """First and last column of the axis below a histogram: the longest dark line, between vertical 0 and its end."""
    dark = image.max(axis=2) < 140
    columns = np.flatnonzero(dark[np.argmax(dark.sum(axis=1))])
    return columns[np.diff(columns, append=columns[-1] + 1) == 1][[0, -1]]


def test_the_two_ends_of_each_colour(tmp_path):
    s = pair(areas=[0.2 * np.pi * 0.25, 0.6 * np.pi * 0.64])
    for color in ("coverage", "area", "radius"):
        for image in (picture(tmp_path, s, color=color), coarse(tmp_path, s, color)):
            assert at(image, -1, 0) == pytest.approx(DARK, abs=3)
            assert at(image, 1, 0) == pytest.approx(BRIGHT, abs=3)
    swapped = pair(areas=[0.6 * np.pi * 0.25, 0.3 * np.pi * 0.64])  # the larger area is the smaller share
    for image in (picture(tmp_path, swapped), coarse(tmp_path, swapped, "coverage")):
        assert at(image, -1, 0) == pytest.approx(BRIGHT, abs=3)
        assert at(image, 1, 0) == pytest.approx(DARK, abs=3)
    assert at(picture(tmp_path, s, color="normal"), 1, 0) == pytest.approx([128, 128, 255], abs=1)


def coarse(tmp_path, s, color):
    """What plot shows of the same, at the same pixels."""
    path = s.plot(color, screenshot=tmp_path / "b.png", camera=sf.Camera(**ABOVE), size=(496, 528))
    return read(path)


def test_areas_left_open_are_made_for_the_picture_alone(tmp_path):
    s = grid()
    with_areas = grid(areas=sf.effective_areas(s))
    for color in ("area", "coverage"):
        assert (coarse(tmp_path, s, color) == coarse(tmp_path, with_areas, color)).all()
        assert (picture(tmp_path, s, color=color) == picture(tmp_path, with_areas, color=color)).all()
    assert s.areas is None


def test_given_areas_are_shown_unless_a_method_is_named(tmp_path):
    given, paper = grid(areas=1.0), grid(areas=sf.effective_areas(grid(), method="paper"))
    assert (picture(tmp_path, given, method="paper") == picture(tmp_path, paper)).all()
    assert (picture(tmp_path, given) != picture(tmp_path, paper)).any()


def test_overlapping_disks_are_each_seen_where_they_are_nearest(tmp_path):
    s = sf.Surfels([[-0.2, 0, 0], [0.2, 0, 0]], [DOWN] * 2, radii=1.0, areas=[1.0, 2.0])
    image = part(picture(tmp_path, s, color="area"), "main")
    middle = image[263]
    assert is_color(middle[150:244], DARK).all()
    assert is_color(middle[252:346], BRIGHT).all()


def test_a_few_outliers_leave_colours_for_the_others(tmp_path):
    areas = np.ones(121)
    areas[60] = 1000.0
    areas[:60] = 2.0
    image = picture(tmp_path, grid(11, 0.3, areas=areas), color="area")
    assert at(image, 0, 0.3) == pytest.approx(DARK, abs=3)
    assert at(image, 0, -0.3) == pytest.approx(BRIGHT, abs=3)
    assert at(image, 0, 0) == pytest.approx(BRIGHT, abs=3)


def test_the_histogram_has_its_bars_where_they_should_be(tmp_path):
    points = [[x, y, 0] for x in (-1, 1) for y in (-1, 1)]
    share = np.array([0.255, 0.255, 0.68, 0.255])
    s = sf.Surfels(points, [DOWN] * 4, radii=0.5, areas=share * np.pi * 0.25)
    image = part(picture(tmp_path, s), "tall histogram")
    first, last = axis(image)
    bars = is_color(image, BARS)
    columns = np.flatnonzero(bars.any(axis=0))
    cut = np.argmax(np.diff(columns)) + 1
    heights = []
    for bar, value in ((columns[:cut], 0.255), (columns[cut:], 0.68)):
        low, high = np.floor(value / 0.0175) * 0.0175, np.ceil(value / 0.0175) * 0.0175  # 40 bins up to 0.7
        for side, edge in ((bar[0], low), (bar[-1], high)):
            assert side == pytest.approx(first + (last - first) * edge / 0.7, abs=3)
        heights.append(bars[:, bar].sum(axis=0).max())
    assert heights[0] == pytest.approx(3 * heights[1], abs=3)
    assert not is_color(image, PICKED).any()

    image = part(picture(tmp_path, s, 2), "histogram")
    first, last = axis(image)
    mark = np.argwhere(is_color(image, PICKED))
    assert mark[:, 1].mean() == pytest.approx(first + (last - first) * 0.68 / 0.7, abs=2)


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
    assert image[263, 10].tolist() != [255, 255, 255]


def test_without_a_camera_a_sheet_is_seen_from_its_front(tmp_path):
    s = grid()
    turned = sf.Surfels(s.points, -s.normals, radii=s.radii)
    for sheet in (s, turned):
        main = part(picture(tmp_path, sheet, view=None), "main")
        drawn = (main < 250).any(axis=2)
        assert 0.15 < drawn.mean() < 0.8
        for edge in (drawn[0], drawn[-1], drawn[:, 0], drawn[:, -1]):
            assert not edge.any()


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


def test_survey_coordinates_look_like_any_other(tmp_path):
    s, far = grid(), np.array([5.1e6, 4.3e5, 800.0])
    moved = sf.Surfels(s.points + far, s.normals, radii=s.radii)
    view = ABOVE | {"eye": np.add(far, [0, 0, 4]), "target": far}
    here, there = picture(tmp_path, s, 24), picture(tmp_path, moved, 24, view=view)
    for which in ("main", "own", "leaders", "histogram"):
        differ = np.abs(part(here, which) - part(there, which)).max(axis=2) > 8
        assert differ.mean() < 0.002


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
        with viewer.quiet_vtk():
            areas = sf.effective_areas(s) if s.areas is None else s.areas
            view = inspection.AreaView(s, areas, "curved", (800, 600), off_screen=True)
            views.append(view)
            view.show_color("coverage")
            view.frame(sf.Camera(**(ABOVE | camera)))
            view.listen()
        return view

    yield make
    for view in views:
        view.plotter.close()


def seen(view):
    with viewer.quiet_vtk():
        return view.plotter.screenshot(return_img=True).astype(int)


def click(view, x, y, drag=0):
    mouse = view.plotter.iren.interactor
    column, row = round(247.5 + UNIT * x), round(600 - 1 - (263.5 - UNIT * y))
    mouse.SetEventInformation(column, row, 0, 0, "\0", 0, None)
    mouse.LeftButtonPressEvent()
    if drag:
        mouse.SetEventInformation(column + drag, row, 0, 0, "\0", 0, None)
        mouse.MouseMoveEvent()
    mouse.LeftButtonReleaseEvent()


def press(view, key):
    keys = view.plotter.iren.interactor
    keys.SetKeyCode(key)
    keys.SetKeySym(key)
    keys.KeyPressEvent()
    keys.CharEvent()


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


def test_a_click_beside_the_surfels_changes_nothing(window):
    view = window(grid())
    view.pick(24)
    seen(view)
    click(view, 2.5, 0)  # on the panel
    assert view.picked.index == 24


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
    assert all(f"{key}: {color}" in inspection.KEYS for key, color in inspection.COLORS.items())


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


WRONG = [
    ({"pick": 2}, r"^pick: wanted a whole number from 0 to 1, got 2$"),
    ({"pick": -1}, r"^pick: wanted a whole number from 0 to 1, got -1$"),
    ({"pick": 0.5}, r"^pick: wanted a whole number, got 0\.5$"),
    ({"color": "level"}, r"^color: wanted one of 'coverage', 'area', 'radius', 'normal', got 'level'$"),
    ({"method": "best"}, r"^method: wanted one of 'paper', 'curved', got 'best'$"),
    ({"size": 3}, r"^size: wanted \(width, height\), got 3$"),
    ({"screenshot": "a.gif"}, r"^screenshot: wanted a name ending in \.png or \.jpg, got 'a\.gif'$"),
]


@pytest.mark.parametrize(("options", "message"), WRONG, ids=str)
def test_wrong_arguments(options, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        pair().plot_areas(**({"screenshot": tmp_path / "a.png"} | options))


def test_a_picture_without_a_folder(tmp_path):
    with pytest.raises(sf.FileError, match=r"a\.png: cannot be written: there is no folder .*none"):
        pair().plot_areas(screenshot=tmp_path / "none" / "a.png")


def test_without_a_display_a_picture_is_saved_and_this_is_said(tmp_path, monkeypatch, capfd):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    assert read(pair().plot_areas(size=(400, 300))).shape == (300, 400, 3)
    assert "there is no display, so the picture goes to" in capfd.readouterr().err


@pytest.mark.parametrize("size", [(800, 600), (1280, 720), (320, 240), (200, 900)])
def test_the_parts_of_the_window_fill_it(tmp_path, size):
    """No pixel is left black by a part that is not drawn."""
    for pick in (None, 24):
        image = picture(tmp_path, grid(), pick, size=size)
        assert image.shape == (size[1], size[0], 3)
        assert (image.max(axis=2) < 5).mean() < 0.03
    assert inspection_panel.MAIN == 0
