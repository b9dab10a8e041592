"""Images on faces of meshes: what each face has of them in the mean."""

from typing import NamedTuple

import numpy as np

from surflux._base.color import srgb_to_linear

NO_PLACE = 0xFFFFFFFF  # of a corner
_LARGEST = 1 << 29  # pixels of a file: 23 000 on a side, 1.6 GB


class Texture(NamedTuple):
    """An image: (h, w, 3) pixels of 8 or 16 bits, and what each of their values is, linear."""

    pixels: np.ndarray
    linear: np.ndarray


def texture_of(image):
    """The Texture of an image of Pillow; ValueError where it has no colours of 8 or 16 bits."""
    pixels = np.asarray(image)
    if pixels.dtype.kind == "u" and pixels.dtype.itemsize == 2:  # of either byte order
        pixels = pixels if pixels.ndim == 3 else pixels[:, :, None].repeat(3, axis=2)
        return Texture(pixels[:, :, :3], srgb_to_linear(np.arange(65536) / 65535.0))
    if image.mode in ("I", "F"):
        raise ValueError(f"a texture of mode {image.mode}; wanted 8 or 16 bits a channel")
    return Texture(np.asarray(image.convert("RGB")), srgb_to_linear(np.arange(256) / 255.0))


def read_texture(path):
    """The Texture of a file, by Pillow; ImportError, or what Pillow raises, where there is none."""
    from PIL import Image

    # Its own limit, of 13 000 on a side, is below what photogrammetry writes.
    before, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, _LARGEST
    try:
        with Image.open(path) as image:
            return texture_of(image)
    finally:
        Image.MAX_IMAGE_PIXELS = before


def mean_texels(texture, corners):
    """(f, 3): linear means of a Texture over triangles of places on it (f, 3, 2); it repeats itself.

    Each is looked at in the middles of the 16 triangles that its sides' quarters make; v goes up.
    """
    height, width = texture.pixels.shape[:2]
    upright = [(3 * i + 1, 3 * j + 1) for i in range(4) for j in range(4 - i)]
    places = upright + [(3 * i + 2, 3 * j + 2) for i in range(3) for j in range(3 - i)]
    total = np.zeros((len(corners), 3))
    for a, b in places:  # twelfths
        u, v = ((12 - a - b) * corners[:, 0] + a * corners[:, 1] + b * corners[:, 2]).T / 12.0
        column = np.floor(u * width).astype(np.int64) % width
        row = np.floor((1.0 - v) * height).astype(np.int64) % height
        total += texture.linear[texture.pixels[row, column]]
    return total / len(places)


class TexturedFaces(NamedTuple):
    """Polygons whose corners have places on a texture: the corners of face i are [offsets[i], offsets[i + 1])."""

    vertices: np.ndarray  # (v, 3)
    offsets: np.ndarray  # (f + 1,)
    indices: np.ndarray  # (k,) of corners, into vertices
    places: np.ndarray  # (p, 2), v going up
    of_corners: np.ndarray  # (k,) index into places, or NO_PLACE

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
