"""Files of points as columns, whole or thinned while they are read."""

from typing import NamedTuple

import numpy as np

from surflux._base import check
from surflux._base.files import file_error
from surflux._base.passes import LOG, report, stage
from surflux._base.warn import warn
from surflux.scans.e57 import open_e57
from surflux.scans.formats import format_of
from surflux.scans.las import open_las
from surflux.scans.npz import open_npz
from surflux.scans.obj import open_obj
from surflux.scans.pcd import open_pcd
from surflux.scans.ply import open_ply
from surflux.scans.text import open_text
from surflux.scans.thinning import EvenSample, UniformSample, joined

_OPEN = {"ply": open_ply, "pcd": open_pcd, "las": open_las, "e57": open_e57, "npz": open_npz, "obj": open_obj}
# Of disks: fewer of them do not cover the surface.
_REACHES = ("radius", "area")
_FARTHEST = 1e30
_NEARLY = 0.95  # of the points that are asked for: fewer are told
_UNIFORM = 30_000  # points that tell how dense the scanner was
# Times the points that are taken: what is kept besides for fits, and of few points as many as are soon fitted.
_LEAST_AROUND, _MOST_AROUND, _FIT_IN = 2, 8, 1_000_000
_NOISE = (7, 18)  # classes of LAS
_ROW = "\0row"  # no column of a file has this name


class Columns(NamedTuple):
    """What a file says of its points."""

    columns: dict  # as chunks of a PointFile have them
    rows: np.ndarray  # (n,) int64: where in the file each point stands
    count: int  # of points in the file
    viewpoints: list  # (3,) each, or None
    faces: int
    frame: dict | None = None  # as PointFile has it
    uniform: np.ndarray | None = None  # (m, 3): of points that are thinned, some as dense as they were but for a factor
    around: np.ndarray | None = None  # (m, 3): of points without normals that are thinned, more, as even; else None
    cell: float | None = None  # of the grid that they are thinned by


@np.errstate(invalid="ignore", over="ignore")  # of what any bytes mean as numbers
def read_columns(path, format=None, points=None, seed=0, strict=False):
    """The columns of a file of points; points that are not finite are dropped, with a warning that says how many.

    Args:
        path: str or path.
        format: as format_of takes it.
        points: at most so many, an even sample taken while the file is read; None for all.
        seed: of that sample.
        strict: refuses points that are not finite.

    Raises:
        FileError: the file cannot be read, or holds no points, or some that are refused.
        Cancelled: the callback of the watched pass returned False.
    """
    form = format_of(path, format)
    opened = _OPEN[form](path) if form in _OPEN else open_text(path, form)
    thin = points is not None and (opened.count is None or opened.count > points)
    sample, kept = EvenSample(points, seed) if thin else None, []
    uniform = UniformSample(_UNIFORM, seed) if thin else None
    around = EvenSample(_around(points), seed) if thin else None
    told, count, dropped = stage("reading"), 0, 0
    for chunk in opened.chunks:
        first, count = count, count + len(chunk["points"])
        finite = np.all(np.isfinite(chunk["points"]), axis=1)
        _check_places(path, chunk["points"], finite, first)
        if strict and not np.all(finite):
            row = int(np.argmin(finite))
            at = ", ".join(f"{value:g}" for value in chunk["points"][row])
            raise file_error(path, f"point {first + row}: is at ({at}); wanted finite coordinates")
        rows = np.flatnonzero(finite)
        if len(rows) < len(finite):
            dropped += len(finite) - len(rows)
            chunk = {name: values[rows] for name, values in chunk.items()}
        chunk[_ROW] = rows + first
        if len(rows) and thin:
            uniform.add(chunk["points"])
            sample.add(chunk)
            around = _added(around, chunk)
        elif len(rows):
            kept.append(chunk)
        report(told, count, opened.count or 0)
    if count == dropped:
        none = f"none of its {count} has finite coordinates" if count else "it has none"
        raise file_error(path, f"no points: {none}")
    if dropped:
        shown = file_error(path, "").args[0].removesuffix(": ")
        what = check.counted(dropped, "point")
        warn(f"{shown}: {what} of {count} left out, without a finite place")
    columns = sample.columns() if thin else joined(kept)
    if thin and len(columns["points"]) < count - dropped:
        for name in [name for name in columns if name.lower() in _REACHES]:
            columns.pop(name)
        if len(columns["points"]) < _NEARLY * min(points, count - dropped):
            shown, taken = file_error(path, "").args[0].removesuffix(": "), len(columns["points"])
            LOG.info(
                "%s: %d points are taken, fewer than the %d asked for: many stand in one place", shown, taken, points
            )
    rows, dense = columns.pop(_ROW), uniform.points() if thin else None
    more = {} if around is None or len(rows) == count - dropped else around.columns()
    given = columns, rows, count, opened.viewpoints(), opened.faces, opened.frame, dense
    return Columns(*given, more.get("points"), sample.cell if more else None)


def _around(points):
    """How many points to keep for fits, of a file of which so many are taken: some times as many, and more of few."""
    return min(_MOST_AROUND * points, max(_LEAST_AROUND * points, _FIT_IN))


def _added(around, chunk):
    """The EvenSample with what of a chunk is of surfaces; None once points have normals, or of None."""
    if around is None or np.any(chunk.get("normals", 0.0)):
        return None
    points = chunk["points"]
    strays = np.isin(chunk.get("classification", np.zeros(len(points))), _NOISE) | (
        np.asarray(chunk.get("withheld", np.zeros(len(points)))) == 1
    )
    if not np.all(strays):
        around.add({"points": points[~strays] if np.any(strays) else points})
    return around


def _check_places(path, points, finite, first):
    """Refuses coordinates of which squares leave the range of numbers, as Surfels does, naming the first."""
    far = finite & np.any(np.abs(points) > _FARTHEST, axis=1)
    if np.any(far):
        row = int(np.argmax(far))
        largest = points[row][np.argmax(np.abs(points[row]))]
        raise file_error(path, f"point {first + row}: a coordinate is {largest:g}; wanted up to {_FARTHEST:g}")
