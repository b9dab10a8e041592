"""A cloud as `surflux solve` takes it: read, cleaned, lit, and what was found taken home to the rows of its file."""

import copy
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.color import tone_mapped_bytes
from surflux._base.passes import LOG, watched
from surflux.cli.pictures import camera_of
from surflux.meshes.reading import read_mesh
from surflux.pictures.framing import framing
from surflux.pictures.inside import camera_inside, is_room_around, lies_around
from surflux.points.arranging import thinned_with_rows
from surflux.points.cleaning import cleaned, numbers_of_rows
from surflux.points.depth_steps import without_steps
from surflux.points.exposure import exposed_by, exposure_of_colors, with_colors_beside
from surflux.points.layers import is_terrain_of, layer_of, up_of_frame
from surflux.points.properties import has_linear
from surflux.points.reading import read, warn_of_faces
from surflux.points.scan import read_scan_with_faces
from surflux.points.standing import why_y_is_up
from surflux.points.writing import pack_comments
from surflux.scans.formats import format_of
from surflux.scans.writing import written_suffix
from surflux.scenes.lights import Environment
from surflux.scenes.studio import BACKDROP, clear_day, daylight, room_light, studio
from surflux.solutions.about import about_solution, pixels_of
from surflux.solutions.lit_points import light_at_points, save_lit, spread

# A million surfels take about a minute and 2.5 GB: larger scans go in by this many of their points.
CLOUD_LIMIT = 1_000_000
_KEPT = " (--keep-steps leaves them)", " (--keep-outliers keeps them)"
_LOOSE = 0.1  # of the points of a file with faces may be in none: of the bunny as it was zipped .03
_NORTH = 0.0, 1.0, -1.0  # and down: where the camera looks that terrain is seen by


def is_cloud(path):
    """Whether a file holds points as a scanner has them, and no scene, nor patches that Surfels.save wrote."""
    path = Path(path)
    if path.suffix.lower() == ".toml":
        return False
    return path.suffix.lower() != ".ply" or _core.read_ply(path, [])["elements"].get("patch", 0) == 0


class Cloud:
    """Points of a file, and which surfel each of them is.

    Attributes:
        scan: sf.Scan, all points that were read.
        surfels: sf.Surfels that are lit.
        of_row: (n,) the surfel of each point; -1 of those that are left out, or thinned away.
        alone: (n,) booleans: points that are left out.
    """

    def __init__(self, options, scan=None):
        """scan: what the options read, where it is read already."""
        seed = 0 if options.seed is None else options.seed
        if scan is None:
            scan, faces = read_scan_with_faces(
                options.input, points=options.points, seed=seed, strict=options.strict, progress=True
            )
            warn_of_faces(options.input, faces)
        self.scan = scan
        count = len(scan)
        if options.points is not None and count > 0 and scan.rows[-1] >= options.points:
            LOG.info("%d points are taken of the file, evenly, and written (--points; --thin writes all)", count)
        used, first, self.alone = cleaned(scan, options.keep_outliers)
        if not options.keep_outliers:
            used = _in_faces(options.input, scan, used, first, self.alone)
        orient = False if options.normals in ("keep", "flip") else True if options.eye is None else options.eye
        seen, used = _without_steps(options, scan[used], used, self.alone)
        whole = seen.surfels(viewpoint=options.viewpoint, orient=orient, progress=True)
        whole = whole.flipped() if options.normals == "flip" else whole
        by_colors = scan.reflectance is not None and not has_linear(scan.attributes, "reflectance")
        if by_colors and not options.raw_colors:
            rho = whole.reflectance
            beside = with_colors_beside(whole.points, rho, "--raw-colors")
            whole = exposed(whole if beside is rho else whole.replace(reflectance=beside))
        self._normals, self._whole = whole.normals, whole
        limit = options.thin or options.points or CLOUD_LIMIT
        self.surfels, rows = whole, used
        if len(whole) > limit:
            LOG.info("%d points are thinned to %d (--thin sets the number)", len(whole), limit)
            thinned, kept = thinned_with_rows(whole, limit, seed, progress=True)
            # What is near stands near in memory, too: searches are the faster for it.
            along = _core.morton_order(thinned.points)
            self.surfels, rows = thinned[along], used[kept[along]]
        self._row = rows
        self.of_row, self._whole_of_row = numbers_of_rows(rows, first), numbers_of_rows(used, first)

    def counted(self):
        """How many points have light, in words."""
        left = int(np.count_nonzero(self.alone))
        return f"{check.counted(len(self.scan), 'point')}, as read, with their light" + (
            f" but for {left} left out" if left else ""
        )

    def save(self, path, solution, albedo=False, up=None):
        """Writes all points of the file in their order, with the light that was found.

        Points that were left out have NaN, and 1 as `left_out`; those that were thinned away what surfels around them
        have. `red green blue` are the light that leaves, or the scan's own colours (albedo). PLY files have besides
        what `load_solution` needs.
        """
        lit = np.flatnonzero(self._whole_of_row >= 0)
        source = self._whole_of_row[lit]
        count, columns, more = len(self.scan), {}, {"up": up or (0.0, 0.0, 1.0)}
        places = self._whole.points[source], self._normals[source]
        rho, emission = self._whole.reflectance[source], self._whole.emission[source]
        with watched(None, True):
            found = light_at_points(solution, self.of_row[lit], *places, rho, emission)
        colors = None if albedo else tone_mapped_bytes(found["radiosity"], emission)
        if written_suffix(path) == ".ply":
            areas = np.bincount(solution.parents, solution.surfels.areas)[: len(self.surfels)]
            columns = {
                "reflectance": spread(rho, lit, count),
                "emission": spread(emission, lit, count),
                "radius": spread(self.surfels.radii, self._row, count, np.float64),
                "area": spread(areas, self._row, count, np.float64),
            }
            more |= {"comments": pack_comments(about_solution(solution) | {"points": 1}), "pixels": pixels_of(solution)}
        elif not albedo:  # colours that are light are no reflectance to whoever reads them
            columns["reflectance"] = spread(rho, lit, count)
        return save_lit(self.scan, path, found, lit, places[1], self.alone, colors, columns, **more)


