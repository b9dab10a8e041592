"""The scene of `surflux solar`: points by their classes, those that shade and those that irradiation is told of."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.passes import LOG, watched
from surflux._base.warn import warn
from surflux.geometry.estimates import outward_normals
from surflux.points.cleaning import cleaned, known_classes
from surflux.points.layers import is_terrain
from surflux.points.terrain import high_above, normals_of_terrain

# Classes of LAS by the names that --casters and --receivers take.
CLASSES = {"unclassified": (0, 1), "ground": (2,), "vegetation": (3, 4, 5), "building": (6,), "noise": (7, 18)}
CLASSES |= {"water": (9,), "rail": (10,), "road": (11,), "bridge": (17,)}
_FEW = 16  # points: fewer are no object of their own, for normals and radii are estimated of so many neighbours
_DOWN, _MANY_DOWN = -0.5, 0.01  # z of normals that face the ground, and how many of them are told of


def classes_of(option, text):
    """The numbers of "ground,building,3-5" as a set; ValueError names the option."""
    found = set()
    for part in text.lower().replace(" ", "").split(","):
        first, _, last = part.partition("-")
        if part in CLASSES:
            found |= {*CLASSES[part]}
        elif first.isdecimal() and (last.isdecimal() or first == part) and int(last or first) <= 255:
            found |= set(range(int(first), int(last or first) + 1))
        else:
            names = ", ".join(CLASSES)
            raise ValueError(f"{option}: wanted numbers from 0 to 255 or of {names}, by commas, got {part!r}")
    return found


def parts_of(options, scan):
    """(casters, receivers), masks (n,) of a Scan by its classes; what is left out or not told of is logged."""
    everything = np.ones(len(scan), bool)
    classes = scan.attributes.get("classification")
    if classes is None or np.ndim(classes) != 1:
        for name in ("casters", "receivers"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: {options.input} has no classes")
        return everything, everything
    classes = known_classes(scan.name, classes)
    there = {int(value) for value in np.unique(classes)}
    casting = there - {*CLASSES["noise"]} if options.casters is None else classes_of("--casters", options.casters)
    casters = np.isin(classes, [*casting])
    told = casting - {*CLASSES["vegetation"]}
    if options.receivers is not None:
        told = classes_of("--receivers", options.receivers)
        if there & told - casting:
            missing = sorted(there & told - casting)
            raise ValueError(f"--receivers: class {missing[0]} is not among --casters; what receives shades as well")
    receivers = np.isin(classes, [*told])
    shown = ", ".join(map(str, sorted(there)))
    for name, mask in (("casters", casters), ("receivers", receivers)):
        if not mask.any():
            raise ValueError(f"--{name}: no points are of these classes; {options.input} has {shown}")
    if not casters.all():
        left = ", ".join(map(str, sorted(there - casting)))
        LOG.info("%s of classes %s left out: no shade, no values", check.counted(int((~casters).sum()), "point"), left)
    green = sorted(there & casting & {*CLASSES["vegetation"]})
    if green:
        counted = check.counted(int(np.isin(classes, green).sum()), "point")
        LOG.info("crowns are opaque: %s of vegetation let no light through, in winter either", counted)
    elif there <= {0, 1, 2}:
        LOG.info("nothing is classed as vegetation or building: trees are taken for opaque surfaces, with values")
    return casters, receivers


def scene_of_scan(options, scan, frame):
    """(Scene in a Frame, (n,) the surfel of each point of the scan, -1 of none, (m,) which surfels are receivers).

    Normals are those of all points together. Receivers, and what only shades, then are an object each: radii and areas
    of the one do not go by points of the other.
    """
    casters, receivers = parts_of(options, scan)
    if options.casters is not None:  # what is left out was among the points that normals were fitted to
        scan = replace(scan, fitted=None)
    rows = np.flatnonzero(casters)
    used, first, _ = cleaned(scan[rows], options.keep_outliers)
    used, first = rows[used], rows[first]
    told = receivers[used]
    if not told.any():
        many = check.counted(int(receivers.sum()), "point") + (" of --receivers" if options.receivers else "")
        raise ValueError(
            f"{options.input}: none of its {many} has a value, for all stand alone (--keep-outliers takes them), "
            "or where one of another class does"
        )
    moved = _in_frame(scan, frame)[used]
    viewpoint = None if options.viewpoint is None else frame.points(options.viewpoint)
    reflectance = None if options.colors else options.albedo
    orient = options.normals in (None, "check")
    is_guessed = viewpoint is None and moved.normals is None and not np.any(np.isfinite(moved.viewpoints))
    if is_guessed:
        terrain = is_terrain(moved.points)
        normals = normals_of_terrain(moved.points, moved.fitted) if terrain else _towards_sky(moved, options.threads)
        moved, orient = replace(moved, normals=normals), False
    whole = moved.surfels(reflectance, viewpoint=viewpoint, orient=orient, progress=True)
    groups, objects = [np.flatnonzero(told), np.flatnonzero(~told)], [whole]
    if min(map(len, groups)) < _FEW:
        groups = [np.arange(len(used))]
    else:
        moved = replace(moved, normals=whole.normals)
        objects = [moved[some].surfels(whole.reflectance[some], progress=True) for some in groups]
    objects = [one.flipped() for one in objects] if options.normals == "flip" else objects
    order = used[np.concatenate(groups)]
    surfel = np.full(len(scan), -1)
    surfel[order] = np.arange(len(order))
    surfel[rows] = surfel[first]
    surfel[~receivers] = -1
    told = receivers[order]
    down = np.concatenate([one.normals[:, 2] for one in objects])[told] < _DOWN
    if down.mean() > _MANY_DOWN:
        hint = "if they are the wrong way round, --viewpoint X,Y,Z or --normals flip turns them"
        warn(f"{100.0 * down.mean():.0f} % of the points face the ground; {hint}")
    return sf.Scene(objects, name=Path(options.input).stem), surfel, told


def _towards_sky(scan, threads):
    """Estimated normals of a Scan: outwards, and those of open sheets, as of a roof alone, upwards."""
    sky = high_above(scan.points.min(axis=0), scan.points.max(axis=0))
    with watched(threads, True):
        return outward_normals(scan.points, scan.name, towards=sky, place="the sky", fitted=scan.fitted)


def _in_frame(scan, frame):
    attributes = dict(scan.attributes)
    for name, power in (("radius", 1), ("area", 2)):
        if name in attributes and frame.horizontal != frame.vertical:
            del attributes[name]  # disks do not stay round
        elif name in attributes:
            attributes[name] = attributes[name] * frame.horizontal**power
    return replace(
        scan,
        points=frame.points(scan.points),
        normals=None if scan.normals is None else frame.normals(scan.normals),
        attributes=attributes,
        viewpoints=frame.points(scan.viewpoints),
        fitted=None if scan.fitted is None else frame.normals(scan.fitted),
    )
