"""The sky in patches, each of which is a light of its own: what daylight coefficients are taken for."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.color import rgb_of_grey
from surflux._base.types import Floats
from surflux.scenes.lights import Environment

_SUBDIVISIONS = {144 * m * m + 1: m for m in range(1, 9)}
_TREGENZA = (30, 30, 24, 24, 18, 12, 6)  # patches in each row, from the horizon up
BRIGHT = 4.0  # times the mean of its patch, and of all directions: a pixel that is no part of a smooth sky


class SkyPatches:
    """The sky dome in patches of about the same solid angle, and the ground.

    145 are those of Tregenza (1987): rows of 30, 30, 24, 24, 18, 12 and 6 patches, 12 degrees high, and a cap at the
    zenith. 577, 1297, 2305, ... have m = 2, 3, 4, ... rows of m times as many for each of these (Reinhart 2001).
    Their order is that of Radiance's gendaymtx, so that its matrices and ours go together: patch 0 is the ground,
    all of the lower half; then rows from the horizon up, each clockwise seen from above, its first patch centred on
    north; the cap comes last. +x is east, +y is north, +z is up.

    Args:
        count: of patches of the sky: 145, 577, 1297, 2305, ... 9217.

    Raises:
        ValueError: another count.

    >>> import surflux as sf
    >>> patches = sf.SkyPatches(145)
    >>> len(patches), patches.solid_angles[1:].sum().round(6).item()  # with the ground; 2 pi of sky
    (146, 6.283185)
    >>> patches.index([[0, 0, 1], [0, 1, 0.1], [1, 2, -3]]).tolist()  # the zenith, north over the horizon, the ground
    [145, 1, 0]
    """

    def __init__(self, count: int = 145) -> None:
        self._core = _core.SkyPatches(_SUBDIVISIONS[patch_count("count", count)])
        self._pixels: NDArray[np.uint32] | None = None  # of an image: the patch that each lies in

    def __len__(self) -> int:
        return len(self._core)

    def __repr__(self) -> str:
        return f"SkyPatches({len(self) - 1})"

    def __reduce__(self) -> tuple[type[SkyPatches], tuple[int]]:
        return SkyPatches, (len(self) - 1,)

    @property
    def directions(self) -> Floats:
        """(n, 3) unit directions to the middles of the patches, the ground's first."""
        return np.asarray(self._core.directions)

    @property
    def solid_angles(self) -> Floats:
        """(n,) solid angles in steradians: 2 pi of the ground, and of all patches of the sky together."""
        return np.asarray(self._core.solid_angles)

    @property
    def projected(self) -> Floats:
        """(n,) irradiance of a level plane that faces up, from each patch at radiance 1; pi of all, 0 of the ground."""
        m = _SUBDIVISIONS[len(self) - 1]
        height = 0.5 * np.pi / (7 * m + 0.5)
        squares = np.sin(height * np.arange(7 * m + 1)) ** 2
        counts = np.repeat(_TREGENZA, m) * m
        cap = np.pi * (1.0 - squares[-1])
        return np.concatenate([[0.0], np.repeat(np.pi * np.diff(squares) / counts, counts), [cap]])

    def _places(self, across: int) -> Floats:
        """(patches of the sky, across**2, 3): directions that stand for equal parts of each patch but the ground."""
        m = _SUBDIVISIONS[len(self) - 1]
        height = 0.5 * np.pi / (7 * m + 0.5)
        u, v = (np.ravel(k) for k in np.meshgrid(*[(np.arange(across) + 0.5) / across] * 2))
        sines, azimuths = [], []
        for row, count in enumerate(np.repeat(_TREGENZA, m) * m):
            low, high = np.sin(height * row), np.sin(height * (row + 1))
            sines.append(np.tile(low + v * (high - low), (count, 1)))
            azimuths.append(2.0 * np.pi * (np.arange(count)[:, None] + u - 0.5) / count)
        sines.append(1.0 - v[None, :] * (1.0 - np.cos(0.5 * height)))
        azimuths.append(2.0 * np.pi * u[None, :])
        sine, azimuth = np.concatenate(sines), np.concatenate(azimuths)
        level = np.sqrt(1.0 - sine**2)
        return np.stack([level * np.sin(azimuth), level * np.cos(azimuth), sine], axis=-1)

    def environment(self, radiances: ArrayLike) -> Environment:
        """The Environment in which each patch has one radiance, exactly: borders of pixels are on those of patches.

        Args:
            radiances: (n,) or (n, 3), W/(m2 sr), of all patches, the ground's first; at least 0.

        Raises:
            ValueError: radiances of another shape, not finite or below 0.

        >>> import surflux as sf
        >>> patches = sf.SkyPatches(145)
        >>> patches.environment(patches.directions[:, 2].clip(0))
        Environment(image of 720 x 30 pixels, up=(0.0, 0.0, 1.0))
        """
        array = check.numeric("radiances", radiances)
        if array.ndim == 1:
            array = rgb_of_grey(array)
        array = check.in_range("radiances", check.finite_array("radiances", array, (len(self), 3)), 0.0)
        if self._pixels is None:
            # Two rows of pixels for a row of patches, of which the cap has half the height; and columns that each row's
            # patches, and halves of them, have in whole numbers.
            m = _SUBDIVISIONS[len(self) - 1]
            height, width = 2 * (14 * m + 1), 720 * m
            theta = np.pi * (np.arange(height)[:, None] + 0.5) / height
            phi = np.pi - 2.0 * np.pi * (np.arange(width)[None, :] + 0.5) / width
            level = np.sin(theta)
            toward = np.stack([level * np.cos(phi), level * np.sin(phi), np.cos(theta) + 0.0 * phi], axis=-1)
            self._pixels = self.index(toward.reshape(-1, 3)).reshape(height, width)
        return Environment(array[self._pixels])

    def index(self, directions: ArrayLike) -> NDArray[np.uint32]:
        """(m,) the patch that each of directions (m, 3) lies in, of any length but 0; the horizon itself is sky.

        Raises:
            ValueError: directions of another shape, not finite or of zero length.
        """
        directions = check.unit_vectors("directions", check.finite_array("directions", directions, (None, 3)))
        return np.asarray(self._core.index(directions))

    def radiance(self, environment: Environment) -> Floats:
        """(n, 3) mean radiance of an Environment in each patch, W/(m2 sr).

        The mean over pieces of pixels, each counted where its middle lies: even skies stay even, and the power of a sun
        of one pixel is kept to some 1 %.

        Raises:
            ValueError: not an Environment.
        """
        if not isinstance(environment, Environment):
            raise ValueError(f"environment: wanted an Environment, got {type(environment).__name__}")
        return np.asarray(self._core.radiance(environment._to_core()))

    def narrow_light(self, environment: Environment) -> float:
        """The share of an Environment's light, 0 to 1, that lies in small parts of patches, as that of a sun does.

        Of pixels of the sky, four times as bright as their patch and as the mean of all directions, it is what they
        have more than their patch: what `radiance` spreads.

        Raises:
            ValueError: not an Environment.

        >>> import numpy as np, surflux as sf
        >>> image = np.ones((32, 64, 3))
        >>> image[5, 7] = 1000.0
        >>> round(sf.SkyPatches(145).narrow_light(sf.Environment(image)), 2)
        0.26
        """
        return self._narrow_light(environment, self.radiance(environment))

    def _narrow_light(self, environment, radiances):
        """The same, with what `radiance` says of it."""
        if environment.image is None:
            return 0.0
        pixels, weights = _pixels(environment)
        all_light = (weights * pixels).sum()
        rows, columns = np.nonzero(pixels > BRIGHT * all_light / weights.sum())
        if not len(rows):
            return 0.0
        patch = self.index(_directions(environment, rows, columns))
        of_patch = radiances[patch].sum(axis=1)
        bright, weights = pixels[rows, columns], weights[rows, columns]
        is_narrow = (patch > 0) & (bright > BRIGHT * of_patch)
        return float((weights * (bright - of_patch))[is_narrow].sum() / max(all_light, np.finfo(float).tiny))

    def _misplaced_ground(self, environment, radiances, ways):
        """The share of an Environment's light along ways (m, 3) that one radiance of all the ground has wrong.

        Of their sum or, where what is too much here is too little there, of half of all differences.
        """
        if len(ways) == 0:
            return 0.0
        light = _pixels(environment)[0][_pixel_of(environment, ways)]
        off = np.where(self.index(ways) == 0, radiances[0].sum() - light, 0.0)
        return float(max(abs(off.sum()), 0.5 * np.abs(off).sum()) / max(light.sum(), np.finfo(float).tiny))


