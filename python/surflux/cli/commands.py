"""The command line, `surflux`."""

import argparse
import contextlib
import json
import logging
import math
import os
import sys
import warnings
from pathlib import Path

import numpy as np

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux._base.passes import LOG, thread_limit
from surflux.cli import checking
from surflux.cli.facing import facing_cloud
from surflux.cli.options import command_line
from surflux.cli.pictures import camera_of, check_gaussians, check_images, write_gaussians, write_images
from surflux.pictures.animation import check_target
from surflux.scenes.options import TRANSPORTS
from surflux.scenes.studio import BACKDROP, studio
from surflux.solutions.solution_file import holds_solution

# A million surfels take about a minute and 2.5 GB: larger scans go in by this many of their points.
CLOUD_LIMIT = 1_000_000


def main(arguments=None):
    """Runs one command and returns its exit status: 0, 2 for input that cannot be taken, 1 for anything else."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    if arguments[:1] == ["bench"]:  # has options of its own
        options = argparse.Namespace(run=_bench, arguments=arguments[1:])
    else:
        options = command_line(RUNS, CLOUD_LIMIT).parse_args(arguments)
    try:
        with warnings.catch_warnings(), _log_said():
            warnings.showwarning = lambda message, *_, **__: _say(f"warning: {message}")
            _check_options(options)
            with thread_limit(getattr(options, "threads", None)):  # of all that the command does
                status = options.run(options) or 0
        sys.stdout.flush()  # here, where a reader that has gone is noticed and forgiven
        return status
    except BrokenPipeError:
        # Whoever read our output has gone; nothing is left to say, not even at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (OSError, ValueError) as error:  # FileError is an OSError
        return _fail(error, 2)
    except (KeyboardInterrupt, sf.Cancelled):
        return _fail("interrupted", 130)
    except (ImportError, MemoryError, RuntimeError) as error:  # DeviceError is a RuntimeError
        return _fail(str(error) or type(error).__name__, 1)


def _fail(error, status):
    print(f"surflux: error: {' '.join(str(error).split())}", file=sys.stderr)
    return status


class _Said(logging.Handler):
    """What the library logs, on stderr."""

    def emit(self, record):
        _say(record.getMessage())


@contextlib.contextmanager
def _log_said():
    before, said = LOG.level, _Said()
    LOG.addHandler(said)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.removeHandler(said)
        LOG.setLevel(before)


def _say(text):
    print(f"surflux: {text}", file=sys.stderr)


def _check_options(options):
    """Refuses, before any work, what would only be found out after it."""
    given = {name: value for name, value in vars(options).items() if value is not None}
    checks = {
        "thin": lambda name, value: check.count(name, value, 2),
        "points": lambda name, value: check.count(name, value, 2),
        "threads": check.count,
        "samples": lambda name, value: check.count(name, value, 1, 8),
        "turntable": check.count,
        "turn": lambda name, value: check.number(name, value, -1e6, 1e6),
        "fps": lambda name, value: check.number(name, value, 0.0, 1000.0, low_open=True),
        "stops": lambda name, value: check.number(name, value, -100.0, 100.0),
        "smallest": check.count,
        "seed": check.seed,
        "rays": lambda name, value: check.count(name, value, 16, 65535),
        "bounces": lambda name, value: None if value == "all" else check.count(name, value, 0),
        "epsilon_t": lambda name, value: check.number(name, value, 0.0, low_open=True),
        "tolerance": lambda name, value: check.number(name, value, 0.0, 1.0, low_open=True, high_open=True),
        "pick": lambda name, value: check.count(name, value, 0),
        "zeta": lambda name, value: check.number(name, value, 0.0, low_open=True),
        "transport": lambda name, value: check.choice(name, value, TRANSPORTS),
    }
    for name, checked in checks.items():
        if name in given:
            checked(f"--{name.replace('_', '-')}", given[name])
    if "viewpoint" in given and _is_scene(options.input):
        raise ValueError("--viewpoint: is for a cloud; a scene file says by itself what its normals are")
    if "points" in given and _is_scene(options.input):
        raise ValueError("--points: is for a cloud; a scene file thins an object by its key thin")
    if given.get("exposure", "auto") == "auto":
        options.exposure = None
    else:
        try:
            options.exposure = check.number("--exposure", float(options.exposure), 0.0, low_open=True)
        except ValueError:
            raise ValueError(f"--exposure: wanted a number above 0 or auto, got {options.exposure!r}") from None
    for side in given.get("size", ()):
        check.count("--size", side, 1, 16384)
    if "output" in given:
        output = Path(given["output"])
        if output.suffix.lower() != ".ply":
            raise ValueError(f"-o: wanted a name ending in .ply, got {str(output)!r}")
        require_place(output)


def _solve(options):
    if options.solver == "meshless":
        for name in ("zeta", "transport"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name}: goes with --solver radiosity")
        if options.no_insert:
            raise ValueError("--no-insert: goes with --solver radiosity")
    if options.no_image and options.image:
        raise ValueError("--no-image: does not go with --image")
    images = [] if options.no_image else options.image or [_default_image(_solve_output(options))]
    require_place(_solve_output(options))
    check_images(images)
    scene = _scene_to_solve(options)
    given = {name: getattr(options, name) for name in ("tolerance", "zeta", "rays", "transport", "seed", "threads")}
    if options.no_insert:
        given["insert"] = False
    settings = {name: value for name, value in given.items() if value is not None}
    camera = camera_of(options, scene.surfels, scene.camera)
    solver = sf.solve_meshless if options.solver == "meshless" else sf.solve
    solution = solver(scene, **settings, progress=True)
    output = _solve_output(options)
    solution.save(output)
    behind = {} if _is_scene(options.input) or options.light == "sky" else {"background": BACKDROP}
    undrawn = _draw(solution, camera, options, images, **behind)
    if undrawn is not None:
        images = []
    result = {
        "input": options.input,
        "surfels": len(solution.surfels),
        "area": float(solution.surfels.areas.sum()),
        "mean_radiosity": [float(v) for v in np.average(solution.radiosity, axis=0, weights=solution.surfels.areas)],
        "timings": solution.timings,
        "history": solution.history,
        "error": solution.error,
        "output": str(output),
        "images": [str(image) for image in images],
    }
    # Who asked for a picture and got none is told by the exit status, too; the solution is saved either way.
    status = 1 if undrawn is not None and options.image else 0
    if options.json:
        return _print_json(result) or status
    rgb = ", ".join(f"{v:.4g}" for v in result["mean_radiosity"])
    print(f"{check.counted(result['surfels'], 'surfel')}, area {result['area']:.6g}, mean radiosity {rgb}")
    if math.isfinite(solution.error):
        print(f"estimated error of the irradiance: {100 * solution.error:.2g} %")
    for stage, seconds in solution.timings.items():
        print(f"  {stage:<16} {seconds:8.3f} s")
    print(f"solved surfels: {output}")
    for image in images:
        print(f"picture: {image}")
    return status


def _draw(solution, camera, options, images, **settings):
    """Writes the pictures of `surflux solve`; where there is no OpenGL, says so and returns why."""
    try:
        if images:
            write_images(solution, camera, options, images, **settings)
    except sf.DeviceError as error:
        _say(f"warning: no picture, for {error} (--no-image asks for none)")
        return error
    return None


def _solve_output(options):
    return Path(options.output or f"{Path(options.input).stem}_solved.ply")


def _scene_to_solve(options):
    if _is_scene(options.input):
        if options.thin is not None:
            raise ValueError("--thin: is for a cloud; a scene file thins an object by its key thin")
        if options.light is not None:
            raise ValueError("--light: is for a cloud; a scene file has lights of its own")
        if options.normals is not None:
            raise ValueError("--normals: is for a cloud; a scene file turns an object by its key orient")
        return _load_scene(options)
    cloud = facing_cloud(options, _cloud)
    if holds_solution(options.input):
        raise sf.FileError(
            f"{options.input}: is solved already, and holds no lights; `surflux render` and `surflux view` show it"
        )
    limit = options.thin or options.points or CLOUD_LIMIT
    if len(cloud) > limit:
        _say(f"{len(cloud)} points are thinned to {limit} (--thin sets the number)")
        cloud = cloud.thinned(limit, 0 if options.seed is None else options.seed, progress=True)
    camera = camera_of(options, cloud, None)
    if options.light == "sky":
        _say("the cloud is lit by a sky of radiance 1 from all sides")
        lights = [sf.Environment(1.0)]
    else:
        _say("a cloud has no light: it gets a lamp behind the camera, and a sky (--light sky: of radiance 1, alone)")
        lights = studio(cloud, camera)
    return sf.Scene([cloud], lights, camera=camera, name=Path(options.input).stem)


def _load_scene(options):
    return sf.load_scene(options.input, threads=options.threads, progress=True)  # which has threads of its own


def _cloud(options, orient=False):
    given = {"viewpoint": options.viewpoint, "points": options.points, "seed": getattr(options, "seed", None) or 0}
    return sf.read(options.input, **given, orient=orient, progress=True)


def _is_scene(path):
    return Path(path).suffix.lower() == ".toml"


def _area(options):
    cloud = _load_scene(options).surfels if _is_scene(options.input) else _cloud(options)
    knobs = {name: getattr(options, name) for name in ("kappa", "resolution", "epsilon")}
    areas = sf.effective_areas(
        cloud,
        method=options.method,
        backend=options.backend,
        threads=options.threads,
        progress=True,
        **{name: value for name, value in knobs.items() if value is not None},
    )
    if options.output:
        cloud.areas = areas
        cloud.save(options.output)
    result = {
        "input": options.input,
        "surfels": len(cloud),
        "area": float(areas.sum()),
        "smallest": float(areas.min()),
        "largest": float(areas.max()),
        "method": options.method,
        "output": options.output,
    }
    if options.json:
        return _print_json(result)
    print(f"{check.counted(len(cloud), 'surfel')}, area {result['area']:.6g}")
    print(f"  each from {result['smallest']:.3g} to {result['largest']:.3g}")
    if options.output:
        print(f"surfels with areas: {options.output}")
    return 0


def _check_cloud(options):
    if _is_scene(options.input):
        if options.output:
            raise ValueError("--output: is for a cloud; a scene file turns an object's surfels round by its key orient")
        scene = _load_scene(options)
    else:
        scene = sf.Scene([_cloud(options)])
    result, lines = checking.checked(options, scene)
    if options.json:
        return _print_json(result)
    print("\n".join(lines))
    return 0


def _render(options):
    images = options.image or ([] if options.gaussians else [_default_image(Path(options.input))])
    if options.gaussians:
        check_gaussians(options.gaussians)
    if options.turntable is None:
        check_images(images)
    elif not options.image:
        raise ValueError("--turntable: wants an --image: a film (.mp4, .gif), or a pattern such as frames/%04d.png")
    else:
        for image in images:
            check_target(image, "--image")
    solution = sf.load_solution(options.input)
    camera = camera_of(options, solution.surfels, solution.camera)
    settings = {
        "samples": options.samples,
        "background": options.background,
        "culling": not options.both_sides,
        "threads": options.threads,
    }
    if options.gaussians:
        write_gaussians(solution, options)
    if options.turntable is None:
        if images:
            write_images(solution, camera, options, images, **settings)
    else:
        tone = {"exposure": options.exposure, "stops": options.stops, "filmic": not options.linear}
        cameras = sf.turntable(camera, options.turntable)
        images = [
            path
            for image in images
            for path in solution.animate(
                cameras, image, options.size, fps=options.fps, progress=True, **tone, **settings
            )
        ]
    if options.json:
        files = {"gaussians": options.gaussians} if options.gaussians else {}
        return _print_json({"input": options.input, "images": [str(image) for image in images], **files})
    if options.gaussians:
        print(f"Gaussians: {options.gaussians}")
    for image in images:
        print(f"picture: {image}")
    return 0


def _default_image(output):
    return output.with_suffix(".png")


def _relight(options):
    from surflux.cli import relight

    result, lines = relight.run(options)
    if options.json:
        return _print_json(result)
    print("\n".join(lines))
    return 0


def _view(options):
    from surflux.cli import view

    return view.run(options)


def _bench(options):
    from surflux.bench import command

    return command.main(options.arguments)


def _info(options):
    found = sf.info()
    if options.json:
        return _print_json(found)
    print(found)
    return 0


def _print_json(result):
    print(json.dumps(_plain(result), indent=2, allow_nan=False))
    return 0


def _plain(value):
    """value in the types that JSON has, which do not include NaN."""
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


RUNS = {
    "solve": _solve,
    "area": _area,
    "check": _check_cloud,
    "render": _render,
    "relight": _relight,
    "view": _view,
    "bench": _bench,
    "info": _info,
}

if __name__ == "__main__":
    sys.exit(main())
