"""Gaussians from files."""

from __future__ import annotations

import os
from pathlib import Path

from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.files import file_error, require_file
from surflux._base.types import FilePath
from surflux.splats.gaussians import Gaussians, checked_up
from surflux.splats.gltf_reading import read_gltf
from surflux.splats.ply_file import read_ply


def load_gaussians(path: FilePath, *, up: ArrayLike | None = None) -> Gaussians:
    """The Gaussians of a file, PLY or glTF, that Gaussians.save or another program wrote.

    PLY as the program of Kerbl and others (2023) writes it, ascii or binary, not the compressed kinds. Of glTF all
    primitives with KHR_gaussian_splatting in the scene, by the matrices of their nodes, where those turn, move and
    scale alike in all directions; compressed ones are not read.

    Args:
        path: str or path, ending in .ply, .glb or .gltf.
        up: (3,), for glTF alone: what is to be up, which in the file is +y; None for (0, 0, 1). (0, 1, 0) keeps the
            coordinates of the file.

    Returns:
        Gaussians. Saved again under a name with the same ending, they are the same numbers, bit by bit, but for
        positions in survey coordinates, which are right to the precision of floats from an origin amid them.

    Raises:
        ValueError: path or up is none; `up` for PLY.
        FileError: with the path and the reason: a file that cannot be read, is cut off, or holds no Gaussians.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[0, 0, 0]], normals=[[0, 0, 1]], radii=0.1, areas=0.03)
    >>> solution = sf.solve(sf.Scene([floor], lights=[sf.DirectionalLight([0, 0, -1], 2.0)]))
    >>> path = sf.Gaussians.of(solution).save("floor.ply")
    >>> sf.load_gaussians(path)
    Gaussians(1 Gaussian, degree 0, srgb)
    """
    path = check.path("path", path)
    suffix = Path(path).suffix.lower()
    require_file(path)
    if suffix not in (".ply", ".glb", ".gltf"):
        raise file_error(path, "cannot be read as Gaussians; wanted a name ending in .ply, .glb or .gltf")
    if suffix == ".ply" and up is not None:
        raise ValueError("up: a .ply file has the coordinates of the scene; .glb and .gltf have one direction up")
    *arrays, space = read_ply(path) if suffix == ".ply" else read_gltf(path, checked_up(up))
    try:
        return Gaussians(*arrays, color_space=space)
    except ValueError as fault:
        raise file_error(os.fsdecode(path), str(fault)) from fault
