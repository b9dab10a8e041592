"""What is decided for all tiles together, so that no seams show: a pass over them that keeps a thinned overview."""

from dataclasses import dataclass

import numpy as np

from surflux._base import check
from surflux._base.files import file_error
from surflux._base.passes import LOG, report, stage
from surflux.geometry.estimates import estimated_normals
from surflux.points.cleaning import some_stray, standing_alone
from surflux.points.layers import layer_of
from surflux.points.properties import unit_normals
from surflux.points.scan_surfels import with_estimated
from surflux.points.shades import Shades
from surflux.points.terrain import high_above
from surflux.scans.lattice import Lattice
from surflux.scans.thinning import EvenSample
from surflux.scans.tiling import points_around
from surflux.solving.tile_far import FarField

MATERIALS = tuple(f"{name}_{c}" for name in ("reflectance", "emission") for c in "rgb")
# Columns of points that light goes by.
NEEDED = {"normals", "colors", "intensity", "withheld", *MATERIALS}
_OVERVIEW = 40_000  # points
_FEW = 100  # points of a thinned tile, whose normals are estimated before it is thinned
_CELLS = 1.5  # of a turned lattice, that a surface goes through, for each that its area holds: a mean of directions
_OFF_LATTICE = 1e-2  # steps: coordinates are rounded to 64 bits
_BACKWARDS = 0.8  # of the points that face away from above: the files have their normals the other way round


@dataclass(eq=False)
class TileOptions:
    """What solve_tiles takes, checked; lengths in the unit of the files."""

    halo: float
    far: float
    points: int
    viewpoint: np.ndarray | None
    normals: str
    keep_outliers: bool
    raw_colors: bool
    seed: int


class Survey:
    """All tiles as one.

    Attributes:
        headers: TileHeader of each.
        low, high: (t, 3) corners of the box around the points of each.
        shades: Shades.
        strays: whether points that stand alone are left out.
        viewpoint: (3,) towards which estimated normals turn; None where the files have normals.
        turned: whether the normals of the files face the wrong way, all of them.
        spacing: how far points are apart, about.
        lattice: Lattice of all samples.
        cell: of points in a tile and its halo; None where all are taken.
        far: FarField.
        overview: columns of a thinned sample of all tiles, as far has them.
    """

    def __init__(self, headers, folder, options):
        self.headers, self.options = headers, options
        counts = np.array([tile.count for tile in headers])
        low, high = (np.array([getattr(tile, name) for tile in headers]) for name in ("low", "high"))
        self.spacing = _spacing(counts, low, high)
        self.lattice = Lattice(options.seed, low.min(axis=0))
        self.cell = _near_cell(counts, low, high, self.spacing, options)
        reach = float(np.max(high.max(axis=0) - low.min(axis=0)))
        wide = max(options.far * self.spacing * np.sqrt(_CELLS), 2.0 * (self.cell or 0.0))
        self.far = FarField(folder, self.lattice, wide, options.halo, reach)
        self.shades = Shades(options.raw_colors)
        sample, places = (EvenSample(_OVERVIEW, options.seed) for _ in range(2))
        self._side = high_above(low.min(axis=0), high.max(axis=0)) if options.viewpoint is None else options.viewpoint
        told, boxes, alone, has_normals = stage("tiles, first pass"), [], 0, False
        faults = {}
        for k, tile in enumerate(headers):
            report(told, k, len(headers))
            columns = _columns_of(tile.path)
            boxes.append((columns["points"].min(axis=0), columns["points"].max(axis=0)))
            self.shades.add(columns)
            has_normals = "normals" in columns
            columns["alone"] = standing_alone(columns["points"])
            alone += int(np.count_nonzero(columns["alone"]))
            if not options.keep_outliers and "withheld" in columns:
                rows = columns["withheld"] == 0
                if not np.any(rows):
                    raise file_error(tile.path, "all of its points are withheld; keep_outliers takes them")
                columns = {name: values[rows] for name, values in columns.items()}
            columns.pop("withheld", None)
            places.add({"points": columns["points"]})
            first, faults[k] = self._first_level(columns)
            self.far.add(first)
            sample.add(first)
        report(told, len(headers), len(headers))
        self.shades.warn_of_black("tiles")
        self.low, self.high = (np.array([box[side] for box in boxes]) for side in (0, 1))
        self._refuse_alone(faults)
        self.strays = not options.keep_outliers and some_stray(alone, counts.sum())
        self.overview = self._kept(sample.columns())
        self.viewpoint, self.turned = self._orientation(has_normals, places.columns()["points"])

    def _first_level(self, columns):
        """(columns of level 0 of what lies far, with normals, see _with_normals: where the file has none, those of the
        thinned surface).

        They are towards the viewpoint, or upwards as of a terrain, which tiles without normals have to be where there
        is none: who knows the side need not look for it.
        """
        first = self.far.thinned(columns)
        if len(first["points"]) >= _FEW:
            return _with_normals(first, self._side)
        columns, fault = _with_normals(columns, self._side)
        return self.far.thinned(columns), fault

    def _refuse_alone(self, faults):
        """Tiles whose points have no plane, by number, are refused where none that has one reaches into their halo."""
        sound = np.array([fault is None for fault in faults.values()])
        for k in np.flatnonzero(~sound):
            apart = np.maximum(self.low[:, :2] - self.high[k, :2], self.low[k, :2] - self.high[:, :2]).max(axis=1)
            if not np.any(sound & (apart <= self.options.halo)):
                raise file_error(self.headers[k].path, faults[k])

    def _kept(self, columns):
        """Columns without what stands alone, where that is left out."""
        alone = columns["alone"]
        columns = {name: values for name, values in columns.items() if name != "alone"}
        return {name: values[~alone] for name, values in columns.items()} if self.strays else columns

    def rounding(self, tiles):
        """(3,) how far apart the files of tiles (t,) may have one point: a step, of one lattice next to nothing."""
        steps, offsets = (np.array([getattr(self.headers[k], name) for k in tiles]) for name in ("step", "offset"))
        step = steps.max(axis=0)
        apart = (offsets - offsets[0]) / step
        is_one = np.all((steps == step) & (np.abs(apart - np.round(apart)) < _OFF_LATTICE), axis=0)
        largest = np.abs([self.low[tiles], self.high[tiles]]).max(axis=(0, 1))
        return np.maximum(
            np.where(is_one, _OFF_LATTICE, 1.0 + _OFF_LATTICE) * step, 8.0 * np.finfo(float).eps * largest
        )

    def around(self, k):
        """Columns of what is farther from a tile than the halo; None if nothing is."""
        found = self.far.around(self.low[k, :2], self.high[k, :2])
        return None if found is None else self._kept(found)

    def facing(self, points, normals):
        """Normals (n, 3) of the first pass, towards the side that is seen."""
        if self.viewpoint is not None:
            away = np.sum((self.viewpoint - points) * normals, axis=1) < 0.0
            normals = np.where(away[:, None], -normals, normals)
        return -normals if self.turned else normals

    def _orientation(self, has_normals, places):
        """(the viewpoint of estimated normals or None, whether all normals are turned over).

        places: points (n, 3) of all tiles, evenly.
        """
        given, how = self.options.viewpoint, self.options.normals
        if given is not None:
            return (None if has_normals else given), how == "flip"
        place = None
        if layer_of(places) == "terrain":
            place = high_above(self.low.min(axis=0), self.high.max(axis=0))
        if has_normals:
            if how == "check" and place is not None:
                away = np.sum((place - self.overview["points"]) * self.overview["normals"], axis=1) < 0.0
                if np.mean(away) > _BACKWARDS:
                    LOG.info("normals of the tiles face away from above and are turned over, all of them")
                    return None, True
            return None, how == "flip"
        if place is None:
            what = "wanted where the tiles were seen from, for they are no terrain and have no normals; got None"
            raise ValueError(f"viewpoint: {what}")
        LOG.info("estimated normals face upwards, as of a terrain seen from above (viewpoint: elsewhere)")
        return place, how == "flip"


