"""What all solvers do around their pass of the core."""

import contextlib
from collections.abc import Callable
from contextvars import ContextVar
from functools import wraps
from inspect import signature
from time import perf_counter
from typing import TypeVar, cast

import numpy as np

from surflux import _core
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.warn import warn
from surflux.geometry.gloss import warn_of_gloss
from surflux.points.surfels import Surfels
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.lights import AreaLight, environments_among
from surflux.scenes.options import ASKED, checked_solve_options
from surflux.scenes.scene import Scene
from surflux.solutions.solution import Solution
from surflux.solving.darkness import warn_of_darkness, warn_of_lost_power, warn_of_power_into_backs
from surflux.solving.light_on_backs import LightOnBacks

Solver = TypeVar("Solver", bound=Callable[..., Solution])

# Of the RMS irradiance: an estimate above this is no solution.
MUCH_ERROR = 0.25
# Constants of a solver of _core that differ from its own: see tuned().
_tuning: ContextVar[dict | None] = ContextVar("tuning", default=None)
# What a solver of _core gives that a Solution takes as it is.
FOUND = ("parents", "objects", "levels", "cut", "radiosity", "irradiance", "direct", "emitted", "error")


def check_scene(scene):
    if not isinstance(scene, Scene):
        raise ValueError(f"scene: wanted a Scene, got {type(scene).__name__}")


def with_scene_options(chosen: tuple[str, ...]) -> Callable[[Solver], Solver]:
    """The solver with the scene's own options, those that it has, where the call does not give others.

    A call that asks for an error or a time takes the place of the scene's knobs that these choose, `chosen`, and the
    other way round.
    """

    def decorate(solver: Solver) -> Solver:
        names = signature(solver).parameters

        @wraps(solver)
        def solve(scene, **given):
            check_scene(scene)
            asks = any(given.get(name) is not None for name in ASKED)
            turns = any(given.get(name) is not None for name in chosen)
            instead = (chosen if asks else ()) + (ASKED if asks or turns else ())
            own = checked_solve_options(scene.solve_options)  # which is a dict that may have changed since it was set
            own = {name: value for name, value in own.items() if name in names and name not in instead}
            return solver(scene, **(own | given))

        return cast(Solver, solve)  # wraps keeps the signature

    return decorate


@contextlib.contextmanager
def tuned(constants):
    """While the block runs, solvers take these in place of their own (bench turns them).

    Those of solve() by rays are in _core.refinement_tuning(), by pairs in _core.pairs_tuning(), those of
    solve_meshless() in _core.meshless_tuning() and those of form_factors() in _core.form_factor_tuning(). `transport`
    says by what solve() goes.
    """
    before = _tuning.set(constants)
    try:
        yield
    finally:
        _tuning.reset(before)


def tuning():
    """What tuned() has set."""
    return _tuning.get() or {}


def require_no_deadline(seconds, cluster):
    """cluster: an Engine."""
    if seconds is not None and not cluster.is_alone:
        raise ValueError(
            "seconds: does not go with cluster or checkpoint, for how far a process gets in a time is its own; "
            "wanted error, or rays and what else decides about it"
        )


def with_areas(scene, threads, progress):
    """Compiles the scene, so that attempts find it compiled."""
    with thread_limit(threads):
        scene._to_core(progress=progress)


def attempt_by(solver, scene, options, threads, progress, field=None, converges=True, deadline=None):
    """(Solution of a solver of _core, a function that warns of what is wrong with it).

    field: (compiled scene, result, Solution) -> the field of that, or None. converges: whether its residual has
    to come below options["tolerance"]. deadline: of perf_counter(); Overdue where the solver is not done by then.
    """
    _refuse_light_below_zero(scene)
    with thread_limit(threads):
        start = perf_counter()
        core = scene._to_core(progress=progress)
        areas_seconds = perf_counter() - start
        with stage_callback(progress) as callback, until(deadline, callback) as goes_on:
            result = solver(core, **options, progress=goes_on)

    def say():
        warn_of_layers(scene)
        warn_of_gloss(core.surfels)
        residual = result["history"][-1]["residual"]
        if converges and residual > options["tolerance"]:
            warn(f"the linear solver stopped at a residual of {residual:.2g}")
        with thread_limit(threads):
            sides, told = LightOnBacks(scene.lights, core), []
            if sides.share is not None:
                solution.history[-1]["direct_on_backs"] = sides.share
            dark = warn_of_darkness(scene, core, result, told)
            if not dark:
                sides.warn(told)
        if not dark:  # of next to no light, what becomes of it says little
            _warn_of_lost_light(result, converges)

    surfels = Surfels._from_core(result["surfels"])
    for name in FOUND:
        if isinstance(result[name], np.ndarray):
            result[name].setflags(write=False)
    solution = Solution(
        surfels,
        **{name: result[name] for name in FOUND},
        timings={"areas": areas_seconds, **result["timings"]},
        history=[{"iteration": k + 1, **figures} for k, figures in enumerate(result["history"])],
        lamps=[light for light in scene.lights if isinstance(light, AreaLight)],
        environments=environments_among(scene.lights),
        camera=scene.camera,
        scene=scene,
    )
    if field is not None:
        solution._known_field = field(core, result, solution)
    return solution, say


class Overdue(Exception):
    """A deadline has passed."""


@contextlib.contextmanager
def until(deadline, callback):
    """The callback (stage, done, total) of a pass that is to end at a deadline, too, with Overdue; None for none."""
    if deadline is None:
        yield callback
        return
    over = False

    def goes_on(label, done, total):
        nonlocal over
        over = perf_counter() > deadline
        return not over and (callback is None or callback(label, done, total))

    try:
        yield goes_on
    except _core.Cancelled:
        if over:
            raise Overdue from None
        raise


def _warn_of_lost_light(result, converges):
    figures = result["history"][-1]
    warn_of_power_into_backs(figures)
    if not converges:  # of some bounces alone it is known that the others are missing
        return
    warn_of_lost_power(figures, "solver", figures["power_lost_error"])
    if result["error"] > MUCH_ERROR:
        warn(
            f"the irradiance is off by an estimated {result['error']:.0%}: light is concentrated on less than a patch "
            "or a disk, or surfaces are far larger than what is around them; finer ones help"
        )


def _refuse_light_below_zero(scene):
    """Few spherical harmonics of a lamp are below 0 elsewhere; refinement and errors by luminance take no such."""
    for light in environments_among(scene.lights):
        if light.image is not None and light.image.min() < 0.0:
            raise ValueError(
                "scene: solvers take light of at least 0, and its Environment of harmonics is below 0 in places; "
                "reference_irradiance and reference_radiance take it"
            )
