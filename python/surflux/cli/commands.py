"""The command line, `surflux`."""

import argparse
import sys
import warnings
from pathlib import Path

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux._base.passes import LOG, thread_limit
from surflux.cli import areas, checking, solve, tiles
from surflux.cli.cloud import CLOUD_LIMIT, is_cloud
from surflux.cli.completion import script
from surflux.cli.examples import epilog
from surflux.cli.interrupts import INTERRUPTED, ended_by_ctrl_c, leave
from surflux.cli.mesh import SUFFIXES as OF_MESHES
from surflux.cli.mesh import is_mesh, patches_of_mesh
from surflux.cli.options import command_line
from surflux.cli.outputs import check_outputs, images_of
from surflux.cli.parser import vectors_joined
from surflux.cli.pictures import (
    animations,
    background_of,
    camera_of,
    check_film,
    check_gaussians,
    check_images,
    write_gaussians,
    write_images,
)
from surflux.cli.points import Points
from surflux.cli.processes import in_all_processes, joined
from surflux.cli.saying import fail, how_much, lines_of_files, log_said, print_json, say, settings_text, told
from surflux.cli.solve import is_scene, load_scene
from surflux.cli.streams import usable_streams
from surflux.meshes.reading import read_mesh
from surflux.pictures.animation import FPS
from surflux.points.writing import ply_path
from surflux.scans.writing import WRITTEN
from surflux.scenes.options import TRANSPORTS
from surflux.solutions.saving import SUFFIXES as OF_SOLUTIONS

# Options that the library checks, as arguments of the same names.
_ARGUMENTS = {"backend", "color", "epsilon", "eye", "fov", "kappa", "level", "light", "method", "pick", "resolution"}
_ARGUMENTS |= {"style", "target", "up", "viewpoint"}


def main(arguments=None):
    """Runs one command and returns its exit status: 0, 2 for input that cannot be taken, 1 for anything else.

    arguments: of a program that goes on; None for those of the process, which Ctrl-C then ends, with 130.
    """
    if arguments is not None:
        with usable_streams():
            return _run(list(arguments))
    with usable_streams(own=True):
        with ended_by_ctrl_c():
            status = _run(sys.argv[1:])
        if status == INTERRUPTED:  # said already; threads that go on are not waited for
            leave(said=True)
    return status


def _run(arguments):
    if arguments[:1] == ["bench"]:  # has options of its own
        loud = {"quiet": {"-q", "--quiet"}, "verbose": {"-v", "--verbose"}}
        loud = {name: not flags.isdisjoint(arguments) for name, flags in loud.items()}
        options = argparse.Namespace(run=_bench, arguments=arguments[1:], **loud)
    else:
        options = command_line(RUNS, CLOUD_LIMIT).parse_args(vectors_joined(arguments))
    return in_all_processes(options, _run_options)


def _run_options(options):
    try:
        with warnings.catch_warnings(), log_said(how_much(options)), joined(options):
            warnings.showwarning = lambda message, *_, **__: say(f"warning: {message}")
            _check_options(options)
            LOG.debug(settings_text(options))
            with thread_limit(getattr(options, "threads", None)):  # of all that the command does
                status = options.run(options) or 0
        sys.stdout.flush()  # here, where a reader that has gone is noticed and forgiven
        return status
    except BrokenPipeError:  # whoever read our output has gone; nothing is left to say
        return 1
    except (OSError, ValueError, ImportError) as error:  # FileError is an OSError; a missing extra says its pip line
        return fail(_option_named(options, error), 2)
    except (KeyboardInterrupt, sf.Cancelled):
        return fail("interrupted", INTERRUPTED)
    except (MemoryError, RuntimeError) as error:  # DeviceError is a RuntimeError
        return fail(str(error) or type(error).__name__, 1)


def _option_named(options, error):
    """What an error says, beginning with the option whose value it is about where the library calls it an argument."""
    name, colon, said = str(error).partition(": ")
    if isinstance(error, ValueError) and colon and name in _ARGUMENTS and getattr(options, name, None) is not None:
        return f"--{name}: {said}"
    return error


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
        "fps": lambda name, value: check.number(name, value, *FPS),
        "stops": lambda name, value: check.number(name, value, -100.0, 100.0),
        "fov": lambda name, value: check.number(name, value, 0.0, 180.0, low_open=True, high_open=True),
        "smallest": check.count,
        "seed": check.seed,
        "rays": lambda name, value: check.count(name, value, 16, 65535),
        "bounces": lambda name, value: None if value == "all" else check.count(name, value, 0),
        "epsilon_t": lambda name, value: check.number(name, value, 0.0, low_open=True),
        "tolerance": lambda name, value: check.number(name, value, 0.0, 1.0, low_open=True, high_open=True),
        "pick": lambda name, value: check.count(name, value, 0),
        "zeta": lambda name, value: check.number(name, value, 0.0, low_open=True),
        "seconds": lambda name, value: check.number(name, value, 0.0, low_open=True),
        "transport": lambda name, value: check.choice(name, value, TRANSPORTS),
    }
    for name, checked in checks.items():
        if name in given:
            checked(f"--{name.replace('_', '-')}", given[name])
    if given.get("command") == "solve":
        tiles.check_options(options)
    if given.get("mesh") and is_scene(options.input):
        raise ValueError("--mesh: is for a PLY file; a scene file says by its key kind what it takes")
    if "viewpoint" in given and is_scene(options.input):
        raise ValueError("--viewpoint: is for a cloud; a scene file says by itself what its normals are")
    if "points" in given and is_scene(options.input):
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
    if "output" in given and not given.get("tiles"):
        output = Path(given["output"])
        _check_suffix(output, options)
        require_place(output)
    if given.get("solution") is not None:
        require_place(ply_path(given["solution"], "--solution"))
    if "input" in given:
        check_outputs(options)


