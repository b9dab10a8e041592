"""Scans: points with all that their file says of each."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux._base import check
from surflux._base.color import WHITE, linear_to_srgb, reflectance_of_colors, white_of_colors
from surflux._base.files import file_error
from surflux._base.frozen import frozen, given_away
from surflux._base.passes import LOG, watched
from surflux._base.types import FilePath, Floats, Integer, Progress
from surflux.points.denser import denser_normals
from surflux.points.depth_steps import without_steps
from surflux.points.exposure import warn_of_black
from surflux.points.properties import has_linear, unit_normals, warn_of_colors_left
from surflux.points.scan_surfels import arrays_of_scan, oriented_around, surfels_of_arrays
from surflux.points.seen_from import FACED, FACING, viewed_from
from surflux.points.surfels import Surfels
from surflux.scans.columns import FLAGS
from surflux.scans.names import OWN, Names
from surflux.scans.reading import read_columns
from surflux.scans.viewpoints import rows_of_places
from surflux.scans.writing import write_points, written_suffix

_BLOCK = 1_000_000  # colours made linear at once
_NOWHERE = np.zeros((0, 3))
Format = Literal["ply", "pcd", "las", "laz", "copc", "e57", "npz", "xyz", "xyzn", "xyzrgb", "pts", "csv", "obj"]


@dataclass(frozen=True, eq=False, repr=False)
class Scan:
    """Points as a file has them, with whatever it says of each: what read makes surfels of. Arrays are read-only, and
    copies of those given.

    >>> import numpy as np, surflux as sf
    >>> np.savez("roof.npz", points=np.random.default_rng(0).random((50, 3)), classification=np.arange(50) % 7)
    >>> scan = sf.read_scan("roof.npz")
    >>> scan
    Scan(50 points; classification)
    >>> scan[scan.attributes["classification"] == 6].surfels()
    Surfels(7 surfels, no areas)
    """

    points: Floats
    """(n, 3) float64, in the frame of the file: offsets and poses are applied."""
    normals: Floats | None = None
    """(n, 3), unit; rows of NaN where the file's are zero or not finite. None where it has none."""
    reflectance: Floats | None = None
    """(n, 3) linear reflectance of the file's colours, 0 to 1, white at .98. None where it has none, or all are 0."""
    attributes: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """What else is known, (n,) each or (n, m), in its own type: intensity, classification, return_number,
    number_of_returns, point_source_id, gps_time, scan_angle (degrees), label, scan, and the file's other columns."""
    viewpoints: Floats = field(default_factory=lambda: _NOWHERE)
    """(k, 3): where each of k scans was taken from, rows of NaN where the file does not say. With more than one,
    attributes["scan"] says of each point which is its own. Of points thinned while they were read the
    origin, where all were as dense as if a scanner had turned there."""
    rows: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    """(n,): the row of the file that each point stands in; some are missing where points were left out."""
    name: str = "scan"
    """Of messages: the path."""
    frame: Mapping[str, Any] | None = None
    """Of a LAS file: steps of its coordinates, its reference system and format of points, which save keeps."""
    fitted: Floats | None = None
    """(n, 3), unit: of points without normals that were thinned while they were read, those of fits to more points of
    the file, which surfels() turns to the side that is seen. None: it fits them to the points."""

    def __post_init__(self) -> None:
        points = check.numeric("points", self.points)
        n = len(points) if points.ndim else 1
        own = {"points": check.rows("points", points, n, 3)}
        for name in ("normals", "reflectance", "fitted"):
            if (value := getattr(self, name)) is not None:
                own[name] = check.rows(name, value, n, 3)
        if "reflectance" in own:
            own["reflectance"] = check.in_range(
                "reflectance", check.all_finite("reflectance", own["reflectance"]), 0, 1
            )
        viewpoints = check.numeric("viewpoints", self.viewpoints)
        k = len(viewpoints) if viewpoints.ndim > 1 else 1
        own["viewpoints"] = check.rows("viewpoints", viewpoints, k, 3) if viewpoints.size else _NOWHERE
        for name, values in own.items():
            object.__setattr__(self, name, frozen(values, np.float64))
        object.__setattr__(self, "rows", frozen(self.rows))
        for name, values in check.arrays_by_name("attributes", self.attributes).items():
            if np.ma.is_masked(values) or np.shape(values)[:1] != (n,):
                got = "a masked array" if np.ma.is_masked(values) else f"shape {np.shape(values)}"
                raise ValueError(f"{name}: wanted an array of {check.counted(n, 'row')}, got {got}")
        object.__setattr__(self, "attributes", {name: frozen(of) for name, of in self.attributes.items()})

    @property
    def viewpoint(self) -> Floats | None:
        """(3,): where all points were seen from; None where that is not known, or not one place."""
        return self.viewpoints[0] if len(self.viewpoints) == 1 and np.all(np.isfinite(self.viewpoints)) else None

    def __setstate__(self, state: dict[str, Any]) -> None:
        for values in (*state.values(), *state["attributes"].values()):
            if isinstance(values, np.ndarray):
                given_away(values)
        self.__dict__.update(state)

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        has = [name for name in ("normals", "reflectance") if getattr(self, name) is not None]
        return (
            f"Scan({'; '.join([check.counted(len(self), 'point'), ', '.join([*has, *self.attributes])]).rstrip('; ')})"
        )

    def __getitem__(self, selection: slice | ArrayLike) -> Scan:
        """The points chosen by a boolean mask (n,), an array or list of indices, or a slice.

        Raises ValueError for anything else, IndexError past the end.
        """
        chosen = check.selection("selection", selection, len(self))

        def some(values):
            return None if values is None else given_away(values[chosen])

        return Scan(
            some(self.points),
            some(self.normals),
            some(self.reflectance),
            {name: some(values) for name, values in self.attributes.items()},
            self.viewpoints,
            some(self.rows) if len(self.rows) == len(self) else self.rows,
            self.name,
            self.frame,
            some(self.fitted),
        )

    def surfels(
        self,
        reflectance: ArrayLike | None = None,
        emission: ArrayLike = 0.0,
        viewpoint: ArrayLike | None = None,
        *,
        orient: bool | ArrayLike = False,
        threads: int | None = None,
        progress: Progress = False,
    ) -> Surfels:
        """Surfels of the points, as read gives them.

        Args:
            reflectance, emission: as read takes them. None is the reflectance of the colours, else grey by the
                intensity, .5 on average, else .5.
            viewpoint: (3,), towards which estimated normals turn; None for the scan's own, each scan's for its points.
            orient: as read takes it.
            threads: at most this many; None for all.
            progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
                False cancels.

        Raises:
            ValueError: an argument, by name.
            FileError: the points cannot be surfels.
            Cancelled: the callback returned False.
        """
        if viewpoint is not None:
            viewpoint = check.vector3("viewpoint", viewpoint)
        with watched(threads, progress):
            arrays = arrays_of_scan(self)
            return surfels_of_arrays(self.name, arrays, reflectance, emission, viewpoint, oriented_around(orient))

    def without_depth_steps(self, progress: Progress = False) -> Scan:
        """The frame of a depth camera with its points where planes through the steps of its depth are.

        Structured light and stereo measure 1 / |z| in whole steps, and walls come out as flights of stairs: normals
        face the camera, and disks stand apart. Points are moved along their rays by some steps at most, to planes that
        are fitted to the pixels around; those nearer or farther than all of these are left out. `surflux solve`
        does this to the frames that it reads. Logs what was done.

        Args:
            progress: True for a bar on stderr, or a callback (done, total) -> bool; False cancels.

        Returns:
            Scan; this one where points are no such frame: seen from the origin along z or back, with few depths.

        Raises:
            Cancelled: the callback returned False.

        >>> import numpy as np, surflux as sf
        >>> x, y = np.meshgrid(np.linspace(-0.5, 0.5, 100), np.linspace(-0.4, 0.4, 80))
        >>> steps = np.round((0.5 + 0.2 * x) / 0.003)  # of a wall at an angle
        >>> scan = sf.Scan((np.dstack([x, y, np.ones_like(x)]) / (0.003 * steps)[..., None]).reshape(-1, 3))
        >>> off = [abs(p @ [0.2, 0.0, 0.5] - 1.0).mean() for p in (scan.points, scan.without_depth_steps().points)]
        >>> bool(off[1] < 0.3 * off[0])
        True
        """
        with watched(None, progress):
            found = without_steps(self.points)
        return self if found is None else replace(self, points=found[0], fitted=None)[found[1]]

    def save(
        self,
        path: FilePath,
        columns: Mapping[str, ArrayLike] | None = None,
        *,
        normals: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        comments: Sequence[str] = (),
        up: ArrayLike = (0.0, 0.0, 1.0),
    ) -> Path:
        """Writes the points in their order, with all that is known of each, and what was found for them.

        PLY and CSV have all (PLY whole numbers up to 2^53); `red`, `green` and `blue` in bytes; (n, 3) columns by
        channel, as name_r, name_g and name_b; a name that another column has, such as x, gets a number, with a
        warning. Where points are missing or in another order, `row` is the row of each in the file that was read, row_2
        where that file has a `row` of its own. LAS and LAZ take `pip install 'surflux[scans]'`; what they have no field
        for stands in extra dimensions, and is read back by its name; coordinates of a LAS file come back bit by bit,
        with its coordinate reference system. NPZ has arrays by name, VTP is for ParaView, glTF (.glb, .gltf) for
        viewers, which have y up; points of these two are not read back. PLY and NPZ keep viewpoints, too; of points
        without normals a warning says where they are lost.

        Args:
            path: ending in .ply, .las, .laz, .csv, .npz, .vtp, .glb or .gltf. A file that is there is replaced, whole
                or not at all.
            columns: more of each point by name, (n,) or (n, k); in place of attributes of the same name, or of its
                channels. NaN: not known.
            normals: (n, 3) in place of the scan's.
            colors: (n, 3), whole numbers from 0 to 255, of what is to be seen; None for the reflectance, .98 being
                white.
            comments: lines of text, which PLY files hold.
            up: (3,), what becomes y in glTF, by the matrix of its node.

        Returns:
            The Path written.

        Raises:
            ValueError: an argument, by name.
            FileError: the file cannot be written; where it takes a package that is not installed, the line that
                installs it.

        >>> import surflux as sf
        >>> scan = sf.Scan([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], attributes={"classification": [2, 6]})
        >>> again = sf.read_scan(scan.save("lit.ply", {"kwh": [1100.0, 950.5]}))
        >>> again.attributes["kwh"].tolist(), again.attributes["classification"].tolist()
        ([1100.0, 950.5], [2, 6])
        """
        return self._save(path, columns, normals, colors, comments, up)

    def _save(self, path, columns, normals, colors, comments, up, pixels=None):
        """Writes as `save` does; pixels: as of write_points."""
        suffix, n = written_suffix(check.path("path", path)), len(self)
        up = check.direction("up", up)
        if n == 0:
            raise ValueError("path: wanted points to write, and there are none")
        out = {"points": check.finite_array("points", self.points, (n, 3))}
        given = self.normals if normals is None else check.rows("normals", normals, n, 3)
        if given is not None:
            out["normals"] = given
        if colors is not None:
            out["colors"] = check.byte_colors("colors", colors, n)
        elif self.reflectance is not None:
            out["colors"] = self.display_colors(16 if suffix in (".las", ".laz") else 8)
        columns = {} if columns is None else check.arrays_by_name("columns", columns)
        given = {str(name): check.rows(f"columns: {name}", values, n) for name, values in columns.items()}
        for where, names in (("columns", given), ("attributes", self.attributes)):
            own = next((name for name in names if name in OWN), None)
            if own is not None:
                raise ValueError(f"{where}: {own} are what a file has for its own; wanted another name")
        replaced = {f"{name}_{c}" for name, values in given.items() if values.ndim == 2 for c in "rgb"}
        for name, values in self.attributes.items():
            if name not in replaced:
                out[str(name)] = check.rows(f"attributes: {name}", values, n)
        out |= given
        path = Path(os.fsdecode(path))
        if len(self.rows) == n and not np.array_equal(self.rows, np.arange(n)):
            names = Names(path, out)
            out[names.free("row")] = self.rows
            names.warn_of_others()
        write_points(path, out, self.frame, comments, up, pixels, self.viewpoints)
        return path

    def display_colors(self, bits: Literal[8, 16] = 8) -> NDArray[np.uint8] | NDArray[np.uint16]:
        """(n, 3): the reflectance as sRGB in so many bits, .98 being white; grey where the scan has none."""
        kind = np.uint8 if bits == 8 else np.uint16
        if self.reflectance is None:
            return np.full((len(self), 3), 128, dtype=kind) * kind(1 if bits == 8 else 257)
        return np.rint((2**bits - 1) * linear_to_srgb(self.reflectance / WHITE)).astype(kind)


