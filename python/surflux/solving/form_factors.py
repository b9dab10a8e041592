"""Form factors between all pairs of surfels."""

from __future__ import annotations

from typing import Literal, TypedDict, Unpack, overload

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.types import Floats, Progress
from surflux._base.warn import warn
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.scene import Scene
from surflux.solving.run import check_scene, tuning


class _Options(TypedDict, total=False):
    error: float
    rays: int
    epsilon: float
    seed: int
    threads: int | None
    progress: Progress


@overload
def form_factors(
    scene: Scene, visibility: bool = True, *, return_escape: Literal[False] = False, **options: Unpack[_Options]
) -> Floats: ...
@overload
def form_factors(
    scene: Scene, visibility: bool = True, *, return_escape: Literal[True], **options: Unpack[_Options]
) -> tuple[Floats, Floats]: ...
def form_factors(
    scene: Scene,
    visibility: bool = True,
    *,
    error: float = 0.001,
    rays: int = 1024,
    epsilon: float = 0.8,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
    return_escape: bool = False,
) -> Floats | tuple[Floats, Floats]:
    """Form factors between all surfels of a scene.

    F[i, j] is the fraction of what surfel i emits that reaches surfel j: A_i F_ij = A_j F_ji to rounding, with areas
    that count once where surfels coincide and face the same way, as those of a solution do. F[i, i] is
    that of a concave piece onto itself. Without what blocks them, factors between patches of meshes are contour
    integrals (Sparrow 1963), precise to 1e-9 of themselves where patches touch and farther off, and to some 3e-6 of
    slivers a hundred times as long as they are far apart; those of disks are good to a few per cent, and better farther
    off but for the rims of clouds, where disks end at the outermost points.

    Pairs that nothing can stand between, which a shaft around both proves, are done with. Of every other pair the
    share that is free is sampled: rays between points of both, more of them until the standard error is half of what
    `error` allows, so that the factor is within that with 95 % probability. Pairs whose rays are all free or all
    blocked get so many that a larger share would have been noticed, with 95 % probability too.

    With visibility, each row plus what escapes plus what back faces absorb is 1. A patch all of whose pairs are proved
    free loses what its row lacks. Of others, rays over the hemisphere of each surfel tell what escapes, and where a row
    contradicts them, by more than three standard errors or because nothing escapes, the symmetric diagonal scaling that
    `solve` uses mends it.

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
        UserWarning: patches on which walls of other objects stand: each has one row for both sides. Pairs of patches
            that a million rays did not bring to `error`, and how many.

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
    check.flag("visibility", visibility)
    check.flag("return_escape", return_escape)
    if return_escape and not visibility:
        raise ValueError("return_escape: wanted visibility=True with it, for what escapes is found by rays")
    options = {
        "error": check.number("error", error, 1e-6, 1.0),
        "rays": check.count("rays", rays, 16),
        "epsilon": check.number("epsilon", epsilon, 0.0, 1.0, low_open=True, high_open=True),
        "seed": check.seed("seed", seed),
        "tuning": tuning(),
    }
    with thread_limit(threads):
        core = scene._to_core(progress=progress)
        warn_of_layers(scene)
        with stage_callback(progress) as callback:
            factors, escape, imprecise, _ = _core.form_factors(core, visibility, **options, progress=callback)
    if imprecise:
        pairs = check.counted(imprecise, "partly blocked pair")
        warn(f"{pairs} did not come to the error of {options['error']:g} with the most rays")
    return (factors, escape) if return_escape else factors
