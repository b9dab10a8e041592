"""What a view or a page shows: surfels, with all that is known of them."""

from typing import TypeAlias

import numpy as np

from surflux._base import check
from surflux._base.passes import LOG
from surflux.geometry.hierarchy import build_hierarchy
from surflux.pictures.framing import own_or_framing
from surflux.points.surfels import Surfels
from surflux.scenes.lights import AreaLight
from surflux.scenes.scene import Scene
from surflux.solutions.leaves import inserted_among, means_of_parents
from surflux.solutions.rendering import drawn_surfels
from surflux.solutions.solution import Solution

Thing: TypeAlias = Surfels | Scene | Solution


class Subject:
    """Surfels, a Scene or a Solution, and what both views ask of it.

    Args:
        thing: Surfels, Scene or Solution.
        values: dict of further arrays by name, (n,) or (n, 3), or None.

    Attributes:
        surfels: Surfels that are shown.
        objects: (n,) index of the object that each belongs to.
        solution, scene: where there is one, else None. A solution that was not loaded from a file knows its scene.
        values: dict of further arrays.
        camera: the one that comes with it, or None.
        lamps: list of AreaLight.
    """

    def __init__(self, thing, values=None):
        if not isinstance(thing, (Surfels, Scene, Solution)):
            raise ValueError(f"thing: wanted Surfels, a Scene or a Solution, got {type(thing).__name__}")
        self.solution = thing if isinstance(thing, Solution) else None
        self.scene = thing if isinstance(thing, Scene) else None if self.solution is None else thing._scene
        self.surfels = thing if isinstance(thing, Surfels) else thing.surfels
        self._tree = None
        n = len(check.some_surfels("thing", self.surfels))
        if self.solution is not None:
            self.objects = self.solution.objects.astype(np.int64)
        elif self.scene is not None:
            self.objects = np.repeat(np.arange(len(thing.objects)), [len(s) for s in thing.objects])
        else:
            self.objects = np.zeros(n, np.int64)
        if not isinstance(values, (dict, type(None))):
            raise ValueError(f"values: wanted a dict of arrays, got {type(values).__name__}")
        self.values = {name: _shown(name, value, n) for name, value in (values or {}).items()}
        self._given = self  # whose values came from outside
        self.camera = None if isinstance(thing, Surfels) else thing.camera
        if self.solution is not None:
            self.lamps = list(self.solution._lamps)
        else:
            self.lamps = [light for light in thing.lights if isinstance(light, AreaLight)] if self.scene else []
        faces = [own._faces for own in (self.scene.objects if self.scene else [self.surfels])]
        if any(own is not None and own.textures is not None for own in faces):
            LOG.info("textures are not shown: patches have their mean (Solution.render draws them)")

    def __len__(self):
        return len(self.surfels)

    def solved_again(self, solution):
        """A Subject of another solution of the scene, with the same arrays: of surfels that one has in place of others
        the mean by area, or what the surfel of the scene has that they are parts of.
        """
        found, given = Subject(solution), self._given
        before = given.solution
        if np.array_equal(before.parents, solution.parents):
            found.values = dict(given.values)
        else:
            for name, value in given.values.items():
                columns = np.asarray(value, np.float64).reshape(len(value), -1)
                means = means_of_parents(before.parents, before.surfels.areas, columns)
                found.values[name] = means[solution.parents].reshape(-1, *value.shape[1:])
        found._given = given
        return found

    def framed(self, size):
        """The Camera to begin with in a picture of size (width, height)."""
        return own_or_framing(self.camera, self.surfels, size)

    def tree(self):
        """The Hierarchy of the surfels, made when first asked for."""
        if self._tree is None:
            self._tree = build_hierarchy(self.surfels)
        return self._tree

    def inserted(self):
        """(n,) booleans: which surfels stand for a part of one of the scene's."""
        if self.solution is None:
            return np.zeros(len(self), bool)
        return inserted_among(self.solution.parents)

    def drawn(self):
        """(radii (n,), triangles (t, 3, 3)) as they leave no gaps where surfels were inserted."""
        if self.solution is None:
            return self.surfels.radii, self.surfels.triangles
        core = drawn_surfels(self.solution)
        return core.radii, core.triangles

    def lamp_quads(self):
        """(l, 4, 3) corners of the lamps around origin(), counterclockwise as seen from where they shine."""
        corner, u, v = (
            np.array([getattr(lamp, k) for lamp in self.lamps]).reshape(-1, 3) for k in ("corner", "edge_u", "edge_v")
        )
        low = corner - self.origin()
        return np.stack([low, low + u, low + u + v, low + v], axis=1)

    def origin(self):
        """(3,) the middle of all: around it single precision serves survey coordinates too."""
        points = self.surfels.points
        return (points.min(axis=0) + points.max(axis=0)) / 2


def _shown(name, value, n):
    """An array to colour n surfels by: numbers, of which some may be unknown, or light."""
    array = check.per_row(name, value, n)
    return array if array.ndim == 1 else check.finite_array(name, array, (n, 3))
