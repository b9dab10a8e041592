"""Files of points for `surflux doctor`: what they hold, and what becomes of it."""

import shlex

import numpy as np

import surflux as sf
from surflux import _core
from surflux._base import check
from surflux._base.color import white_of_colors
from surflux._base.passes import watched
from surflux._base.summary import box_text
from surflux.cli.cloud import Cloud, camera_of_cloud, is_cloud, lights_of_cloud, patches_of_file
from surflux.points.cleaning import cleaned, known_classes
from surflux.points.intensity import scale_of_intensity
from surflux.points.properties import found, has_linear
from surflux.points.scan import scan_of_columns
from surflux.scans.formats import format_of
from surflux.scans.georeference import georeference
from surflux.scans.reading import read_columns

# ASPRS LAS 1.4 R15, table 17.
CLASSES = ("never classified", "unclassified", "ground", "low vegetation", "medium vegetation", "high vegetation")
CLASSES += ("building", "low point (noise)", "model key-point", "water", "rail", "road surface", "overlap")
CLASSES += ("wire guard", "wire conductor", "transmission tower", "wire connector", "bridge deck", "high noise")
CLASSES += ("overhead structure", "ignored ground", "snow", "temporal exclusion")
_COARSE = 0.1  # spacings between two numbers that the file can tell apart
_LIGHTS = {
    "sun": "sun and sky of a clear day, as of terrain (--light studio, sky)",
    "studio": "a lamp behind the camera's left shoulder, in a room above the camera, and a sky (--light sun, sky)",
    None: "none but its own, for it shines by itself (--light studio, sun, sky)",
}


def facts_of_points(options, limit, solve_options):
    """What is known of a file of points: a dict for programs, "solve" and "next" in it.

    Args:
        limit: points that `surflux solve` takes; of more an even sample is looked at.
        solve_options: function of a list of arguments: the options of `surflux solve`.
    """
    path, form = options.input, format_of(options.input)
    most = options.points or limit
    with watched(None, True):
        read = read_columns(path, form, most)
    scan = scan_of_columns(path, read)
    sampled = len(scan) < read.count and read.count > most
    facts = {
        "format": form,
        "points": read.count,
        "sampled": len(scan) if sampled else None,
        "finite": None if sampled else len(scan),
        "faces": read.faces,
        **_places(scan, sampled),
        "unit": _unit(options.input, form, scan.points),
        "normals": _normals(scan, options.viewpoint, is_cloud(path)),
        "colors": _colors(read.columns.get("colors")),
        "intensity": _intensity(scan.attributes.get("intensity")),
        "classes": _classes(scan.name, scan.attributes.get("classification")),
        "returns": _returns(scan.attributes),
        "scanners": scan.viewpoints,
        "attributes": list(scan.attributes),
    }
    return facts | _solved(options, scan, facts, limit, solve_options)


def _unit(path, form, points):
    """The unit of coordinates, where the file or its format tells of it; nothing is guessed."""
    if form == "e57":
        return "metres, as E57 has them"
    try:
        found = georeference(path, 0.5 * (points.min(axis=0) + points.max(axis=0))[:2])
    except (sf.FileError, ImportError) as error:
        return f"not known: {error}"
    if found is None:
        return "not told by the file"
    of_z = "" if found.vertical is None else f", of z {found.vertical:.6g} m"
    return f"{found.horizontal:.6g} m{of_z} ({found.name}, at {found.latitude:.4f}, {found.longitude:.4f})"


def _places(scan, sampled):
    points = scan.points
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float(np.linalg.norm(high - low))
    _, first, isolated = cleaned(scan, say=False)  # solve says so
    alone = points[first == np.arange(len(points))]
    found = {
        "bounds": np.array([low, high]),
        "extent": extent,
        "offset": float(np.linalg.norm(0.5 * (low + high))),
        "duplicates": None if sampled else len(points) - len(alone),
        "isolated": None if sampled else int(np.count_nonzero(isolated)),
        "spacing": None,
        "steps": None,
    }
    if len(alone) > 1:
        nearest = _core.nearest_points(alone, 2)[:, 1]
        found["spacing"] = float(np.median(np.linalg.norm(alone - alone[nearest], axis=1)))
        # Coordinates that were 4-byte floats: how far two of them are from each other at least.
        if np.array_equal(points, points.astype(np.float32)):
            step = float(np.spacing(np.float32(np.max(np.abs(points)))))
            found["steps"] = step if step > _COARSE * found["spacing"] else None
    return found


