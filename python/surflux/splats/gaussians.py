"""Gaussians: what surfels send, baked for renderers of 3D Gaussian splatting."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.passes import watched
from surflux._base.types import FilePath, Floats, Progress
from surflux.solutions.solution import Solution
from surflux.splats.baking import baked
from surflux.splats.gltf_writing import write_gltf
from surflux.splats.ply_file import write_ply
from surflux.splats.view_colors import HIGHEST, colors_seen

COLOR_SPACES = ("srgb", "linear")
_LARGEST = float(np.float32(check.LARGEST))  # what is rounded to floats is not more than that, either
_UNIT = 1e-6  # a quaternion within this of unit length is one that was rounded to float32


class Gaussians:
    """Gaussians of 3D Gaussian splatting (Kerbl and others 2023), which viewers in browsers and game engines draw.

    `Gaussians.of(solution)` bakes the light that surfels send into them, `save` writes PLY and glTF, and
    `load_gaussians` reads both. They are rows of arrays, which are read-only.

    Surfels are one-sided, and Gaussians are not: from behind a surface its colours show, where surflux shows nothing. A
    camera outside of a room sees the outer side of its walls.

    Args:
        positions: (n, 3), in the unit of the surfels (m).
        scales: (n, 3) standard deviations along three axes, at least 0, in the same unit.
        rotations: (n, 4) quaternions (w, x, y, z) of those axes, of any length but 0.
        opacities: (n,) of the centre, 0 to 1.
        harmonics: (n, k, 3), k = 1, 4, 9 or 16: colours as spherical harmonics of degree 0 to 3 in the direction from
            the camera to the Gaussian, those of the file formats: with the Condon-Shortley phase, and 0.5 to be added.
        color_space: "srgb" where colours are sRGB-coded, as almost all are, or "linear". Either is what a display
            shows, exposed, with 1 for white; renderers blend Gaussians as they are coded.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.07)
    >>> solution = sf.solve(sf.Scene([floor], lights=[sf.Environment([1.0, 0.5, 0.5])]))
    >>> gaussians = sf.Gaussians.of(solution)
    >>> gaussians
    Gaussians(16 Gaussians, degree 0, srgb)
    >>> gaussians.scales[0].round(4)  # patches of 0.25 by 0.25
    array([0.1698, 0.1698, 0.0017])
    >>> gaussians.colors_towards([0, 0, 1])[0].round(3)  # white is what the brightest channel has
    array([1.   , 0.735, 0.735])
    >>> path = gaussians.save("floor.glb")
    """

    positions: Floats
    scales: Floats
    rotations: Floats
    opacities: Floats
    harmonics: Floats
    color_space: Literal["srgb", "linear"]

    def __init__(
        self,
        positions: ArrayLike,
        scales: ArrayLike,
        rotations: ArrayLike,
        opacities: ArrayLike,
        harmonics: ArrayLike,
        *,
        color_space: Literal["srgb", "linear"] = "srgb",
    ) -> None:
        positions = check.finite_array("positions", positions, (None, 3))
        self.positions = _kept(check.in_range("positions", positions, -_LARGEST, _LARGEST))
        n = len(positions)
        self.scales = _kept(check.in_range("scales", check.finite_array("scales", scales, (n, 3)), 0.0, _LARGEST))
        rotations = check.finite_array("rotations", rotations, (n, 4))
        unit = check.unit_vectors("rotations", rotations)
        rounded = np.abs(np.linalg.norm(np.clip(rotations, -2.0, 2.0), axis=1) - 1.0) <= _UNIT
        self.rotations = _kept(np.where(rounded[:, None], rotations, unit))
        self.opacities = _kept(check.in_range("opacities", check.finite_array("opacities", opacities, (n,)), 0.0, 1.0))
        given = check.numeric("harmonics", harmonics)
        if given.ndim != 3 or given.shape[1] not in (1, 4, 9, 16):
            raise ValueError(f"harmonics: wanted shape (n, k, 3) with k = 1, 4, 9 or 16, got {given.shape}")
        harmonics = check.finite_array("harmonics", given, (n, given.shape[1], 3))
        self.harmonics = _kept(check.in_range("harmonics", harmonics, -_LARGEST, _LARGEST))
        self.color_space = check.choice("color_space", color_space, COLOR_SPACES)

    @classmethod
    def of(
        cls,
        solution: Solution,
        *,
        degree: int | None = None,
        exposure: float | None = None,
        stops: float = 0.0,
        color_space: Literal["srgb", "linear"] = "srgb",
        threads: int | None = None,
        progress: Progress = False,
    ) -> Self:
        """The Gaussians of a solution, one for each of its surfels, in their order.

        Each stands for its surfel's share of the surface: for a disk it is round, for a patch of a mesh it has the axes
        of its second moments, and it is so wide that 1 % of what is behind the surface shows through. So outlines are
        wider by about a third of the distance of two surfels: surfels should be small where outlines matter. A third
        standard deviation is a hundredth of the others. Where surfels stand back to back, as with two_sided, Gaussians
        are moved off the surface by up to half a standard deviation: renderers would mix the two sides, and up to a
        twentieth of what is seen is still of the far one.

        Colours are exposed, cut off at 1 and coded. Those of diffuse surfels are the same from everywhere. Of glossy
        ones (DistantTransfer.relight) the coded colour as a function of the direction is fitted by least squares in
        front, at 64 directions; lobes narrower than harmonics of that degree (exponents above some 5) come out wider
        and dimmer. The scene's AreaLights are not among the surfels; lamps that are meshes with emission are.

        Args:
            solution: Solution, of any solver.
            degree: of the harmonics, 0 to 3; None for 3 where surfels are glossy, else 0. 3 makes files of diffuse
                surfels four times as large, for readers that take no other.
            exposure: the factor on radiance, as of tone_map; None to show the brightest percent of the surfels that do
                not emit white, as colours of files do.
            stops: so many times twice as bright, below 0 darker.
            color_space: "srgb", or "linear" for glTF files alone, whose viewers then blend light itself.
            threads: at most this many; None for all.
            progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

        Returns:
            Gaussians.

        Raises:
            ValueError: an argument, by name.
            Cancelled: the callback returned False.
        """
        if degree is not None:
            degree = check.count("degree", degree, 0, HIGHEST)
        check.choice("color_space", color_space, COLOR_SPACES)
        with watched(threads, progress):
            return cls(*baked(solution, degree, exposure, stops, color_space), color_space=color_space)

    @property
    def degree(self) -> int:
        """Of the harmonics, 0 to 3."""
        return round(self.harmonics.shape[1] ** 0.5) - 1

    def colors_towards(self, directions: ArrayLike) -> Floats:
        """What a viewer shows of each Gaussian at its centre, seen from a direction.

        Args:
            directions: (3,) for all, or (n, 3), away from the Gaussians, of any length but 0, as those of
                Solution.radiance_towards.

        Returns:
            (n, 3) in the coding of color_space, not below 0 and not cut off above.

        Raises:
            ValueError: directions of another shape, or of zero length.
        """
        given = check.numeric("directions", directions)
        given = np.broadcast_to(given, (len(self), 3)) if given.shape == (3,) else given
        towards = check.unit_vectors("directions", check.finite_array("directions", given, (len(self), 3)))
        return colors_seen(self.harmonics, towards)

    def save(self, path: FilePath, *, up: ArrayLike | None = None) -> Path:
        """Writes a file that viewers of Gaussian splatting open; load_gaussians reads it back.

        - .ply: as the program of Kerbl and others writes it, which most viewers read.
        - .glb, .gltf: glTF 2.0 with KHR_gaussian_splatting (ratified 2026), in one file. Viewers that do not know the
          extension show points in the colours of COLOR_0. Its node turns z up to y up, which glTF has.

        Both hold 32-bit floats. Of survey coordinates, which those do not hold, positions are written from an origin
        amid them: in glTF it is in the node, whose numbers are doubles; in PLY a comment keeps it for load_gaussians,
        and other programs show the Gaussians around 0.

        Args:
            path: str or path. A file that is there is replaced, whole or not at all.
            up: (3,), for glTF alone: what is up in the scene; None for (0, 0, 1). A scene that came from glTF has
                (0, 1, 0), and its coordinates stay.

        Returns:
            The Path written.

        Raises:
            ValueError: a path with another suffix; linear colours, or an `up`, for PLY; more than 4 GB for .glb.
            FileError: the file cannot be written.
        """
        path = Path(check.path("path", path))
        suffix = path.suffix.lower()
        if suffix not in (".ply", ".glb", ".gltf"):
            raise ValueError(f"path: wanted a name ending in .ply, .glb or .gltf, got {str(path)!r}")
        if suffix != ".ply":
            write_gltf(path, self, checked_up(up))
            return path
        if up is not None:
            raise ValueError("up: a .ply file has the coordinates of the scene; .glb and .gltf have one direction up")
        if self.color_space != "srgb":
            raise ValueError("path: linear colours fit into .glb and .gltf alone; a .ply file has them sRGB-coded")
        write_ply(path, self)
        return path

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"Gaussians({check.counted(len(self), 'Gaussian')}, degree {self.degree}, {self.color_space})"


def checked_up(up):
    """A unit vector (3,); None is +z."""
    return np.array([0.0, 0.0, 1.0]) if up is None else check.direction("up", up)


def _kept(array):
    array = array.copy()
    array.setflags(write=False)
    return array
