"""What a plot of surfels draws, judged by the pixels."""

import numpy as np
import pytest

import surflux as sf
from surflux.drawing import plots

SQUARE = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
RED, GREEN = [0.8, 0.0, 0.0], [0.0, 0.8, 0.0]
# Looking down, the picture's half height is 2 at the plane z = 0: 50 pixels for each unit.
ABOVE = {"eye": (0, 0, 4), "target": (0, 0, 0), "up": (0, 1, 0), "fov": 2 * np.degrees(np.arctan(0.5))}
BELOW = ABOVE | {"eye": (0, 0, -4)}


def picture(tmp_path, s, view=ABOVE, color="reflectance", **options):
    from PIL import Image

    path = plots.plot(
        s, color=color, screenshot=tmp_path / "a.png", camera=sf.Camera(**view), size=(200, 200), **options
    )
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def at(image, x, y):
    return image[round(100 - 50 * y), round(100 + 50 * x)].tolist()


def pair(**options):
    return sf.Surfels([[-1, 0, 0], [1, 0, 0]], [[0, 0, 1]] * 2, radii=[0.5, 0.8], **options)


def test_disks_have_their_place_size_and_colour(tmp_path):
    image = picture(tmp_path, pair(reflectance=[RED, GREEN]))
    red = image[:, :, 0] > image[:, :, 1] + 100
    green = image[:, :, 1] > image[:, :, 0] + 100
    # A polygon of 16 corners covers 8 sin(pi / 8) = 3.06 r^2; 2500 pixels make one unit of area.
    assert red.sum() / 2500 == pytest.approx(3.06 * 0.25, rel=0.03)
    assert green.sum() / 2500 == pytest.approx(3.06 * 0.64, rel=0.03)
    assert np.argwhere(red).mean(axis=0) == pytest.approx([99.5, 49.5], abs=0.6)
    assert np.argwhere(green).mean(axis=0) == pytest.approx([99.5, 149.5], abs=0.6)
    assert at(image, 0, 1.5) == [255, 255, 255]
    assert at(image, -1, 0) == pytest.approx([231, 0, 0], abs=1)  # 0.8 by the sRGB curve is 0.906


def test_disks_are_not_drawn_from_behind_unless_asked(tmp_path):
    s = pair(reflectance=RED)
    assert (picture(tmp_path, s, BELOW) == 255).all()
    assert (picture(tmp_path, s, BELOW, culling=False)[:, :, 1] == 0).any()


def test_patches_are_drawn_as_the_polygons_they_are(tmp_path):
    image = picture(tmp_path, sf.Surfels.from_mesh(SQUARE, reflectance=RED))
    assert ((image[:, :, 1] < 50).sum()) == pytest.approx(100 * 100, rel=0.03)
    assert at(image, 0.95, 0.95)[1] == 0
    assert at(image, 1.15, 0) == [255, 255, 255]  # where the disk around the square would be


def test_normals_as_colours(tmp_path):
    assert at(picture(tmp_path, pair(), color="normal"), 1, 0) == pytest.approx([128, 128, 255], abs=1)


def test_numbers_as_colours(tmp_path):
    s = pair(areas=[1.0, 2.0])
    for color, values in (("radius", {}), ("area", {}), ("level", {"level": np.array([0, 3])})):
        image = picture(tmp_path, s, color=color, values=values)
        low, high = at(image, -1, 0), at(image, 1, 0)
        assert low == pytest.approx([68, 1, 84], abs=3)  # the two ends of viridis
        assert high == pytest.approx([253, 231, 37], abs=3)


def test_radiosity_is_shown_with_its_brightest_as_white(tmp_path):
    image = picture(tmp_path, pair(), color="radiosity", values={"radiosity": [[50.0] * 3, [200.0] * 3]})
    assert at(image, 1, 0) == pytest.approx([255] * 3, abs=3)
    assert at(image, -1, 0) == pytest.approx([137] * 3, abs=3)  # 0.25 by the sRGB curve is 0.537


def test_survey_coordinates_look_like_any_other(tmp_path):
    s, far = pair(reflectance=RED), np.array([5.1e6, 4.3e5, 800.0])
    moved = sf.Surfels(s.points + far, s.normals, radii=s.radii, reflectance=RED)
    view = ABOVE | {"eye": np.add(far, [0, 0, 4]), "target": far}
    assert np.abs(picture(tmp_path, moved, view) - picture(tmp_path, s)).max() <= 2


def test_without_a_camera_all_is_in_view(tmp_path):
    from PIL import Image

    s = sf.Surfels.from_mesh(SQUARE, reflectance=RED, two_sided=True)
    image = np.asarray(Image.open(s.plot(screenshot=tmp_path / "a.png", size=(100, 80))).convert("RGB")).astype(int)
    assert image.shape == (80, 100, 3)
    red = image[:, :, 0] > image[:, :, 1] + 100
    assert red.mean() > 0.1
    assert not red[[0, -1]].any()
    assert not red[:, [0, -1]].any()


def test_without_a_display_a_picture_is_saved_and_this_is_said(tmp_path, monkeypatch, capfd, caplog):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    path = pair().plot()
    assert path.read_bytes()[:4] == b"\x89PNG"
    (said,) = caplog.records
    assert (said.name, said.levelname) == ("surflux", "WARNING")
    assert said.message == f"there is no display, so the picture goes to {path}"
    assert capfd.readouterr().out == ""
    assert pair().plot() != path
    assert list(tmp_path.iterdir()) == []  # the working folder is the user's
    monkeypatch.setenv("DISPLAY", ":0")
    assert plots.has_display()


def test_a_picture_without_a_folder(tmp_path):
    with pytest.raises(sf.FileError, match=r"a\.png: cannot be written: there is no folder .*none"):
        pair().plot(screenshot=tmp_path / "none" / "a.png")


def test_values_must_fit(tmp_path):
    with pytest.raises(ValueError, match=r"^level: wanted shape \(2,\) or \(2, 3\) for 2 surfels, got \(3,\)"):
        plots.plot(pair(), color="level", values={"level": [1, 2, 3]}, screenshot=tmp_path / "a.png")
    with pytest.raises(
        ValueError, match=r"^color: wanted one of area, coverage, emission, normal, radius, reflectance, .*got 'level'"
    ):
        pair().plot("level")


def test_the_polygons_of_disks_face_along_the_normals():
    normals = np.random.default_rng(0).normal(size=(50, 3))
    s = sf.Surfels(np.zeros((50, 3)), normals, radii=np.linspace(1, 2, 50))
    mesh = plots.disks(s)
    rims = mesh.points.reshape(50, 16, 3)
    assert np.linalg.norm(rims, axis=2) == pytest.approx(np.repeat(s.radii[:, None], 16, axis=1), rel=1e-6)
    turn = np.cross(rims[:, 0], rims[:, 1])
    assert turn / np.linalg.norm(turn, axis=1, keepdims=True) == pytest.approx(s.normals, abs=1e-6)
    assert mesh.cell_data["surfel"].tolist() == list(range(50))


def test_very_many_disks_have_fewer_corners():
    n = 100_001
    s = sf.Surfels(np.zeros((n, 3)), np.tile([0.0, 0, 1], (n, 1)), radii=1)
    assert plots.disks(s).n_points == 6 * n
