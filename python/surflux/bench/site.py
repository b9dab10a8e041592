"""`surflux bench --site FOLDER`: tables that the README and the guide quote, each as FOLDER/NAME.json and NAME.md, and
plots that they show, as NAME.json and a PNG for each picture. --only measures some of them.

On two cores all take some two hours: speed_error and transfer half of one each, estimates, estimates_large,
many_surfels, dim_room, asked, growth and cluster five to ten minutes each, the others less. Each is written when it is
done.

Beside the rows stand the command that gives them alone, the day, the commit and the machine. While other programs keep
the machine busy, seconds of a table that is there stay, with their day and commit, and all else is measured; plots stay
as they are. In a checkout the folder is data/figures: `python tests/support/quoted_figures.py` brings the pages' tables
up to it, and tests/python/test_figures.py fails where a page quotes another number.
"""

import contextlib
import datetime
import json
import os
import shlex
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path

import surflux as sf
from surflux.bench import (
    areas,
    cases,
    closed_forms,
    dim_room,
    estimates,
    facing,
    limits,
    many_surfels,
    plot,
    processes,
    ray_casting,
    reference,
    scale,
    scenes,
    sky,
    solar,
    solvers,
    tiles,
    transfer,
)

FOLDER = "data/figures"  # of a checkout
BUSY = 0.5  # programs that wait for a processor, in the mean of the last minute


@dataclass(frozen=True)
class Table:
    """How a table is made: `measure(repeats, threads)` gives its rows, `text(rows)` their Markdown; `pictures`, name ->
    (rows, path), are drawn beside it.
    """

    command: str
    measure: object
    text: object
    timed: tuple = ()  # columns that are seconds
    pictures: dict = field(default_factory=dict)


def _alone(name):
    """The command for a table that `surflux bench` has no option for."""
    return f"surflux bench --site {FOLDER} --only {name}"


def _shared_out(rows):
    return f"{processes.table(rows)}\n\nReckoned from these, times as fast as one:\n\n{processes.reckoned(rows)}"


def _of(rows):
    return [asdict(row) for row in rows]


def _text(table, row):
    """Of rows as JSON has them what `table` makes of such as `row`."""
    return lambda rows: table([row(**one) for one in rows])


TABLES = {
    "cases": Table(
        "surflux bench",
        lambda repeats, threads: _of(cases.measure_all(cases.CASES, repeats, threads)),
        _text(cases.table, cases.Row),
        timed=("seconds", "stages", "repeats"),
    ),
    "areas": Table("surflux bench --areas", lambda repeats, threads: areas.of_clouds(), areas.as_markdown),
    "area_convergence": Table("surflux bench --areas", lambda repeats, threads: areas.convergence(), areas.as_markdown),
    "area_speeds": Table("surflux bench --areas", areas.methods, areas.as_markdown, timed=("seconds", "points/s")),
    "many_surfels": Table(
        _alone("many_surfels"),
        lambda repeats, threads: _of(many_surfels.measure(many_surfels.SIZES, threads)),
        _text(many_surfels.table, many_surfels.Row),
        timed=("seconds", "clock_silence"),
        pictures={"many_surfels": plot.draw_many_surfels},
    ),
    "dim_room": Table(
        _alone("dim_room"),
        lambda repeats, threads: _of(dim_room.measure(repeats, threads)),
        _text(dim_room.table, dim_room.Row),
    ),
    "estimates": Table(
        _alone("estimates"),
        lambda repeats, threads: _of(
            estimates.measure([n for n in estimates.SCENES if n not in estimates.LARGE], repeats, threads)
        ),
        _text(estimates.table, estimates.Row),
    ),
    "estimates_large": Table(
        _alone("estimates_large"),
        lambda repeats, threads: _of(estimates.measure(estimates.LARGE, repeats, threads)),
        _text(estimates.table, estimates.Row),
    ),
    "asked": Table(
        _alone("asked"),
        lambda repeats, threads: _of(estimates.measure_asked(estimates.ASKED_SCENES, repeats, threads)),
        _text(estimates.asked_table, estimates.Row),
    ),
    "pictures": Table(
        _alone("pictures"),
        lambda repeats, threads: _of(ray_casting.measure(ray_casting.SCENES, threads)),
        _text(ray_casting.table, ray_casting.Row),
    ),
    "reference": Table(
        "surflux bench --reference",
        lambda repeats, threads: [reference.shown(row) for row in reference.measure(threads)],
        _text(reference.table, reference.Row),
    ),
    "transfer": Table(
        "surflux bench --transfer",
        lambda repeats, threads: [transfer.shown(r) for r in transfer.measure(transfer.CASES, repeats, threads)],
        transfer.short_table,
        timed=("seconds", "relight_ms", "bounce_ms", "frames", "frame_ms"),
    ),
    "cluster": Table(
        "surflux bench --cluster",
        lambda repeats, threads: _of(processes.measure()),
        _text(_shared_out, processes.Row),
    ),
}
# Of functions of the number of threads.
_ROWS = {
    "limits": limits.rows,
    "closed_forms": closed_forms.rows,
    "facing": facing.rows,
    "sky_view": sky.rows,
    "solar": solar.rows,
    "tiles": tiles.rows,
    "tile_memory": tiles.memory,
}
TABLES |= {
    name: Table(
        _alone(name),
        lambda _, threads, rows=rows: rows(threads),
        areas.as_markdown,
    )
    for name, rows in _ROWS.items()
}


