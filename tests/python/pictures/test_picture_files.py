"""Pictures as other programs write them: windows of EXR, exposure and lines of Radiance's HDR."""

import numpy as np
import pytest

import surflux as sf
from picture_files import write_exr, write_hdr

PIXELS = np.random.default_rng(0).random((8, 16, 3)).astype(np.float32)


def by_name(pixels, names="RGB"):
    return {name: pixels[..., c] for c, name in enumerate(names)}


@pytest.mark.parametrize("shown", [(0, 0, 15, 7), (10, 20, 25, 27)])
def test_what_an_exr_leaves_out_is_black(tmp_path, shown):
    """The data window of a crop inside the display window: it was stretched over all of it."""
    left, top = shown[:2]
    inside = (left + 4, top + 2, left + 11, top + 5)
    path = write_exr(tmp_path / "crop.exr", by_name(PIXELS[2:6, 4:12]), inside, shown)
    wanted = np.zeros_like(PIXELS)
    wanted[2:6, 4:12] = PIXELS[2:6, 4:12]
    np.testing.assert_array_equal(sf.read_image(path), wanted)


@pytest.mark.parametrize("shown", [(2, 1, 13, 6), (-3, 4, 9, 11), (20, 0, 23, 3)])
def test_what_lies_beyond_the_display_window_is_cut_off(tmp_path, shown):
    path = write_exr(tmp_path / "overscan.exr", by_name(PIXELS), (0, 0, 15, 7), shown)
    left, top, right, bottom = shown
    wanted = np.zeros((bottom - top + 1, right - left + 1, 3), np.float32)
    for y in range(len(wanted)):
        for x in range(len(wanted[0])):
            if 0 <= y + top < 8 and 0 <= x + left < 16:
                wanted[y, x] = PIXELS[y + top, x + left]
    np.testing.assert_array_equal(sf.read_image(path), wanted)


def test_a_display_window_that_no_file_fills_is_refused(tmp_path):
    path = write_exr(tmp_path / "huge.exr", by_name(PIXELS), (0, 0, 15, 7), (0, 0, 99_999, 99_999))
    with pytest.raises(sf.FileError, match=r"huge\.exr: claims 100000 x 100000 pixels"):
        sf.read_image(path)


def test_luminance_and_chroma_are_refused(tmp_path):
    path = write_exr(tmp_path / "chroma.exr", by_name(PIXELS, ["Y", "RY", "BY"]))
    with pytest.raises(sf.FileError, match=r"chroma\.exr: luminance and chroma \(Y, RY, BY\) are not supported"):
        sf.read_image(path)


def test_tristimulus_values_are_refused(tmp_path):
    path = write_exr(tmp_path / "cie.exr", by_name(PIXELS, "XYZ"))
    with pytest.raises(sf.FileError, match=r"cie\.exr: CIE X Y Z are not supported; wanted R, G and B"):
        sf.read_image(path)
    channels = by_name(PIXELS, "XYZ")
    np.testing.assert_array_equal(sf.read_image(write_exr(path, by_name(PIXELS) | channels)), PIXELS)
    del channels["X"]  # grey, and depth
    np.testing.assert_array_equal(sf.read_image(write_exr(path, channels))[..., 0], PIXELS[..., 1])


@pytest.mark.parametrize(
    ("said", "times"),
    [
        ("EXPOSURE=4\n", [4, 4, 4]),
        ("EXPOSURE= 0.25 \nEXPOSURE=2\n", [0.5, 0.5, 0.5]),
        ("COLORCORR=1 2 4\n", [1, 2, 4]),
        ("SOFTWARE=of EXPOSURE=3\n", [1, 1, 1]),
    ],
)
def test_pixels_of_hdr_are_radiance_times_exposure(tmp_path, said, times):
    """Files of one radiance, exposed otherwise, are one picture."""
    pixels = np.full((4, 7, 3), 0.5)
    found = sf.read_image(write_hdr(tmp_path / "exposed.hdr", pixels * times, said))
    np.testing.assert_allclose(found, pixels, rtol=0.02)  # half a step of the largest channel


@pytest.mark.parametrize("seed", range(3))
def test_hdr_is_as_bright_as_what_was_written(tmp_path, seed):
    """Bytes are cut off when they are written: all was half of one too dark, .5 % in the mean, dim channels more."""
    radiance = np.exp(np.random.default_rng(seed).normal(size=(64, 128, 3)))
    sf.write_image(tmp_path / "a.hdr", radiance)
    for path in (tmp_path / "a.hdr", write_hdr(tmp_path / "other.hdr", radiance)):
        found = sf.read_image(path)
        assert abs(found.mean() / radiance.mean() - 1.0) < 2e-4
        step = np.exp2(np.frexp(radiance.max(axis=2, keepdims=True))[1] - 8.0)
        assert np.all(np.abs(found - radiance) < np.where(found > 0.0, 0.501, 1.0) * step)  # less than one step is none
    sf.write_image(tmp_path / "black.hdr", [[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    np.testing.assert_array_equal(sf.read_image(tmp_path / "black.hdr")[0, :, 1:], 0.0)
    assert np.all(sf.read_image(tmp_path / "black.hdr")[0, 1] == 0.0)


@pytest.mark.parametrize("value", [np.inf, -1.0, 2e38])
def test_hdr_refuses_what_it_cannot_hold(tmp_path, value):
    """Infinite pixels came back black."""
    with pytest.raises(ValueError, match=r"image: \.hdr takes values from 0 to 1\.7e38, got .*; \.exr takes any"):
        sf.write_image(tmp_path / "a.hdr", [[[1.0, value, 0.0]]])


@pytest.mark.parametrize(
    "said",
    [
        "EXPOSURE=0\n",
        "EXPOSURE=bright\n",
        "COLORCORR=1 2\n",
        "EXPOSURE=h\xe9ll\n",
        "EXPOSURE=1e-200\nEXPOSURE=1e-200\n",  # pixels were infinite
        "EXPOSURE=1e200\nEXPOSURE=1e200\n",  # and black
    ],
)
def test_exposures_that_are_none(tmp_path, said):
    path = write_hdr(tmp_path / "exposed.hdr", np.full((4, 7, 3), 0.5), said)
    with pytest.raises(sf.FileError, match=r"exposed\.hdr: its (EXPOSURE|COLORCORR) is '.*'; wanted above 0"):
        sf.read_image(path)


def test_lines_of_hdr_run_as_it_says(tmp_path):
    pixels = np.exp2(np.arange(28 * 3).reshape(4, 7, 3) // 3 - 14.0)
    wanted = sf.read_image(write_hdr(tmp_path / "down.hdr", pixels))
    np.testing.assert_allclose(wanted, pixels, rtol=0.01)
    for axes, stored in (("+Y {h} +X {w}", pixels[::-1]), ("-Y {h} -X {w}", pixels[:, ::-1])):
        found = sf.read_image(write_hdr(tmp_path / "turned.hdr", stored, axes=axes))
        np.testing.assert_array_equal(found, wanted)
    for axes in ("+X {w} -Y {h}", "\xe9X {w} -Y {h}"):
        with pytest.raises(sf.FileError, match=r"turned\.hdr: its lines run up or down .*wanted Y first"):
            sf.read_image(write_hdr(tmp_path / "turned.hdr", pixels, axes=axes))
