"""Pictures in and out: EXR, HDR and PNG, linear radiance everywhere but in PNG files."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.check import number
from surflux._base.color import linear_to_srgb, rgb_of_grey
from surflux._base.files import file_error
from surflux._base.types import FilePath, Image

# Layers whose channels have names of their own: those that compositing programs look for.
CHANNELS = {"depth": ("Z",), "normal": ("N.X", "N.Y", "N.Z")}


def write_image(
    path: FilePath,
    image: ArrayLike | Mapping[str, ArrayLike],
    *,
    exposure: float | Literal["auto"] | None = None,
    stops: float = 0.0,
    filmic: bool = True,
    **layers: ArrayLike,
) -> Path:
    """Writes a picture; the suffix of `path` says how.

    - .exr: linear 32-bit floats R G B, and the layers: `indirect` (h, w, 3) becomes indirect.R, .G and .B, `normal`
      N.X, N.Y and N.Z, an (h, w) layer one channel of its name, `depth` (h, w) the channel Z. Infinity stays infinity.
    - .hdr: linear R G B with shared exponents (Radiance).
    - .png: 8 bit sRGB of the tone-mapped picture (see tone_map).

    The file appears whole or not at all.

    Args:
        path: str or path.
        image: (h, w, 3), linear radiance, row 0 on top; or all layers of a picture as Solution.render gives them, of
            which files other than .exr take the radiance alone.
        exposure: for .png alone: the factor on radiance; None or "auto" to choose it from the picture.
        stops: for .png alone: so many times twice as bright, below 0 darker.
        filmic: for .png alone: False cuts off at 1, where else highlights are bent towards it.
        layers: for .exr alone, by name: (h, w), (h, w, 1) or (h, w, 3) each.

    Returns:
        The Path written.

    Raises:
        ValueError: an argument, by name: a wrong shape, NaN, layers for a format that has none, an exposure for one
            that needs none, whole numbers beyond what a float holds.
        FileError: the path and the reason: an unknown suffix, a folder that is not there or takes no file.

    >>> import numpy as np
    >>> import surflux as sf
    >>> sf.write_image("grey.exr", np.full((2, 4, 3), 0.25), depth=np.ones((2, 4))).name
    'grey.exr'
    """
    path = Path(check.path("path", path))
    suffix = path.suffix.lower()
    if isinstance(image, dict):
        if "radiance" not in image:
            raise ValueError(f"image: wanted a layer 'radiance' among {', '.join(map(repr, image))}")
        more = {name: values for name, values in image.items() if name != "radiance"}
        image, layers = image["radiance"], (more if suffix not in (".hdr", ".png") else {}) | layers
    image = _picture("image", image)
    if image.shape[2:] != (3,):
        raise ValueError(f"image: wanted shape (h, w, 3), got {image.shape}")
    if np.any(np.isnan(image)):
        row, column = np.argwhere(np.isnan(image).any(axis=2))[0]
        raise ValueError(f"image: pixel ({row}, {column}) is NaN")
    if layers and suffix in (".hdr", ".png"):
        raise ValueError(f"{next(iter(layers))}: a {suffix} file has no layers; .exr has")
    factor, stops = checked_tone(suffix, exposure, stops, filmic)
    if suffix == ".png":
        image = _core.tone_map(image, resolved_exposure(factor, image, stops), filmic)
    names, channels = ["R", "G", "B"], [image]
    for name, values in layers.items():
        values = _picture(name, values)
        if values.shape[:2] != image.shape[:2] or values.shape[2:] not in ((), (1,), (3,)):
            wanted = f"({image.shape[0]}, {image.shape[1]}) or ({image.shape[0]}, {image.shape[1]}, 3)"
            raise ValueError(f"{name}: wanted the image's shape {wanted}, got {values.shape}")
        values = values.reshape(*values.shape[:2], -1)
        own = CHANNELS.get(name, ())
        if len(own) != values.shape[2]:
            own = [f"{name}.{c}" for c in "RGB"] if values.shape[2] == 3 else [name]
        names += own
        channels.append(values)
    from surflux import _image  # brings OpenImageIO

    _image.write_image(os.fsencode(path), names, np.concatenate(channels, axis=2))
    return path


def read_image(path: FilePath, layer: str | None = None) -> Image:
    """Reads a picture from .exr, .hdr or .png (sRGB made linear).

    Of an .exr file its display window, black where it holds no pixels; of an .hdr file radiance: pixels over EXPOSURE
    and COLORCORR. Luminance with chroma (Y RY BY), CIE X Y Z, and .hdr files stored by columns (X first) are refused.

    Args:
        path: str or path.
        layer: of an .exr file, by the name that write_image took; None for the picture itself.

    Returns:
        (h, w, 3) float32, linear R G B, row 0 on top; a grey picture has its value three times. (h, w) for a layer of
        one channel.

    Raises:
        ValueError: path is none.
        FileError: the path and the reason: no such file, an unknown suffix, broken content, no such layer.

    >>> import numpy as np
    >>> import surflux as sf
    >>> path = sf.write_image("ramp.exr", np.zeros((2, 4, 3)), depth=[[1, 2, 3, 4]] * 2)
    >>> sf.read_image(path, layer="depth")[0]
    array([1., 2., 3., 4.], dtype=float32)
    """
    path = check.path("path", path)
    from surflux import _image  # brings OpenImageIO

    names, pixels = _image.read_image(os.fsencode(path))
    own = CHANNELS.get(layer, ())
    if layer is None and not set("RGB") <= set(names) and set("XYZ") <= set(names):
        raise file_error(path, "CIE X Y Z are not supported; wanted R, G and B")
    single = own[0] if len(own) == 1 else "Y" if layer is None else layer
    for triple in (own, [c if layer is None else f"{layer}.{c}" for c in "RGB"]):
        if len(triple) == 3 and all(name in names for name in triple):
            return np.ascontiguousarray(pixels[:, :, [names.index(name) for name in triple]])
    if single in names:
        channel = pixels[:, :, names.index(single)]
        return rgb_of_grey(channel) if layer is None else np.ascontiguousarray(channel)
    wanted = "R G B or Y" if layer is None else f"layer '{layer}'"
    raise file_error(path, f"has no {wanted}; its channels are {' '.join(names)}")


def tone_map(
    image: ArrayLike, *, exposure: float | Literal["auto"] | None = None, stops: float = 0.0, filmic: bool = True
) -> Image:
    """Linear radiance -> what a display shows: exposure, a shoulder that bends highlights towards 1, the sRGB curve.

    Args:
        image: (h, w, 3); NaN and negative values come out 0, infinity 1.
        exposure: the factor on radiance; None or "auto" for the one that brings the log-average luminance to 0.22,
            taken without black, without one and the same value in more than 1 % of the pixels (background, lamps), and
            without the darkest and brightest 2 % of the rest. (Views, pages and colours in PLY files make the brightest
            percent of the surfels white.)
        stops: so many times twice as bright, below 0 darker.
        filmic: False cuts off at 1 instead.

    Returns:
        (h, w, 3) float32 in 0 to 1.

    Raises:
        ValueError: an argument, by name.

    >>> import numpy as np
    >>> import surflux as sf
    >>> sf.tone_map(np.full((1, 1, 3), 0.5), exposure=1.0, filmic=False).round(3)
    array([[[0.735, 0.735, 0.735]]], dtype=float32)
    """
    image = _picture("image", image)
    if image.shape[2:] != (3,):
        raise ValueError(f"image: wanted shape (h, w, 3), got {image.shape}")
    factor = resolved_exposure(_exposure(exposure), image, number("stops", stops, -100.0, 100.0))
    return linear_to_srgb(_core.tone_map(image, factor, bool(filmic))).astype(np.float32)


def checked_tone(suffix, exposure, stops, filmic):
    """(factor or None, stops) for a file with this suffix."""
    factor, stops = _exposure(exposure), number("stops", stops, -100.0, 100.0)
    check.flag("filmic", filmic)
    for name, given in (("exposure", factor is not None), ("stops", stops != 0.0), ("filmic", not filmic)):
        if given and suffix in (".exr", ".hdr"):
            raise ValueError(f"{name}: a {suffix} file holds radiance itself, and is not tone-mapped")
    return factor, stops


def resolved_exposure(exposure, image, stops=0.0):
    """The factor on radiance: as given, or chosen from the picture."""
    exposure = _exposure(exposure)
    return (_core.automatic_exposure(image) if exposure is None else exposure) * 2.0**stops


def _picture(name, values):
    try:
        given = np.asarray(values)
        values = given.astype(np.float32)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: wanted an array of numbers") from None
    if values.ndim not in (2, 3) or values.size == 0:
        raise ValueError(f"{name}: wanted shape (h, w) or (h, w, 3) with at least one pixel, got {values.shape}")
    if given.dtype.kind in "iu" and np.any(np.abs(given.astype(np.float64)) > 2**24):
        raise ValueError(f"{name}: wanted whole numbers up to 2^24, which are all that 32-bit floats hold")
    return values


def _exposure(value):
    if value is None or (isinstance(value, str) and value == "auto"):
        return None
    value = number("exposure", value, 0.0, np.inf)
    if value == 0.0:
        raise ValueError("exposure: wanted a positive number, got 0")
    return value