def _normals(scan, viewpoint, checked):
    bad = len(scan) if scan.normals is None else int(np.count_nonzero(np.isnan(scan.normals[:, 0])))
    places = int(np.count_nonzero(np.isfinite(scan.viewpoints).all(axis=1)))
    if bad == 0:
        side = "as the file has them"
        side += "; solve turns over what faces inwards (--normals keep leaves it)" if checked else ""
    elif viewpoint is not None:
        side = "towards --viewpoint"
    elif scan.viewpoint is not None:
        side = "towards the scanner's position, of which the file tells"
    elif places and "scan" in scan.attributes:
        side = "of each scan towards its own scanner's position, of which the file tells"
    elif bad < len(scan):
        side = "as the nearest normal that the file has"
    else:
        side = None  # said when they are estimated
    return {"given": scan.normals is not None, "estimated": bad, "side": side}


def _colors(colors):
    if colors is None:
        return None
    largest = float(np.max(colors))
    floats = colors.dtype.kind == "f"
    white = white_of_colors(colors, "float" if floats else "uchar") if largest > 0 else None
    return {"bits": None if floats else 8 * colors.dtype.itemsize, "largest": largest, "white": white}


def _intensity(values):
    values = np.zeros(0) if values is None else values[np.isfinite(values)]
    if len(values) == 0:
        return None
    return {"least": float(np.min(values)), "largest": float(np.max(values)), "mean": float(np.mean(values))}


def _classes(path, values):
    if values is None or values.ndim != 1:
        return None
    codes, counts = np.unique(known_classes(path, values), return_counts=True)
    return [{"class": int(c), "name": class_name(int(c)), "points": int(n)} for c, n in zip(codes, counts, strict=True)]


def class_name(code):
    """What ASPRS calls a class."""
    if 0 <= code < len(CLASSES):
        return CLASSES[code]
    return "reserved" if code < 64 else "defined by its user"


def _returns(attributes):
    number, of = attributes.get("return_number"), attributes.get("number_of_returns")
    if number is None or of is None:
        return None
    return {"most": int(of.max()), "of_several": int(np.count_nonzero(of > 1)), "last": int(np.sum(number == of))}


def _solved(options, scan, facts, limit, solve_options):
    """What `surflux solve` makes of the file, by its own way of doing so: "solve" and "next"."""
    given = []
    if options.viewpoint is not None:
        given.append(f"--viewpoint={','.join(f'{v:g}' for v in options.viewpoint)}")
    if facts["points"] > limit or options.points is not None:
        given.append(f"--points={options.points or limit}")
    given = solve_options([*given, "--", options.input])
    try:
        surfels = Cloud(given, scan).surfels if is_cloud(options.input) else patches_of_file(given)
    except (sf.FileError, ValueError) as error:
        return {"solve": {"refused": str(error), "surfels": 0}, "next": "see help(surflux.read) for what it takes"}
    camera = camera_of_cloud(given, surfels, scan.viewpoint)
    lights_of_cloud(given, surfels, camera)
    grey = facts["colors"] is None or facts["colors"]["largest"] == 0
    intensity = scan.attributes.get("intensity")
    by_intensity = grey and intensity is not None and scale_of_intensity(intensity) is not None
    return {
        "solve": {
            "refused": None,
            "surfels": len(surfels),
            "patches": len(np.unique(surfels.triangle_surfel)),
            "reflectance": surfels.reflectance.mean(axis=0),
            "reflectance_of": _material(scan, grey, by_intensity),
            "radius": float(np.median(surfels.radii)),
            "camera": camera.to_dict(),
            "up": given.up or (0.0, 0.0, 1.0),
            "light": given.light,
        },
        "next": _next(options, given, facts["faces"]),
    }


def _next(options, given, faces):
    file = shlex.quote(options.input)
    more = "" if given.viewpoint is None else f" --viewpoint={','.join(f'{v:g}' for v in given.viewpoint)}"
    more += "" if given.points is None else f" --points {given.points}"
    return f"surflux solve {file}{more}" + (
        f" for the points alone, surflux solve --mesh {file} for the faces" if faces else ""
    )


def _material(scan, grey, by_intensity):
    if all(found(scan.attributes, f"reflectance_{c}") for c in "rgb"):
        return "the file's reflectance_r, _g and _b"
    if has_linear(scan.attributes, "reflectance"):
        return f"the file's column {found(scan.attributes, 'reflectance')}"
    if not grey:
        return "the colours, sRGB made linear, white at .98"
    return "grey by the intensity, .5 on average" if by_intensity else "grey, .5"