def _pixels(environment):
    """(height, width) each: sums of the channels of an Environment's pixels, and weights as their solid angles."""
    pixels = np.asarray(environment.image, dtype=float).sum(axis=2)
    height, width = pixels.shape
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return pixels, np.repeat((edges[:-1] - edges[1:])[:, None], width, axis=1)


def _pixel_of(environment, ways):
    """Rows and columns (m,) each of the pixels of an Environment in unit directions (m, 3): _directions backwards."""
    height, width = environment.image.shape[:2]
    x, y, z = (ways @ np.asarray(environment._to_core().axes).T).T
    row = np.arccos(np.clip(z, -1.0, 1.0)) / np.pi * height
    column = (np.pi - np.arctan2(y, x)) / (2.0 * np.pi) * width
    return np.minimum(row.astype(int), height - 1), np.minimum(column.astype(int), width - 1)


def _directions(environment, rows, columns):
    """(m, 3) towards the middles of an Environment's pixels."""
    height, width = environment.image.shape[:2]
    z = 0.5 * (np.cos(np.pi * rows / height) + np.cos(np.pi * (rows + 1) / height))
    level, phi = np.sqrt(1.0 - z * z), np.pi - 2.0 * np.pi * (columns + 0.5) / width
    image_axes = np.asarray(environment._to_core().axes)
    return np.stack([level * np.cos(phi), level * np.sin(phi), z], axis=1) @ image_axes


def patch_count(name: str, count: int) -> int:
    """count, if a sky can have so many patches; refused by `name` otherwise."""
    if check.count(name, count) not in _SUBDIVISIONS:
        raise ValueError(f"{name}: wanted one of {', '.join(map(str, _SUBDIVISIONS))}, got {count}")
    return count
