"""One tile with what is around it, as surfels: its own points and those of the halo in full, the rest thinned."""

from dataclasses import replace

import numpy as np

from surflux import _core
from surflux._base.files import file_error
from surflux.geometry.estimates import estimated_normals, estimated_radii
from surflux.points.cleaning import first_across, first_among, numbers_of_rows, standing_alone
from surflux.points.scan import Scan, scan_of_columns
from surflux.points.surfels import Surfels
from surflux.points.terrain import facades_outwards
from surflux.scans.reading import read_columns
from surflux.scans.thinning import joined
from surflux.scans.tiling import points_around
from surflux.solving.tile_survey import MATERIALS, NEEDED


class TileScene:
    """Attributes:
    scan: sf.Scan, all points of the tile.
    surfels: sf.Surfels of the tile and all around it.
    around: how many of these are of other tiles.
    of_row: (n,) the surfel of each point of the tile; -1 of those that are left out, or thinned away.
    alone: (n,) booleans: points that are left out.
    lit: (m,) rows of the tile that have light; normals, reflectance, emission: (m, 3) of these.
    """

    def __init__(self, survey, k, strict=False):
        tile = survey.headers[k]
        read = read_columns(tile.path, None, None, 0, strict)
        near = [{name: values for name, values in read.columns.items() if name in NEEDED or name == "points"}]
        own, tiles = len(read.rows), [k]
        low, high = (survey.low[k, :2] - survey.options.halo, survey.high[k, :2] + survey.options.halo)
        for j, other in enumerate(survey.headers):
            apart = np.any(survey.low[j, :2] > high) or np.any(survey.high[j, :2] < low)
            if j != k and not apart:
                found = points_around(other.path, low, high, NEEDED, "reading")
                if found is not None:
                    near.append(found)
                    tiles.append(j)
        colors = read.columns.pop("colors", None)
        self.scan = scan_of_columns(tile.path, read)
        if survey.shades.has_colors and colors is not None:
            self.scan = replace(self.scan, reflectance=survey.shades.of_colors(colors))
        tile_of = np.repeat(tiles, [len(columns["points"]) for columns in near])
        near = joined(near)
        first, alone = _cleaned(survey, near, tile_of)
        used = np.flatnonzero((first == np.arange(len(first))) & ~alone)
        self.alone = alone[:own]
        if len(used) < 3:
            raise file_error(tile.path, f"wanted at least 3 points of the tile and its halo, got {len(used)}")
        whole = _surfels_of(survey, tile.path, {name: values[used] for name, values in near.items()})
        kept = np.arange(len(used))
        if survey.cell is not None:
            kept = survey.lattice.nearest(survey.lattice.turned(whole.points), survey.cell)
        kept = kept[_core.morton_order(np.ascontiguousarray(whole.points[kept]))]
        self.of_row, of_whole = numbers_of_rows(used[kept], first)[:own], numbers_of_rows(used, first)[:own]
        self.lit = np.flatnonzero(of_whole >= 0)
        source = of_whole[self.lit]
        self.normals, self.reflectance = whole.normals[source], whole.reflectance[source]
        self.emission = whole.emission[source]
        self.surfels = _with_far(survey, k, whole, kept)
        self.around = len(self.surfels) - int(np.count_nonzero(used[kept] < own))


def _cleaned(survey, columns, tile_of):
    """((n,) the first point at each one's place, (n,) booleans: left out).

    Tiles may overlap. Of a point that two of them have, the coordinates are as their files round them.
    Withheld points take no part: tiles with buffers hold copies of their neighbours' points, which must not count in
    place of these.
    """
    points, alone = columns["points"], np.zeros(len(columns["points"]), bool)
    if not survey.options.keep_outliers and "withheld" in columns:
        alone = columns["withheld"] == 1
    taken = np.flatnonzero(~alone)
    if survey.strays:
        alone[taken] = standing_alone(points[taken])
    first = first_among(taken, points, columns.get("normals"))
    tiles = np.unique(tile_of)
    rounding, boxes = survey.rounding(tiles), np.zeros(len(points), np.int64)
    for j in tiles:
        boxes += np.all((points >= survey.low[j] - rounding) & (points <= survey.high[j] + rounding), axis=1)
    shared = np.flatnonzero((boxes > 1) & (first == np.arange(len(first))) & ~alone)
    if len(shared):
        first[shared] = shared[first_across(tile_of[shared], points[shared], rounding)]
    return first[first], alone


def _surfels_of(survey, path, columns):
    """Surfels of points as their files have them, towards the side that the survey says."""
    attributes = {name: columns[name] for name in MATERIALS if name in columns}
    rho = survey.shades.reflectance(columns)
    scan = Scan(columns["points"], columns.get("normals"), rho, attributes, name=path)
    try:
        if scan.normals is None and survey.viewpoint is not None and survey.options.viewpoint is None:  # upwards
            normals = np.array(estimated_normals(scan.points, survey.viewpoint))
            scan = replace(scan, normals=facades_outwards(scan.points, normals))
        found = scan.surfels(viewpoint=survey.viewpoint)
    except ValueError as error:  # such as all points on a line
        raise file_error(path, f"with its halo: {error}") from error
    return found.flipped() if survey.turned else found


def _with_far(survey, k, whole, kept):
    """Surfels of what is near, radii by themselves, and of what is far.

    Were radii made of all together, disks of walls at the end of the halo would reach from thinned point to thinned
    point, and stand high above all houses.
    """
    near = whole.points[kept], whole.normals[kept], whole.reflectance[kept], whole.emission[kept]
    radii = estimated_radii(*near[:2]) if len(kept) > 1 else np.full(len(kept), survey.cell or survey.spacing)
    far = survey.around(k)
    if far is None:
        return _surfels(near, radii)
    parts = thinned_parts(survey, far)
    both = [np.concatenate(some) for some in zip(near, parts, strict=True)]
    return _surfels(both, np.concatenate([radii, _radii_below_tops(survey, far, parts[1])]))


def _surfels(parts, radii):
    points, normals, reflectance, emission = parts
    return Surfels(points, normals, radii=radii, reflectance=reflectance, emission=emission)


def _radii_below_tops(survey, columns, normals):
    """(n,) radii of thinned points: none rises above what it stands for by more than points are apart."""
    points = columns["points"]
    radii = estimated_radii(points, normals) if len(points) > 1 else np.full(len(points), survey.far.cell)
    steep = np.sqrt(np.clip(1.0 - normals[:, 2] ** 2, 1e-12, 1.0))
    return np.minimum(radii, (columns["top"] - points[:, 2] + survey.spacing) / steep)


def thinned_parts(survey, columns):
    """(points, normals, reflectance, emission), (n, 3) each, of columns of the first pass."""
    normals = survey.facing(columns["points"], columns["normals"])
    rho, emission = survey.shades.reflectance(columns), np.zeros(normals.shape)
    given = [_given(columns, name) for name in ("reflectance", "emission")]
    rho = rho if given[0] is None else np.where(np.isnan(given[0]), rho, given[0])
    emission = emission if given[1] is None else np.where(np.isnan(given[1]), 0.0, given[1])
    return columns["points"], normals, rho, emission


def _given(columns, name):
    """(n, 3) of a property that the files have; None where they do not."""
    names = [f"{name}_{c}" for c in "rgb"]
    return np.stack([columns[one] for one in names], axis=-1) if names[0] in columns else None
