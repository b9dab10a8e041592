"""`surflux solar`: what sun and sky bring to every point of a cloud, mesh or scene, in kWh/m2."""

from argparse import Namespace
from pathlib import Path
from time import perf_counter

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.files import require_file, require_place
from surflux._base.passes import LOG
from surflux.cli.mesh import patches_of_mesh
from surflux.cli.outputs import images_of, output_of
from surflux.cli.pictures import camera_of
from surflux.cli.saying import note_replaced
from surflux.cli.solar_cloud import scene_of_scan
from surflux.cli.solar_site import check_weather, site_of
from surflux.cli.solve import kind_of
from surflux.drawing.plots import picture_path
from surflux.drawing.value_map import SCALE, value_map
from surflux.meshes.reading import GLTF
from surflux.pictures.framing import framing
from surflux.points.reading import warn_of_faces
from surflux.points.scan import read_scan_with_faces
from surflux.scans.writing import written_suffix

PARTS = "beam", "diffuse", "reflected"
# Tilts of surfaces in degrees: names, and where they begin.
TILTS = ("level, to 15 degrees", 0.0), ("tilted, to 60", 15.0), ("facades, to 120", 60.0), ("facing down", 120.0)
_COMPASS = "north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"


def run(options, limit):
    """What is found: a dict for programs, and lines of text. Writes the table and the picture.

    limit: of points that are read where --points gives none.
    """
    begin = perf_counter()
    kind, weather = _checked(options)
    table = output_of(options)
    image = next(map(Path, images_of(options)), None)
    written_suffix(table, "-o")
    require_place(table)
    if image is not None:
        picture_path("--image", image)
    if options.table is None:
        note_replaced(table)
    scan, scene, surfel, told, site = _input(options, kind, weather, limit)
    camera = _camera(options, scene, site.frame)
    if kind in ("cloud", "mesh"):
        edge = "points" if kind == "cloud" else "mesh"
        LOG.info("what lies past the edge of the %s is open: low sun comes in from there", edge)
    seconds = {"input": perf_counter() - begin}
    settings = {"seed": options.seed or 0, "bounces": None if options.bounces == "all" else options.bounces}
    if options.sun_step is not None:
        settings["sun_step"] = options.sun_step
    found = sf.solar_irradiation(scene, **site.hours, **settings, progress=True)
    seconds |= found.timings
    values = {"kwh": found.total} | {f"kwh_{part}": getattr(found, part) for part in PARTS}
    if not options.no_sky_view:
        start = perf_counter()
        values["sky_view"] = sf.sky_view_factor(scene, seed=options.seed or 0, progress=True)
        seconds["sky view"] = perf_counter() - start
    start = perf_counter()
    columns = {name: np.where(surfel < 0, np.nan, value[surfel]) for name, value in values.items()}
    scan.save(table, columns=columns)
    seconds["table"] = perf_counter() - start
    start = perf_counter()
    if image is not None:
        _draw(scene.surfels, np.where(told, found.total, np.nan), image, options, site, camera)
        seconds["picture"] = perf_counter() - start
    seconds["all"] = perf_counter() - begin
    areas = np.asarray(scene._to_core().surfels.areas)
    result = {"input": options.input, "output": str(table), "image": None if image is None else str(image)}
    result |= {"place": list(site.place), "north": site.frame.north, "weather": site.words, "hours": found.hours}
    result |= {"casters": len(told)} | figures(values, scene.surfels.normals[:, 2], areas, told) | {"timings": seconds}
    return result, _lines(result)


def _checked(options):
    """Refuses what would only be found out after minutes; (kind of the input, see kind_of, the Weather of --epw)."""
    if options.no_image and options.image:
        raise ValueError("--no-image: does not go with --image")
    check.number("--albedo", options.albedo, 0.0, 1.0, high_open=True)
    given = {name: getattr(options, name) for name in ("north", "altitude", "unit", "sun_step")}
    bounds = {"north": (-360.0, 360.0), "altitude": (-500.0, 9000.0), "unit": (1e-6, 1e6), "sun_step": (0.25, 30.0)}
    for name, value in given.items():
        if value is not None:
            check.number(f"--{name.replace('_', '-')}", value, *bounds[name])
    require_file(options.input)
    kind = kind_of(options)
    if kind == "mesh" and options.up is None and Path(options.input).suffix.lower() in GLTF:
        raise ValueError(
            f"{options.input}: glTF has y up, and the sun stands over z: a scene file that names it turns "
            "it; --up 0,0,1 says that this one has z up"
        )
    if kind != "cloud":
        refused = "casters", "receivers", "points", "viewpoint", "keep_outliers"
        for name in refused if kind == "mesh" else (*refused, "colors", "normals"):
            if getattr(options, name):
                flag = f"--{name.replace('_', '-')}"
                why = "" if kind == "mesh" else "; scenes and patches of a mesh say by themselves what they are"
                raise ValueError(f"{flag}: is for a cloud{why}")
    return kind, check_weather(options)


