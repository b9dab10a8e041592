"""Solving a scene: radiosity per surfel, and form factors."""

import warnings

from surflux import _check, _core
from surflux._passes import stage_callback, thread_limit
from surflux._solving import check_scene, solution_by
from surflux.solve_options import TRANSPORTS, most_surfels, shadow_options


def solve(
    scene,
    *,
    zeta=0.02,
    insert=True,
    tolerance=1e-4,
    max_surfels=None,
    transport="auto",
    rays=256,
    probes=16,
    shadow_rays=64,
    epsilon=0.8,
    max_memory=None,
    seed=0,
    threads=None,
    progress=False,
):
    """Radiosity of a scene, with shadows and all interreflection (D04 section 7).

    Solves B = E + rho H, H = D + F B (D04 eq. 1, with the unknown as D03 section 3 has it) for red, green and blue, or
    once where the scene is grey. The scene stays as it is; areas that it lacks are computed.

    There are two ways to find how light is exchanged. With `transport="rays"` nodes of the hierarchy of surfels (D04
    section 6) gather light by rays, once and for all, from whatever surfel or group of surfels each ray's cone covers.
    Nodes give way to their members where interpolation between them would be off by more than `zeta` (global
    refinement, D04 7.1); the linear system is solved by GMRES, again from where it stood. Direct light is computed at
    every surfel. Seconds and memory grow about in proportion to the surfels; the noise of the rays, 1 or 2 % of the
    indirect light with 256, stays. With `transport="pairs"` all pairs of surfels exchange light by form factors that
    are symmetric and closed: each row, with what rays find to leave the scene or to end on a back face, makes 1.
    Precise to .1 % in smooth scenes; memory grows as 4 n^2 bytes, seconds as n^2. "auto" takes pairs up to 2000
    surfels and rays beyond.

    With `insert`, a surfel beside which the field is not what its slope says, by more than zeta, gives way to four
    (D04 7.2), at the borders of shadows above all; they in turn, down to a sixteenth of the radius of surfels (RMS by
    area). Of polygons they take the part that is nearest to each. Their areas add up to that of the surfel.

    Args:
        scene: Scene.
        zeta: what interpolation may leave, of the area-weighted RMS of H; positive.
        insert: False solves for the scene's own surfels alone.
        tolerance: |residual| / |right-hand side| of the linear system; in (0, 1).
        max_surfels: of the solution; None for twice those of the scene, but not 50 000 more. Where that is not enough,
            what matters most to the RMS goes first; `history` says how many were left out.
        transport: "auto", "pairs" or "rays".
        rays: of a node; with pairs of each surfel, to measure what escapes and what Environments send, four times as
            many where not all meet the same; 16 to 65535.
        probes, shadow_rays: shadow rays from a surfel to a light: as many to begin with, and where more than one
            disagrees.
        epsilon: surfels with n_i . n_j above this that overlap stand for the same surface and may form a group (D04 eq.
            10); in (0, 1).
        max_memory: bytes for the exchange of all pairs; None for three quarters of the machine's memory, or
            of what is left of a lower limit (container, batch queue, ulimit -v).
        seed: of everything random; the result is the same for the same seed, whatever the number of threads.
        threads: at most this many; None for all.
        progress: True for bars on stderr, or a callback (done, total) -> bool, called for one stage after another;
            False cancels.

    Returns:
        Solution.

    Raises:
        ValueError: an argument out of range, by name; more surfels than the memory takes for pairs.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> points = [[x, y, 0.0] for x in range(10) for y in range(10)]
    >>> cloud = sf.Surfels(points, normals=[[0, 0, 1]] * 100, reflectance=0.5)
    >>> solution = sf.solve(sf.Scene([cloud], lights=[sf.Environment(1.0)]))
    >>> bool(abs(solution.irradiance - 3.14159).max() < 1e-4)  # a flat cloud sees the whole sky
    True
    """
    check_scene(scene)
    count = sum(len(s) for s in scene.objects)
    options = {
        "transport": _check.choice("transport", transport, TRANSPORTS),
        "zeta": _check.number("zeta", zeta, 0.0, low_open=True),
        "insert": _check.flag("insert", insert),
        "max_surfels": most_surfels(max_surfels, insert, count),
        "tolerance": _check.number("tolerance", tolerance, 0.0, 1.0, low_open=True, high_open=True),
        "rays": _check.count("rays", rays, 16, 65535),
        **shadow_options(probes, shadow_rays),
        "epsilon": _check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
        "max_memory": 0.0 if max_memory is None else _check.number("max_memory", max_memory, 0.0, low_open=True),
        "seed": _check.seed("seed", seed),
    }
    if transport == "pairs" or (transport == "auto" and count <= _core.PAIRS_UP_TO):
        _core.require_memory_for_pairs(count, options["max_memory"])
    solution = solution_by(_core.solve, scene, options, threads, progress)
    if solution.cut is None:  # of all pairs, every surfel of the scene is a node
        solution.cut = solution.parents
    return solution


