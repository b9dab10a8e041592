"""Solvers asked for an error, or for the best within a time, instead of by their knobs."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from surflux._base import check
from surflux._base.passes import LOG
from surflux._base.warn import warn
from surflux.solving.run import Overdue

# Powers of two by which the estimate falls, and the seconds grow, from a rung to the next, before two have told.
_GAIN, _COST = 0.7, 1.0
_LEAST_GAIN, _MOST_GAIN = 0.3, 1.3
_FARTHEST = 2.5  # rungs at once
# The estimate at rung 0 in rooms, by which the first attempt goes, but no farther than _FIRST: much of what a solve
# takes is the same for all rungs, so that one attempt is best.
_TYPICAL, _FIRST = 0.03, 2.0
_COARSEST = -1.5  # rung of the first attempt within a time, of 16 or 32 rays: half of the seconds of rung 0, or less
_FINEST, _NO_MORE = "these are the finest settings", "finer settings gain nothing any more"
_NO_GAIN = 0.1  # of an estimate: an attempt that takes off less than that a rung, of twice the seconds, is the last
_CELLS, _MOST_PLACES = 16, 3  # to a side of the grid that tells where errors are
_AIM = 0.88  # of the error that is wanted: estimates have an error themselves


@dataclass(frozen=True)
class Ladder:
    """Settings of a solver from coarse to fine, by a number of rungs, which need not be whole.

    settings: rung, from _COARSEST up -> dict of the solver's own options; top: the highest rung.
    """

    settings: Callable[[float], dict]
    top: float


def check_asked(error, seconds, given, defaults):
    """(error, seconds), checked; refuses options of `defaults` that are given as well, for they are chosen."""
    if error is not None:
        error = check.number("error", error, 0.0, 1.0, low_open=True, high_open=True)
    if seconds is not None:
        seconds = check.number("seconds", seconds, 0.0, low_open=True)
    asked = "error" if error is not None else "seconds"
    for name, default in defaults.items():
        if given[name] != default:
            raise ValueError(f"{name}: is chosen where {asked} is given; wanted one of the two")
    return error, seconds


def solve_asked(ladder, attempt, error, seconds):
    """The Solution of the lowest rung whose own estimate is at most `error`, or the best within `seconds`.

    attempt: (settings, deadline or None) -> (Solution, function that warns of it); raises Overdue where perf_counter()
        passes the deadline.
    """
    begun, tried, rung = perf_counter(), [], _COARSEST
    if seconds is None:
        rung = min(_FIRST, max(0.0, math.log2(_TYPICAL / (_AIM * error)) / _GAIN))
    best, coarser, why = None, None, None
    while why is None:
        settings = ladder.settings(rung)
        # The first has no deadline: a coarse answer is better than none.
        deadline = begun + seconds if seconds is not None and best is not None else None
        start = perf_counter()
        try:
            found = attempt(settings, deadline)
        except (Overdue, MemoryError) as fault:
            if best is None:
                raise
            why = "the time is up" if isinstance(fault, Overdue) else "there is no memory for finer settings"
            tried.append({"rung": rung, **settings, "error": math.nan, "seconds": perf_counter() - start})
            break
        now = perf_counter()
        estimate = found[0].error
        tried.append({"rung": rung, **settings, "error": estimate, "seconds": now - start})
        LOG.info(
            "attempt %d: estimated error %s after %.3g s, by %s",
            len(tried),
            _percent(estimate),
            now - begun,
            _text(settings),
        )
        if best is None or not estimate >= best[0].error:
            coarser, best = None if best is None else best[0].per_surfel("irradiance"), found
        del found
        if math.isnan(estimate):  # no light arrives
            why = "there is no light"
        elif error is None and estimate == 0.0:
            why = "nothing is left to gain"
        elif error is not None and estimate <= error:
            why = "the error is reached"
        elif rung >= ladder.top:
            why = _FINEST
        elif not _gains(tried):
            why = _NO_MORE
        else:
            rung = _next(ladder, tried, error, None if seconds is None else begun + seconds - now)
            why = "the next would not be ready in time" if rung is None else None
    solution, warn_of_it = best
    warn_of_it()
    if error is not None and solution.error > error:
        where = "" if coarser is None else _places(coarser, solution)
        more = why in (_NO_MORE, _FINEST) and len(solution.surfels.triangles)
        finer = "; finer patches may help (patch_area)" if more else ""
        warn(
            f"error: wanted {_percent(error)}, reached an estimated {_percent(solution.error)}, "
            f"for {why}{where}{finer}; what was tried stands in Solution.attempts"
        )
    _tell(solution, tried, error, seconds)
    return solution


def _gains(tried):
    if len(tried) < 2:
        return True
    last, previous = tried[-1], tried[-2]
    return last["error"] < (1.0 - _NO_GAIN) ** (last["rung"] - previous["rung"]) * previous["error"]


def _next(ladder, tried, error, left):
    """The rung to try, None where there is no time for one."""
    last = tried[-1]
    gain, cost = _GAIN, _COST
    if len(tried) > 1:
        previous = tried[-2]
        rungs = last["rung"] - previous["rung"]
        gain = math.log2(previous["error"] / last["error"]) / rungs
        gain = min(max(gain, _LEAST_GAIN), _MOST_GAIN)
        cost = max(cost, math.log2(last["seconds"] / previous["seconds"]) / rungs)
    step = _FARTHEST
    if error is not None:
        step = min(step, math.log2(last["error"] / (_AIM * error)) / gain)
    if left is not None:
        fits = math.log2(max(left, 1e-9) / last["seconds"]) / cost
        step = min(step, fits)
        if step < 0.25:
            return None
    return min(ladder.top, last["rung"] + max(step, 0.25))


def _tell(solution, tried, error, seconds):
    """What was asked and tried, in the solution's history, timings and attempts."""
    of = next(entry for entry in tried if entry["error"] == solution.error or math.isnan(solution.error))
    wanted = {"wanted_error": error, "wanted_seconds": seconds, "attempts": len(tried)}
    solution.history[-1] |= {name: value for name, value in wanted.items() if value is not None}
    others = sum(entry["seconds"] for entry in tried if entry is not of)
    if others > 0.0:
        solution.timings["attempts"] = others
    solution.attempts = [{name: value for name, value in entry.items() if name != "rung"} for entry in tried]


