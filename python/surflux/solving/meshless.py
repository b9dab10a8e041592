"""Solving a scene in a meshless basis (Lehtinen and others 2007)."""

from __future__ import annotations

import math
from typing import Any

from surflux import _core
from surflux._base import check
from surflux._base.types import FilePath, Progress
from surflux.cluster.engines import shared_out
from surflux.scenes.options import shadow_options
from surflux.scenes.scene import Scene
from surflux.solutions.fields import BasisField, light_of
from surflux.solutions.solution import Solution
from surflux.solving.asking import Ladder, check_asked, solve_asked
from surflux.solving.run import attempt_by, require_no_deadline, tuning, with_areas, with_scene_options

_TOP = 6.0  # epsilon_e .0025 and 32 000 rays


@shared_out
@with_scene_options(("levels", "epsilon_e", "rays", "probes", "shadow_rays", "bounces"))
def solve_meshless(
    scene: Scene,
    *,
    error: float | None = None,
    seconds: float | None = None,
    levels: int = 6,
    radius: float | None = None,
    epsilon_e: float = 0.04,
    epsilon_omega: float = 0.314,
    rays: int = 512,
    bounces: int | None = None,
    indirect_only: bool = True,
    tolerance: float = 1e-4,
    probes: int = 16,
    shadow_rays: int = 64,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> Solution:
    """Radiosity of a scene by meshless finite elements (L07 section 6.3), on patches and disks alike.

    Irradiance is a sum of basis functions that scattered points on the surfaces induce: Shepard's weights on several
    levels, each of half the spacing, where finer levels correct what coarser ones leave (L07 section 4), at a place as
    far as what was gathered around bears out: near walls it may see other functions than the points there. Light is
    gathered by rays at the points of the coarsest level, then at finer ones around where neighbours differ, or where
    the correction is large. So the field is smooth, and where light changes little its points are few, however finely
    the surfaces are modelled. Surfels send by the field's means over them. Where the last corrections on a surfel are
    still large, as on tiles and reliefs finer than the last level, or rays contradict the field on one that is large or
    bright, light is gathered on all of that surfel, and counts for it alone: not for `irradiance_at`, nor for pictures.

    Args:
        scene: Scene. Functions of one of its objects say nothing about the others. Of its solve_options those count
            that are arguments here, too, wherever the call does not give others.
        error, seconds: see `solve`; they choose levels, epsilon_e, rays, probes and shadow_rays.
        levels: of the basis, at most; 1 to 10. Clouds have two more, which repeat the receivers that are as close
            together as their disks.
        radius: least distance of two points of the first level on a plane, in the unit of the positions; halved from
            level to level. None: by the areas of the objects.
        epsilon_e: what light at a receiver may be off by before it is refined, of the area-weighted RMS of what is
            solved for, or of four times its first bounce where that is less; in dim parts of the scene of five times
            the light there, down to a thousandth of that RMS; 1.4 times as much on each finer level, which speaks for
            less of the surface, and half as much at surfels themselves; positive.
        epsilon_omega: solid angle in steradians, as a receiver sees it, below which a patch wider than the coarsest
            spacing sends by its mean, too, and below which a larger one's functions are fine enough; positive.
        rays: of a receiver, 16 to 65535; half as many on every other finer level, down to 128. Where lights shine on
            patches, a quarter of them sample these (many lights: Conty Estevez and Kulla 2018). Where their standard
            error is more than half of what light may be off by in dim parts, as in a room lit through a gap, a receiver
            is shot once more, with 512 to four times as many, aimed at what it and those around it found bright; with
            rays below 128 none is.
        bounces: how often light is reflected; None for until the residual is below `tolerance`. With a number of them
            what the basis loses of the light at edges is not given back, some tenths of a per cent. `Solution.error` is
            of all bounces, and `power_lost` has what those left out would bring.
        indirect_only: True leaves what lights bring out of the basis, as L07 recommends: it is computed at every
            surfel, and where rays meet surfaces that are coarse. False has it in the basis. What emissive surfels bring
            is out of it either way.
        tolerance: |residual| / |right-hand side| of the linear system, where all bounces are wanted; in (0, 1).
        probes, shadow_rays, seed, cluster, checkpoint, threads, progress: see `solve`.

    Returns:
        Solution: `surfels` are the scene's own. `irradiance_at` evaluates the basis, as long as it is not from a file.

    Raises:
        ValueError: an argument out of range, by name; a process of the cluster with other scenes, options, versions or
            instruction sets.
        DeviceError: another process of the cluster has failed.
        FileError: the checkpoint is damaged, or of another call.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.1)
    >>> solution = sf.solve_meshless(sf.Scene([floor], lights=[sf.Environment(1.0)]))
    >>> print(solution.irradiance_at([[0.3, 0.6, 0.0]], [[0, 0, 1]]).round(4))
    [[3.1416 3.1416 3.1416]]
    """
    given = {
        "levels": levels,
        "radius": radius,
        "epsilon_e": epsilon_e,
        "epsilon_omega": epsilon_omega,
        "rays": rays,
        "bounces": bounces,
        "indirect_only": indirect_only,
        "tolerance": tolerance,
        "probes": probes,
        "shadow_rays": shadow_rays,
        "seed": seed,
    }

    require_no_deadline(seconds, cluster)

    def field(core, result, solution):
        basis = result["field"]
        if isinstance(basis, dict):
            basis = _core.MeshlessField(basis, core)
        return BasisField(basis, core, solution.surfels, solution.objects, light_of(solution), result["lit"])

    def solver(core, progress, **options):
        return cluster.call(_program, scene, options, progress)

    def attempt(settings=None, deadline=None):
        options = _checked(given | (settings or {}))
        converges = bounces is None
        solution, say = attempt_by(solver, scene, options, threads, progress, field, converges, deadline)
        solution._bounces = bounces
        return solution, say

    if error is not None or seconds is not None:
        if bounces is not None:
            raise ValueError("bounces: estimates of the error are of all of them; wanted none with error or seconds")
        defaults = {"levels": 6, "epsilon_e": 0.04, "rays": 512, "probes": 16, "shadow_rays": 64}
        error, seconds = check_asked(error, seconds, given, defaults)
        with_areas(scene, threads, progress)
        return solve_asked(Ladder(_settings, top=_TOP), attempt, error, seconds)
    solution, say = attempt()
    say()
    return solution


def _program(core, options, team, progress):
    """What each process of a cluster runs."""
    found = _core.solve_meshless(core, **options, team=team, progress=progress)
    if team is not None:  # of one process the field goes to another, which has a compiled scene of its own
        found["field"] = found["field"].functions()
    return found


def _checked(given):
    """Options as the core takes them."""
    radius, bounces = given["radius"], given["bounces"]
    return {
        "levels": check.count("levels", given["levels"], 1, 10),
        "radius": 0.0 if radius is None else check.number("radius", radius, 0.0, low_open=True),
        "epsilon_e": check.number("epsilon_e", given["epsilon_e"], 0.0, low_open=True),
        "epsilon_omega": check.number("epsilon_omega", given["epsilon_omega"], 0.0, low_open=True),
        "rays": check.count("rays", given["rays"], 16, 65535),
        "bounces": -1 if bounces is None else check.count("bounces", bounces, 0),
        "indirect_only": check.flag("indirect_only", given["indirect_only"]),
        "tolerance": check.number("tolerance", given["tolerance"], 0.0, 1.0, low_open=True, high_open=True),
        **shadow_options(given["probes"], given["shadow_rays"]),
        "seed": check.seed("seed", given["seed"]),
        "tuning": tuning(),
    }


def _settings(rung):
    """What is finer from rung to rung (Ladder): the light that may be off, with the standard error of rays."""
    rays = min(65535, round(128 * 4.0 ** (2.0 / 3.0 * rung)))
    levels = min(10, 6 + max(0, math.ceil(rung - 3.0)))
    return {"levels": levels, "epsilon_e": 0.16 * 0.5**rung, "rays": rays, "probes": rays // 4, "shadow_rays": rays}
