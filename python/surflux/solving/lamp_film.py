"""Films of lamps that move: each frame is relit and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.types import FilePath, Integer, Progress, Size
from surflux._base.warn import FrameWarnings
from surflux.pictures.animation import write_frames
from surflux.pictures.camera import Camera
from surflux.scenes.lights import Light
from surflux.solving.lamp_renderer import LampRenderer
from surflux.solving.light_on_backs import warn_of_lamps_in_bodies
from surflux.solving.local_transfer import LocalTransfer, as_list
from surflux.solving.relit_film import write_relit

_SOME = 16  # frames whose lamps say which surfels are never lit


def animate_lamps(
    transfer: LocalTransfer,
    frames: Sequence[Light | Sequence[Light]],
    path: FilePath,
    size: Size = (800, 600),
    *,
    camera: Camera | None = None,
    reflectance: ArrayLike | None = None,
    bounces: int | None = None,
    seed: Integer = 0,
    direct: Literal["interpolated", "traced"] = "interpolated",
    fps: float = 25,
    exposure: float | Literal["auto"] | None = None,
    stops: float = 0.0,
    filmic: bool = True,
    progress: Progress = False,
    **options: Any,
) -> list[Path]:
    """Pictures of a scene under one set of lamps after another, as a film or as numbered pictures.

    Each frame is drawn as `transfer.relight(lights).render(camera)` is. While no area light moves, OpenGL draws the
    first alone: how much of which surfels each pixel shows is kept, and what other lamps bring is a product with it.
    `render` does not blend surfels that are dark with lit ones; here that is said of those that are dark in 16 frames
    all over the film.
    With direct="traced" frames are those of a LampRenderer: direct light at every pixel, with sharp shadows.

    Args:
        transfer: LocalTransfer, as precompute_transfer finds it.
        frames: list with one or more lights for each frame, such as load_lamps reads.
        path, size, fps, exposure, stops, filmic, progress: see Solution.animate.
        camera: Camera; None for the scene's own, or one that has all surfels in view.
        reflectance, bounces, seed: see LocalTransfer.relight.
        direct: "interpolated" between surfels, or "traced" to every pixel.
        options: all else goes to Solution.render; with "traced" to LampRenderer (`culling`, `shadow_cell`, and
            `samples`, which are 2 unless given) and its frames (`background`, `penumbra_rays`, `threads`).

    Returns:
        list of the Paths written: of one film, or of all pictures.

    Raises:
        ValueError: an argument, by name.
        ImportError: a film, and the extra `video` is not there.
        FileError: what cannot be written, by path.
        DeviceError: there is no OpenGL; says what was tried.
        Cancelled: the callback returned False; a film is not written then.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
    >>> frames = [sf.PointLight([x, 0.5, 0.5], 1.0) for x in (0.3, 0.6)]
    >>> [path.name for path in sf.animate_lamps(transfer, frames, "lamp%02d.png", (40, 30))]
    ['lamp01.png', 'lamp02.png']
    """
    if not isinstance(transfer, LocalTransfer):
        raise ValueError(f"transfer: wanted a LocalTransfer, got {type(transfer).__name__}")
    if not isinstance(frames, (list, tuple)) or not frames:
        raise ValueError("frames: wanted a list with the lights of at least one frame")
    tone = {"exposure": exposure, "stops": stops, "filmic": filmic, "fps": fps, "progress": progress}
    said = FrameWarnings(len(frames))
    if check.choice("direct", direct, ("interpolated", "traced")) == "traced":
        light = {"reflectance": reflectance, "bounces": bounces, "seed": seed}
        written = _write_traced(transfer, frames, path, size, camera, light, said, **tone, **options)
    else:

        def relit(k):
            with said.of(k):
                return transfer.relight(frames[k], reflectance=reflectance, bounces=bounces, seed=seed)

        some = _some_lights(frames)
        given = transfer._given(some, reflectance, bounces, 16384, seed)
        written = write_relit(
            relit,
            len(frames),
            path,
            size,
            scene=transfer.scene,
            dark=(transfer._relit(some, given, 1, 1).radiosity == 0).all(axis=1),
            camera=camera,
            **tone,
            **options,
        )
    said.say()
    return written


def _write_traced(
    transfer,
    frames,
    path,
    size,
    camera,
    light,
    said,
    *,
    samples=2,
    culling=True,
    shadow_cell=4,
    threads=None,
    **options,
):
    """The frames of a LampRenderer, which warns of nothing; light: options of all of them. said: FrameWarnings."""
    look = {"samples": samples, "culling": culling, "shadow_cell": shadow_cell, "threads": threads}
    renderer = LampRenderer(transfer, camera, size, **look)

    def drawn(k, layers, **settings):
        found = renderer.frame(frames[k], layers=layers, threads=threads, **light, **settings)
        with said.of(k):
            warn_of_lamps_in_bodies(as_list(frames[k]), transfer._scene_core())
        return found

    return write_frames(drawn, len(frames), path, size, **options)


def _some_lights(frames):
    """Lamps of frames all over the film, together."""
    chosen = np.unique(np.linspace(0, len(frames) - 1, _SOME).astype(int))
    some = [frames[k] for k in chosen]
    return [light for lights in some for light in as_list(lights)]
