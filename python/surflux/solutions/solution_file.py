"""Solutions from files."""

from __future__ import annotations

import math
import os

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.files import file_error
from surflux._base.types import FilePath
from surflux.pictures.camera import Camera
from surflux.points.ply_arrays import load_arrays
from surflux.points.surfels import Surfels
from surflux.points.writing import unpack_comments
from surflux.scans.formats import format_of
from surflux.scenes.lights import AreaLight
from surflux.solutions.about import environments_of
from surflux.solutions.solution import Solution

HEADER_LIMIT = 1 << 20  # bytes: what a solution says about itself is in there


NO_SOLUTION = "holds points but no solution"


def load_solution(path: FilePath) -> Solution:
    """The Solution that Solution.save wrote.

    Files have no lobes: of surfels that are glossy the diffuse part is shown, and `radiance_towards` and pictures warn.

    Raises:
        ValueError: path is none.
        FileError: with the path and the reason; a file of points that holds no solution is none.

    >>> import surflux as sf
    >>> floor = sf.Surfels([[0, 0, 0]], normals=[[0, 0, 1]], radii=0.1, areas=0.03)
    >>> path = sf.solve(sf.Scene([floor], lights=[sf.DirectionalLight([0, 0, -1], 2.0)])).save("floor.ply")
    >>> sf.load_solution(path).irradiance
    array([[2., 2., 2.]])
    """
    path = check.path("path", path)
    if os.path.isfile(path) and os.fsdecode(path).lower().endswith(".toml"):
        raise file_error(path, f"holds a scene but no solution; `surflux solve {os.fsdecode(path)}` makes one")
    if os.path.isfile(path) and (form := format_of(path)) != "ply":
        raise file_error(path, f"is no solution, but {form}; `surflux solve {os.fsdecode(path)}` makes one")
    arrays = load_arrays(path)
    about = unpack_comments(arrays["comments"], path)
    if about.get("solution") != 1 or any(arrays[name] is None for name in ("radiosity", "irradiance", "direct")):
        raise file_error(path, f"{NO_SOLUTION}; `surflux solve {os.fsdecode(path)}` makes one")
    try:
        camera = None if about["camera"] is None else Camera(**about["camera"])
        lamps = [AreaLight(*lamp) for lamp in about["lamps"]]
        environments = environments_of(about, arrays["environment"])
        error = float(_number(about["error"]))
        timings = {stage: float(seconds) for stage, seconds in dict(about["timings"]).items()}
        history, attempts = (
            [{name: _number(value) for name, value in dict(figures).items()} for figures in entries]
            for entries in (about["history"], about.get("attempts", ()))
        )
    except (AttributeError, KeyError, TypeError, ValueError, OverflowError) as fault:
        raise file_error(path, f"its description of the solution is damaged ({fault})") from fault
    given = ("normals", "radii", "areas", "reflectance", "emission")
    for name in given:
        if arrays[name] is None:
            raise file_error(path, f"its surfels have no {name}, which a solution has")
    try:
        check.finite_array("normals", arrays["normals"], (None, 3))
        core = _core.Surfels(
            arrays["points"],
            *(arrays[name] for name in given),
            arrays["triangles"],
            arrays["triangle_surfel"],
            **arrays["gloss"],
        )
    except ValueError as fault:
        raise file_error(path, str(fault)) from fault
    columns = arrays["columns"]
    n = len(arrays["points"])  # each surfel and each object of the scene has at least one of them
    if about.get("points") == 1:  # of a cloud, by the rows of its file
        columns = {"parent": np.arange(n), "object": np.zeros(n)}  # others of these names are the cloud's
    solution = Solution(
        Surfels._from_core(core),
        parents=_indices(path, columns, "parent", "a surfel", n),
        objects=_indices(path, columns, "object", "an object", n),
        levels=_levels(path, columns),
        radiosity=arrays["radiosity"],
        irradiance=arrays["irradiance"],
        direct=arrays["direct"],
        cut=_indices(path, columns, "cut", "a node") if "cut" in columns else None,
        error=error,
        timings=timings,
        history=history,
        attempts=attempts,
        lamps=lamps,
        environments=environments,
        camera=camera,
    )
    solution._lobes_lost = about.get("lobes_lost", core.has_specular) is True
    return solution


def _number(figure):
    return math.nan if figure is None else figure


def _indices(path, columns, name, what, below=2**31):
    if name not in columns:
        raise file_error(path, f"its surfels have no {name}, which a solution has")
    column = columns[name]
    with np.errstate(invalid="ignore"):
        bad = ~((column >= 0) & (column < below) & (column == np.floor(column)))
    if np.any(bad):
        row = int(np.argmax(bad))
        raise file_error(path, f"vertex {row}: {name} is {column[row]:g}; wanted the index of {what}")
    return column.astype(np.uint32)


def _levels(path, columns):
    """None of a file that was written before there were some."""
    column = columns.get("level")
    if column is not None and not np.all(np.abs(column) < 2**15):
        raise file_error(path, f"vertex {int(np.argmin(np.abs(column) < 2**15))}: its level is out of range")
    return column


def holds_solution(path):
    """Whether the header of a PLY file that can be read names what only a solution has."""
    with open(path, "rb") as file:
        header = file.read(HEADER_LIMIT).split(b"end_header")[0].split()
    return all(name in header for name in (b"radiosity_r", b"irradiance_r", b"direct_r"))
