"""Surfels of what files say: what is missing is estimated, and what cannot be surfels is the file's fault."""

import os

import numpy as np

from surflux._base.files import file_error
from surflux._base.passes import LOG
from surflux._base.warn import warn
from surflux.geometry.cores import replaced
from surflux.geometry.estimates import estimated_normals, percent
from surflux.geometry.facing import checked_places, facing_of
from surflux.points.intensity import scale_of_intensity
from surflux.points.layers import is_terrain
from surflux.points.properties import (
    LINEAR,
    check_rows,
    found,
    require_less_than_one,
    take_gloss,
    take_linear,
    take_radii,
)
from surflux.points.seen_from import FACED, normals_of_seen, viewed_from
from surflux.points.surfels import Surfels
from surflux.scans.columns import attribute_name

_SAID, _MANY, _MOST = 0.0005, 0.05, 0.5  # of the points
_BACKWARDS = 0.8  # of the points that face away from where all were seen: the file has its normals the other way round
_KEEP = "`--normals keep`, or orient=False, leaves them as they are"


def arrays_of_scan(scan):
    """What a Scan says about surfels, as load_arrays has it, with its viewpoints, the scan of each point, and normals
    that were fitted where it was denser.

    NaN is not known, as in what `surflux solve` writes of points that it leaves out.
    """
    columns = dict(scan.attributes)
    _drop_unknown(scan.name, columns)
    out = {"points": scan.points, "normals": scan.normals, "radii": take_radii(scan.name, columns)}
    out["areas"] = columns.pop("area", None)  # our own; an Area may be that of what a point stands for on a map
    check_rows(scan.name, "area", out["areas"], 0.0)
    for name in LINEAR:
        out[name] = take_linear(scan.name, columns, name)
        if out[name] is not None:
            usual = 0.0 if name == "emission" else 0.5 if scan.reflectance is None else scan.reflectance
            out[name] = _known(scan.name, name, out[name], usual)
        check_rows(scan.name, name, out[name], 0.0)
    if out["reflectance"] is None:
        out["reflectance"] = scan.reflectance
    else:
        require_less_than_one(scan.name, out["reflectance"])
    out["gloss"] = take_gloss(scan.name, columns)
    out["columns"] = columns
    out["viewpoints"], out["scan"], out["fitted"] = scan.viewpoints, columns.get("scan"), scan.fitted
    return out


def _drop_unknown(path, columns):
    """Takes radii and areas out that are NaN of some points: those of the others covered a surface without them."""
    names = [name for name in (found(columns, "radius"), "area") if name is not None and name in columns]
    unknown = {name: np.isnan(columns[name]) for name in names}
    unknown = {name: bad for name, bad in unknown.items() if np.any(bad)}
    if unknown:
        for name in names:
            columns.pop(name)
        some, bad = " and ".join(unknown), next(iter(unknown.values()))
        LOG.info(
            "%s: %s not known (NaN) of %d of %d points: estimated of all", path, some, np.count_nonzero(bad), len(bad)
        )


def _known(path, name, values, usual):
    """RGB (n, 3) with what is usual, (n, 3) or one number, in rows that hold NaN."""
    unknown = np.any(np.isnan(values), axis=1)
    if not np.any(unknown):
        return values
    LOG.info("%s: %s not known (NaN) of %d of %d points", path, name, np.count_nonzero(unknown), len(values))
    return np.where(unknown[:, None], usual, values)


def _reflectance(path, arrays):
    if arrays["reflectance"] is not None:
        return arrays["reflectance"]
    names = [name for name in arrays["columns"] if attribute_name(name) == "intensity"]
    scale = scale_of_intensity(arrays["columns"][names[0]]) if names else None
    if scale is None:
        return 0.5
    scale.tell(os.fsdecode(path))
    return scale.reflectance(arrays["columns"][names[0]])


def surfels_of_arrays(path, arrays, reflectance, emission, viewpoint, orient=None):
    """Surfels of what load_arrays or arrays_of_scan give.

    orient: None leaves the file's normals as they are; else places in the air (k, 3), also none, see `facing`.
    """
    places = arrays.get("viewpoints", ())
    if viewpoint is None and len(places) == 1 and np.all(np.isfinite(places)):
        viewpoint = places[0]
    if reflectance is None:
        reflectance = _reflectance(path, arrays)
    if arrays["emission"] is not None and np.ndim(emission) == 0 and emission == 0:
        emission = arrays["emission"]
    try:
        surfels = Surfels(
            arrays["points"],
            _complete_normals(path, arrays, viewpoint, orient),
            radii=arrays["radii"],
            areas=arrays["areas"],
            reflectance=reflectance,
            emission=emission,
            **arrays["gloss"],
            viewpoint=viewpoint,
        )
    except ValueError as error:
        # A message begins with the argument it is about: these come from the file.
        if str(error).startswith(("points", "normals", "radii", "areas", "specular", "exponent")):
            raise file_error(path, str(error)) from error
        raise
    if len(arrays.get("triangles", ())):
        core = surfels._core
        of = arrays["triangle_surfel"]
        surfels = Surfels._from_core(
            replaced(core, areas=arrays["areas"], triangles=arrays["triangles"], triangle_surfel=of)
        )
    return surfels