def _places(coarse, fine):
    """Where a solution differs most from the irradiance of a coarser one, by the scene's surfels, in words: cells of a
    grid in which the squares add up to most.
    """
    surfels, parents = fine.surfels, fine.parents
    areas = np.bincount(parents, surfels.areas)
    centers = np.stack([np.bincount(parents, surfels.areas * x) for x in surfels.points.T], axis=1) / areas[:, None]
    off = (fine.per_surfel("irradiance") - coarse) ** 2
    weights = areas * off.sum(axis=1)
    if not weights.sum() > 0.0:
        return ""
    low, side = centers.min(axis=0), max(np.ptp(centers, axis=0).max(), np.finfo(float).tiny)
    cells = np.minimum((_CELLS * (centers - low) / side).astype(np.int64), _CELLS - 1)
    _, of = np.unique(cells @ (_CELLS ** np.arange(3)), return_inverse=True)
    sums = np.bincount(of, weights)
    places = []
    most = [cell for cell in np.argsort(-sums)[:_MOST_PLACES] if sums[cell] > 0.0]
    for cell in most:
        inside = of == cell
        x, y, z = np.average(centers[inside], axis=0, weights=weights[inside])
        places.append(f"({x:.4g}, {y:.4g}, {z:.4g})")
    return f"; {sums[most].sum() / sums.sum():.0%} of what the last attempt changed is around {', '.join(places)}"


def _text(settings):
    return ", ".join(
        f"{name} {value:.3g}" if isinstance(value, float) else f"{name} {value}" for name, value in settings.items()
    )


def _percent(share):
    return f"{100 * share:.2g} %"
