"""Turntables, camera paths, and what comes of them: numbered pictures and films."""

import base64
import builtins
import gc
import subprocess
import weakref

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux.pictures import animation
from surflux.pictures.gif import GifWriter


@pytest.fixture(scope="module")
def solution():
    floor = sf.Surfels.from_mesh(
        ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1, reflectance=[0.8, 0.4, 0.2]
    )
    return sf.solve(sf.Scene([floor], lights=[sf.PointLight([0.8, 0.2, 0.7], 3.0)]))


CAMERA = sf.Camera([0.3, -3, 2], [0.1, 0, 0], fov=40)


def test_a_turntable_keeps_its_distance_and_comes_around():
    cameras = sf.turntable(CAMERA, 12)
    assert len(cameras) == 12
    assert cameras[0] == CAMERA
    for camera in cameras:
        assert np.linalg.norm(camera.eye - camera.target) == pytest.approx(np.linalg.norm(CAMERA.eye - CAMERA.target))
        np.testing.assert_allclose(camera.target, CAMERA.target, atol=1e-12)
        assert camera.eye[2] == pytest.approx(2)
        assert camera.fov == 40
    half = cameras[6]
    np.testing.assert_allclose(half.eye[:2] - CAMERA.target[:2], CAMERA.target[:2] - CAMERA.eye[:2], atol=1e-12)
    # From above against the clock, as longitudes go east; a negative number of turns goes back.
    assert np.cross(cameras[0].eye - CAMERA.target, cameras[1].eye - CAMERA.target)[2] > 0
    back = sf.turntable(CAMERA, 12, turns=-1)
    np.testing.assert_allclose(back[1].eye, cameras[11].eye, atol=1e-12)


def test_a_turntable_around_another_axis():
    cameras = sf.turntable(sf.Camera([1, -2, 0], [1, 0, 0]), 4, axis=[0, 0, 2], center=[0, 0, 0])
    np.testing.assert_allclose(cameras[1].eye, [2, 1, 0], atol=1e-12)
    np.testing.assert_allclose(cameras[1].target, [0, 1, 0], atol=1e-12)
    rolled = sf.turntable(sf.Camera([0, -2, 0], [0, 0, 0]), 4, axis=[0, 1, 0])
    np.testing.assert_allclose(np.abs(rolled[1].up), [1, 0, 0], atol=1e-12)


