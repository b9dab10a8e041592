"""What the view of areas shows, judged by the pixels."""

import numpy as np
import pytest

import surflux as sf
from area_pictures import ABOVE, BARS, BRIGHT, DARK, DOWN, PICKED, at, axis, grid, is_color, pair, part, picture, read


@pytest.mark.slow
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


@pytest.mark.slow
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
        middle = (np.floor(value / 0.0175) + 0.5) * 0.0175  # 40 bins up to 0.7
        assert bar.mean() == pytest.approx(first + (last - first) * middle / 0.7, abs=2)
        heights.append(bars[:, bar].sum(axis=0).max())
    # Of a bar the rows at its top and at the axis may be blended: up to 2 pixels less, and three times that here.
    assert heights[0] == pytest.approx(3 * heights[1], abs=6)
    assert not is_color(image, PICKED).any()

    image = part(picture(tmp_path, s, 2), "histogram")
    first, last = axis(image)
    mark = np.argwhere(is_color(image, PICKED))
    assert mark[:, 1].mean() == pytest.approx(first + (last - first) * 0.68 / 0.7, abs=2)


def test_without_a_camera_a_sheet_is_seen_from_its_front(tmp_path):
    s = grid()
    turned = sf.Surfels(s.points, -s.normals, radii=s.radii)
    for sheet in (s, turned):
        main = part(picture(tmp_path, sheet, view=None), "main")
        drawn = (main < 250).any(axis=2)
        assert 0.15 < drawn.mean() < 0.8
        for edge in (drawn[0], drawn[-1], drawn[:, 0], drawn[:, -1]):
            assert not edge.any()


@pytest.mark.slow
def test_survey_coordinates_look_like_any_other(tmp_path):
    s, far = grid(), np.array([5.1e6, 4.3e5, 800.0])
    moved = sf.Surfels(s.points + far, s.normals, radii=s.radii)
    view = ABOVE | {"eye": np.add(far, [0, 0, 4]), "target": far}
    here, there = picture(tmp_path, s, 24), picture(tmp_path, moved, 24, view=view)
    for which in ("main", "own", "leaders", "histogram"):
        differ = np.abs(part(here, which) - part(there, which)).max(axis=2) > 8
        assert differ.mean() < 0.002


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


def test_without_a_display_a_picture_is_saved_and_this_is_said(tmp_path, monkeypatch, caplog):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    assert read(pair().plot_areas(size=(400, 300))).shape == (300, 400, 3)
    assert "there is no display, so the picture goes to" in caplog.text


@pytest.mark.slow
@pytest.mark.parametrize("size", [(800, 600), (1280, 720), (320, 240), (200, 900)])
def test_the_parts_of_the_window_fill_it(tmp_path, size):
    """No pixel is left black by a part that is not drawn."""
    for pick in (None, 24):
        image = picture(tmp_path, grid(), pick, size=size)
        assert image.shape == (size[1], size[0], 3)
        assert (image.max(axis=2) < 5).mean() < 0.03
