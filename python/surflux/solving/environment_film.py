"""Films of an environment that turns: each frame is relit and drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.types import FilePath, Progress, Size
from surflux.pictures.camera import Camera
from surflux.scenes.lights import Environment
from surflux.solving.distant_transfer import DistantTransfer
from surflux.solving.relit_film import write_relit
from surflux.solving.turning_light import WAVES, TurningLight


def animate_environment(
    transfer: DistantTransfer,
    environment: Environment | ArrayLike,
    path: FilePath,
    size: Size = (800, 600),
    *,
    frames: int = 120,
    turns: float = 1.0,
    axis: ArrayLike | None = None,
    camera: Camera | None = None,
    reflectance: ArrayLike | None = None,
    specular: ArrayLike | None = None,
    exponent: ArrayLike | None = None,
    bounces: int | None = None,
    fps: float = 25,
    exposure: float | Literal["auto"] | None = None,
    stops: float = 0.0,
    filmic: bool = True,
    progress: Progress = False,
    **options: Any,
) -> list[Path]:
    """Pictures of a scene under an environment that turns, as a film or as numbered pictures.

    The camera stands still, the first frame has the environment as it is, and the last is a step before it comes round,
    so that a film may run in a circle. Each frame is drawn as `transfer.relight(environment, rotation=...)` is, with
    glossy surfels as the camera sees them. OpenGL draws the first alone: how much of which surfels each pixel shows is
    kept. `render` does not blend surfels that are dark with lit ones; here that is said of those that no environment
    lights.

    Args:
        transfer: DistantTransfer, as precompute_transfer finds it.
        environment: see DistantTransfer.relight.
        path, size, fps, exposure, stops, filmic, progress: see Solution.animate.
        frames: how many.
        turns: how often around; below 0 clockwise, seen from the tip of the axis.
        axis: (3,), the direction to turn around; None for what is up in an Environment, of harmonics for z.
        camera: Camera; None for the scene's own, or one that has all surfels in view.
        reflectance, specular, exponent, bounces: see DistantTransfer.relight.
        options: all else goes to Solution.render.

    Returns:
        list of the Paths written: of one film, or of all pictures.

    Raises:
        ValueError: an argument, by name.
        ImportError: a film, and the extra `video` is not there.
        FileError: what cannot be written, by path.
        DeviceError: there is no OpenGL; says what was tried.
        Cancelled: the callback returned False; a film is not written then.

    >>> import surflux as sf
    >>> ball = sf.Surfels.from_mesh(([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, 0, 1]], [[0, 1, 3], [1, 2, 3]]), 0.1)
    >>> transfer = sf.precompute_transfer(sf.Scene([ball]), "distant")
    >>> sky = sf.Environment([[[3.0, 2, 1], [1, 1, 1], [0, 0, 0], [1, 1, 1]]])
    >>> [path.name for path in sf.animate_environment(transfer, sky, "sky%02d.png", (40, 30), frames=2)]
    ['sky01.png', 'sky02.png']
    """
    given = {"reflectance": reflectance, "bounces": bounces}
    light = TurningLight(transfer, environment, axis, specular=specular, exponent=exponent, **given)
    frames = check.count("frames", frames)
    turns = check.number("turns", turns, -1e6, 1e6)
    # Waves are found by as many relightings as there are of them.
    relit = light.diffuse if frames > WAVES and not light.glossy else light.relight
    tone = {"exposure": exposure, "stops": stops, "filmic": filmic}
    return write_relit(
        lambda k: relit(360.0 * turns * k / frames),
        frames,
        path,
        size,
        scene=transfer.scene,
        dark=(transfer.relight(Environment(1.0).harmonics(1), **given).radiosity == 0).all(axis=1),
        camera=camera,
        fps=fps,
        progress=progress,
        **tone,
        **options,
    )