def oriented_around(orient):
    """Places (k, 3) of the argument orient; None for False."""
    if isinstance(orient, (bool, np.bool_)):
        return np.zeros((0, 3)) if orient else None
    return checked_places("orient", orient)


def _complete_normals(path, arrays, viewpoint, orient):
    """The file's normals, the bad ones among them estimated; None where all are bad or missing, and can be left to
    Surfels.
    """
    normals, fitted = arrays["normals"], arrays.get("fitted")
    bad = np.ones(0, dtype=bool) if normals is None else np.isnan(normals[:, 0])
    if np.any(bad):
        some = f"{np.count_nonzero(bad)} of {len(bad)}"
        warn(f"{os.fsdecode(path)}: {some} normals are zero or not finite and were estimated")
    if np.all(bad):  # or missing
        if viewpoint is not None:
            return None if fitted is None else estimated_normals(arrays["points"], viewpoint, fitted)
        known = _towards_scanners(arrays, fitted)
        return normals_of_seen(os.fsdecode(path), arrays["points"], orient, fitted) if known is None else known
    given = arrays["points"], normals, bad, viewpoint, fitted
    out, estimated = with_estimated(*given) if np.any(bad) else (normals, None)
    if orient is not None and not len(arrays.get("triangles", ())):
        places = orient if viewpoint is None else np.vstack([orient, viewpoint])
        out = _turned_over(path, arrays["points"], out, places)
    if np.any(bad) and viewpoint is not None:
        out[bad] = estimated[bad]
    return out


def _turned_over(path, points, normals, places):
    """The normals of a file, with those turned over that face inwards; what is done, and what is open, is logged."""
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    name = os.fsdecode(path)
    kind, place = viewed_from(points)
    if place is not None:
        away = np.mean(np.sum((place - points) * normals, axis=1) < 0.0)
        if away > _BACKWARDS:
            words = "%s: its normals face away and are turned over, all of them, to face %s; %s"
            LOG.info(words, name, FACED[kind], _KEEP)
            normals = -normals
        places = np.vstack([places, place])
    found = facing_of(points, normals, places)
    turned, inside_out, against = np.mean([found.turned, found.inside_out, found.against], axis=1)
    if turned > _SAID:
        room = " (a room seen from inside stays, if a viewpoint is in it)" if inside_out > _SAID else ""
        LOG.info("%s: %s of the points faced inwards and are turned over%s; %s", name, percent(turned), room, _KEEP)
    by_most = np.mean(found.turned & found.open)
    if by_most > _MANY:
        LOG.info(
            "%s: %s of the points are turned to the side that most of their open surface faces, which may be wrong: "
            "`--normals keep` leaves them, `--normals flip` turns all points over",
            name,
            percent(by_most),
        )
    if found.unsure.any():
        LOG.warning(
            "%s: normals change sides along lines, on which %s of the points stand: a part may be turned over, without "
            "light, and points that are so far apart do not tell which. `surflux view` shows it, `surflux check` says "
            "where, and Surfels.flipped turns points over",
            name,
            percent(np.mean(found.unsure)),
        )
    if against > _MOST and not _is_ground(points, normals):  # a valley is seen less from above
        LOG.info(
            "%s: the open surfaces of %s of the points face the side that is seen less, which is right in a room, and "
            "wrong around a body: `--normals flip`, or Surfels.flipped, turns all points over",
            name,
            percent(against),
        )
    return np.where(found.turned[:, None], -normals, normals)


def _is_ground(points, normals):
    """Whether points are a terrain that faces up."""
    return np.mean(normals[:, 2] > 0.0) > _MOST and is_terrain(points)


def with_estimated(points, normals, bad, viewpoint, fitted=None):
    """((n, 3) normals with those that are bad, some but not all, estimated and to the side of the nearest good one;
    (n, 3) estimates of all, towards the viewpoint).
    """
    estimated = np.array(estimated_normals(points, viewpoint, fitted))
    nearest = _nearest(points[~bad], points[bad])
    flipped = np.sum(estimated[bad] * normals[~bad][nearest], axis=1) < 0.0
    out = normals.copy()
    out[bad] = np.where(flipped[:, None], -estimated[bad], estimated[bad])
    return out, estimated


def _towards_scanners(arrays, fitted):
    """Estimated normals of points of several scans, each towards its own scanner; None where no position is known."""
    places, scan = arrays.get("viewpoints", ()), arrays.get("scan")
    if scan is None or scan.ndim != 1 or not np.any(np.isfinite(places)):
        return None
    normals = np.array(estimated_normals(arrays["points"], None, fitted))
    with np.errstate(invalid="ignore"):
        known = (scan >= 0) & (scan < len(places)) & (scan == np.floor(scan))  # any file may have such a column
    seen_from = np.where(known[:, None], places[np.where(known, scan, 0).astype(np.int64)], np.nan)
    towards = np.sum((seen_from - arrays["points"]) * normals, axis=1)  # NaN of a scan without a position
    return np.where(towards[:, None] < 0.0, -normals, normals)


def _nearest(points, queries):
    """For each query the index of the nearest point."""
    import pyvista
    from vtkmodules.vtkCommonDataModel import vtkStaticPointLocator

    locator = vtkStaticPointLocator()
    locator.SetDataSet(pyvista.PolyData(points))
    locator.BuildLocator()
    return np.array([locator.FindClosestPoint(query) for query in queries], dtype=np.int64)