def test_a_path_goes_through_its_cameras():
    cameras = [
        sf.Camera([0, -4, 1], [0, 0, 0], fov=40),
        sf.Camera([2, -3, 2], [0, 0.5, 0], fov=50),
        sf.Camera([4, 0, 1], [0, 0, 0.5], up=(0, 0.6, 0.8), fov=30),
    ]
    path = sf.camera_path(cameras, 21)
    for k, camera in enumerate(cameras):
        for name in ("eye", "target", "up", "fov"):
            np.testing.assert_allclose(getattr(path[10 * k], name), getattr(camera, name), atol=1e-12)
    # Smooth: steps change by little from one to the next, over the middle camera too.
    eyes = np.array([camera.eye for camera in path])
    steps = np.diff(eyes, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 0.25 * np.linalg.norm(steps, axis=1).max()
    around = sf.camera_path(cameras, 9, closed=True)
    np.testing.assert_allclose(around[0].eye, cameras[0].eye)
    np.testing.assert_allclose(around[6].eye, cameras[2].eye)
    assert len(around) == 9


def test_numbered_pictures(solution, tmp_path):
    cameras = sf.turntable(CAMERA, 3)
    seen = []
    paths = solution.animate(
        cameras,
        tmp_path / "turn%03d.png",
        (40, 30),
        samples=1,
        progress=lambda done, total: seen.append((done, total)) or True,
    )
    assert paths == [tmp_path / f"turn{k:03d}.png" for k in (1, 2, 3)]
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    # All with the exposure of the first.
    exposure = animation.resolved_exposure(None, solution.render(cameras[0], (40, 30), samples=1))
    for path, camera in zip(paths, cameras, strict=True):
        expected = sf.tone_map(solution.render(camera, (40, 30), samples=1), exposure=exposure)
        shown = sf.tone_map(sf.read_image(path), exposure=1.0, filmic=False)
        np.testing.assert_allclose(shown, expected, atol=0.5 / 255 + 1e-3)


def test_layers_of_every_frame(solution, tmp_path):
    paths = solution.animate(sf.turntable(CAMERA, 2), tmp_path / "%d.exr", (20, 16), samples=1, layers=True)
    assert [p.name for p in paths] == ["1.exr", "2.exr"]
    assert sf.read_image(paths[1], "normal").shape == (16, 20, 3)
    (path,) = solution.animate([CAMERA], tmp_path / "%d.exr", (20, 16), samples=1, layers=["depth"])
    np.testing.assert_array_equal(sf.read_image(path), solution.render(CAMERA, (20, 16), samples=1))
    assert np.isfinite(sf.read_image(path, "depth")).any()


@pytest.mark.parametrize("name", ["film.mp4", "film.gif"])
def test_films(solution, tmp_path, name):
    imageio = pytest.importorskip("imageio.v2", reason="needs surflux[video]")
    pytest.importorskip("imageio_ffmpeg", reason="needs surflux[video]")
    cameras = sf.turntable(CAMERA, 5)
    path = tmp_path / name
    assert solution.animate(cameras, path, (64, 48), fps=10) == [path]
    assert [p.name for p in tmp_path.iterdir()] == [name]
    film = imageio.mimread(path)
    assert len(film) == 5
    for frame, camera in zip(film, cameras, strict=True):
        assert frame.shape[:2] == (48, 64)
        picture = solution.render(camera, (64, 48))
        exposure = animation.resolved_exposure(None, solution.render(cameras[0], (64, 48)))
        exact = 255 * sf.tone_map(picture, exposure=exposure)
        assert np.abs(frame[..., :3] - exact).mean() < 8
    # A cancelled one leaves nothing.
    with pytest.raises(sf.Cancelled):
        solution.animate(cameras, tmp_path / f"other.{name[-3:]}", (64, 48), progress=lambda done, _: done < 2)
    assert [p.name for p in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", quick("film.mp4", of=["film.mp4", "film.gif"]))
def test_a_film_is_written_frame_by_frame(solution, tmp_path, monkeypatch, name):
    """Whatever its length: neither what is drawn is kept, nor what is written, by whoever writes it."""
    imageio = pytest.importorskip("imageio.v2", reason="needs surflux[video]")
    pytest.importorskip("imageio_ffmpeg", reason="needs surflux[video]")
    from PIL import Image

    size, rng = (34, 18), np.random.default_rng(0)
    drawn, kept = [], []

    def render(*_, **__):
        return {"radiance": rng.uniform(size=(size[1], size[0], 3)).astype(np.float32)}

    monkeypatch.setattr(solution, "render", render)
    real = animation.tone_map

    def tone_map(image, **tone):
        arrays = (o for o in gc.get_objects() if isinstance(o, Image.Image) and o.size == size)
        kept.append(sum(ref() is not None for ref in drawn) + sum(1 for _ in arrays))
        drawn.append(weakref.ref(image))
        return real(image, **tone)

    monkeypatch.setattr(animation, "tone_map", tone_map)
    solution.animate(sf.turntable(CAMERA, 12), tmp_path / name, size, fps=20)
    assert len(drawn) == 12
    assert max(kept) <= 3  # the one before, as Pillow's picture in all its colours and in 256
    film = imageio.mimread(tmp_path / name, memtest=False)
    assert len(film) == 12
    assert film[0].shape[:2] == size[::-1]
    if name == "film.gif":
        with Image.open(tmp_path / name) as shown:
            assert (shown.n_frames, shown.info["loop"], shown.info["duration"]) == (12, 0, 50)


COLORS = np.array([[221, 60, 60], [60, 221, 60], [60, 60, 221], [221, 221, 60], [162, 162, 162]])  # of stripes


@pytest.fixture(scope="module")
def stripes(tmp_path_factory):
    """A film of upright stripes, 64 pixels wide and 720 high each: as high as browsers take for BT.709 without tags."""
    pytest.importorskip("imageio_ffmpeg", reason="needs surflux[video]")
    path = tmp_path_factory.mktemp("stripes") / "film.mp4"
    frame = np.repeat(COLORS, 64, axis=0)[None].repeat(720, axis=0).astype(np.uint8)
    with animation._film(path, 10) as add:
        for _ in range(3):
            add(frame)
    return path


def test_films_say_how_their_colours_are_converted(stripes):
    """And are converted so: by BT.709, from 16 to 235 and 240 (Rec. ITU-R BT.709-6, 3.2 to 3.4)."""
    import imageio_ffmpeg

    ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", stripes]
    said = subprocess.run(ffmpeg, capture_output=True, text=True).stderr
    assert "yuv420p(tv, bt709/bt709/iec61966-2-1" in said
    raw = subprocess.run([*ffmpeg, "-frames:v", "1", "-f", "rawvideo", "-"], capture_output=True, check=True).stdout
    y, rest = np.split(np.frombuffer(raw, np.uint8).astype(float), [320 * 720])
    y, (blue, red) = y.reshape(720, 320)[90, 32::64], rest.reshape(2, 360, 160)[:, 45, 16::32]
    y, blue, red = (y - 16) / 219, (blue - 128) / 224, (red - 128) / 224
    r, b = y + 1.5748 * red, y + 1.8556 * blue
    g = (y - 0.2126 * r - 0.0722 * b) / 0.7152
    np.testing.assert_allclose(255 * np.transpose([r, g, b]), COLORS, atol=4)


def test_browsers_show_films_in_the_colours_of_pictures(stripes, tmp_path, browser):
    data = base64.b64encode(stripes.read_bytes()).decode()
    page = tmp_path / "film.html"
    page.write_text(f'<body style="margin: 0"><video id="film" muted src="data:video/mp4;base64,{data}"></video>')
    browser.visit(page)
    browser.wait('document.getElementById("film").readyState >= 2')
    browser.wait_until(lambda: np.any(browser.picture()[90, 32] != 255))  # what is there is drawn later
    shown = browser.picture()[90, 32:320:64]
    np.testing.assert_allclose(shown, COLORS, atol=4)  # green was (49, 196, 56), red (236, 76, 58)


def test_a_callback_that_says_nothing_or_zero_goes_on_and_one_that_says_false_stops(solution, tmp_path):
    """As passes of the core take it."""
    cameras = sf.turntable(CAMERA, 2)
    assert len(solution.animate(cameras, tmp_path / "a%d.png", (16, 16), progress=lambda *_: None)) == 2
    assert len(solution.animate(cameras, tmp_path / "a%d.png", (16, 16), progress=lambda *_: 0)) == 2
    with pytest.raises(sf.Cancelled):
        solution.animate(cameras, tmp_path / "b%d.png", (16, 16), progress=lambda *_: False)


def test_without_the_extra_films_say_what_to_install(solution, tmp_path, monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.startswith("imageio"):
            raise ImportError(f"No module named '{name}'")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(
        ImportError, match=r"\.mp4 files need `pip install 'surflux\[video\]'`.*numbered pictures do not"
    ):
        solution.animate([CAMERA], tmp_path / "a.mp4", (16, 16))


def test_refusals(solution, tmp_path):
    for cameras in ([], CAMERA, [CAMERA, 3]):
        with pytest.raises(ValueError, match=r"^cameras: wanted"):
            solution.animate(cameras, tmp_path / "%d.png")
    for path, reason in [
        ("a.png", r"^path: wanted a pattern"),
        ("%d%d.png", r"^path: wanted a pattern"),
        ("%s.png", r"^path: wanted a pattern"),
        ("a.avi", r"^path: wanted a name ending in \.mp4"),
        (5, r"^path: wanted a path"),
    ]:
        with pytest.raises(ValueError, match=reason):
            solution.animate([CAMERA], path)
    with pytest.raises(sf.FileError, match="there is no folder"):
        solution.animate([CAMERA], tmp_path / "none" / "%d.png")
    for name, value in [("fps", 0), ("fps", 1e-9), ("fps", "fast"), ("stops", np.nan), ("filmic", 1), ("exposure", 0)]:
        with pytest.raises(ValueError, match=rf"^{name}: "):
            solution.animate([CAMERA], tmp_path / "%d.png", (8, 8), **{name: value})
    for name, value in [("exposure", 2.0), ("stops", 1.0), ("filmic", False)]:
        with pytest.raises(ValueError, match=rf"^{name}: a \.exr file holds radiance itself"):
            solution.animate([CAMERA], tmp_path / "%d.exr", (8, 8), **{name: value})
    with pytest.raises(ValueError, match=r"^layers: a \.png file has none"):
        solution.animate([CAMERA], tmp_path / "%d.png", (8, 8), layers=True)
    with pytest.raises(sf.Cancelled):
        solution.animate([CAMERA] * 2, tmp_path / "%d.png", (8, 8), progress=lambda done, _: done < 1)
    for name, value in [("camera", 3), ("frames", 0), ("turns", "one"), ("axis", [0, 0, 0]), ("center", [1, 2])]:
        with pytest.raises(ValueError, match=rf"^{name}: wanted"):
            sf.turntable(**{"camera": CAMERA, "frames": 3, name: value})
    for name, value in [("cameras", [CAMERA]), ("cameras", [CAMERA, 1]), ("frames", 1), ("closed", 1)]:
        with pytest.raises(ValueError, match=rf"^{name}: wanted"):
            sf.camera_path(**{"cameras": [CAMERA, CAMERA], "frames": 3, name: value})
    above = [sf.Camera([0, 0, 1], [1, 0, 1]), sf.Camera([1, 0, 1], [0, 0, 1])]
    with pytest.raises(ValueError, match=r"^cameras: on the way between them one looks nowhere"):
        sf.camera_path(above, 3)


@pytest.mark.parametrize("fps", [24, 30, 50])
def test_gifs_keep_their_time(tmp_path, fps):
    """Frames of 30 in a second, in hundredths: 3, 4 and 3; of 3 all, a second took .9."""
    image = pytest.importorskip("PIL.Image")
    writer = GifWriter(tmp_path / "film.gif", fps)
    for k in range(fps):
        writer.append_data(np.full((4, 4, 3), k, np.uint8))
    writer.close()
    with image.open(tmp_path / "film.gif") as shown:
        total = 0
        for k in range(fps):
            shown.seek(k)
            total += shown.info["duration"]
    assert total == 1000