def _in_faces(path, scan, rows, first, alone):
    """Those of `rows` of a Scan at whose place, see first_of_each, a vertex of a face is, where the file has faces.

    Others are marked in `alone`, and logged: programs that mesh scans leave a few points, of doubled layers. Where many
    are in no face, they are points of their own.
    """
    if format_of(path) != "ply" or not _core.read_ply(path, [])["elements"].get("face", 0):
        return rows
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # all was said when it was read
            mesh = read_mesh(path)
    except _core.FileError:  # of its faces, which are not taken
        return rows
    of_face = np.zeros(len(mesh.vertices), bool)
    of_face[mesh.indices] = True
    found = np.zeros(len(scan), bool)
    np.logical_or.at(found, first, of_face[scan.rows])
    loose = rows[~found[rows]]
    if len(loose) == 0 or len(loose) > _LOOSE * len(scan):
        return rows
    many = check.counted(len(loose), "point")
    LOG.info("in no face, left out of light and picture: %s of %d%s", many, len(scan), _KEPT[1])
    alone[loose] = True
    return rows[found[rows]]


def _without_steps(options, scan, rows, alone):
    """(a Scan whose points are moved where their depth has steps; the rows that it has of `rows`).

    What is off all around it is left out, and marked in `alone`, but with --keep-outliers.
    """
    with watched(None, True):
        found = None if options.keep_steps else without_steps(scan.points, options.keep_outliers, *_KEPT)
    if found is None:
        return scan, rows
    moved, kept = found
    alone[rows[~kept]] = True
    return replace(scan, points=moved, fitted=None)[kept], rows[kept]


def patches_of_file(options):
    """Surfels of a file that holds patches, thinned where there are too many."""
    surfels = read(options.input, viewpoint=options.viewpoint, points=options.points, progress=True)
    surfels = surfels.flipped() if options.normals == "flip" else surfels
    limit = options.thin or options.points or CLOUD_LIMIT
    if len(surfels) <= limit:
        return surfels
    LOG.info("%d points are thinned to %d (--thin sets the number)", len(surfels), limit)
    return surfels.thinned(limit, 0 if options.seed is None else options.seed, progress=True)


def exposed(surfels):
    """Surfels whose mean reflectance is plausible: colours of a scan are as bright as its light and exposure were.

    The mean is that of all that are not black, and hardly any of them become white.
    """
    rho = surfels.reflectance
    seen = rho[rho.any(axis=1)]
    if len(seen) == 0:
        return surfels
    factor = exposure_of_colors(seen.mean(), np.percentile(seen.max(axis=1), 99), "--raw-colors")
    return surfels if factor == 1.0 else surfels.replace(reflectance=exposed_by(factor, rho))