@dataclass(frozen=True)
class Plot:
    """What is drawn: `measure(repeats, threads)` gives rows, of which `pictures`, name -> (rows, path), are made and
    `text(rows)`, some of them in Markdown."""

    command: str
    measure: object
    text: object
    pictures: dict


def _curves(repeats, threads):
    there = [name for name in scenes.NAMES if not scenes.why_not(name)]
    return solvers.measure(solvers.QUICK, there, repeats, threads)


def _growth(repeats, threads):
    return scale.measure(GROWTH, 1, threads, paths=PATHS)


# What takes minutes of the hour that all of --scale takes.
GROWTH = ("three spheres", "two bunnies", *(f"statues of {count}" for count in (100_000, 300_000, 1_000_000)))
PATHS = 4096
PLOTS = {
    "speed_error": Plot(
        "surflux bench --quick --plot curves.png",
        _curves,
        _text(solvers.short_table, solvers.Row),
        {"speed_error": plot.draw, "error_seconds": plot.draw_asked},
    ),
    "growth": Plot(
        " ".join([f"surflux bench --scale --repeats 1 --paths {PATHS}", *(f'--scene "{name}"' for name in GROWTH)]),
        _growth,
        _text(scale.short_table, scale.Row),
        {"growth": plot.draw_growth},
    ),
}


def write(folder, repeats, threads, only=None):
    """Measures what is asked for, all if `only` is None, and writes each when it is done; returns their Markdown, one
    below the other.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    now = {"date": datetime.date.today().isoformat(), "commit": commit()}  # before files in the checkout change
    load = os.getloadavg()[0]  # before anything is measured here
    busy = load > BUSY
    if busy:
        print(f"bench: other programs keep this machine busy (load {load:.1f})", file=sys.stderr)
    names = [name for name in (*TABLES, *PLOTS) if only is None or name in only]
    texts = [_write_table(folder, name, now, busy, repeats, threads) for name in names if name in TABLES]
    texts += [_write_plot(folder, name, now, busy, repeats, threads) for name in names if name in PLOTS]
    return "\n\n".join(texts)


def _write_table(folder, name, now, busy, repeats, threads):
    table, path = TABLES[name], folder / f"{name}.json"
    print(f"bench: table {name}", file=sys.stderr)
    rows = table.measure(repeats, threads)
    if not rows:
        return f"{name}: nothing could be measured here"
    found = _found(table, folder, now, rows)
    if table.timed and busy and path.exists():
        found = with_seconds_of(json.loads(path.read_text()), found, table.timed)
    path.write_text(json.dumps(found, indent=1) + "\n")
    path.with_suffix(".md").write_text(text(name, found) + "\n")
    for picture, draw in table.pictures.items():
        draw(found["rows"], folder / f"{picture}.png")
    return text(name, found)


def _write_plot(folder, name, now, busy, repeats, threads):
    what, path = PLOTS[name], folder / f"{name}.json"
    if busy and path.exists():
        return f"{name}: as it was"
    print(f"bench: plot {name}", file=sys.stderr)
    rows = what.measure(repeats, threads)
    found = _found(what, folder, now, _of(rows))
    lines = ",\n".join(" " + json.dumps(row) for row in found["rows"])  # one each
    path.write_text(f"{json.dumps(found | {'rows': []}, indent=1)[:-3]}\n{lines}\n ]\n}}\n")
    for picture, draw in what.pictures.items():
        draw(rows, folder / f"{picture}.png")
    return text(name, found)


def _found(what, folder, now, rows):
    command = what.command.replace(FOLDER, shlex.quote(str(folder)))
    machine = {key: sf.info()[key] for key in ("threads", "instruction set", "Embree", "GL")}
    return {"command": command, **now, "machine": machine, "rows": rows}


def with_seconds_of(old, found, timed):
    """What was found, with the seconds of an older file; rows that it has not are left out, which is said."""
    rows = {next(iter(row.values())): row for row in old["rows"]}
    kept = []
    for row in found["rows"]:
        name = next(iter(row.values()))
        if name in rows:
            kept.append(row | {column: rows[name][column] for column in timed})
        else:
            print(f"bench: {name} left out: its seconds were never measured on a quiet machine", file=sys.stderr)
    seconds = old.get("seconds", {key: old[key] for key in ("date", "commit")})
    return found | {"seconds": seconds, "rows": kept}


def text(name, found):
    """A table as pages have it: Markdown, and below it how, when and of which commit it was measured."""
    below = f"`{found['command']}`, {_when(found)}, {found['machine']['threads']} threads"
    if "seconds" in found:
        below += f"; seconds {_when(found['seconds'])}"
    return f"{(TABLES | PLOTS)[name].text(found['rows'])}\n\n*{below}.*"


def _when(found):
    return f"{found['date']}, commit {found['commit']}"


def commit():
    """The commit of the working folder, with "-dirty" where files differ from it; outside of a checkout the version."""
    with contextlib.suppress(OSError, subprocess.CalledProcessError):
        told = ["git", "describe", "--always", "--dirty", "--exclude=*"]
        return subprocess.run(told, check=True, capture_output=True, text=True).stdout.strip()
    return f"of {sf.__version__}"
