"""`surflux bench --site FOLDER`: tables that the README and the guide quote, each as FOLDER/NAME.json and NAME.md.

Beside the rows stand the command that gives them alone, the day, the commit and the machine. In a checkout the folder is
data/figures: `python tests/support/quoted_figures.py` brings the pages' tables up to it, and tests/python/test_figures.py
fails where a page quotes another number.
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
from surflux.bench import areas, cases

BUSY = 0.5  # programs that wait for a processor, in the mean of the last minute


@dataclass(frozen=True)
class Table:
    """How a table is made: `measure(repeats, threads)` gives its rows, `text(rows)` their Markdown."""

    command: str
    measure: object
    text: object


def _cases(repeats, threads):
    return [asdict(row) for row in cases.measure_all(cases.CASES, repeats, threads)]


TABLES = {
    "cases": Table("surflux bench", _cases, lambda rows: cases.table([cases.Row(**row) for row in rows])),
    "areas": Table("surflux bench --areas", lambda repeats, threads: areas.of_clouds(), areas.as_markdown),
}


def write(folder, repeats, threads):
    """Measures all tables and writes each when it is done; returns their Markdown, one below the other."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    if (load := os.getloadavg()[0]) > BUSY:
        print(f"bench: other programs keep this machine busy (load {load:.1f}): seconds are too long", file=sys.stderr)
    texts = []
    for name, table in TABLES.items():
        found = {
            "command": table.command,
            "date": datetime.date.today().isoformat(),
            "commit": commit(),
            "machine": {key: sf.info()[key] for key in ("threads", "instruction set", "Embree", "GL")},
            "rows": table.measure(repeats, threads),
        }
        (folder / f"{name}.json").write_text(json.dumps(found, indent=1) + "\n")
        texts.append(text(name, found))
        (folder / f"{name}.md").write_text(texts[-1] + "\n")
    return "\n\n".join(texts)


def text(name, found):
    """A table as pages have it: Markdown, and below it how, when and of which commit it was measured."""
    date, command, threads = found["date"], found["command"], found["machine"]["threads"]
    below = f"*`{command}`, {date}, commit {found['commit']}, {threads} threads.*"
    return f"{TABLES[name].text(found['rows'])}\n\n{below}"


def commit():
    """The commit of the working folder, with "-dirty" where files differ from it; outside of a checkout the version."""
    with contextlib.suppress(OSError, subprocess.CalledProcessError):
        told = ["git", "describe", "--always", "--dirty", "--exclude=*"]
        return subprocess.run(told, check=True, capture_output=True, text=True).stdout.strip()
    return f"of {sf.__version__}"