def camera_of_cloud(options, surfels, scanner=None, *, finer=None):
    """The camera of the picture; what is up, where nobody says it, is that of a depth camera, of a statue, or z.

    Terrain is seen from the south, as a map has it; what lies all around its scanner (3,), as a room does, from there.
    finer: Surfels of the same surface that tell what it is, where these are too few.
    """
    kind = _told_kind(options, surfels if finer is None else finer)
    if kind == "frame" and options.up is None and options.eye is None:
        return _camera_of_frame(options, surfels)
    if kind == "terrain" and options.up is None:
        return camera_of(options, surfels, framing(surfels, options.size, direction=_NORTH))
    scanner = np.zeros(3) if kind == "turn" else scanner
    scanner = scanner if options.viewpoint is None else np.asarray(options.viewpoint)
    if scanner is not None and options.eye is None and options.target is None and lies_around(surfels.points, scanner):
        LOG.info("the picture is seen from the scanner's place, for the points lie around it (--eye)")
        return camera_of(options, surfels, camera_inside(surfels.points, scanner, options.up or (0.0, 0.0, 1.0)))
    return camera_of(options, surfels, None)


def _told_kind(options, surfels):
    """What layer_of finds; where nobody says what is up and no layer does, --up becomes what is taken for it."""
    kind = layer_of(surfels.points)
    if options.up is not None:
        return kind
    if kind == "frame" and np.mean(np.sum(surfels.points * surfels.normals, axis=1) < 0.0) < 0.5:
        kind = None  # of what shows the origin its backs no camera there saw anything
    reason = why_y_is_up(surfels) if kind is None else None
    if reason is not None:
        options.up = (0.0, 1.0, 0.0)
        LOG.info("y is taken for up: %s (--up 0,0,1 for z)", reason)
    elif kind != "frame":
        LOG.info("z is taken for up (--up 0,1,0 for y)")
    return kind


def _camera_of_frame(options, surfels):
    options.up = up_of_frame(surfels.points)
    LOG.info("the picture has %s for up, as the frame of a depth camera has (--up)", "y" if options.up[1] > 0 else "-y")
    ahead = (0.0, 0.0, -options.up[1])
    return camera_of(options, surfels, framing(surfels, options.size, options.up, direction=ahead))


def lights_of_cloud(options, surfels, camera, what="cloud"):
    """The lights of --light, which becomes what was chosen; says so. What shines by itself gets none unasked: None."""
    if options.light is None and np.any(surfels.emission):
        LOG.info("the %s shines by itself: no other light is added (--light studio, sun or sky)", what)
        return []
    up = options.up or (0.0, 0.0, 1.0)
    is_inside = is_room_around(surfels.points, camera.eye, up)
    is_terrain = options.light in (None, "sun") and is_terrain_of(surfels.points, options.up)
    if options.light is None:
        options.light = "sun" if is_terrain else "studio"
        where = "above" if is_inside else "behind"
        said = {
            "sun": "terrain has no light: it gets the sun and sky of a clear day, in W/m2 (--light studio or sky)",
            "studio": f"a {what} has no light: it gets a lamp {where} the camera, and a sky (--light sun or sky)",
        }
        LOG.info(said[options.light])
    if options.light == "sky":
        LOG.info("the %s is lit by a sky of radiance 1 from all sides", what)
        return [Environment(1.0)]
    if options.light == "sun":
        lights = [clear_day()] if is_terrain else daylight(camera, up)  # as of tiles, wherever the camera stands
        if len(lights) == 1:
            LOG.info("the light, z up and y north: %r", lights[0])
        else:
            LOG.info("the light: sun and sky of a clear day, with (%g, %g, %g) up (--up)", *up)
        return lights
    return room_light(surfels, camera, up) if is_inside else studio(surfels, camera)


def before_backdrop(options, solution):
    """(the solution to show and keep, what is seen behind it, as write_layers takes it).

    A studio has a grey backdrop: its sky only fills in shadows, and nobody is to see it.
    """
    if options.light != "studio":
        return solution, True
    twin = copy.copy(solution)
    twin._environments = []
    return twin, BACKDROP
