"""Pictures of one solution after another from one place: what stays between them is kept."""

import numpy as np

from surflux import _core
from surflux.solutions.blending import blended_groups
from surflux.solutions.fields import BasisField
from surflux.solutions.rendering import FOOTPRINT, View, drawn_surfels, layer_names, picture
from surflux.solutions.seen_colors import SeenColors

_FLAT_LAYERS = {"radiance", "direct", "indirect", "albedo", "alpha"}
_MOST_PIXELS = 1 << 21  # of a picture as a matrix: some 200 bytes each


class Painter:
    """Draws what Solution.render does, quicker where only the light has changed since the last picture.

    A picture is linear in what the surfels send: while surfels, camera and size stay, it is a product with a matrix
    (_core.FlatImage) that has for each pixel how much it shows of which surfels.

    Args:
        dark: (n,) which surfels no light ever reaches, such as a floor below a plinth: what is lit does not blend with
            them. None for those that are dark in each picture.
    """

    def __init__(self, dark=None):
        self._dark, self._key, self._matrix = dark, None, None

    def layers(self, solution, camera, size, *, layers, background=0.0, samples=2, culling=True, **traced):
        """A dict of the layers named, as Solution.render gives it; traced: its `direct` and `rays`."""
        names = layer_names(layers)
        view = View(solution, camera, size, background, samples, culling, **traced)
        groups = blended_groups(solution, self._dark)
        return picture(solution, view, names, None, groups, self._flat(solution, groups, view, names))

    def _flat(self, solution, groups, view, names):
        """What blends layers, (values, are lamps seen?) each, as splats do; None where it would not pay."""
        width, height = view.size
        anew = (
            isinstance(solution._field, BasisField) or view.direct == "traced" or SeenColors.of(solution).textured.any()
        )
        if anew or set(names) - _FLAT_LAYERS or width * height > _MOST_PIXELS:
            return None
        key = _Key(solution, groups, view)
        first, stays = self._key is None, key.is_like(self._key)
        if not stays:
            self._key, self._matrix = key, None
        if self._matrix is None:
            if not (first or stays):  # what moves once may move again
                return None
            self._matrix = key.matrix()
        shining = np.reshape([np.divide(lamp.exitance, np.pi) for lamp in solution._lamps], (-1, 3))

        def blended(layers):
            drawn = [self._matrix.draw(values, shining if lit else np.zeros_like(shining)) for values, lit in layers]
            return {"layers": drawn, "coverage": self._matrix.coverage}

        return blended


class _Key:
    """All that the matrix of a picture depends on."""

    def __init__(self, solution, groups, view):
        self._surfels, self._groups, self._walls = drawn_surfels(solution), groups, solution._walls
        self._lamps = [(lamp.corner, lamp.edge_u, lamp.edge_v) for lamp in solution._lamps]
        self._view = (*(tuple(np.atleast_1d(v)) for v in view.camera), view.size, view.samples, view.culling)

    def is_like(self, other):
        return (
            other is not None
            and _look_alike(self._surfels, other._surfels)
            and (self._view, self._lamps) == (other._view, other._lamps)
            and np.array_equal(self._groups, other._groups)
        )

    def matrix(self):
        *camera, size, samples, culling = self._view
        eye, target, up, (fov,), (height,) = camera
        lamps = [(*lamp, np.zeros(3)) for lamp in self._lamps]
        look = eye, target, up, fov, height
        walls = self._walls.between(self._surfels)
        return _core.FlatImage(self._surfels, lamps, look, *size, FOOTPRINT, samples, culling, self._groups, walls)


def _look_alike(one, other):
    """Whether compiled surfels have the same places and shapes: with another reflectance they are others."""
    shape = ("positions", "normals", "radii", "triangles", "triangle_surfel")
    return one is other or all(np.array_equal(getattr(one, name), getattr(other, name)) for name in shape)