def form_factors(
    scene,
    visibility=True,
    *,
    error=0.001,
    rays=1024,
    epsilon=0.8,
    seed=0,
    threads=None,
    progress=False,
    return_escape=False,
):
    """Form factors between all surfels of a scene.

    F[i, j] is the fraction of what surfel i emits that reaches surfel j: A_i F_ij = A_j F_ji to rounding, with areas
    that count once where surfels coincide and face the same way, as those of a solution do. F[i, i] is
    that of a concave piece onto itself. Without what blocks them, factors between patches of meshes are contour
    integrals (Sparrow 1963), precise to 1e-9 of themselves where patches touch and farther off; those of disks are
    good to a few per cent close by and better farther off.

    Pairs that nothing can stand between, which a shaft around both proves, are done with. Of every other pair the
    share that is free is sampled: rays between points of both, more of them until the standard error is half of what
    `error` allows, so that the factor is within that with 95 % probability. Pairs whose rays are all free or all
    blocked get so many that a larger share would have been noticed, with 95 % probability too.

    With visibility, each row plus what escapes plus what back faces absorb is 1. Rays over the hemisphere of each
    surfel tell what escapes, and where a row contradicts them, by more than three standard errors or because nothing
    escapes, the symmetric diagonal scaling that `solve` uses mends it.

    Args:
        scene: Scene of at most 20 000 surfels.
        visibility: False takes every pair as free, and scales nothing.
        error: 1e-6 to 1, what blocking may be misjudged by: F summed from a surfel to any set of others, over all
            columns or over a wall, is within `error` of its true value; a single factor within error * sqrt(F0), F0
            being the larger of F[i, j] and F[j, i] without what blocks them. Each with 95 % probability, for patches;
            shares of disks are not sampled finer than 5 %. Costs rays in proportion to 1/error or
            more, towards 1e-5 to its square.
        rays, epsilon, seed, threads, progress: see `solve`.
        return_escape: True returns (F, escape), escape (n,) being the share of each row that is not in F: what leaves
            the scene and what ends on back faces. Needs visibility.

    Warns:
        UserWarning: pairs of patches that a million rays did not bring to `error`, and how many.

    Returns:
        (n, n) float64.

    Raises:
        ValueError: an argument out of range, by name; more than 20 000 surfels.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    >>> floor_and_ceiling = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [7, 6, 5, 4]]), patch_area=0.01)
    >>> F = sf.form_factors(sf.Scene([floor_and_ceiling]))
    >>> print(f"{F[:100, 100:].sum() / 100:.3f}")  # opposite faces of a cube: .1998
    0.200
    """
    check_scene(scene)
    count = sum(len(s) for s in scene.objects)
    if count > 20_000:
        raise ValueError(f"scene: wanted at most 20000 surfels for a dense matrix, got {count}")
    _check.flag("visibility", visibility)
    _check.flag("return_escape", return_escape)
    if return_escape and not visibility:
        raise ValueError("return_escape: wanted visibility=True with it, for what escapes is found by rays")
    options = {
        "error": _check.number("error", error, 1e-6, 1.0),
        "rays": _check.count("rays", rays, 16),
        "epsilon": _check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
        "seed": _check.seed("seed", seed),
    }
    with thread_limit(threads):
        core = scene._to_core(progress=progress)
        with stage_callback(progress) as callback:
            factors, escape, imprecise, _ = _core.form_factors(core, visibility, **options, progress=callback)
    if imprecise:
        pairs = _check.counted(imprecise, "partly blocked pair")
        warnings.warn(f"{pairs} did not come to the error of {options['error']:g} with the most rays", stacklevel=2)
    return (factors, escape) if return_escape else factors
