"""precompute_transfer: light transport found once, for lights that then change."""

from __future__ import annotations

from time import perf_counter
from typing import Any, Literal, overload

from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.types import FilePath, Progress
from surflux._base.warn import warn
from surflux.cluster.engines import shared_out
from surflux.geometry.areas import area_of
from surflux.geometry.gloss import warn_of_gloss
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.scene import Scene
from surflux.scenes.sky_patches import SkyPatches, patch_count
from surflux.solving.distant_transfer import DistantTransfer
from surflux.solving.local_transfer import LocalTransfer
from surflux.solving.run import check_scene
from surflux.solving.sky_transfer import SkyTransfer
from surflux.solving.transfer import LARGEST, Transfer

SAMPLES = 4  # of the unoccluded light of each group of senders
EPSILON = {"local": 0.2, "distant": 0.15, "sky": 0.1}
RAYS = {"local": 128, "distant": 256, "sky": 256}
KINDS = {"local": LocalTransfer, "distant": DistantTransfer, "sky": SkyTransfer}
MOST_SENDERS = 2**23  # links hold 24 bits of a node of a binary tree
VISIBILITY_RAYS = 1024  # of each receiver


@overload
def precompute_transfer(
    scene: Scene,
    lighting: Literal["local"] = "local",
    *,
    bounces: int | None = None,
    epsilon_t: float | None = None,
    levels: int = 6,
    radius: float | None = None,
    rays: int | None = None,
    senders: int = 65536,
    region: ArrayLike | None = None,
    max_memory: float | None = None,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> LocalTransfer: ...
@overload
def precompute_transfer(
    scene: Scene,
    lighting: Literal["distant"],
    *,
    bounces: int | None = None,
    epsilon_t: float | None = None,
    levels: int = 6,
    radius: float | None = None,
    rays: int | None = None,
    senders: int = 65536,
    max_memory: float | None = None,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> DistantTransfer: ...
@overload
def precompute_transfer(
    scene: Scene,
    lighting: Literal["sky"],
    *,
    bounces: int | None = None,
    epsilon_t: float | None = None,
    levels: int = 6,
    radius: float | None = None,
    rays: int | None = None,
    senders: int = 65536,
    patches: int | None = None,
    max_memory: float | None = None,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> SkyTransfer: ...
@shared_out
def precompute_transfer(
    scene: Scene,
    lighting: Literal["local", "distant", "sky"] = "local",
    *,
    bounces: int | None = None,
    epsilon_t: float | None = None,
    levels: int = 6,
    radius: float | None = None,
    rays: int | None = None,
    senders: int = 65536,
    patches: int | None = None,
    region: ArrayLike | None = None,
    max_memory: float | None = None,
    seed: int = 0,
    cluster: Any = None,
    checkpoint: FilePath | None = None,
    threads: int | None = None,
    progress: Progress = False,
) -> Transfer:
    """Light transport of a scene, found once, for lights that then move, turn and change (L07 sections 6.4 and 6.5).

    Rays from the points of a multilevel basis link them to groups of surfels, whatever the light. `relight` of the
    result finds the direct light of the groups, and the operator turns what they reflect of it into indirect light
    everywhere, with one product for each bounce. Points are refined where they differ in what a test tells of them.
    Surfels whose own rays contradict the basis have rows of their own, those that are alike one together, and so have
    patches whose middles something covers, as a ball does that stands on a floor.

    "local" is direct-to-indirect transfer: `LocalTransfer.relight` takes lamps. Its test are 512 lamps at random places
    in the air; points keep irradiance and its gradient by the normal.

    "distant" is for an environment by five bands of spherical harmonics: `DistantTransfer.relight` takes it, turned if
    wanted, and surfels may be glossy. Its test is what points see of the sky; points keep that by 169 harmonics.

    "sky" is for skies in patches and a sun that is none of them: `SkyTransfer.relight` takes them, and its
    coefficients, bounces included, a year of patches. Its test is what points receive of distant light, directly and by
    way of one reflection; points keep what each patch brings directly.

    What departs from L07: senders are groups of surfels and no basis functions, so that nothing is interpolated of
    senders; bounces are products at run time, so that reflectance may change, too; visibility stands for transfer
    matrices, which are "times visibility".

    Args:
        scene: Scene; its lights do not matter. Emission is at most 1e30. `Transfer` keeps it.
        lighting: "local", lamps in the scene and around it; "distant"; "sky".
        bounces: how often light is reflected; None for all reflections there are (GMRES, to a residual of 1e-5).
        epsilon_t: what a point may be off by before it is refined; 1.4 times as much on each finer level; positive.
            "local": what it has of the light of a lamp, of the RMS over the scene or, in dim places, of twice what
            is there, in the mean square over the lamps; None for .2. "distant": what it sees of the
            sky, the RMS over the sphere; of twice the RMS over the scene
            where that is less, as in a room with a window; None for .15.
            "sky": what it has of a natural sky, whose harmonics have a power that falls as the square of their band
            (Dror, Willsky and Adelson 2004), of the RMS over the scene; None for .1.
        levels, radius: of the basis, as in `solve_meshless`.
        rays: of a point on the coarsest level, 16 to 65535; half as many on every other finer level, down to 128; None
            for 128 ("local") or 256.
        senders: groups of surfels, at most; the more, the nearer lamps may come to surfaces. Half of them are kept for
            groups to be parted by walls that go through them, as one with surfels on both sides lights both: too few
            (some hundreds of surfels a group) let light through walls. 1 to 8 388 608.
        region: where lamps will be, the least and the greatest corner of a box (2, 3): points are refined for those
            alone ("local"). None for anywhere in the air, hollow walls, too.
        patches: of the sky ("sky"): 145, 577, 1297, 2305, ... (see SkyPatches); None for 145.
        max_memory: bytes for the operator and for finding it, beside the scene, as far as they can be told before (to
            a quarter); None for three quarters of the machine's memory, or of what is left of a lower limit
            (container, batch queue, ulimit -v). Levels, and rows of surfels, that do not fit are left out, with a
            warning; see `Transfer.left_out`.
        seed, cluster, checkpoint, threads, progress: see `solve`.

    Returns:
        LocalTransfer, DistantTransfer or SkyTransfer.

    Raises:
        ValueError: an argument out of range, by name; areas that are 0 of all surfels; a first level that does not fit
            max_memory; a process of the cluster with other scenes, options, versions or instruction sets.
        DeviceError: another process of the cluster has failed.
        FileError: the checkpoint is damaged, or of another call.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
    >>> near, far = (transfer.indirect(sf.PointLight([x, 0.5, 0.5], 1.0)).mean() for x in (0.2, 0.8))
    >>> bool(near > far)
    True
    """
    check_scene(scene)
    for of in scene.objects:
        check.in_range("scene: emission", of.emission, high=LARGEST)
    check.choice("lighting", lighting, tuple(EPSILON))
    if patches is not None and lighting != "sky":
        raise ValueError(f"patches: is for lighting 'sky', not {lighting!r}")
    bounces = None if bounces is None else check.count("bounces", bounces, 0)
    epsilon_t = EPSILON[lighting] if epsilon_t is None else epsilon_t
    if region is not None:
        if lighting != "local":
            raise ValueError(f"region: is for lighting 'local', not {lighting!r}")
        region = check.positions("region", region, (2, 3))
        if not (region[0] < region[1]).all():
            raise ValueError(f"region: wanted the least and the greatest corner of a box, got {region.tolist()}")
    options = {
        "lighting": lighting,
        "patches": 145 if patches is None else patch_count("patches", patches),
        "levels": check.count("levels", levels, 1, 10),
        "radius": 0.0 if radius is None else check.number("radius", radius, 0.0, low_open=True),
        "epsilon": check.number("epsilon_t", epsilon_t, 0.0, low_open=True),
        "rays": RAYS[lighting] if rays is None else check.count("rays", rays, 16, 65535),
        "senders": check.count("senders", senders, 1, MOST_SENDERS),
        "samples": SAMPLES,
        "region": region,
        "max_memory": 0.0 if max_memory is None else check.number("max_memory", max_memory, 0.0, low_open=True),
        "seed": check.seed("seed", seed),
    }
    with thread_limit(threads):
        start = perf_counter()
        compiled = scene._to_core(progress=progress)
        area_of(compiled.surfels.areas)  # without any there are no senders, and no receivers
        seconds = perf_counter() - start
        with stage_callback(progress) as callback:
            core = cluster.call(_program, scene, options, callback)
    warn_of_layers(scene)
    if lighting != "distant":
        warn_of_gloss(compiled.surfels)
    kind = KINDS[lighting]
    if isinstance(core, tuple):
        core = getattr(_core, kind.__name__).of_arrays(compiled, *core)
    if core.left_out:
        left_out = check.counted(core.left_out, "place")
        warn(f"max_memory kept {left_out} from being refined: light is coarser there; more memory or epsilon_t help")
    return kind(core, scene, bounces, {"areas": seconds, **core.timings})


def _program(core, options, team, progress):
    """What each process of a cluster runs."""
    lighting, patches = options["lighting"], options["patches"]
    rest = {name: value for name, value in options.items() if name not in ("lighting", "patches")}
    given = core, _core.OperatorOptions(**rest, team=team)
    if lighting == "local":
        found = _core.LocalTransfer(*given, progress)
    elif lighting == "distant":
        found = _core.DistantTransfer(*given, VISIBILITY_RAYS, progress)
    else:
        found = _core.SkyTransfer(*given, SkyPatches(patches)._core, progress)
    # Of one process it goes to another, which has a compiled scene of its own.
    return found if team is None else (found.arrays(), list(found.timings.items()))
