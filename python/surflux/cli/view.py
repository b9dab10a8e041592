"""What `surflux view` does."""

import sys
from pathlib import Path

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux._base.warn import warn
from surflux.cli.cloud import camera_of_cloud
from surflux.cli.mesh import cut_to_tell, is_mesh, take_up
from surflux.cli.pictures import camera_of
from surflux.drawing.plots import picture_path
from surflux.points.reading import read_with_faces
from surflux.solutions.solution_file import NO_SOLUTION
from surflux.viewing.page import page_path

# What a page leaves to whoever looks at it, and what it is where nobody says.
_OF_WINDOWS = {"style": "disks", "light": "all", "stops": 0.0, "level": 0, "inserted": False, "pick": None}


def thing_of(options):
    """(what a file holds, as Surfels, Scene or Solution; whether w may write a camera into it).

    A scene is solved, unless --no-solve says otherwise.
    """
    path = Path(options.input)
    if path.suffix.lower() == ".toml":
        scene = sf.load_scene(path, progress=True)
        if options.no_solve or options.areas:
            return scene, True
        zeta = {} if options.zeta is None else {"zeta": options.zeta}
        return sf.solve(scene, **zeta, progress=True), True
    suffix = path.suffix.lower()
    if is_mesh(options):
        take_up(options)
        return sf.Surfels.from_mesh(path, progress=True), False
    try:
        if suffix == ".ply":
            return sf.load_solution(path), True
    except sf.FileError as error:
        if NO_SOLUTION not in str(error):
            raise
    surfels, faces = read_with_faces(path, viewpoint=options.viewpoint, points=options.points, progress=True)
    if faces:
        warn(f"{path}: has {check.counted(faces, 'face')}, left out, as its points are shown: --mesh shows the faces")
    return surfels, False


def refuse_options(options):
    """Refuses, before any work, options that do not go together."""
    scene = Path(options.input).suffix.lower() == ".toml"
    if options.zeta is not None and (not scene or options.no_solve):
        raise ValueError("--zeta: goes with a scene that is solved")
    if options.method is not None and not options.areas:
        raise ValueError("--method: goes with --areas")
    _check_looks(options)
    if options.export is not None:
        if options.screenshot is not None:
            raise ValueError("--export: wanted without --screenshot")
        require_place(page_path("--export", options.export))
        for name, usual in _OF_WINDOWS.items():
            if getattr(options, name) != usual:
                raise ValueError(f"--{name}: is the window's; wanted without --export")
    if options.screenshot is not None:
        picture_path("--screenshot", options.screenshot)


def _check_looks(options):
    """Refuses colours, styles and lights that nothing has, before a scene is solved to be shown."""
    from surflux.drawing.area_window import COLORS
    from surflux.drawing.glyphs import STYLES
    from surflux.viewing.properties import LIGHTS, PROPERTIES

    if options.color is not None:
        check.choice("--color", options.color, tuple(COLORS.values()) if options.areas else tuple(PROPERTIES))
    check.choice("--style", options.style, STYLES)
    check.choice("--light", options.light, LIGHTS)


def run(options):
    """One `surflux view`."""
    refuse_options(options)
    thing, keeps_camera = thing_of(options)
    surfels = thing if isinstance(thing, sf.Surfels) else thing.surfels
    camera = None if isinstance(thing, sf.Surfels) else thing.camera
    chosen = (options.eye, options.target, *(() if options.areas else (options.up, options.fov)))
    if options.pick is not None and options.areas:
        camera = None  # close to the surfel, unless told otherwise
    if isinstance(thing, sf.Surfels) and not options.areas:
        finer = cut_to_tell(options, surfels) if is_mesh(options) else None
        camera = camera_of_cloud(options, surfels, finer=finer)
    elif camera is not None or any(v is not None for v in chosen):
        camera = camera_of(options, surfels, camera)
    if options.areas:
        path = surfels.plot_areas(
            options.pick,
            color=options.color or "coverage",
            method=options.method,
            progress=True,
            screenshot=options.screenshot,
            camera=camera,
            up=options.up,
            size=options.size,
        )
    elif options.export is not None:
        title = getattr(thing, "name", "") or Path(options.input).stem
        page = sf.Page(thing, colors=colors_of_page(options.color, thing), camera=camera, title=title)
        path = page.save(options.export)
        print(f"page: {path} ({path.stat().st_size / 1e6:.1f} MB, {check.counted(len(surfels), 'surfel')})")
        return 0
    else:
        path = sf.view(
            thing,
            color=options.color,
            style=options.style,
            light=options.light,
            stops=options.stops,
            level=options.level,
            inserted=options.inserted,
            pick=options.pick,
            camera=camera,
            size=options.size,
            screenshot=options.screenshot,
            file=options.input if keeps_camera else None,
        )
    if path is not None:
        print(f"picture: {path}")
    sys.stdout.flush()
    return 0


def colors_of_page(color, thing):
    """The usual colours of a page, the one that was asked for first."""
    from surflux.viewing.page import USUAL
    from surflux.viewing.properties import names_of
    from surflux.viewing.subject import Subject

    if color is None:
        return None
    there = names_of(Subject(thing))
    check.choice("color", color, there)
    return [color, *(name for name in USUAL if name in there and name != color)]
