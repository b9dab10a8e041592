"""`surflux solve`: a scene file, a cloud or a mesh, solved, written and drawn."""

from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux.cli import tiles
from surflux.cli.cloud import (
    Cloud,
    before_backdrop,
    camera_of_cloud,
    is_cloud,
    lights_of_cloud,
    patches_of_file,
)
from surflux.cli.mesh import is_mesh, patches_of_mesh, save_faces, take_up, tell_dark
from surflux.cli.outputs import images_of, output_of
from surflux.cli.pictures import background_of, camera_of, check_images, draw_if_possible
from surflux.cli.processes import check_processes, is_first, processes_given
from surflux.cli.saying import error_lines, note_replaced, print_json, told
from surflux.scenes.studio import ground
from surflux.solutions.solution_file import holds_solution

_OF_CLOUDS = ("albedo", "strict", "keep_outliers", "keep_steps", "raw_colors")
# Options that do not go with what is no cloud, and what a scene file has in their place.
_REFUSED = {
    "scene": ("thin", "light", "normals", "ground", *_OF_CLOUDS),
    "mesh": ("points", "viewpoint", "thin", *_OF_CLOUDS),
    "patches": _OF_CLOUDS,
}
_IN_SCENES = {
    "thin": "thins an object by its key thin",
    "light": "has lights of its own",
    "normals": "turns an object by its key orient",
}


def is_scene(path):
    return Path(path).suffix.lower() == ".toml"


def load_scene(options):
    return sf.load_scene(options.input, threads=options.threads, progress=True)  # which has threads of its own


def run(options):
    """One `surflux solve`; its exit status."""
    check_processes(options)
    if options.solver == "meshless":
        for name in ("zeta", "transport"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: goes with --solver radiosity")
        if options.insert is not None:
            raise ValueError(f"--{'' if options.insert else 'no-'}insert: goes with --solver radiosity")
    for name in ("zeta", "rays"):
        if getattr(options, name) is not None and (options.error or options.seconds):
            asked = "error" if options.error else "seconds"
            raise ValueError(f"--{name}: is chosen where --{asked} is given; wanted one of the two")
    if options.no_image and options.image:
        raise ValueError("--no-image: does not go with --image")
    if options.tiles:
        return told(options, *tiles.run(options))
    output = output_of(options)
    images = images_of(options)
    require_place(output)
    check_images(images)
    kind = kind_of(options)
    _refuse_options(options, kind)
    scene, cloud = _scene_to_solve(options, kind)
    if options.output is None:
        note_replaced(output)
    names = ("error", "seconds", "tolerance", "zeta", "rays", "transport", "seed", "threads")
    given = {name: getattr(options, name) for name in names}
    if options.solver == "radiosity":
        given["insert"] = options.insert
        if options.insert is None and cloud is not None and not options.ground:
            # Points have the light at their own places: that of inserted surfels would be a mean around them.
            given["insert"] = False
    settings = {name: value for name, value in given.items() if value is not None} | processes_given(options)
    camera = camera_of(options, scene.surfels, scene.camera)
    solver = sf.solve_meshless if options.solver == "meshless" else sf.solve
    solution = solver(scene, **settings, progress=True)
    if not is_first(options):
        return 0
    if kind == "mesh":
        tell_dark(options, scene.objects[0], solution.per_surfel("irradiance"))
    solution, behind = before_backdrop(options, solution)
    behind = background_of(options, behind)
    suffix = output.suffix.lower()
    if kind == "mesh" and suffix == ".vtp":
        save_faces(output, options.input, solution)
    elif cloud is None:
        solution.save(output, up=options.up or (0.0, 0.0, 1.0))
    else:
        cloud.save(output, solution, options.albedo, options.up)
    if options.solution:
        solution.save(options.solution)
    undrawn = draw_if_possible(
        solution, camera, options, images, background=behind, direct=options.direct or "interpolated"
    )
    if undrawn is not None:
        images = []
    result = {
        "input": options.input,
        "surfels": len(solution.surfels),
        "area": float(solution.surfels.areas.sum()),
        "mean_radiosity": [float(v) for v in np.average(solution.radiosity, axis=0, weights=solution.surfels.areas)],
        "timings": solution.timings,
        "history": solution.history,
        "attempts": solution.attempts,
        "error": solution.error,
        "output": str(output),
        "images": [str(image) for image in images],
    }
    if cloud is not None:
        result |= {"points": len(cloud.scan), "left_out": int(np.count_nonzero(cloud.alone))}
    if options.solution:
        result["solution"] = str(options.solution)
    # Who asked for a picture and got none is told by the exit status, too; the solution is saved either way.
    status = 1 if undrawn is not None and options.image else 0
    if options.json:
        return print_json(result) or status
    rgb = ", ".join(f"{v:.4g}" for v in result["mean_radiosity"])
    print(f"{check.counted(result['surfels'], 'surfel')}, area {result['area']:.6g}, mean radiosity {rgb}")
    for line in error_lines(solution):
        print(line)
    for stage, seconds in solution.timings.items():
        print(f"  {stage:<16} {seconds:8.3f} s")
    if cloud is None:
        what = {".ply": "solved surfels", ".vtp": "faces of the mesh, with their light"}
        print(f"{what.get(suffix, 'lit surfaces')}: {output}")
    else:
        print(f"{cloud.counted()}: {output}")
    if options.solution:
        print(f"solved surfels: {options.solution}")
    for image in images:
        print(f"picture: {image}")
    return status


def kind_of(options):
    """What the input is: "scene", "mesh", "cloud", or "patches" that Surfels.save wrote."""
    if is_scene(options.input):
        return "scene"
    return "mesh" if is_mesh(options) else "cloud" if is_cloud(options.input) else "patches"


def _refuse_options(options, kind):
    for name in _REFUSED.get(kind, ()):
        if getattr(options, name):
            hint = _IN_SCENES.get(name) if kind == "scene" else None
            raise ValueError(f"--{name.replace('_', '-')}: is for a cloud{f'; a scene file {hint}' if hint else ''}")


def _scene_to_solve(options, kind):
    """(Scene, Cloud or None of anything else)."""
    if kind == "scene":
        return load_scene(options), None
    if kind != "mesh" and Path(options.input).suffix.lower() == ".ply" and holds_solution(options.input):
        raise sf.FileError(
            f"{options.input}: is solved already, and holds no lights; `surflux render` and `surflux view` show it"
        )
    if kind == "mesh":
        take_up(options)
    cloud = Cloud(options) if kind == "cloud" else None
    surfels = cloud.surfels if cloud else (patches_of_mesh if kind == "mesh" else patches_of_file)(options)
    camera = camera_of_cloud(options, surfels, cloud.scan.viewpoint if cloud else None)
    objects = [surfels]
    if options.ground:  # which faces of a mesh may stand on, or stick into
        objects = sf.divide_patches([surfels, ground(surfels, options.up or (0.0, 0.0, 1.0))])
    name = Path(options.input).stem
    lights = lights_of_cloud(options, surfels, camera, "mesh" if kind == "mesh" else "cloud")
    return sf.Scene(objects, lights, camera=camera, name=name), cloud
