"""Surveys in tiles, solved one tile after another: each with its neighbours in full and the rest thinned."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.color import display_bytes, white_of
from surflux._base.files import file_error, require_file
from surflux._base.passes import LOG, report, stage, watched
from surflux._base.types import FilePath, Integer, Progress
from surflux.points.surfels import Surfels
from surflux.scans.georeference import georeference
from surflux.scans.tiling import check_alike, tile_header
from surflux.scenes.lights import Light
from surflux.scenes.options import checked_solve_options
from surflux.scenes.scene import Scene
from surflux.scenes.sky import Sky
from surflux.scenes.studio import clear_day
from surflux.solutions.lit_points import light_at_points, save_lit, spread
from surflux.solving.radiosity import solve
from surflux.solving.tile_record import Record, key_of
from surflux.solving.tile_result import SolvedTile, SolvedTiles
from surflux.solving.tile_scene import TileScene, thinned_parts
from surflux.solving.tile_survey import Survey, TileOptions


def solve_tiles(
    paths: Sequence[FilePath],
    folder: FilePath,
    *,
    lights: Sequence[Light | Sky] | None = None,
    halo: float = 150.0,
    far: float = 4.0,
    points: Integer = 1_000_000,
    unit: float | None = None,
    viewpoint: ArrayLike | None = None,
    normals: Literal["check", "keep", "flip"] = "check",
    albedo: bool = False,
    keep_outliers: bool = False,
    raw_colors: bool = False,
    strict: bool = False,
    solve_options: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> SolvedTiles:
    """Light on all points of a survey in tiles of LAS, LAZ or COPC, whatever their number, written tile by tile.

    Each tile is solved together with the points of all others within the halo, in full, and with what lies beyond,
    thinned: to points `far` times as far apart as those of the tile, up to twice the halo away, then again twice as far
    apart for each doubling of the distance. All of it casts shadows and sends light. So memory goes by one tile and its
    surroundings. Which side faces out, what strays, how bright colours are and how results are exposed is decided once,
    from a pass over all tiles, so that no seams show.

    Each output has all points of its tile in their order, with all that is known of each, and besides `irradiance`,
    `direct` and `radiosity` by channel, normals and `left_out`, as `surflux solve CLOUD -o OUT.laz` writes them. A run
    that is stopped goes on where it was: outputs that are finished, of the same files and options, are kept, as the
    record `surflux-tiles.json` in the folder tells.

    Args:
        paths: of the tiles, at least one; of one point format and one coordinate reference system. They may overlap.
        folder: of the outputs, made where it is not there; they have the names of their tiles, `.copc` left out.
        lights: as Scene takes them, the same for all tiles; None for the sun and sky of a clear day, W/m2: the sun 40
            degrees high at 150 degrees from +y, 800 W/m2, and 100 of the sky.
        halo: metres around the box of a tile, above 0.
        far: how far points beyond are apart, over those of the tile, at least 1.
        points: at most about so many of a tile with its halo: all tiles are thinned alike where one has more, and
            points that are thinned away have the light of the surface around them.
        unit: metres of the files' unit; None for what their coordinate reference system says, 1 where they have none.
        viewpoint: (3,), towards which estimated normals turn; None for upwards where the points are a terrain.
        normals: of files that have some: "check" turns all over where most face away from above, "keep" takes them as
            they are, "flip" turns all over, estimated ones too.
        albedo: colours of the outputs are those of the tiles, not those of their light.
        keep_outliers: takes points that stand alone, or that the files withhold, which are left out otherwise.
        raw_colors: takes colours as bright as they are; their mean reflectance is made plausible otherwise.
        strict: refuses tiles with points that have no finite place.
        solve_options: of solve, by name, but seed, threads and progress; insert is False where it is not given.
        seed: of everything random; the result is the same for the same seed, whatever the number of threads.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        SolvedTiles.

    Raises:
        ValueError: an argument, by name; an output that would be an input.
        FileError: a tile that cannot be read, or does not go with the first; an output that cannot be written, or
            stands in the place of a file that is none. Outputs that are finished stay.
        ImportError: the unit of a coordinate reference system needs pyproj (`pip install 'surflux[solar]'`).
        Cancelled: the callback returned False.

    >>> import numpy as np, surflux as sf
    >>> rng = np.random.default_rng(0)
    >>> for k in range(2):
    ...     xy = rng.uniform([100.0 * k, 0.0], [100.0 * k + 100.0, 100.0], (500, 2))
    ...     _ = sf.Scan(np.column_stack([xy, 2.0 * np.sin(xy[:, 0] / 9.0)])).save(f"{k}.laz")
    >>> given = {"lights": [sf.Environment(1.0)], "viewpoint": (100, 50, 1e4)}
    >>> solved = sf.solve_tiles(["0.laz", "1.laz"], "lit", halo=30, **given)
    >>> [tile.output.name for tile in solved], len(sf.read_scan("lit/1.laz"))
    (['0.laz', '1.laz'], 500)
    """
    paths, folder = _checked_paths(paths), Path(check.path("folder", folder))
    names = _output_names(paths, folder)
    halo = check.number("halo", halo, 0.0, 1e9, low_open=True)
    far = check.number("far", far, 1.0, 1e6)
    points = check.count("points", points, 2)
    unit = None if unit is None else check.number("unit", unit, 0.0, 1e9, low_open=True)
    viewpoint = None if viewpoint is None else check.vector3("viewpoint", viewpoint)
    check.choice("normals", normals, ("check", "keep", "flip"))
    flags = {"albedo": albedo, "keep_outliers": keep_outliers, "raw_colors": raw_colors, "strict": strict}
    flags = {name: check.flag(name, value) for name, value in flags.items()}
    seed = check.seed("seed", seed)
    # Points have the light at their own places: that of inserted surfels would be a mean around them.
    settings = {"insert": False} | _checked_settings(solve_options)
    lights = [clear_day()] if lights is None else lights
    lit_by = Scene([_ANYTHING], lights).lights  # whose messages name them
    with watched(threads, progress):
        headers = [tile_header(path) for path in paths]
        check_alike(headers)
        unit = _unit_of(headers) if unit is None else unit
        about = {"halo": halo / unit, "far": far, "points": points, "normals": normals, "seed": seed, **flags}
        about |= {"viewpoint": None if viewpoint is None else viewpoint.tolist(), "solve": settings}
        run = _Run(paths, names, folder, key_of(paths, lit_by, about))
        run.prepare()
        if run.left:
            rest = {name: flags[name] for name in ("keep_outliers", "raw_colors")}
            options = TileOptions(halo / unit, far, points, viewpoint, normals, **rest, seed=seed)
            _solve_rest(run, headers, options, lit_by, settings, albedo, strict)
    return SolvedTiles(tuple(run.done[name] for name in names))


_ANYTHING = Surfels([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], radii=1.0)


class _Run:
    """What is finished of a run, and what is left."""

    def __init__(self, paths, names, folder, key):
        self.paths, self.names, self.folder, self.key = paths, names, folder, key
        self.done, self.left = {}, []

    def prepare(self):
        """Makes the folder, and finds what is finished; refuses files that are none of ours, before any work."""
        try:
            self.folder.mkdir(exist_ok=True)
        except OSError as error:
            raise file_error(self.folder, f"cannot be made: {error.strerror or error}") from error
        if not os.access(self.folder, os.W_OK):
            raise file_error(self.folder, "cannot be written to: no permission")
        self.record = Record(self.folder)
        for k, name in enumerate(self.names):
            self.record.require_ours(name)
            figures = self.record.finished(name, self.key)
            if figures is None:
                self.left.append(k)
            else:
                self._take(k, figures, True)
        if self.left:
            self.record.claim(self.names[k] for k in self.left)
        if self.done:
            LOG.info(
                "kept: %d of %s, solved before from the same files by the same options",
                len(self.done),
                check.counted(len(self.names), "tile"),
            )

    def finish(self, k, figures):
        """Notes that the output of a tile is written."""
        self.record.add(self.names[k], self.key, figures)
        self._take(k, figures, False)

    def _take(self, k, figures, kept):
        name = self.names[k]
        self.done[name] = SolvedTile(Path(self.paths[k]), self.folder / name, **figures, kept=kept)


def _solve_rest(run, headers, options, lights, settings, albedo, strict):
    survey = Survey(headers, run.folder, options)
    try:
        white = None if albedo else _white(survey, lights, options.seed)
        for k in run.left:
            LOG.info("tile %d of %d: %s", k + 1, len(headers), headers[k].path)
            report(stage("tiles"), k, len(headers))
            begun = perf_counter()
            figures = _solve_one(run, survey, k, lights, settings, white, strict)
            run.finish(k, figures | {"seconds": perf_counter() - begun})
        report(stage("tiles"), len(headers), len(headers))
    finally:
        survey.far.close()


def _solve_one(run, survey, k, lights, settings, white, strict):
    """Solves and writes a tile; what is said of it."""
    tile = TileScene(survey, k, strict)
    solution = solve(Scene([tile.surfels], list(lights)), **settings, seed=survey.options.seed)
    count, lit = len(tile.scan), tile.lit
    places = tile.scan.points[lit], tile.normals
    found = light_at_points(solution, tile.of_row[lit], *places, tile.reflectance, tile.emission)
    colors = None if white is None else display_bytes(found["radiosity"] / white)
    columns = {"left_out": tile.alone.astype(np.uint8)}  # also where none is, so that all tiles have the same columns
    if white is not None:
        columns["reflectance"] = spread(tile.reflectance, lit, count)
    save_lit(tile.scan, run.folder / run.names[k], found, lit, tile.normals, tile.alone, colors, columns)
    return {
        "points": count,
        "left_out": int(np.count_nonzero(tile.alone)),
        "surfels": len(tile.surfels),
        "around": tile.around,
        "error": float(solution.error),
    }


def _white(survey, lights, seed):
    """The radiosity that colours of all tiles show as white, from a coarse solution of all of them."""
    points, normals, rho, emission = thinned_parts(survey, survey.overview)
    surfels = Surfels(points, normals, reflectance=rho, emission=emission)
    return white_of(solve(Scene([surfels], list(lights)), insert=False, seed=seed).radiosity)


def _checked_paths(paths):
    if isinstance(paths, (str, bytes, os.PathLike)) or not isinstance(paths, Sequence):
        raise ValueError(f"paths: wanted a list of paths, got {type(paths).__name__}")
    found = [check.path("paths", path) for path in paths]
    if not found:
        raise ValueError("paths: wanted at least one tile, got none")
    for path in found:
        require_file(path)
    return found


def _output_names(paths, folder):
    """The name of each output; refuses two of one name, and those that would be inputs."""
    names = []
    for path in paths:
        stem, suffix = os.path.splitext(os.path.basename(path))
        stem = stem[: -len(".copc")] if stem.lower().endswith(".copc") else stem
        names.append(stem + (suffix if suffix.lower() in (".las", ".laz") else ".laz"))
    seen, inputs = {}, {_identity(path) for path in paths}
    for path, name in zip(paths, names, strict=True):
        if name in seen:
            raise ValueError(f"paths: {seen[name]!r} and {path!r} would both be written as {name!r}")
        seen[name] = path
        output = folder / name
        if output.exists() and _identity(output) in inputs:
            raise ValueError(f"folder: {str(output)!r} is a tile itself; wanted another folder")
    return names


def _identity(path):
    """What is the same for all names of a file."""
    found = os.stat(path)
    return found.st_dev, found.st_ino


def _checked_settings(options):
    found = checked_solve_options(options)
    if "seed" in found:
        raise ValueError("solve_options: seed is an argument of its own")
    return found


def _unit_of(headers):
    """Metres of the unit of x and y; without a coordinate reference system 1, which is said."""
    low, high = np.min([tile.low for tile in headers], axis=0), np.max([tile.high for tile in headers], axis=0)
    about = georeference(headers[0].path, 0.5 * (low + high)[:2])
    if about is None:
        LOG.info("the unit of the tiles is taken for metres, as nothing says otherwise (unit)")
        return 1.0
    return about.horizontal
