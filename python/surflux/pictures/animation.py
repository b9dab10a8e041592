"""Turntables and camera paths, to films or numbered pictures."""

from __future__ import annotations

import re
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.files import file_error, require_place, unfinished
from surflux._base.passes import progress_callback, report
from surflux.geometry.rotation import rotation_about
from surflux.pictures.camera import Camera
from surflux.pictures.gif import GifWriter
from surflux.pictures.images import checked_tone, resolved_exposure, tone_map, write_image

FILMS = (".mp4", ".gif")
FPS = 0.01, 1000.0  # from and to; GIF has no frame that lasts longer than 655 s
PICTURES = (".png", ".exr", ".hdr")
NUMBER = re.compile(r"%0?\d*d")


def turntable(
    camera: Camera, frames: int, *, turns: float = 1.0, axis: ArrayLike | None = None, center: ArrayLike | None = None
) -> list[Camera]:
    """Cameras once around what a camera looks at, in even steps: the last is a step before the first.

    Args:
        camera: Camera, the first one.
        frames: how many.
        turns: how often around; below 0 the other way round. From above, the camera goes against the clock.
        axis: (3,), the direction to turn around; None for the camera's up.
        center: (3,), a point of the axis; None for the camera's target.

    Returns:
        list of Camera.

    Raises:
        ValueError: an argument, by name.

    >>> import surflux as sf
    >>> cameras = sf.turntable(sf.Camera([0, -2, 1], [0, 0, 0]), 4)
    >>> [(camera.eye.round(6) + 0.0).tolist() for camera in cameras]
    [[0.0, -2.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0], [-2.0, 0.0, 1.0]]
    """
    _check_camera("camera", camera)
    frames = check.count("frames", frames)
    turns = check.number("turns", turns, -1e6, 1e6)
    axis = camera.up if axis is None else check.vector3("axis", axis)
    center = camera.target if center is None else check.vector3("center", center)
    if not np.linalg.norm(axis) > 0.0:
        raise ValueError("axis: wanted a direction, got zero")
    out = []
    for k in range(frames):
        turn = rotation_about(axis, 2.0 * np.pi * turns * k / frames)
        eye, target = (center + turn @ (point - center) for point in (camera.eye, camera.target))
        out.append(Camera(eye, target, turn @ camera.up, camera.fov, height=camera.height))
    return out


def camera_path(cameras: list[Camera] | tuple[Camera, ...], frames: int, *, closed: bool = False) -> list[Camera]:
    """Cameras on a smooth way through some given ones (Catmull and Rom 1974), at an even pace between each two.

    Eye, target, up and field of view, or height, each go through those of the given cameras.

    Args:
        cameras: list of at least two Camera.
        frames: how many there are to be in all, at least 2.
        closed: True returns to the first camera, and stops a step before it.

    Returns:
        list of Camera.

    Raises:
        ValueError: an argument, by name; a way on which a camera comes to look nowhere.

    >>> import surflux as sf
    >>> ends = [sf.Camera([0, -4, 1], [0, 0, 0]), sf.Camera([0, -2, 1], [0, 0, 0])]
    >>> [float(camera.eye[1]) for camera in sf.camera_path(ends, 3)]
    [-4.0, -3.0, -2.0]
    """
    if not isinstance(cameras, (list, tuple)) or len(cameras) < 2:
        raise ValueError("cameras: wanted a list of at least two")
    for camera in cameras:
        _check_camera("cameras", camera)
    orthographic = cameras[0].height is not None
    if any((camera.height is not None) != orthographic for camera in cameras):
        raise ValueError("cameras: wanted pinhole cameras or orthographic ones, got both")
    frames = check.count("frames", frames, 2)
    check.flag("closed", closed)
    knots = np.array([[*c.eye, *c.target, *(c.up / np.linalg.norm(c.up)), c.fov, c.height or 0.0] for c in cameras])
    count = len(knots)
    if closed:
        at = np.arange(frames) * (count / frames)
        before, here, there, after = (knots[(at.astype(int) + k) % count] for k in (-1, 0, 1, 2))
    else:
        at = np.linspace(0.0, count - 1.0, frames)
        longer = np.concatenate([2 * knots[:1] - knots[1:2], knots, 2 * knots[-1:] - knots[-2:-1]])
        first = np.minimum(at.astype(int), count - 2)
        before, here, there, after = (longer[first + k] for k in range(4))
        at = at - first
    t = (at - np.floor(at) if closed else at)[:, None]
    way = here + 0.5 * t * (
        there - before + t * (2 * before - 5 * here + 4 * there - after + t * (3 * (here - there) + after - before))
    )
    try:
        heights = way[:, 10] if orthographic else [None] * frames
        return [Camera(w[:3], w[3:6], w[6:9], w[9], height=h) for w, h in zip(way, heights, strict=True)]
    except ValueError as error:
        raise ValueError(f"cameras: on the way between them one looks nowhere ({error})") from None


