"""What pyvista finds by the entry point `pyvista.accessors` and loads when `dataset.surflux` is first asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyvista

from surflux._base import check
from surflux.meshes.strips import without_strips
from surflux.points.surfels import Surfels
from surflux.scenes.scene import Light, Scene
from surflux.solutions.lit_points import LIGHT
from surflux.solving.radiosity import solve


class PolyDataAccessor:
    """surflux on a pyvista.PolyData: `dataset.surflux`, with pyvista 0.48 or newer, without an import.

    What has faces is a mesh, what has none a cloud of points.

    >>> import pyvista
    >>> import surflux as sf
    >>> lit = PolyDataAccessor(pyvista.Cube()).solve([sf.Environment(1.0)])
    >>> lit.cell_data["irradiance"][0].round(3)
    array([3.142, 3.142, 3.142], dtype=float32)
    """

    def __init__(self, dataset: pyvista.PolyData) -> None:
        self._dataset = dataset

    def surfels(self, **options: Any) -> Surfels:
        """Surfels of the dataset.

        Args:
            options: of Surfels.from_mesh, such as patch_area, where the dataset has faces; of Surfels, such as
                viewpoint, where it has points alone.

        Returns:
            Surfels: patches of the faces, or one of each point, in their order.

        Raises:
            ValueError, Cancelled: as Surfels.from_mesh and Surfels do.
        """
        return Surfels.from_mesh(self._dataset, **options) if self._has_faces() else Surfels(self._dataset, **options)

    def solve(
        self,
        lights: Sequence[Light] = (),
        surfels: Surfels | None = None,
        others: Sequence[Surfels] = (),
        **options: Any,
    ) -> pyvista.PolyData:
        """A copy of the dataset with its light, found by sf.solve.

        Args:
            lights: as sf.Scene takes them.
            surfels: what `surfels` gave; None for `surfels()`.
            others: objects that stand around, which cast shadows and reflect light, too.
            options: of sf.solve, such as error.

        Returns:
            PolyData with arrays "irradiance", "direct" and "radiosity", float32 (n, 3), RGB in W/m2: cell data of a
            mesh, NaN of cells without area, and point data of a cloud. Strips of triangles become triangles.

        Raises:
            ValueError: `surfels` that are not the faces, or as many as the points, of the dataset; as sf.Scene and
                sf.solve do.
            Cancelled: the callback of options["progress"] returned False.
        """
        surfels = self.surfels() if surfels is None else check.surfels("surfels", surfels)
        data = self._dataset
        data = without_strips(data) if data.n_strips else data.copy()
        faces = data.GetNumberOfPolys()
        if faces and (surfels._faces is None or surfels._faces.count != faces):
            raise ValueError(f"surfels: wanted those of the dataset's {check.counted(faces, 'face')}")
        if not faces and len(surfels) != data.n_points:
            many = check.counted(data.n_points, "point")
            raise ValueError(f"surfels: wanted one for each of the dataset's {many}, got {len(surfels)}")
        solution = solve(Scene([surfels, *others], lights), **options)
        for name in LIGHT:
            if faces:
                found = np.full((data.n_cells, 3), np.nan, dtype=np.float32)
                found[data.n_verts + data.n_lines :] = solution.per_face(name)  # cells of these kinds come first
                data.cell_data[name] = found
            else:
                data.point_data[name] = solution.per_surfel(name)[: data.n_points].astype(np.float32)
        return data

    def _has_faces(self):
        return self._dataset.GetNumberOfPolys() + self._dataset.GetNumberOfStrips() > 0


if hasattr(pyvista, "register_dataset_accessor"):  # from 0.48 on
    pyvista.register_dataset_accessor("surflux", pyvista.PolyData)(PolyDataAccessor)
