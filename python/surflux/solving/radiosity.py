"""Solving a scene by radiosity on surfels (Dobashi, Yamamoto and Nishita 2004)."""

from __future__ import annotations

from typing import Any, Literal

from surflux import _core
from surflux._base import check
from surflux._base.types import FilePath, Progress
from surflux.cluster.engines import shared_out
from surflux.scenes.options import CHOSEN, TRANSPORTS, most_surfels, shadow_options
from surflux.scenes.scene import Scene
from surflux.solutions.solution import Solution
from surflux.solving.asking import Ladder, check_asked, solve_asked
from surflux.solving.run import attempt_by, require_no_deadline, tuning, with_areas, with_scene_options

_RAYS_BY_RUNG = 2.0 / 3.0  # powers of four by which rays grow where zeta is halved
_TOP = 7.0  # zeta .0006 and 41 000 rays


@shared_out
@with_scene_options(CHOSEN)
def solve(
    scene: Scene,
    *,
    error: float | None = None,
    seconds: float | None = None,
    zeta: float = 0.02,
    insert: bool = True,
    tolerance: float = 1e-4,
    max_surfels: int | None = None,
    transport: Literal["auto", "pairs", "rays"] = "auto",
    rays: int = 256,
    probes: int = 16,
    shadow_rays: int = 64,
    epsilon: float = 0.8,
    max_memory: float | None = None,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> Solution:
    """Radiosity of a scene, with shadows and all interreflection (D04 section 7).

    Solves B = E + rho H, H = D + F B (D04 eq. 1, with the unknown as D03 section 3 has it) for red, green and blue, or
    once where the scene is grey. The scene stays as it is; areas that it lacks are computed.

    There are two ways to find how light is exchanged. With `transport="rays"` nodes of the hierarchy of surfels (D04
    section 6) gather light by rays, once and for all, from whatever surfel or group of surfels each ray's cone covers.
    Nodes give way to their members where interpolation between them would be off by more than `zeta` (global
    refinement, D04 7.1); the linear system is solved by GMRES, again from where it stood. Direct light is computed at
    every surfel. Seconds and memory grow about in proportion to the surfels; the standard error of the rays, 1 or 2 %
    of the indirect light with 256, stays, but for what a quadratic through the nodes around takes off it (local
    regression, Cleveland 1979, as far as Stein's estimate of the risk finds it better; not under a constant
    Environment). Where it is more than zeta times ten times the light there, as in a room lit by a gap, nodes get up to
    four times the rays, aimed at what others around found bright. With `transport="pairs"` all pairs of surfels
    exchange light by form factors that are symmetric and closed: each row, with what rays find to leave the scene or to
    end on a back face, makes 1. Precise to .1 % in smooth scenes; memory grows as 4 n^2 bytes, seconds as n^2. "auto"
    takes pairs up to 2000 surfels and rays beyond.

    With `insert`, a surfel beside which the field is not what its slope says, by more than zeta, gives way to four
    (D04 7.2), at the borders of shadows above all; they in turn, down to a sixteenth of the radius of surfels (RMS by
    area). Of polygons they take the part that is nearest to each. Their areas add up to that of the surfel.

    Args:
        scene: Scene. Its solve_options count wherever the call does not give others.
        error: the relative RMS error of H that is wanted, such as 0.02, in (0, 1): `Solution.error` is at most that, or
            a warning says why not, and where light still changes. It chooses zeta, rays, probes and shadow_rays, and
            max_surfels where none is given.
        seconds: of wall-clock time that attempts may take, once areas are known: the best of them counts. The first
            and coarsest is made in any case. With `error` whichever comes first ends it.
        zeta: what interpolation may leave, of the area-weighted RMS of H, and in a dim room of ten times what light
            there is (transport="rays"; the logarithmic mean of H that a node's rays meet, a thousandth of the RMS at
            least); positive.
        insert: False solves for the scene's own surfels alone.
        tolerance: |residual| / |right-hand side| of the linear system, with transport="rays" both in units of the light
            that there is; in (0, 1).
        max_surfels: of the solution; None for twice those of the scene, but not 50 000 more. Where that is not enough,
            what matters most to the RMS goes first; `history` says how many were left out.
        transport: "auto", "pairs" or "rays".
        rays: of a node; with pairs of each surfel, to measure what escapes and what Environments send, four times as
            many where not all meet the same; 16 to 65535.
        probes, shadow_rays: shadow rays from a surfel to a light: as many to begin with, and where more than one
            disagrees; more for a patch that is a large part of the scene.
        epsilon: surfels with n_i . n_j above this that overlap stand for the same surface and may form a group (D04 eq.
            10); in (0, 1).
        max_memory: bytes for the exchange of all pairs; None for three quarters of the machine's memory, or
            of what is left of a lower limit (container, batch queue, ulimit -v).
        seed: of everything random; the result is the same for the same seed, whatever the number of threads and of
            processes.
        cluster: a communicator of mpi4py, such as MPI.COMM_WORLD: its processes share the work out. All of them make
            the same call, with the same scene, and all get the solution. Or a client of dask.distributed: its workers
            do, and one that is lost is replaced. Does not go with `seconds`.
        checkpoint: a folder that keeps what was computed, stage by stage. The same call goes on from there, to the same
            bits, in any number of processes. Does not go with `seconds`.
        threads: at most this many of each process, None for all; workers of Dask have their own number.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Solution.

    Raises:
        ValueError: an argument out of range, by name; more surfels than the memory takes for pairs; processes of a
            cluster with other scenes, options, versions or instruction sets.
        FileError: the checkpoint is damaged, or that of another call.
        DeviceError: another process of the cluster has failed.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> points = [[x, y, 0.0] for x in range(10) for y in range(10)]
    >>> cloud = sf.Surfels(points, normals=[[0, 0, 1]] * 100, reflectance=0.5)
    >>> solution = sf.solve(sf.Scene([cloud], lights=[sf.Environment(1.0)]))
    >>> bool(abs(solution.irradiance - 3.14159).max() < 1e-4)  # a flat cloud sees the whole sky
    True
    """
    given = {
        "transport": transport,
        "zeta": zeta,
        "insert": insert,
        "max_surfels": max_surfels,
        "tolerance": tolerance,
        "rays": rays,
        "probes": probes,
        "shadow_rays": shadow_rays,
        "epsilon": epsilon,
        "max_memory": max_memory,
        "seed": seed,
    }

    require_no_deadline(seconds, cluster)

    def solver(core, progress, **options):
        return cluster.call(_program, scene, options, progress)

    def attempt(settings=None, deadline=None):
        options = _checked(scene, given | (settings or {}))
        solution, say = attempt_by(solver, scene, options, threads, progress, deadline=deadline)
        if solution.cut is None:  # of all pairs, every surfel of the scene is a node
            solution.cut = solution.parents
        return solution, say

    if error is not None or seconds is not None:
        count = sum(len(s) for s in scene.objects)
        ladder = _ladder(count, max_surfels is None and check.flag("insert", insert))
        defaults = {"zeta": 0.02, "rays": 256, "probes": 16, "shadow_rays": 64}
        error, seconds = check_asked(error, seconds, given, defaults)
        with_areas(scene, threads, progress)
        return solve_asked(ladder, attempt, error, seconds)
    solution, say = attempt()
    say()
    return solution


def _program(core, options, team, progress):
    """What each process of a cluster runs."""
    return _core.solve(core, **options, team=team, progress=progress)


def _checked(scene, given):
    """Options as the core takes them."""
    count = sum(len(s) for s in scene.objects)
    options = {
        "transport": check.choice("transport", given["transport"], TRANSPORTS),
        "zeta": check.number("zeta", given["zeta"], 0.0, low_open=True),
        "insert": check.flag("insert", given["insert"]),
        "max_surfels": most_surfels(given["max_surfels"], given["insert"], count),
        "tolerance": check.number("tolerance", given["tolerance"], 0.0, 1.0, low_open=True, high_open=True),
        "rays": check.count("rays", given["rays"], 16, 65535),
        **shadow_options(given["probes"], given["shadow_rays"]),
        "epsilon": check.number("epsilon", given["epsilon"], 0.0, 1.0, low_open=True, high_open=True),
        "max_memory": 0.0,
        "seed": check.seed("seed", given["seed"]),
        "tuning": tuning(),
    }
    if given["max_memory"] is not None:
        options["max_memory"] = check.number("max_memory", given["max_memory"], 0.0, low_open=True)
    if options["transport"] == "pairs" or (options["transport"] == "auto" and count <= _core.PAIRS_UP_TO):
        _core.require_memory_for_pairs(count, options["max_memory"])
    return options


def _ladder(count, grows):
    """Settings for a scene of `count` surfels; grows: whether as many may be inserted as finer settings ask for.

    Rays of nodes and of lights go together, and zeta with their standard error.
    """

    def settings(rung):
        rays = min(65535, round(64 * 4.0 ** (_RAYS_BY_RUNG * rung)))
        chosen = {"zeta": 0.08 * 0.5**rung, "rays": rays, "probes": max(1, rays // 4), "shadow_rays": rays}
        if grows:
            chosen["max_surfels"] = count + round(min(count, 50000) * 2.0 ** max(0.0, rung - 2.0))
        return chosen

    return Ladder(settings, top=_TOP)