def animate(solution, cameras, path, size, **options):
    """What Solution.animate does."""
    if not isinstance(cameras, (list, tuple)) or not cameras:
        raise ValueError("cameras: wanted a list of at least one Camera")
    for camera in cameras:
        _check_camera("cameras", camera)

    def drawn(k, **settings):
        return solution.render(cameras[k], size, **settings)

    return write_frames(drawn, len(cameras), path, size, **options)


def write_frames(drawn, count, path, size, *, fps, exposure, stops, filmic, progress, layers=False, **options):
    """Writes frames as a film or as numbered pictures.

    Args:
        drawn: function (k, layers=names, **options) of a frame, from 0 on: a dict of its layers.
        count: of frames, at least 1.
        path, size, fps, exposure, stops, filmic, layers, progress: see Solution.animate.

    Returns:
        list of the Paths written.
    """
    fps = check.number("fps", fps, *FPS)
    name = check_target(path)
    suffix = Path(name).suffix.lower()
    exposure, stops = check_series(suffix, size, exposure, stops, filmic)
    if layers is not False and suffix != ".exr":
        raise ValueError(f"layers: a {suffix} file has none; .exr has")
    wanted = ["radiance", *layers] if isinstance(layers, (list, tuple)) else layers or ["radiance"]
    written, shown = [], None  # the factor on radiance is that of the first frame
    with progress_callback(progress, "frames") as callback, ExitStack() as stack:
        add = stack.enter_context(_film(name, fps)) if suffix in FILMS else None
        for k in range(count):
            report(callback, k, count)
            found = drawn(k, layers=wanted, **options)
            image = found.pop("radiance")
            if suffix in (".png", *FILMS) and shown is None:
                shown = resolved_exposure(exposure, image, stops)
            if add is not None:
                add(np.rint(255.0 * tone_map(image, exposure=shown, filmic=filmic)).astype(np.uint8))
                continue
            more = {"exposure": shown, "filmic": filmic} if suffix == ".png" else found
            written.append(write_image(name % (k + 1), image, **more))
        if callback is not None:
            callback(count, count)
    return written or [Path(name)]


def check_series(suffix, size, exposure, stops, filmic):
    """(factor or None, stops) for a film or numbered pictures with this suffix; refuses a size that it cannot have."""
    if suffix == ".mp4" and isinstance(size, (tuple, list)) and any(side % 2 for side in size):
        raise ValueError(f"size: .mp4 takes even numbers alone, got {tuple(size)}")
    return checked_tone(suffix, exposure, stops, filmic)


def check_target(path, argument="path"):
    """path as a str, if frames can be written there."""
    name = check.path(argument, path)
    suffix = Path(name).suffix.lower()
    if suffix in FILMS:
        _imageio(suffix)
    elif suffix not in PICTURES:
        raise ValueError(f"{argument}: wanted a name ending in {', '.join((*FILMS, *PICTURES))}, got {name!r}")
    elif len(NUMBER.findall(name)) != 1 or name.count("%") != 1:
        raise ValueError(f"{argument}: wanted a pattern for numbered pictures, such as 'frames/%04d.png', got {name!r}")
    require_place(name)
    return name


@contextmanager
def _film(path, fps):
    """What takes frames one by one into a file, which appears whole at the end, or not at all."""
    suffix = Path(path).suffix.lower()
    imageio = _imageio(suffix)

    def refused(error):
        return file_error(path, f"cannot be written: {error}")

    with unfinished(path) as beside:
        try:
            if suffix == ".gif":
                writer = GifWriter(beside, fps)
            else:
                writer = imageio.get_writer(beside, mode="I", fps=fps, **MP4)
        except (OSError, RuntimeError) as error:
            raise refused(error) from error

        def add(frame):
            try:
                writer.append_data(frame)
            except (OSError, RuntimeError) as error:
                raise refused(error) from error

        try:
            yield add
        except BaseException:
            with suppress(OSError, RuntimeError):
                writer.close()
            raise
        try:
            writer.close()
        except (OSError, RuntimeError) as error:
            raise refused(error) from error


# What every player shows: H.264 with colours at half the resolution, converted by BT.709, as the file says. Otherwise
# ffmpeg takes BT.601 and says nothing, which browsers take for BT.709.
_BT709 = "color_primaries=bt709:color_trc=iec61966-2-1:colorspace=bt709:range=tv"
MP4 = {
    "codec": "libx264",
    "pixelformat": "yuv420p",
    "quality": 8,
    "macro_block_size": 2,
    "ffmpeg_log_level": "error",
    "output_params": ["-vf", f"scale=out_color_matrix=bt709:out_range=tv,setparams={_BT709}"],
}


def _imageio(suffix):
    """The module imageio.v2, with what the suffix needs."""
    try:
        import imageio.v2 as imageio

        if suffix == ".mp4":
            import imageio_ffmpeg  # noqa: F401
    except ImportError as error:
        raise ImportError(
            f"{suffix} files need `pip install 'surflux[video]'` ({error}); numbered pictures do not"
        ) from error
    return imageio


def _check_camera(name, camera):
    if not isinstance(camera, Camera):
        raise ValueError(f"{name}: wanted Cameras, got {type(camera).__name__}")
