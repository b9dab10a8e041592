"""Colours of what pictures see: those of textures at the very place, while light is blended between surfels."""

import numpy as np

_LEAST_COSINE = 0.02  # of what is seen at a slant: on the edge a subpixel would see no end of it


class SeenColors:
    """Textures of the meshes of a Scene, on surfels that are its own or parts of them.

    textured (n,): which surfels lie on faces that have textures, in their own colours. reflectance, emission (n, 3):
    what surfels bring to layers; 1 and 0 of textured ones, so that light is blended and colours are put in after it.
    """

    def __init__(self, scene, surfels, objects, parents):
        """scene: None where it is not known. objects, parents (n,): the object and the surfel of the scene of each."""
        self._surfels = surfels
        self._meshes = []  # (the row of each surfel among those of an object or -1, its Faces)
        self.textured = np.zeros(len(surfels), bool)
        first = 0
        for k, own in enumerate([] if scene is None else scene.objects):
            mine = np.flatnonzero(objects == k)
            rows = parents[mine] - first
            first += len(own)
            if own._faces is None or own._faces.textures is None:
                continue
            if np.array_equal(surfels.reflectance[mine], own.reflectance[rows]) and np.array_equal(
                surfels.emission[mine], own.emission[rows]
            ):
                on_it = own._faces.textures.on(own._faces.of[rows])
                self.textured[mine[on_it]] = True
                row = np.full(len(surfels), -1)
                row[mine[on_it]] = rows[on_it]
                self._meshes.append((row, own._faces))
        self.reflectance, self.emission = surfels.reflectance, surfels.emission
        if self._meshes:
            self.reflectance = np.where(self.textured[:, None], 1.0, self.reflectance)
            self.emission = np.where(self.textured[:, None], 0.0, self.emission)

    @classmethod
    def of(cls, solution):
        return cls(solution._scene, solution.surfels, solution.objects, solution.parents)

    def put_on(self, layers, seen, places, camera, rows):
        """The layers (h, w, 3) times the reflectance that is seen; the first, of direct light, with what shines.

        See at().
        """
        if not self._meshes:
            return layers
        reflectance, emission = self.at(seen, places, camera, rows)
        direct, *others = (layer * reflectance for layer in layers)
        return [direct + emission / np.float32(np.pi), *others]

    def at(self, seen, places, camera, rows):
        """(reflectance, emission), (h, w, 3) float32, at subpixels, 1 and 0 where no textured surfel is seen.

        Args:
            seen: their "index" and "depth".
            places: (h, w, 3), what they see.
            camera, rows: the Camera, and how many rows of subpixels the whole picture has.
        """
        index = seen["index"]
        there = index >= 0
        there[there] = self.textured[index[there]]
        surfel, points, depth = index[there], places[there], seen["depth"][there].astype(np.float64)
        sides = _sides_of_subpixels(camera, rows, points, depth, self._surfels.normals[surfel])
        colors = self._surfels.reflectance[surfel], self._surfels.emission[surfel]
        for row, faces in self._meshes:
            some = np.flatnonzero(row[surfel] >= 0)
            own = [values[some] for values in colors]
            of = faces.divided(row[surfel[some]], points[some]).of
            faces.textures.paint(of, points[some], sides[some], *own)
            for values, painted in zip(colors, own, strict=True):
                values[some] = painted
        reflectance, emission = np.ones((*index.shape, 3), np.float32), np.zeros((*index.shape, 3), np.float32)
        reflectance[there], emission[there] = colors
        return reflectance, emission


def _sides_of_subpixels(camera, rows, points, depth, normals):
    """(m, 2, 3): the sides of what subpixels see of planes, at points (m, 3) at a depth along the view (m,)."""
    if camera.height is None:
        size, towards = 2.0 * np.tan(np.radians(camera.fov) / 2.0) / rows * depth, camera.eye - points
    else:
        size, towards = np.full(len(points), camera.height / rows), np.subtract(camera.eye, camera.target)[None]
    towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    cosine = (towards * normals).sum(axis=1)
    along = towards - cosine[:, None] * normals
    straight = np.abs(cosine) > 1.0 - 1e-9  # then any two sides will do
    along[straight] = np.cross(normals[straight], np.eye(3)[np.abs(normals[straight]).argmin(axis=1)])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    longer = size / np.maximum(np.abs(cosine), _LEAST_COSINE)
    return np.stack([longer[:, None] * along, size[:, None] * np.cross(normals, along)], axis=1)