def _check_suffix(output, options):
    """Refuses a name of -o that says no format of what the command writes of its input."""
    wanted = (".ply",)
    if options.command == "solve":
        wanted = {"mesh": OF_MESHES, "cloud": tuple(WRITTEN)}.get(solve.kind_of(options), OF_SOLUTIONS)
    if output.suffix.lower() not in wanted:
        is_picture = hasattr(options, "image") and output.suffix.lower() in (".png", ".exr", ".hdr")
        hint = "; a picture is --image" if is_picture else ""
        raise ValueError(f"-o: wanted a name ending in {', '.join(wanted)}, got {str(output)!r}{hint}")


def _cloud(options):
    given = {"viewpoint": options.viewpoint, "points": options.points, "seed": getattr(options, "seed", None) or 0}
    return sf.read(options.input, **given, progress=True)


def _area(options):
    points = None
    if is_scene(options.input):
        cloud = load_scene(options).surfels
    elif is_cloud(options.input):
        points = Points(options)
        cloud = points.surfels
    else:
        cloud = _cloud(options)
    return told(options, *areas.measured(options, cloud, points))


def _check_cloud(options):
    if is_scene(options.input):
        if options.output:
            raise ValueError("--output: is for a cloud; a scene file turns an object's surfels round by its key orient")
        scene = load_scene(options)
    elif is_mesh(options):
        if options.points is not None:
            raise ValueError("--points: is for a cloud")
        mesh = read_mesh(options.input)
        scene = sf.Scene([patches_of_mesh(options, mesh=mesh)])
        return told(options, *checking.checked(options, scene, mesh))
    elif options.output and is_cloud(options.input):
        points = Points(options)
        return told(options, *checking.checked(options, sf.Scene([points.surfels]), points=points))
    else:
        scene = sf.Scene([_cloud(options)])
    return told(options, *checking.checked(options, scene))


def _doctor(options):
    from surflux.cli import doctor

    def solve_options(arguments):
        return command_line(RUNS, CLOUD_LIMIT).parse_args(["solve", *arguments])

    result, lines = doctor.examined(options, CLOUD_LIMIT, solve_options)
    status = 2 if result.get("solve", {}).get("refused") else 0
    return told(options, result, lines) or status


def _render(options):
    images = images_of(options)
    if options.gaussians:
        check_gaussians(options.gaussians)
    if options.turntable is None:
        check_images(images)
    elif not options.image:
        raise ValueError("--turntable: wants an --image: a film (.mp4, .gif), or a pattern such as frames/%04d.png")
    else:
        for image in images:
            check_film(image, options)
    solution = sf.load_solution(options.input)
    camera = camera_of(options, solution.surfels, solution.camera)
    settings = {"samples": options.samples, "culling": not options.both_sides, "threads": options.threads}
    background = background_of(options)
    if options.gaussians:
        write_gaussians(solution, options)
    drawn = [[image] for image in images]
    if options.turntable is None:
        if images:
            write_images(solution, camera, options, images, background=background, **settings)
    else:
        drawn = animations(solution, camera, options, images, background, settings)
    if options.json:
        files = {"gaussians": options.gaussians} if options.gaussians else {}
        paths = [str(image) for series in drawn for image in series]
        return print_json({"input": options.input, "images": paths, **files})
    if options.gaussians:
        print(f"Gaussians: {options.gaussians}")
    for series in drawn:
        print("\n".join(lines_of_files("picture", series)))
    return 0


def _relight(options):
    from surflux.cli import relight

    return told(options, *relight.run(options))


def _solar(options):
    from surflux.cli import solar

    return told(options, *solar.run(options, CLOUD_LIMIT))


def _view(options):
    from surflux.cli import view

    return view.run(options)


def _bench(options):
    from surflux.bench import command

    return command.main(options.arguments, epilog("bench"))


def _info(options):
    found = sf.info()
    if options.json:
        return print_json(found)
    print(found)
    return 0


def _completion(options):
    from surflux.bench.command import add_options

    parser = command_line(RUNS, CLOUD_LIMIT)
    commands = next(action for action in parser._actions if action.dest == "command").choices
    add_options(commands["bench"])  # which reads its own otherwise
    print(script(options.shell, parser), end="")
    return 0


RUNS = {
    "solve": solve.run,
    "area": _area,
    "check": _check_cloud,
    "doctor": _doctor,
    "render": _render,
    "relight": _relight,
    "solar": _solar,
    "view": _view,
    "bench": _bench,
    "info": _info,
    "completion": _completion,
}

if __name__ == "__main__":
    sys.exit(main())
