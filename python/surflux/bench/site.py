"""`surflux bench --site FOLDER`: tables that the README and the guide quote, each as FOLDER/NAME.json and NAME.md, and
plots that they show, as NAME.json and a PNG for each picture. --only measures some of them.

Beside the rows stand the command that gives them alone, the day, the commit and the machine. While other programs keep
the machine busy, seconds of a table that is there stay, with their day and commit, and all else is measured; plots stay
as they are. In a checkout the folder is data/figures: `python tests/support/quoted_figures.py` brings the pages' tables
up to it, and tests/python/test_figures.py fails where a page quotes another number.
"""

import contextlib
import datetime
import json
import os
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import surflux as sf
from surflux.bench import areas, cases, plot, scale, scenes, solvers, transfer

BUSY = 0.5  # programs that wait for a processor, in the mean of the last minute


@dataclass(frozen=True)
class Table:
    """How a table is made: `measure(repeats, threads)` gives its rows, `text(rows)` their Markdown."""

    command: str
    measure: object
    text: object
    timed: tuple = ()  # columns that are seconds


def _cases(repeats, threads):
    return [asdict(row) for row in cases.measure_all(cases.CASES, repeats, threads)]


def _transfer(repeats, threads):
    return [transfer.shown(row) for row in transfer.measure(transfer.CASES, repeats, threads)]


TABLES = {
    "cases": Table(
        "surflux bench",
        _cases,
        lambda rows: cases.table([cases.Row(**row) for row in rows]),
        timed=("seconds", "stages", "repeats"),
    ),
    "areas": Table("surflux bench --areas", lambda repeats, threads: areas.of_clouds(), areas.as_markdown),
    "area_speeds": Table("surflux bench --areas", areas.methods, areas.as_markdown, timed=("seconds", "points/s")),
    "transfer": Table(
        "surflux bench --transfer",
        _transfer,
        transfer.short_table,
        timed=("seconds", "relight_ms", "bounce_ms", "frames", "frame_ms"),
    ),
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
        lambda rows: solvers.short_table([solvers.Row(**row) for row in rows]),
        {"speed_error": plot.draw, "error_seconds": plot.draw_asked},
    ),
    "growth": Plot(
        " ".join([f"surflux bench --scale --repeats 1 --paths {PATHS}", *(f'--scene "{name}"' for name in GROWTH)]),
        _growth,
        lambda rows: scale.short_table([scale.Row(**row) for row in rows]),
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
    found = _found(table, now, table.measure(repeats, threads))
    if table.timed and busy and path.exists():
        found = with_seconds_of(json.loads(path.read_text()), found, table.timed)
    path.write_text(json.dumps(found, indent=1) + "\n")
    path.with_suffix(".md").write_text(text(name, found) + "\n")
    return text(name, found)


def _write_plot(folder, name, now, busy, repeats, threads):
    what, path = PLOTS[name], folder / f"{name}.json"
    if busy and path.exists():
        return f"{name}: as it was"
    rows = what.measure(repeats, threads)
    found = _found(what, now, [asdict(row) for row in rows])
    lines = ",\n".join(" " + json.dumps(row) for row in found["rows"])  # one each
    path.write_text(f"{json.dumps(found | {'rows': []}, indent=1)[:-3]}\n{lines}\n ]\n}}\n")
    for picture, draw in what.pictures.items():
        draw(rows, folder / f"{picture}.png")
    return text(name, found)


def _found(what, now, rows):
    machine = {key: sf.info()[key] for key in ("threads", "instruction set", "Embree", "GL")}
    return {"command": what.command, **now, "machine": machine, "rows": rows}


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
