"""`surflux bench`: seconds and errors of every pass on the machine at hand, in one table.

Each case is run once to warm up and then several times; seconds are medians, all stages counted. An error is measured
against a closed form where there is one; "own estimate" is Solution.error. With --quick or --full it measures instead
what each knob of each solver does (`solvers`), with --scale both from 2500 surfels to ten millions (`scale`),
with --areas effective areas (`areas`), with --reference the path tracer against Mitsuba (`reference`), with --constants
what each constant of a solver that is no option trades (`constants`), with --transfer precomputed light transport
beside what it is to reach (`transfer`), with --cluster processes that share a pass out (`processes`), with --site the
tables and plots that the README and the guide have (`site`), some of which no other option measures.
"""

import argparse
import json
import math
import sys
from dataclasses import asdict, replace
from pathlib import Path

import surflux as sf
from surflux._base import check
from surflux._base.files import require_place
from surflux.bench import cases, scenes


def main(arguments=None, epilog=None):
    """Measures what is asked for, prints the table, and returns the exit status."""
    parser = argparse.ArgumentParser(
        prog="surflux bench",
        description="Seconds and errors on this machine: of every pass, one case after another; or, with one of the "
        "options below, one thing in detail.",
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_options(parser)
    loudness = parser.add_mutually_exclusive_group()
    loudness.add_argument("-q", "--quiet", action="store_true", help="no progress; warnings stay")
    loudness.add_argument("-v", "--verbose", action="store_true", help="tell the seconds of every stage, too")
    options = parser.parse_args(arguments)
    kind = _kind(options)
    _check_options(options, kind)
    if options.list:
        print("\n".join(_scenes(kind) or cases.CASES))
        return 0
    if kind == "site":
        from surflux.bench import site

        print(heading() + site.write(options.site, options.repeats, options.threads, options.only))
        return 0
    if kind == "areas":
        from surflux.bench import areas

        areas.main(options.repeats, options.threads, options.markdown, options.json, options.plot, heading())
        return 0
    run = {
        "quick": _solvers,
        "full": _solvers,
        "scale": _scale,
        "reference": _reference,
        "constants": _constants,
        "transfer": _transfer,
        "cluster": _cluster,
        "cases": _cases,
    }[kind]
    rows, text = run(options)
    text = heading() + text
    print(text)
    if options.markdown:
        Path(options.markdown).write_text(text + "\n")
    if options.json:
        found = {"machine": dict(sf.info()), "rows": [asdict(row) for row in rows]}
        Path(options.json).write_text(json.dumps(found, indent=2) + "\n")
    return 0 if all(getattr(row, "passes", True) for row in rows) else 1


def add_options(parser):
    """What `surflux bench` takes, but for -q and -v."""
    parser.add_argument("--quick", action="store_true", help="error against seconds of solvers and knobs: half an hour")
    parser.add_argument("--full", action="store_true", help="the same on more surfels, with more paths and settings")
    parser.add_argument("--scale", action="store_true", help="2500 surfels to ten millions: seconds, memory, errors")
    parser.add_argument("--reference", action="store_true", help="reference_irradiance against Mitsuba 3")
    parser.add_argument("--areas", action="store_true", help="effective areas alone")
    parser.add_argument(
        "--constants",
        action="store_true",
        help="each constant of the solvers, halved and doubled",
    )
    text = "with --constants: only this one; again for more"
    parser.add_argument("--constant", action="append", metavar="NAME", help=text)
    parser.add_argument("--transfer", action="store_true", help="light that moves: precomputed, relit, drawn")
    parser.add_argument("--cluster", action="store_true", help="1, 2 and 4 processes of one thread that share a pass")
    parser.add_argument("--site", metavar="FOLDER", help="tables and plots of README and guide, JSON of each: hours")
    text = "with --site: only this table or plot; again for more"
    parser.add_argument("--only", action="append", metavar="NAME", help=text)
    parser.add_argument("--case", action="append", metavar="NAME", help="of the cases only this one; again for more")
    parser.add_argument("--scene", action="append", metavar="NAME", help="with a table of scenes: only this")
    parser.add_argument(
        "--paths",
        type=int,
        metavar="N",
        help="of the path tracer: at each point with --reference (default: 4096), at most at each surfel with --quick "
        "(default: 8192), --full (default: 65536) and --scale (default: 16384)",
    )
    parser.add_argument("--cache", metavar="FOLDER", help="with --scale: keep reference values there")
    parser.add_argument("--list", action="store_true", help="print the names of the cases, or of the scenes")
    parser.add_argument("--repeats", type=int, default=3, metavar="N", help="timed runs of each, or seeds (default: 3)")
    parser.add_argument("--threads", type=int, metavar="N", help="at most N threads (default: all)")
    parser.add_argument("--markdown", metavar="OUT.md", help="write the table there too")
    parser.add_argument("--json", metavar="OUT.json", help="write the rows there, for programs")
    parser.add_argument("--plot", metavar="OUT.png", help="with --quick, --full, --scale or --areas: the curves")


def _kind(options):
    """What is asked for, one of the options' names, or "cases" where none of these is."""
    kinds = ("quick", "full", "scale", "reference", "areas", "constants", "transfer", "cluster", "site")
    chosen = [kind for kind in kinds if getattr(options, kind)]
    if len(chosen) > 1:
        raise ValueError(f"--{chosen[1]}: does not go with --{chosen[0]}")
    return chosen[0] if chosen else "cases"


def _check_options(options, kind):
    if options.repeats < 1:
        raise ValueError(f"--repeats: wanted at least 1, got {options.repeats}")
    if options.threads is not None:
        check.count("--threads", options.threads)
    if options.plot and kind not in ("quick", "full", "scale", "areas"):
        raise ValueError("--plot: goes with --quick, --full, --scale or --areas")
    if kind == "site":
        for name in ("markdown", "json"):
            if getattr(options, name):
                raise ValueError(f"--{name}: does not go with --site, which writes both into its folder")
        from surflux.bench import site

        for name in options.only or ():
            check.choice("--only", name, (*site.TABLES, *site.PLOTS))
        if Path(options.site).exists() and not Path(options.site).is_dir():
            raise ValueError(f"--site: wanted a folder, and {options.site} is a file")
    elif options.only:
        raise ValueError("--only: goes with --site")
    if options.constant:
        if kind != "constants":
            raise ValueError("--constant: goes with --constants")
        from surflux.bench import constants

        for name in options.constant:
            if name not in constants.all_names():
                raise ValueError(f"--constant: no solver has a {name!r}")
    if options.case and kind != "cases":
        raise ValueError(f"--case: does not go with --{kind}, which has tables of its own")
    if options.paths is not None:
        if kind not in ("quick", "full", "scale", "reference"):
            raise ValueError("--paths: goes with --quick, --full, --scale or --reference")
        check.count("--paths", options.paths, 1024)
    for name in filter(None, (options.markdown, options.json, options.plot)):
        require_place(name)
    if options.plot:
        _check_plot(options.plot)
    if options.cache and kind != "scale":
        raise ValueError("--cache: goes with --scale")
    if options.scene and not _scenes(kind):
        raise ValueError("--scene: goes with --quick, --full, --scale, --constants or --transfer")
    for option, names in (("case", cases.CASES), ("scene", _scenes(kind))):
        for name in getattr(options, option) or ():
            if name not in names:
                raise ValueError(f"--{option}: there is no {name!r}; --list names them all")


def _check_plot(path):
    """Refuses what cannot be drawn, before hours of measuring."""
    try:
        from matplotlib.backend_bases import FigureCanvasBase
    except ImportError as error:
        raise ImportError(f"--plot: needs `pip install 'surflux[bench]'` ({error})") from error
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in FigureCanvasBase.get_supported_filetypes():
        raise ValueError(f"--plot: wanted a name ending in .png, got {path!r}")


def _scenes(kind):
    """The names of the scenes of a kind of table that has scenes."""
    if kind == "scale":
        from surflux.bench import scale

        return tuple(scale.SCENES)
    if kind == "transfer":
        from surflux.bench import transfer

        return tuple(transfer.CASES)
    return scenes.NAMES if kind in ("quick", "full", "constants") else ()


def _cases(options):
    rows = cases.measure_all(options.case or cases.CASES, options.repeats, options.threads)
    return rows, cases.table(rows)


def _solvers(options):
    """Scenes x solvers x knobs."""
    from surflux.bench import solvers
    from surflux.bench.truth import PATHS_A_ROUND

    names = _scenes_there(options.scene or scenes.NAMES)
    mode = solvers.QUICK if options.quick else solvers.FULL
    if options.paths is not None:
        mode = replace(mode, rounds=math.ceil(options.paths / PATHS_A_ROUND))
    rows = solvers.measure(mode, names, options.repeats, options.threads)
    if options.plot:
        from surflux.bench import plot

        plot.draw(rows, options.plot)
    return rows, solvers.table(rows)


def _scenes_there(names):
    """Those of the scenes that can be built here; of the others it is said why."""
    out = []
    for name in names:
        reason = scenes.why_not(name)
        if reason:
            print(f"bench: {name} left out: {reason}", file=sys.stderr)
        else:
            out.append(name)
    return out


def _constants(options):
    from surflux.bench import constants

    names = _scenes_there(options.scene or constants.SCENES)
    rows = constants.measure(names, options.repeats, options.threads, options.constant or ())
    return rows, constants.table(rows)


def _transfer(options):
    from surflux.bench import transfer

    rows = transfer.measure(options.scene or transfer.CASES, options.repeats, options.threads)
    return rows, transfer.table(rows)


def _cluster(options):
    from surflux.bench import processes

    if reason := processes.why_not():
        raise ImportError(f"--cluster: {reason}")
    rows = processes.measure()
    return rows, f"{processes.table(rows)}\n\n{processes.reckoned(rows)}"


def _scale(options):
    from surflux.bench import plot, scale

    names = options.scene or scale.SCENES
    rows = scale.measure(names, options.repeats, options.threads, options.cache, options.paths)
    if options.plot:
        plot.draw_growth(rows, options.plot)
    return rows, scale.table(rows)


def _reference(options):
    from surflux.bench import reference

    rows = reference.measure(options.threads, options.paths or 4096)
    return rows, reference.table(rows)


def heading():
    found = sf.info()
    return f"{found['threads']} threads, {found['instruction set']}, Embree {found['Embree']}, GL: {found['GL']}\n\n"