def read_scan(
    path: FilePath,
    format: Format | None = None,
    *,
    points: Integer | None = None,
    seed: int = 0,
    strict: bool = False,
    progress: Progress = False,
) -> Scan:
    """Read a file of points with all that it says of each.

    Args:
        path, format, points, seed: as read takes them.
        strict: True refuses a file with points that have no finite place, which are left out otherwise.
        progress: True for bars on stderr, or a callback (done, total) -> bool; False cancels. The total is 0 where the
            file does not say how many points it has.

    Returns:
        Scan. Points without a finite place are left out, with a warning that says how many.

    Raises:
        FileError: the file cannot be read, or holds no points. Names the path, the line or byte where there is one, and
            the reason; where it takes a package that is not installed, the line that installs it.
        ValueError: an argument, by name.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> with open("scan.csv", "w") as file:
    ...     _ = file.write("x,y,z,intensity\\n635619.85,848899.70,406.59,12\\n635621.10,848899.95,406.61,80\\n")
    >>> scan = sf.read_scan("scan.csv")
    >>> scan.points[0].tolist(), scan.attributes["intensity"].tolist()
    ([635619.85, 848899.7, 406.59], [12.0, 80.0])
    """
    return read_scan_with_faces(path, format, points=points, seed=seed, strict=strict, progress=progress)[0]


