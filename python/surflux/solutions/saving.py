"""Files of solutions, written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.passes import LOG
from surflux._base.types import FilePath
from surflux.points.writing import pack_comments, save_surfels
from surflux.solutions.about import about_solution, pixels_of
from surflux.solutions.lit_gltf import save_gltf
from surflux.solutions.seen_colors import SeenColors
from surflux.solutions.towards import without_lobes

SUFFIXES = (".ply", ".glb", ".gltf")


def save(self: Any, path: FilePath, *, up: ArrayLike = (0.0, 0.0, 1.0)) -> Path:
    """Writes surfels and their light: as PLY, which load_solution reads, or lit, as glTF, for viewers.

    PLY is binary, with camera, Environments and figures. Positions, radii, areas and the corners of triangles come
    back bit by bit; normals, reflectance, emission, light and images of Environments to the precision of float32,
    about 7 digits. Left out are the basis of a meshless solution, which pickles and copies keep, and what is
    glossy, which copies keep: a warning says so. For other programs `red green blue` show the radiosity, the
    brightest percent of what does not emit as white, and what emits.

    glTF has the triangles of patches, with light that varies over them, and the points of disks: COLOR_0 as
    bright as those colours, shown without lights of the viewer's (KHR_materials_unlit), _IRRADIANCE and _RADIOSITY.

    Args:
        path: str or path, ending in .ply, .glb or .gltf. A file that is there is replaced, whole or not at all.
        up: (3,), what becomes y in glTF, by the matrix of its node.

    Returns:
        The Path written.

    Raises:
        ValueError: a path with another suffix; up.
        FileError: the file cannot be written.
    """
    up = check.direction("up", up)
    path = Path(check.path("path", path))
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"path: wanted a name ending in {', '.join(SUFFIXES)}, got {str(path)!r}")
    without_lobes(self, path)
    if SeenColors.of(self).textured.any():
        LOG.info("%s: textures are left out; from there, pictures show the mean of each patch", path)
    if path.suffix.lower() != ".ply":
        save_gltf(path, self, up)
        return path
    return save_surfels(
        path,
        self.surfels._core,
        radiosity=self.radiosity,
        irradiance=self.irradiance,
        direct=self.direct,
        columns={"parent": self.parents, "object": self.objects, "level": self.levels}
        | ({} if self.cut is None else {"cut": self.cut}),
        comments=pack_comments(about_solution(self)),
        pixels=pixels_of(self),
    )
