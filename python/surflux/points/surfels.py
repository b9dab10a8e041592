"""Surfels: points that know their normal, the reach of their disk and their material."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux._base import check
from surflux._base.passes import watched
from surflux._base.types import FilePath, Floats, Integers, Mesh, Points, Progress
from surflux.drawing.plots import to_polydata
from surflux.geometry.cores import make_core
from surflux.geometry.estimates import estimated_normals, estimated_radii
from surflux.geometry.gloss import USUAL_EXPONENT, gloss_arrays, require_energy
from surflux.geometry.sheets import sheet_faces
from surflux.meshes.mesh_surfels import sampled_surfels, surfels_of_patches
from surflux.meshes.reading import file_named, name_of, read_mesh
from surflux.meshes.transparency import tell_backs
from surflux.meshes.winding import warn_of_winding
from surflux.points import arranging, materials, showing, summaries
from surflux.points.foreign_clouds import unpacked
from surflux.points.seen_from import normals_of_array
from surflux.points.writing import ply_path, save_surfels

if TYPE_CHECKING:
    import pyvista


class Surfels:
    """Oriented disks that sample a surface, as arrays of one length (D04 section 4).

    A surfel receives and emits on the side its normal points to; its back occludes and absorbs.

    Args:
        points: (n, 3), n >= 1, in any unit; float64 throughout, so survey coordinates cost nothing. Or a cloud of
            Open3D, pyvista or trimesh, whose normals and colours count where none are given.
        normals: (n, 3), normalized here; None to estimate them from 16 neighbours, more where these are noisy or in
            line, and to orient them to the side from which each sheet is seen (see `facing`; needs 3 points), those of
            terrain upwards.
        radii: (n,) or one number, above 0, in the unit of points; None: no gaps (see below; needs 2 points).
        areas: (n,) or one number, at least 0: effective areas; None leaves them open until a solver asks.
        reflectance: linear, in [0, 1): one number, RGB (3,), one number each (n,) or one RGB each (n, 3).
            Where n is 3, three numbers are one RGB. None for the colours of a cloud, sRGB made linear (white at .98),
            or 0.5 where it has none.
        emission: exitance of the surfel itself, at least 0; the same shapes.
        specular, exponent: what reference_radiance and transfer of distant light reflect besides, around the mirror
            direction, and how narrowly; solvers leave it out. See these properties.
        viewpoint: (3,), the side from which the points were seen: estimated normals turn towards it.
            Given normals stay as they are.
        two_sided: True appends a copy of every surfel that faces the other way.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Estimated radii are 1.1 times the least with which disks cover every triangle of the local Delaunay triangulation,
    each its nearest part: in an acute one the circumradius, as in the covering radius of a lattice (Conway and Sloane
    1999, Sphere Packings, Lattices and Groups, chapter 2). The triangulation is that of the points' Voronoi cells in
    their tangent planes (Boissonnat and Ghosh 2010, tangential Delaunay complexes). Each side of a thin sheet covers
    itself. On borders disks reach half way to their neighbours; no radius is more than 2.5 times what is
    usual around, the third smallest of the six nearest neighbours'.

    Raises:
        ValueError: names the argument, what came and what was wanted.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> s = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 2], [0, 0, 1]], radii=0.6, reflectance=[0.8, 0.4, 0.4])
    >>> s
    Surfels(2 surfels, no areas)
    >>> s.normals
    array([[0., 0., 1.],
           [0., 0., 1.]])
    >>> s[s.points[:, 0] > 0.5].points
    array([[1., 0., 0.]])
    """

    def __init__(
        self,
        points: Points,
        normals: ArrayLike | None = None,
        *,
        radii: ArrayLike | None = None,
        areas: ArrayLike | None = None,
        reflectance: ArrayLike | None = None,
        emission: ArrayLike = 0.0,
        specular: ArrayLike = 0.0,
        exponent: ArrayLike = USUAL_EXPONENT,
        viewpoint: ArrayLike | None = None,
        two_sided: bool = False,
        threads: int | None = None,
        progress: Progress = False,
    ) -> None:
        points, normals, reflectance = unpacked(points, normals, reflectance)
        points = check.positions("points", points, (None, 3))
        n = len(points)
        if viewpoint is not None:
            viewpoint = check.vector3("viewpoint", viewpoint)
        if normals is not None:
            normals = check.unit_vectors("normals", check.finite_array("normals", normals, (n, 3)))
        if radii is not None:
            radii = check.per_surfel("radii", radii, n, low_open=True)
        if areas is not None:
            areas = check.per_surfel("areas", areas, n)
        reflectance = check.per_surfel_rgb("reflectance", reflectance, n, high=1.0, high_open=True)
        emission = check.per_surfel_rgb("emission", emission, n)
        gloss = require_energy(reflectance, gloss_arrays(specular, exponent, n))
        two_sided = check.flag("two_sided", two_sided)
        with watched(threads, progress):
            if normals is None:
                normals = normals_of_array(points) if viewpoint is None else estimated_normals(points, viewpoint)
            if radii is None:
                radii = estimated_radii(points, normals)
        core = make_core(points, normals, radii, areas, reflectance, emission, **gloss)
        self._core = core.two_sided() if two_sided else core
        self._arrays = {}
        self._faces = None

    @classmethod
    def _from_core(cls, core, faces=None):
        surfels = cls.__new__(cls)
        surfels._core = core
        surfels._arrays = {}
        surfels._faces = faces
        return surfels

    def _reflecting(self, reflectance):
        """The same with another reflectance, (n, 3)."""
        return Surfels._from_core(
            self._core.with_reflectance(reflectance), self._faces and self._faces.without_colors()
        )

    @classmethod
    def from_mesh(
        cls,
        mesh: Mesh,
        patch_area: float | None = None,
        reflectance: ArrayLike | None = None,
        emission: ArrayLike | None = None,
        *,
        specular: ArrayLike = 0.0,
        exponent: ArrayLike = USUAL_EXPONENT,
        two_sided: bool | Literal["sheets"] = False,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Self:
        """One surfel per patch of a polygonal model (D04 section 7.3), with exact areas.

        The surfel stands at the patch's centroid with a radius that reaches its farthest corner. The patch's
        triangles stay with it, through s[mask] and save, and occlude in place of the disk.

        Args:
            mesh: path of a mesh file, whose axes stay as they are (of glTF y is up); a mesh of trimesh, pyvista, meshio
                (triangles, quads and polygons) or Open3D; or (vertices (v, 3), faces), where faces are an integer array
                (f, k) or a list of corner lists.
            patch_area: largest area of a patch; None for one patch per face. Either way two coplanar triangles that
                make a convex quadrilateral count as one face. Quadrilaterals are cut into a grid of near-square
                cells, triangles into k^2 congruent ones. What another face stands on, or goes through, is cut along it:
                with both sides of a wall in one patch, each would have light of the other.
            reflectance: in [0, 1): one number, RGB, or one of either per face of the mesh, (f,) or (f, 3). None for the
                mesh's own colours, of its vertices, faces or texture (trimesh's), sRGB made linear (white at .98), or
                for Kd of an OBJ file's materials and baseColorFactor of a glTF file's, linear, at most .98, and their
                maps: the mean over each face, or over each patch that a face is cut into; else 0.5.
            emission: exitance in W/m2, the same shapes. None for what materials send: pi times Ke of OBJ
                files, emissiveFactor of glTF times emissiveStrength, which files alone have; else 0.
            specular: the same shapes. exponent: one number, or one per face.
            two_sided: True appends a copy of every patch that faces the other way; "sheets" of those patches alone that
                belong to open sheets such as leaves: to pieces of the mesh, faces that hang together, whose vector
                areas add up to more than half their area (0 where a piece is closed, all of it where it is flat).
            threads: at most this many; None for all.
            progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
                False cancels.

        Faces without area are dropped, and faces that are wound against those they hang together with are told, each by
        a warning that says how many.

        Returns:
            Surfels, in the order of the faces; those of two that count as one stand where the first does.

        Raises:
            ValueError: an argument, by name; a mesh without any face that has an area; a patch_area that makes more
                than 20 million patches.
            FileError: a mesh file that cannot be read.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> square = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]]
        >>> sf.Surfels.from_mesh(square)
        Surfels(1 surfel, 1 of them a patch, area 4)
        >>> sf.Surfels.from_mesh(square, patch_area=0.01)
        Surfels(400 surfels, 400 of them patches, area 4)
        """
        if patch_area is not None:
            patch_area = check.number("patch_area", patch_area, 0.0, low_open=True)
        two_sided = check.sides("two_sided", two_sided)
        polygons = read_mesh(mesh)
        if two_sided is not True and polygons is not mesh:  # which commands have read, and turn over by themselves
            warn_of_winding(polygons, name_of(mesh), two_sided == "sheets" and sheet_faces(polygons))
            tell_backs(name_of(mesh), polygons, two_sided)
        faces = len(polygons.offsets) - 1
        if reflectance is not None:
            reflectance = check.per_surfel_rgb("reflectance", reflectance, faces, high=1.0, high_open=True, what="face")
        if emission is not None:
            emission = check.per_surfel_rgb("emission", emission, faces, what="face")
        polygons = polygons.with_materials(reflectance, emission)
        gloss = require_energy(polygons.face_reflectance(), gloss_arrays(specular, exponent, faces, "face"))
        with file_named(mesh), watched(threads, progress):
            core, of = surfels_of_patches(polygons, patch_area, gloss, two_sided == "sheets")
        surfels = cls._from_core(core, of)
        return arranging.with_other_sides(surfels) if two_sided is True else surfels

    @classmethod
    def sample_mesh(
        cls,
        mesh: Mesh,
        n: int,
        seed: int = 0,
        reflectance: ArrayLike | None = None,
        emission: ArrayLike | None = None,
        *,
        specular: ArrayLike = 0.0,
        exponent: ArrayLike = USUAL_EXPONENT,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Self:
        """n blue-noise surfels on a mesh, with the normals of its faces; their areas stay open.

        5 n uniform points on the triangles, reduced to n by weighted sample elimination (Yuksel 2015).

        Args:
            mesh: as from_mesh takes it.
            n: number of surfels, at least 2.
            seed: the same seed gives the same points.
            reflectance, emission, specular, exponent: as Surfels takes them, for n surfels; None for the mesh's own, as
                in from_mesh: the mean around each point over as much of its triangle as it stands for.
            threads: at most this many; None for all.
            progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
                False cancels.

        Returns:
            Surfels, n of them, with estimated radii, no areas and no triangles.

        Raises:
            ValueError: an argument, by name; a mesh without any face that has an area.
            FileError: a mesh file that cannot be read.
            Cancelled: the callback returned False.
        """
        n = check.count("n", n, 2)
        seed = check.seed("seed", seed)
        if reflectance is not None:
            reflectance = check.per_surfel_rgb("reflectance", reflectance, n, high=1.0, high_open=True)
        if emission is not None:
            emission = check.per_surfel_rgb("emission", emission, n)
        gloss = gloss_arrays(specular, exponent, n)
        with file_named(mesh), watched(threads, progress):
            polygons = read_mesh(mesh)
            warn_of_winding(polygons, name_of(mesh))
            return cls._from_core(sampled_surfels(polygons, n, seed, reflectance, emission, gloss))

    @property
    def points(self) -> Floats:
        """(n, 3) float64, read-only like every array here."""
        return self._array("points", lambda: self._core.positions)

    @property
    def normals(self) -> Floats:
        """(n, 3) unit normals."""
        return self._array("normals", lambda: self._core.normals)

    @property
    def radii(self) -> Floats:
        """(n,) radii R of the tangent disks, in the unit of points."""
        return self._array("radii", lambda: self._core.radii)

    @property
    def areas(self) -> Floats | None:
        """(n,) effective areas S in the unit of points squared, or None where nobody has given any.

        Can be set, to (n,), one number or None.
        """
        return self._array("areas", lambda: self._core.areas if len(self) else np.zeros(0))

    @areas.setter
    def areas(self, values: ArrayLike | None) -> None:
        areas = np.zeros(0) if values is None else check.per_surfel("areas", values, len(self))
        self._core = self._core.with_areas(areas)
        self._arrays.pop("areas", None)

    @property
    def reflectance(self) -> Floats:
        """(n, 3) linear RGB reflectance, 0 <= rho < 1."""
        return self._array("reflectance", lambda: self._core.reflectance)

    @property
    def emission(self) -> Floats:
        """(n, 3) RGB exitance of the surfels themselves, in the unit of the lights (W/m2)."""
        return self._array("emission", lambda: self._core.emission)

    specular, exponent = materials.specular, materials.exponent

    @property
    def triangles(self) -> Floats:
        """(t, 3, 3) corners of the triangles of mesh patches; (0, 3, 3) where there are none."""
        return self._array("triangles", lambda: self._core.triangles)

    @property
    def triangle_surfel(self) -> NDArray[np.uint32]:
        """(t,) the surfel that each triangle belongs to, ascending."""
        return self._array("triangle_surfel", lambda: self._core.triangle_surfel)

    @property
    def faces(self) -> Integers | None:
        """(n,) the face of the mesh in which the centre of each patch of from_mesh lies; None of all other Surfels."""
        return None if self._faces is None else self._array("faces", lambda: self._faces.of.copy())

    @property
    def bounds(self) -> Floats:
        """(2, 3): least and largest coordinates of points and corners of triangles, inf and -inf of none."""
        places = np.concatenate([self.points, self.triangles.reshape(-1, 3)])
        return np.stack([places.min(axis=0, initial=np.inf), places.max(axis=0, initial=-np.inf)])

    def _array(self, name, get):
        if name not in self._arrays:
            array = get()
            if array is not None:
                array.setflags(write=False)
            self._arrays[name] = array
        return self._arrays[name]

    # Nothing of the core's ever changes, so copies share it; areas that are set replace it.
    def __copy__(self) -> Surfels:
        return Surfels._from_core(self._core, self._faces)

    def __deepcopy__(self, memo: dict[int, Any]) -> Surfels:
        return Surfels._from_core(self._core, self._faces)

    def __getstate__(self) -> dict[str, Any]:
        return {"_core": self._core, "_arrays": {}, "_faces": self._faces and self._faces.without_colors()}

    def __len__(self) -> int:
        return len(self._core)

    __repr__, _repr_html_ = summaries.as_text, summaries.as_table

    def __getitem__(self, selection: slice | ArrayLike) -> Surfels:
        """The surfels chosen by a boolean mask (n,), an array or list of indices, a slice or one index; may be none.

        Triangles and areas go with them. Raises ValueError for anything else, IndexError past the end.
        """
        selected = check.selection("selection", selection, len(self))
        faces = None if self._faces is None else self._faces.taken(selected)
        return Surfels._from_core(self._core.select(selected), faces)

    flipped, replace = arranging.flipped, arranging.replace
    transformed, thinned = arranging.transformed, arranging.thinned

    def save(self, path: FilePath) -> Path:
        """Writes a binary PLY from which read() gives the surfels back, triangles included.

        Positions, radii, areas and the corners of triangles come back bit by bit; normals, reflectance and emission to
        the precision of float32, about 7 digits.

        Args:
            path: str or path, ending in .ply. A file that is there is replaced, whole or not at all.

        Returns:
            The Path written.

        Raises:
            ValueError: a path with another suffix; no surfels.
            FileError: a path that cannot be written.
        """
        return save_surfels(ply_path(path), check.some_surfels("surfels", self)._core)

    def to_pyvista(self, kind: Literal["points", "disks", "patches"] = "points") -> pyvista.PolyData:
        """pyvista.PolyData with normals, radius, area (where known), reflectance, emission and face (of from_mesh).

        Args:
            kind: "points" with point arrays; "disks" as they are drawn, polygons for disks and triangles for patches of
                a mesh, or "patches", the triangles alone, both with cell arrays and each cell's index "surfel"; "area"
                is shared out among the cells of a surfel, so that it adds up. The field array "units" says what is in
                what.

        Raises:
            ValueError: another kind, or "patches" where there are none.

        >>> import surflux as sf
        >>> s = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.25)
        >>> s.to_pyvista("patches").n_cells
        8
        """
        return to_polydata(self, kind, {} if self.faces is None else {"face": self.faces})

    plot, plot_areas = showing.plot, showing.plot_areas
