"""Images on faces of meshes: what each face has of them in the mean."""

from typing import NamedTuple

import numpy as np

from surflux._base.color import srgb_to_linear

NO_PLACE = 0xFFFFFFFF  # of a corner


def read_image(path):
    """The image of a file, by Pillow; ImportError, OSError or ValueError where there is none."""
    from PIL import Image

    with Image.open(path) as image:
        image.load()
        return image


def mean_texels(image, corners):
    """(f, 3): linear means of an image over triangles of texture coordinates (f, 3, 2), which it repeats itself over.

    Each is looked at in the middles of the 16 triangles that its sides' quarters make; v goes up.
    """
    pixels = np.asarray(image)
    if pixels.dtype == np.uint16:
        linear = srgb_to_linear(np.arange(65536) / 65535.0)
        pixels = pixels if pixels.ndim == 3 else pixels[:, :, None].repeat(3, axis=2)
    else:
        linear, pixels = srgb_to_linear(np.arange(256) / 255.0), np.asarray(image.convert("RGB"))
    height, width = pixels.shape[:2]
    upright = [(3 * i + 1, 3 * j + 1) for i in range(4) for j in range(4 - i)]
    places = upright + [(3 * i + 2, 3 * j + 2) for i in range(3) for j in range(3 - i)]
    total = np.zeros((len(corners), 3))
    for a, b in places:  # twelfths
        u, v = ((12 - a - b) * corners[:, 0] + a * corners[:, 1] + b * corners[:, 2]).T / 12.0
        column = np.floor(u * width).astype(np.int64) % width
        row = np.floor((1.0 - v) * height).astype(np.int64) % height
        total += linear[pixels[row, column, :3]]
    return total / len(places)


class TexturedFaces(NamedTuple):
    """Polygons whose corners have places on a texture: the corners of face i are [offsets[i], offsets[i + 1])."""

    points: np.ndarray  # (k, 3) of the corners
    offsets: np.ndarray  # (f + 1,)
    places: np.ndarray  # (p, 2), v going up
    of_corners: np.ndarray  # (k,) index into places, or NO_PLACE

    def means(self, faces, image, scale=(1.0, 1.0), shift=(0.0, 0.0)):
        """(len(faces), 3): linear means of an image over some faces, by area; NaN of those that it has no place for.

        Places are times `scale`, plus `shift`.
        """
        first, corners = self.offsets[faces], np.diff(self.offsets)[faces]
        # Polygons as fans of triangles around their first corner.
        of = np.repeat(np.arange(len(faces)), corners - 2)
        second = first[of] + 1 + np.arange(len(of)) - np.repeat(np.cumsum(corners - 2) - (corners - 2), corners - 2)
        fan = np.stack([first[of], second, second + 1], axis=1)
        known = np.all(self.of_corners[fan] != NO_PLACE, axis=1)
        a, b, c = self.points[fan].transpose(1, 0, 2)
        weights = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        thin = np.bincount(of, weights, len(faces))[of] <= 0.0
        weights[thin] = 1.0
        found = np.full((len(of), 3), np.nan)
        if np.any(known):
            at = self.places[self.of_corners[fan[known]]] * scale + shift
            found[known] = mean_texels(image, at)
        sums = (np.bincount(of, weights * channel, len(faces)) for channel in found.T)
        return np.stack([*sums], axis=1) / np.bincount(of, weights, len(faces))[:, None]
