"""Point files, read as surfels."""

from __future__ import annotations

import os
import re

from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.files import file_error
from surflux._base.passes import watched
from surflux._base.types import FilePath, Integer, Progress
from surflux._base.warn import warn
from surflux.points.cleaning import cleaned
from surflux.points.ply_arrays import load_arrays
from surflux.points.scan import Format, scan_of_columns
from surflux.points.scan_surfels import arrays_of_scan, oriented_around, surfels_of_arrays
from surflux.points.surfels import Surfels
from surflux.scans.formats import format_of
from surflux.scans.reading import read_columns

# What the core says of a PLY file with points that scan_of_columns leaves out.
_NOT_FINITE = re.compile(r": vertex \d+: [xyz] is -?(nan|inf); wanted a finite number$")


def read(
    path: FilePath,
    format: Format | None = None,
    reflectance: ArrayLike | None = None,
    emission: ArrayLike = 0.0,
    viewpoint: ArrayLike | None = None,
    *,
    orient: bool | ArrayLike = False,
    clean: bool = False,
    points: Integer | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> Surfels:
    """Read a point file as surfels.

    PLY, PCD, XYZ, PTS, CSV, NPZ, OBJ without faces; LAS, LAZ (COPC, too) and E57 with pip install 'surflux[scans]'. The
    format is what the file begins with, else its suffix. Points, normals, colours and intensity are read wherever a
    format has them; read_scan also gives classes, returns, times and whatever else a file says of its points.

    Of PLY files the vertices become surfels; faces, but for the patches that Surfels.save writes, are left out, with a
    warning (Surfels.from_mesh is for them). Besides `x y z`, `nx ny nz` and colours, `radius`, `area`,
    `reflectance_r/g/b`, `emission_r/g/b`, `specular_r/g/b` and `exponent` are read; also `reflectance` and `emission`,
    one column, or an array (n, 3) of NPZ, and a warning says where their values are none, such as decibels. Names are
    known in any case, in every format; colours are `red green blue`, `r g b`, or CloudCompare's fractions `Rf Gf Bf`,
    and `Points:0`, `Normals:0` and `RGB:0` with their 1 and 2 are ParaView's. A warning names columns that look like
    colours and are not taken.

    Args:
        path: str or path.
        format: "ply", "pcd", "las", "laz", "copc", "e57", "npz", "obj", or text with columns that have no names: "xyz",
            "xyzn" (normals), "xyzrgb" (colours), "pts", "csv"; None to see.
        reflectance: one number, RGB (3,), (n,) or (n, 3), instead of what the file says; None for the file's
            `reflectance_r/g/b` or `reflectance`, else its colours, sRGB made linear with white (255, 65535 or 1) at
            .98, else grey by its intensity, at most .98 and .5 on average (where it is not known, too: NaN, or one
            value below 0 that stands for no data, as -9999), else 0.5.
        emission: exitance, the same shapes; 0 keeps what the file says.
        viewpoint: (3,), where the points were seen from; orients normals that are estimated. None for what the file
            says: the position of each scan of an E57 file, the viewpoint of a PCD file where it is not the default, or
            the cloud is a picture of a depth camera.
        orient: True turns the file's normals over where they face inwards (see `facing`), and logs it; or a place in
            the air (3,), or several (k, 3), such as a camera: what closes around one is a room, seen from inside.
            Patches stay as they are.
        clean: True leaves out, as `surflux solve` does, what is not of the surface, and logs how many: points that
            stand alone, or float with few others, four times as far from all else as is usual (none where more than a
            hundredth of all would, for such a cloud is sampled unevenly), points that a LAS file withholds, and all but
            the first at one place that face one side. Points of a depth camera are moved, see
            Scan.without_depth_steps.
        points: at most so many: a file with more is thinned while it is read, to an even sample of one point in each
            cell of a grid, without ever being whole in memory. None for all. Normals that the file lacks are fitted to
            more points: eight times as many, up to a million, or twice as many. Radii are those of what is left.
        seed: of that grid.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Surfels. Normals that the file lacks are estimated; also those that are zero or not finite, with a warning.
        Points without a finite place are left out, with a warning, too.

    Raises:
        FileError: the file cannot be read, or holds no points, or what it holds cannot be surfels. Names the path, the
            line or byte where there is one, and the reason.
        ValueError: an argument, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> path = sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, 1]], radii=0.6).save("two.ply")
    >>> sf.read(path, reflectance=0.8)
    Surfels(2 surfels, no areas)
    """
    more = {"orient": orient, "clean": clean, "points": points, "seed": seed, "threads": threads, "progress": progress}
    surfels, faces = read_with_faces(path, format, reflectance, emission, viewpoint, **more)
    warn_of_faces(path, faces)
    return surfels


def warn_of_faces(path, faces):
    """Says that a file has faces, where it has some and they are left out."""
    if faces:
        warn(
            f"{os.fsdecode(path)}: has {check.counted(faces, 'face')}, left out because it is read as points: "
            'surflux.Surfels.from_mesh reads it as a mesh (kind = "mesh" in a scene file, kind = "surfels" for points; '
            "surflux solve --mesh)"
        )


def read_with_faces(
    path,
    format=None,
    reflectance=None,
    emission=0.0,
    viewpoint=None,
    *,
    orient=False,
    clean=False,
    points=None,
    seed=0,
    threads=None,
    progress=False,
):
    """What `read` returns, and how many faces the file has that are left out."""
    path = check.path("path", path)
    if viewpoint is not None:
        viewpoint = check.vector3("viewpoint", viewpoint)
    if points is not None:
        points = check.count("points", points, 2)
    seed, clean = check.seed("seed", seed), check.flag("clean", clean)
    orient = oriented_around(orient)
    with watched(threads, progress):
        arrays = _arrays(path, format, points, seed, clean)
        return surfels_of_arrays(path, arrays, reflectance, emission, viewpoint, orient), arrays["faces"]


def _arrays(path, format, points, seed, clean):
    """PLY files go through the core, which also knows patches, but for those to be thinned or with points left out."""
    form = format_of(path, format)
    if form == "ply":
        elements = _core.read_ply(path, [])["elements"]
        has_patches = elements.get("patch", 0) > 0
        if clean and has_patches:
            raise file_error(path, "has patches, of which none is left out: clean is for points")
        if not clean and (points is None or elements.get("vertex", 0) <= points):
            try:
                return load_arrays(path, form)
            except _core.FileError as error:
                if not _NOT_FINITE.search(str(error)) or has_patches:
                    raise
        elif has_patches:
            raise file_error(path, f"its patches would be torn apart by points={points}; read all of it")
    columns = read_columns(path, format, points, seed)
    scan = scan_of_columns(path, columns)
    if clean:
        used = cleaned(scan, undo="clean = false keeps them")[0]
        if len(used) == 0:
            raise file_error(path, "all of its points are withheld; clean = false takes them")
        scan = scan[used].without_depth_steps()
    return arrays_of_scan(scan) | {"faces": columns.faces}
