"""What commands print: results on stdout, everything else on stderr, as much of it as -q and -v ask for."""

import contextlib
import json
import logging
import math
import sys

import numpy as np

from surflux._base.passes import LOG, without_progress

_LISTED = 4  # files: more have one line together
LEVELS = {"quiet": logging.WARNING, "usual": logging.INFO, "verbose": logging.DEBUG}


def fail(error, status):
    """Says what was wrong, in one line; the status."""
    say(f"error: {' '.join(str(error).split())}")
    return status


def say(text):
    """A line on stderr, where that takes it: nothing stops because nobody can be told."""
    with contextlib.suppress(OSError):
        print(f"surflux: {text}", file=sys.stderr)


def note(text):
    """A line on stderr of what is taken for granted; -q leaves it out."""
    LOG.info(text)


def note_replaced(path):
    """Says that an output that nobody has named takes the place of one: perhaps of another input of that stem."""
    if path.exists():
        note(f"{path} is there already, and is replaced (-o names another)")


class _Said(logging.Handler):
    """What the library logs, on stderr."""

    def emit(self, record):
        say(f"warning: {record.getMessage()}" if record.levelno >= logging.WARNING else record.getMessage())


@contextlib.contextmanager
def log_said(how="usual"):
    """What the library logs is said while the block runs.

    how: "quiet" is warnings alone and no progress; "verbose" is stages with their seconds, and what was chosen, too.
    """
    before, said = LOG.level, _Said()
    LOG.addHandler(said)
    LOG.setLevel(LEVELS[how])
    try:
        with without_progress() if how == "quiet" else contextlib.nullcontext():
            yield
    finally:
        LOG.removeHandler(said)
        LOG.setLevel(before)


def how_much(options):
    """A key of LEVELS."""
    if getattr(options, "quiet", False):
        return "quiet"
    return "verbose" if getattr(options, "verbose", False) else "usual"


def settings_text(options):
    """The options of a command as text: those that have a value."""
    unsaid = ("run", "command", "quiet", "verbose", "json", "usual")
    found = {name: value for name, value in vars(options).items() if name not in unsaid}
    given = [f"{name} = {value}" for name, value in found.items() if value is not None and value is not False]
    return f"settings: {', '.join(given)}"


def print_json(result):
    """Prints a result for programs; 0."""
    print(json.dumps(_plain(result), indent=2, allow_nan=False))
    return 0


def told(options, result, lines):
    """Prints a result for programs, or its lines for people; the exit status."""
    if options.json:
        return print_json(result)
    print("\n".join(lines))
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


def error_lines(solution, of="the irradiance"):
    """What a solution says of its own error: lines of text, none where it is unknown. of: what it is."""
    if not math.isfinite(solution.error):
        return []
    lines = [f"estimated error of {of}: {100 * solution.error:.2g} %"]
    last = solution.history[-1] if solution.history else {}
    local = [last.get(name, math.nan) for name in ("local_error", "local_error_p90")]
    if all(map(math.isfinite, local)):
        median, p90 = (f"{100 * value:.2g} %" for value in local)
        lines.append(f"  relative to the light of the place itself: {median} (median), {p90} (90th percentile)")
    return lines


def lines_of_files(what, paths):
    """A line of text for each file, but one for many: of numbered pictures, frame by frame."""
    paths = list(paths)
    if len(paths) <= _LISTED:
        return [f"{what}: {path}" for path in paths]
    return [f"{what}: {paths[0]} to {paths[-1]}, {len(paths)} of them"]
