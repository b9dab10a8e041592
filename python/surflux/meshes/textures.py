"""Images on faces of meshes: what each face has of them in the mean."""

import io
from collections.abc import Callable
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from surflux._base.color import WHITE, rgb_of_grey, srgb_to_linear
from surflux.meshes.fans import fans_of_faces, sums_of_rows
from surflux.meshes.texel_means import mean_texels

NO_PLACE = 0xFFFFFFFF  # of a corner
_ALPHA = np.arange(256) / 255.0
_WITH_ALPHA = ("RGBA", "RGBa", "LA", "La", "PA")
_LARGEST = 1 << 29  # pixels of a file: 23 000 on a side, 1.6 GB


class Texture(NamedTuple):
    """An image: (h, w, 3) pixels of 8 or 16 bits, and what each of their values is, linear.

    With `cover` pixels are (h, w, 4), and it has, from 0 to 1, what is there of a texel by its alpha. Pictures show
    texels that are larger than what they see of it as they are where it is `nearest`, else interpolated.
    """

    pixels: np.ndarray
    linear: np.ndarray
    cover: np.ndarray | None = None
    nearest: bool = False

    def values(self, row, column, channel):
        """What texels have of a channel, linear, times what is there of them; of channel 3 what is there."""
        if self.cover is None:
            return self.linear[self.pixels[row, column, channel]]
        there = self.cover[self.pixels[row, column, 3]]
        return there if channel == 3 else there * self.linear[self.pixels[row, column, channel]]


def texture_of(image, cover=None):
    """The Texture of an image of Pillow; ValueError where it has no colours of 8 or 16 bits.

    cover: (256,), as Texture has it, for images of 8 bits; None where alpha does not count.
    """
    pixels = np.asarray(image)
    if pixels.dtype.kind == "u" and pixels.dtype.itemsize == 2:  # of either byte order
        pixels = pixels if pixels.ndim == 3 else rgb_of_grey(pixels)
        return Texture(pixels[:, :, :3], srgb_to_linear(np.arange(65536) / 65535.0))
    if image.mode in ("I", "F"):
        raise ValueError(f"a texture of mode {image.mode}; wanted 8 or 16 bits a channel")
    linear = srgb_to_linear(np.arange(256) / 255.0)
    if cover is not None:
        pixels = np.asarray(image.convert("RGBA"))
        if (cover < 1.0)[pixels[:, :, 3]].any():
            return Texture(pixels, linear, cover)
    return Texture(np.asarray(image.convert("RGB")), linear)


def read_texture(path):
    """The Texture of a file, with a cover where it has alpha; ImportError, or what Pillow raises, of none."""
    with _opened(path) as image:
        return texture_of(image, _ALPHA if image.mode in _WITH_ALPHA or "transparency" in image.info else None)


def decoded_texture(data, cover):
    """The Texture of the bytes of a file, with a cover as texture_of has it; raises what read_texture does."""
    with _opened(io.BytesIO(data)) as image:
        return texture_of(image, cover)


@contextmanager
def _opened(file):
    from PIL import Image

    # Its own limit, of 13 000 on a side, is below what photogrammetry writes.
    before, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, _LARGEST
    try:
        with Image.open(file) as image:
            yield image
    finally:
        Image.MAX_IMAGE_PIXELS = before


class TextureUse(NamedTuple):
    """What some faces (m,), ascending, have of a texture anywhere: tint (m, 3) times the texel, from 0 to `most`.

    `read` gives the Texture. Texture coordinates are times `scale`, plus `shift`, (2,) each. It is reflectance or,
    where it `shines`, exitance.
    """

    faces: np.ndarray
    tint: np.ndarray
    read: Callable[[], Texture]
    scale: np.ndarray | float = 1.0
    shift: np.ndarray | float = 0.0
    shines: bool = False
    most: float = WHITE


class TexturedFaces(NamedTuple):
    """Polygons whose corners have places on a texture: the corners of face i are [offsets[i], offsets[i + 1])."""

    vertices: np.ndarray  # (v, 3)
    offsets: np.ndarray  # (f + 1,)
    indices: np.ndarray  # (k,) of corners, into vertices
    places: np.ndarray  # (p, 2), v going up
    of_corners: np.ndarray  # (k,) index into places, or NO_PLACE

    def of_each_corner(self):
        """(k, 2) places; NaN of corners that have none."""
        return np.append(self.places, [[np.nan, np.nan]], axis=0)[np.minimum(self.of_corners, len(self.places))]

    def means(self, faces, texture, scale, shift):
        """(len(faces), 3): linear means of a Texture over some faces, by area; NaN of those that have no place on it.

        Places are times `scale`, plus `shift`, (2,) each.
        """
        of, fan, shares = fans_of_faces(self.vertices, self.offsets, self.indices, faces)
        found = np.full((len(of), 3), np.nan)
        known = np.all(self.of_corners[fan] != NO_PLACE, axis=1)
        found[known] = mean_texels(texture, self.places[self.of_corners[fan[known]]] * scale + shift)
        return np.clip(sums_of_rows(of, shares[:, None] * found, len(faces)), 0.0, 1.0)
