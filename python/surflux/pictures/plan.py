"""A plan: values of points as they are seen from above, one point for each pixel, the highest."""

import numpy as np

_ROUNDS = 3  # in which holes are filled from pixels around


class Plan:
    """A picture with y up and x to the right, of points that come in chunks."""

    def __init__(self, low, high, width):
        """low, high: (2,) corners of what it shows; width: of the picture in pixels."""
        low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
        size = np.maximum(high - low, 1e-9 * max(1.0, float(np.max(np.abs(high)))))
        self._low, self._pixel = low, size[0] / width
        self._shape = max(1, int(np.ceil(size[1] / self._pixel - 1e-9))), width
        self._top = np.full(self._shape[0] * width, -np.inf)
        self._values = np.full((self._shape[0] * width, 3), np.nan)

    def add(self, points, values):
        """Takes points (n, 3) with values (n, 3); those with NaN are not seen."""
        height, width = self._shape
        column, row = ((points[:, :2] - self._low) / self._pixel).T
        seen = np.isfinite(values).all(axis=1) & (np.minimum(row, column) >= 0)
        column, row = (np.floor(part[seen]).astype(np.int64) for part in (column, row))
        seen = np.flatnonzero(seen)
        inside = (row <= height) & (column <= width)  # what lies on the last edge counts to the pixel before it
        seen, row, column = seen[inside], row[inside].clip(max=height - 1), column[inside].clip(max=width - 1)
        at = (height - 1 - row) * width + column
        order = np.lexsort((points[seen, 2], at))
        last = np.flatnonzero(np.diff(at[order], append=-1))
        at, seen = at[order][last], seen[order][last]
        higher = points[seen, 2] > self._top[at]
        self._top[at[higher]] = points[seen[higher], 2]
        self._values[at[higher]] = values[seen[higher]]

    def image(self):
        """(height, width, 3) float32; NaN where no point is near."""
        image = self._values.reshape(*self._shape, 3)
        for _ in range(_ROUNDS):
            hole = np.isnan(image[..., 0])
            if not hole.any():
                break
            framed = np.pad(image, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
            height, width = self._shape
            around = [framed[i : i + height, j : j + width] for i in range(3) for j in range(3) if (i, j) != (1, 1)]
            known = np.sum([~np.isnan(part[..., 0]) for part in around], axis=0)
            mean = np.sum([np.nan_to_num(part) for part in around], axis=0) / np.maximum(known, 1)[..., None]
            image = np.where((hole & (known >= 3))[..., None], mean, image)
        return image.astype(np.float32)