def _input(options, kind, weather, limit):
    """(Scan, Scene in the Site's frame, (n,) the surfel of each point or -1, which of them count, Site)."""
    if kind != "cloud":
        if kind == "scene":
            scene = sf.load_scene(options.input, threads=options.threads, progress=True)
        elif kind == "mesh":
            scene = sf.Scene([patches_of_mesh(options, None if options.colors else options.albedo)])
        else:
            scene = sf.Scene([sf.read(options.input, progress=True)])
        surfels = scene.surfels
        site = site_of(options, surfels.points, weather)
        scan = sf.Scan(surfels.points, surfels.normals, surfels.reflectance, name=options.input)
        moved = [one.transformed(site.frame.matrix()) for one in scene.objects]
        everything = np.arange(len(surfels)), np.ones(len(surfels), bool)
        return scan, sf.Scene(moved, camera=_moved(scene.camera, site.frame), name=scene.name), *everything, site
    most = options.points or limit
    scan, faces = read_scan_with_faces(options.input, points=most, seed=options.seed or 0, progress=True)
    warn_of_faces(options.input, faces)
    if scan.rows[-1] >= most:
        LOG.info("%d points are taken of the file, evenly, and written (--points sets how many at most)", len(scan))
    site = site_of(options, scan.points, weather)
    return scan, *scene_of_scan(options, scan, site.frame), site


def _moved(camera, frame):
    if camera is None:
        return None
    up = frame.points(camera.up)
    height = None if camera.height is None else frame.horizontal * camera.height
    return sf.Camera(frame.points(camera.eye), frame.points(camera.target), up, camera.fov, height=height)


def _camera(options, scene, frame):
    """The camera of the picture; --eye, --target and --up are in the file's coordinates."""
    for name in ("eye", "target"):
        if getattr(options, name) is not None:
            setattr(options, name, tuple(frame.points(getattr(options, name))))
    if options.up is not None:
        options.up = tuple(frame.points(options.up))
    size = (1.0 - SCALE) * options.size[0], options.size[1]
    default = scene.camera
    if default is None:  # never from straight above, where facades do not show
        default = framing(scene.surfels, size, (0, 0, 1) if options.up is None else options.up, along=False)
    return camera_of(Namespace(**vars(options) | {"size": size}), scene.surfels, default)


def _draw(surfels, values, image, options, site, camera):
    ahead = camera.target - camera.eye
    towards = _COMPASS[round(np.degrees(np.arctan2(ahead[0], ahead[1])) / 45.0) % 8]
    title = f"{Path(options.input).name}, {site.words}; seen towards {towards}"
    value_map(surfels, values, image, unit="kWh/m2", title=title, camera=camera, size=options.size)


def figures(values, up, areas, told):
    """What a program is told of the points that count: values by name (n,), z of normals, m2, and which count."""
    areas, up, kept = areas[told], up[told], {name: value[told] for name, value in values.items()}
    area = areas.sum()

    def mean(value, some=slice(None)):
        weight = areas[some].sum()
        return float(value[some] @ areas[some] / weight) if weight > 0.0 else np.nan

    order = np.argsort(kept["kwh"])
    best = order[np.searchsorted(np.cumsum(areas[order]), 0.9 * area)]
    tilt = np.degrees(np.arccos(up.clip(-1.0, 1.0)))
    ends = [*(begin for _, begin in TILTS[1:]), 181.0]
    tilts = []
    for (name, begin), end in zip(TILTS, ends, strict=True):
        some = (tilt >= begin) & (tilt < end)
        tilts.append({"tilt": name, "area": float(areas[some].sum()), "kwh": mean(kept["kwh"], some)})
    return {
        "points": len(areas),
        "area": float(area),
        "mean": {name: mean(value) for name, value in kept.items()},
        "best_tenth": float(kept["kwh"][best]),
        "most": float(kept["kwh"].max()),
        "tilts": tilts,
    }


def _lines(result):
    mean = result["mean"]
    counted = check.counted(result["points"], "point")
    shade = "" if result["casters"] == result["points"] else f", of {result['casters']} that shade"
    lines = [f"{counted}{shade}, area {result['area']:.6g} m2, {result['hours']:g} h: {result['weather']}"]
    shares = ""
    if mean["kwh"] > 0.0:
        shares = ": " + ", ".join(f"{part} {100.0 * mean[f'kwh_{part}'] / mean['kwh']:.1f} %" for part in PARTS)
    lines.append(f"mean {mean['kwh']:.4g} kWh/m2{shares}")
    lines.append(f"the best tenth of the area has {result['best_tenth']:.4g} kWh/m2 or more")
    lines += [f"  {t['tilt']:<24} {t['area']:9.0f} m2 {t['kwh']:8.4g} kWh/m2" for t in result["tilts"] if t["area"]]
    if "sky_view" in mean:
        lines.append(f"mean sky-view factor {mean['sky_view']:.3f}")
    lines += [f"  {stage:<16} {seconds:8.3f} s" for stage, seconds in result["timings"].items()]
    lines.append(f"points with kWh/m2: {result['output']}")
    if result["image"] is not None:
        lines.append(f"picture: {result['image']}")
    return lines
