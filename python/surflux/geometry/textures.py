"""Images on faces of meshes: what each face has of them in the mean."""

import io
from collections.abc import Callable
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from surflux._base.color import WHITE, rgb_of_grey, srgb_to_linear
from surflux.geometry.texel_means import mean_texels

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
        first, corners = self.offsets[faces], np.diff(self.offsets)[faces]
        # Polygons as fans of triangles around their first corner, which beyond a concave corner count less than 0.
        of = np.repeat(np.arange(len(faces)), corners - 2)
        second = first[of] + 1 + np.arange(len(of)) - np.repeat(np.cumsum(corners - 2) - (corners - 2), corners - 2)
        fan = np.stack([first[of], second, second + 1], axis=1)
        a, b, c = self.vertices[self.indices[fan]].transpose(1, 0, 2)
        crosses = np.cross(b - a, c - a)
        normals = _sums(of, crosses, len(faces))
        weights = np.einsum("tk,tk->t", crosses, normals[of])
        weights[~(np.bincount(of, weights, len(faces))[of] > 0.0)] = 1.0
        found = np.full((len(of), 3), np.nan)
        known = np.all(self.of_corners[fan] != NO_PLACE, axis=1)
        found[known] = mean_texels(texture, self.places[self.of_corners[fan[known]]] * scale + shift)
        means = _sums(of, weights[:, None] * found, len(faces)) / np.bincount(of, weights, len(faces))[:, None]
        return np.clip(means, 0.0, 1.0)


def _sums(of, values, count):
    """(count, 3): sums of the rows of values that are of the same."""
    return np.stack([np.bincount(of, channel, count) for channel in values.T], axis=1)