def read_scan_with_faces(path, format=None, *, points=None, seed=0, strict=False, progress=False):
    """What read_scan returns, and how many faces the file has that are left out."""
    path = check.path("path", path)
    if points is not None:
        points = check.count("points", points, 2)
    seed, strict = check.seed("seed", seed), check.flag("strict", strict)
    with watched(None, progress):
        columns = read_columns(path, format, points, seed, strict)
        return scan_of_columns(path, columns), columns.faces


@np.errstate(invalid="ignore", over="ignore")  # of what any bytes mean as numbers
def scan_of_columns(path, read):
    """The Scan of what read_columns read of a path."""
    columns = {name: values for name, values in read.columns.items() if name not in FLAGS or np.any(values)}
    points, normals, colors = (columns.pop(name, None) for name in ("points", "normals", "colors"))
    places = rows_of_places(read.viewpoints)
    if read.uniform is not None and "scan" not in columns and not np.any(np.isfinite(places)):
        kind, place = viewed_from(read.uniform)
        if kind == "turn":  # which points as even as these are now do not tell
            places = place[None, :]
            if normals is None:
                LOG.info(FACING, os.fsdecode(path), FACED[kind])
    fitted = None if read.around is None else denser_normals(points, read)
    if not has_linear(columns, "reflectance"):  # else colours show something else
        warn_of_black(os.fsdecode(path), colors)
        if colors is None:
            warn_of_colors_left(path, columns)
    return Scan(
        given_away(points),
        None if normals is None else given_away(unit_normals(normals)),
        None if colors is None else given_away(_reflectance(path, colors, read.rows)),
        {name: given_away(values) for name, values in columns.items()},
        places,
        given_away(read.rows),
        file_error(path, "").args[0].removesuffix(": "),
        read.frame,
        None if fitted is None else given_away(fitted),
    )


def _reflectance(path, colors, rows):
    bad = ~np.all(np.isfinite(colors) & (colors >= 0), axis=1)
    if np.any(bad):
        row = int(np.argmax(bad))
        value = colors[row][~(np.isfinite(colors[row]) & (colors[row] >= 0))][0]
        raise file_error(path, f"point {rows[row]}: colour is {value:g}; wanted a finite number not below 0")
    if not np.any(colors):
        return None  # a record with room for colours that nobody filled in
    white = white_of_colors(colors, "float" if colors.dtype.kind == "f" else "uchar", path)
    if white is None:
        row = int(np.argmax(colors.max(axis=1)))
        raise file_error(path, f"point {rows[row]}: colour is {colors.max():g}; wanted at most 1, 255 or 65535")
    out = np.empty(colors.shape)
    for begin in range(0, len(colors), _BLOCK):
        out[begin : begin + _BLOCK] = reflectance_of_colors(colors[begin : begin + _BLOCK], white)
    return out
