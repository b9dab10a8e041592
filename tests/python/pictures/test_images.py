import os
import sys

import numpy as np
import pytest
from PIL import Image

from surflux import _core, _image
from surflux.pictures.images import read_image, tone_map, write_image


@pytest.fixture
def picture():
    return np.random.default_rng(0).uniform(0.0, 20.0, (9, 16, 3)).astype(np.float32)


def test_exr_keeps_radiance_and_layers_to_the_bit(tmp_path, picture):
    depth = np.full((9, 16), np.inf)
    depth[3:5] = 2.5
    path = tmp_path / "a.exr"
    write_image(path, picture, depth=depth, indirect=0.5 * picture, coverage=depth < 9)
    np.testing.assert_array_equal(read_image(path), picture)
    np.testing.assert_array_equal(read_image(path, "indirect"), 0.5 * picture)
    np.testing.assert_array_equal(read_image(path, "depth"), depth)
    np.testing.assert_array_equal(read_image(path, "coverage"), depth < 9)
    names, _ = _image.read_image(str(path))
    assert sorted(names) == ["B", "G", "R", "Z", "coverage", "indirect.B", "indirect.G", "indirect.R"]
    with pytest.raises(_core.FileError, match=r"a\.exr: has no layer 'direct'.*indirect\.R"):
        read_image(path, "direct")


def test_hdr_keeps_radiance_to_seven_bits(tmp_path, picture):
    write_image(tmp_path / "a.hdr", picture)
    error = np.abs(read_image(tmp_path / "a.hdr") - picture)
    assert (
        error <= picture.max(axis=2, keepdims=True) / 128
    ).all()  # RGBE: 8 bits below the largest channel's exponent


def test_png_holds_what_tone_map_gives(tmp_path, picture):
    for exposure in (None, 0.05):
        write_image(tmp_path / "a.png", picture, exposure=exposure)
        stored = np.asarray(Image.open(tmp_path / "a.png")) / 255.0
        np.testing.assert_allclose(stored, tone_map(picture, exposure=exposure), atol=0.5 / 255 + 1e-4)


def test_tone_map_cuts_off_where_it_is_told_to():
    image = np.array([[[0.0, 0.5, 3.0], [np.nan, np.inf, -1.0]]])
    # sRGB of 0.5 is 0.735357 (IEC 61966-2-1).
    expected = [[[0.0, 0.735357, 1.0], [0.0, 1.0, 0.0]]]
    np.testing.assert_allclose(tone_map(image, exposure=1.0, filmic=False), expected, atol=1e-6)
    assert tone_map(image, exposure=1.0)[0, 0, 1] == pytest.approx(0.735357, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "arguments", "argument"),
    [
        ("a.exr", {"image": np.zeros((4, 4))}, "image"),
        ("a.exr", {"image": np.zeros((4, 0, 3))}, "image"),
        ("a.exr", {"image": np.zeros((4, 4, 4))}, "image"),
        ("a.exr", {"image": "picture"}, "image"),
        ("a.png", {"image": np.full((4, 4, 3), np.nan)}, "image"),
        ("a.exr", {"depth": np.zeros((4, 5))}, "depth"),
        ("a.exr", {"indirect": np.zeros((4, 4, 2))}, "indirect"),
        ("a.exr", {"exposure": 1.0}, "exposure"),
        ("a.hdr", {"exposure": 1.0}, "exposure"),
        ("a.hdr", {"depth": np.zeros((4, 4))}, "depth"),
        ("a.png", {"depth": np.zeros((4, 4))}, "depth"),
        ("a.png", {"exposure": 0.0}, "exposure"),
        ("a.png", {"exposure": np.nan}, "exposure"),
    ],
)
def test_writing_refuses_by_name(tmp_path, name, arguments, argument):
    with pytest.raises(ValueError, match=f"^{argument}: "):
        write_image(tmp_path / name, **{"image": np.zeros((4, 4, 3)), **arguments})
    assert list(tmp_path.iterdir()) == []


def test_files_that_cannot_be(tmp_path, picture):
    for path, reason in [
        ("a.tif", "are supported"),
        ("a", "are supported"),
        ("none/a.exr", "cannot be written: there is no folder .*none"),
    ]:
        with pytest.raises(_core.FileError, match=reason) as error:
            write_image(tmp_path / path, picture)
        assert str(error.value).startswith(str(tmp_path / path))
    with pytest.raises(_core.FileError, match="no such file"):
        read_image(tmp_path / "none.png")
    (tmp_path / "broken.png").write_bytes(b"\x89PNG")
    with pytest.raises(_core.FileError, match="not a PNG file"):
        read_image(tmp_path / "broken.png")


@pytest.mark.skipif(sys.platform != "linux", reason="names are text here")
@pytest.mark.parametrize("suffix", [".png", ".exr"])
def test_names_that_are_no_utf_8(tmp_path, picture, suffix):
    path = tmp_path / os.fsdecode(b"i\xff" + suffix.encode())
    with pytest.raises(_core.FileError, match=r"i\\xff\.\w+: no such file$"):
        read_image(path)
    write_image(path, picture)
    assert read_image(path).shape == picture.shape
    assert list(tmp_path.iterdir()) == [path]


def test_tone_map_refuses_by_name():
    with pytest.raises(ValueError, match=r"^image: "):
        tone_map(np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"^exposure: "):
        tone_map(np.zeros((3, 3, 3)), exposure=-1.0)