def lines_of_points(f):
    """The same in words."""
    bounds, solve = f["bounds"], f["solve"]
    lines = [
        _counts(f),
        f"bounds: {box_text(bounds)}",
        f"extent {f['extent']:.6g}, median spacing {_number(f['spacing'])}; unit: {f['unit']}",
    ]
    if f["offset"] > 10.0 * f["extent"] > 0.0:
        lines.append(f"far from the origin ({f['offset']:.6g}), which loses nothing: positions are 8-byte floats")
    if f["steps"] is not None:
        step = f"{f['steps']:.3g}"
        lines.append(f"coarse: the file has 4-byte floats, which here come in steps of {step}: export it with 8 bytes")
    lines.append(f"normals: {_normals_text(f)}")
    lines.append(f"colours: {_colors_text(f['colors'])}")
    if f["intensity"] is not None:
        lines.append("intensity: {least:.6g} to {largest:.6g}, mean {mean:.6g}".format(**f["intensity"]))
    if f["classes"] is not None:
        named = ", ".join("{points} {name} ({class})".format(**one) for one in f["classes"][:12])
        lines.append(f"classes: {named}{', ...' if len(f['classes']) > 12 else ''}")
    if f["returns"] is not None:
        text = "returns: up to {most} of a pulse, {of_several} points of several, {last} last ones"
        lines.append(text.format(**f["returns"]))
    places = [place for place in f["scanners"] if np.all(np.isfinite(place))]
    if len(f["scanners"]):
        shown = "; ".join(", ".join(f"{v:.6g}" for v in place) for place in places[:4]) or "not told"
        scans = check.counted(len(f["scanners"]), "scan")
        lines.append(f"{scans}, taken from: {shown}{'; ...' if len(places) > 4 else ''}")
    usual = ("intensity", "classification", "return_number", "number_of_returns", "scan")
    others = [name for name in f["attributes"] if name not in usual]
    if others:
        lines.append(f"other columns: {', '.join(others[:16])}{', ...' if len(others) > 16 else ''}")
    if f["duplicates"]:
        lines.append(f"duplicates: {check.counted(f['duplicates'], 'point')} where another one is, which counts once")
    if f["isolated"]:
        lines.append(f"isolated: {check.counted(f['isolated'], 'point')}, four times as far from others as usual there")
    if f["faces"]:
        lines.append(
            f"faces: {f['faces']}: it is a mesh, of which `solve` would take the points alone. `surflux solve --mesh` "
            'lights its faces, `surflux view --mesh` shows them; also kind = "mesh" in a scene file, or '
            "surflux.Surfels.from_mesh"
        )
    return [*lines, *_solve_lines(f, solve)]


def _counts(f):
    count, left = check.counted(f["points"], "point"), f["points"] - (f["finite"] or 0)
    if f["sampled"] is not None:
        more = f", of which an even sample of {f['sampled']} is looked at below"
    else:
        more = f", {left} of them without a finite place" if left else ", all finite"
    return f"points: {count} ({f['format'].upper()}){more}"


def _number(value):
    return "none" if value is None else f"{value:.4g}"


def _normals_text(f):
    normals = f["normals"]
    if normals["estimated"] == 0:
        return f"given, {normals['side']}"
    some = "none given" if not normals["given"] else f"{normals['estimated']} are zero or not finite"
    side = f", {normals['side']}" if normals["side"] else ""
    return f"{some}: estimated from 16 neighbours{side}"


def _colors_text(colors):
    if colors is None:
        return "none"
    if colors["largest"] == 0:
        return "none: the file has room for them, and all are 0"
    if colors["bits"] is None:
        kind = "fractions" if colors["white"] == 1.0 else "numbers"
    elif colors["bits"] > 8 and colors["white"] == 255.0:
        kind = f"8-bit numbers in {colors['bits']}-bit fields"
    else:
        kind = f"{colors['bits']} bits"
    return f"{kind}, up to {colors['largest']:g}; white is {colors['white']:g}"


def up_text(up):
    """The axis nearest to what is up: "z", "-y"."""
    axis = int(np.argmax(np.abs(up)))
    return ("-" if up[axis] < 0 else "") + "xyz"[axis]


def _solve_lines(f, solve):
    if solve["refused"] is not None:
        return [f"`surflux solve` refuses it: {solve['refused']}"]
    eye, target = np.array(solve["camera"]["eye"]), np.array(solve["camera"]["target"])
    back = (eye - target) / np.linalg.norm(eye - target)
    up = np.degrees(np.arcsin(np.clip(back @ solve["up"], -1.0, 1.0)))
    place = ", ".join(f"{v:.9g}" for v in np.round(eye, 4 - int(np.floor(np.log10(f["extent"] or 1.0)))))
    grey = ", ".join(f"{v:.2f}" for v in solve["reflectance"])
    thinned = f" (thinned from {f['points']})" if f["sampled"] is not None else ""
    patches = f", {solve['patches']} of them patches" if solve["patches"] else ""
    above = f"{abs(up):.0f} degrees {'above' if up >= 0 else 'below'}, {up_text(solve['up'])} up"
    lines = [
        f"`surflux solve` takes {check.counted(solve['surfels'], 'surfel')}{thinned}{patches}, "
        f"median radius {solve['radius']:.4g}",
        f"  reflectance: {solve['reflectance_of']}; mean {grey}",
        f"  light: {_LIGHTS[solve['light']]}",
        f"  camera: at ({place}), {above} (--eye, --target, --up choose)",
    ]
    if f["normals"]["estimated"] and f["normals"]["side"] is None:
        lines.append("  if it comes out dark or inside out: --viewpoint X,Y,Z says where the scanner stood")
    return lines