def _spacing(counts, low, high):
    """How far points are apart, about, of all tiles together."""
    sides = np.maximum(high - low, 1e-9 * np.max(high - low, axis=1, keepdims=True))[:, :2]
    area = float(np.sum(np.prod(sides, axis=1)))
    return float(np.sqrt(area / counts.sum())) or 1.0


def _near_cell(counts, low, high, spacing, options):
    """The cell of the lattice that leaves a tile and its halo about as many points as are wanted; None for all."""
    most = 0.0
    sides = np.maximum((high - low)[:, :2], 1e-9)
    for k in range(len(counts)):
        shared = np.minimum(high[:, :2], high[k, :2] + options.halo) - np.maximum(low[:, :2], low[k, :2] - options.halo)
        most = max(most, float(np.sum(counts * np.prod(np.clip(shared / sides, 0.0, 1.0), axis=1))))
    if most <= options.points:
        return None
    cell = spacing * np.sqrt(_CELLS * most / options.points)
    what = "tiles with their halos have up to %.3g points: thinned to one in %.3g of the files' unit (points)"
    LOG.info(what, most, cell)
    return float(cell)


def _columns_of(path):
    columns = points_around(path, -np.inf, np.inf, NEEDED, "reading")
    if columns is None:
        raise file_error(path, "no points: none has finite coordinates")
    return columns


def _with_normals(columns, viewpoint):
    """(columns with unit normals, estimated where the file has none; why they could not be, or None).

    Of points that have no plane, fewer than three or all on a line as at the end of a survey, they are towards the
    viewpoint: those of the tile itself are estimated again, with the points of its halo.
    """
    points = columns["points"]
    normals = unit_normals(columns["normals"]) if "normals" in columns else np.full((len(points), 3), np.nan)
    bad = np.isnan(normals[:, 0])
    try:
        if np.all(bad):
            normals = np.array(estimated_normals(points, viewpoint))
        elif np.any(bad):
            normals, _ = with_estimated(points, normals, bad, viewpoint)
    except ValueError as error:
        few = f"has {check.counted(len(points), 'point')}; wanted at least 3, or normals"
        towards = viewpoint - points[bad]
        towards[~np.any(towards, axis=1)] = 0.0, 0.0, 1.0
        normals[bad] = check.unit_vectors("normals", towards)
        return columns | {"normals": normals}, few if len(points) < 3 else str(error)
    return columns | {"normals": normals}, None
