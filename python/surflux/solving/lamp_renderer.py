"""Pictures under lamps that move: direct light at every pixel (Lehtinen and others 2007, section 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter
from typing import Any, Literal, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.passes import progress_callback, thread_limit
from surflux._base.types import Image, Progress, Size
from surflux.pictures.camera import Camera
from surflux.pictures.framing import own_or_framing
from surflux.points.surfels import Surfels
from surflux.scenes.lights import Environment, Light
from surflux.solutions.background import add_background, environments_behind
from surflux.solutions.rendering import LAYERS, layer_names, picture_size
from surflux.solutions.seen_colors import SeenColors
from surflux.solving.local_transfer import LocalTransfer

FRAME_LAYERS = tuple(name for name in LAYERS if name != "level")
_FOUND = ("radiance", "direct", "indirect", "alpha")  # anew for each frame


class Options(TypedDict, total=False):
    """What LampRenderer.frame takes by name, whatever it returns."""

    background: ArrayLike | Environment
    reflectance: ArrayLike | None
    bounces: int | None
    shadow_rays: int
    penumbra_rays: int
    seed: int
    threads: int | None


class LampRenderer:
    """Draws a scene under lamps that move, frame by frame: what does not depend on lamps is found once and kept.

    Indirect light is that of `transfer.indirect`, flattened (L07 section 6.2): interpolated over patches between their
    corners, where the values of patches that make one surface are averaged; disks blend as splats. Direct light is
    found at every pixel, in closed form times what shadow rays see of the lamp, so that shadows are sharp. One ray
    speaks for the pixels of a cell on a smooth surface, and where its neighbours contradict it all pixels around are
    asked, until shadows are closed; pixels at which surfaces meet always are. So a shadow is missed only where it is
    smaller than a cell and lies within a surface: in Sponza .9 in 10 000 pixels, .2 % of the picture (RMS).

    Args:
        transfer: LocalTransfer, as precompute_transfer finds it.
        camera: Camera; None for the scene's own, or one that has all surfels in view.
        size: (width, height) in pixels.
        samples: pictures are drawn this many times finer each way and averaged; 1 to 8.
        culling: False shows surfaces from behind, too, in the light of their fronts.
        shadow_cell: side of a cell in pixels (subpixels, with `samples`), 1 to 64; 1 has a ray for every pixel.
        threads, progress: see solve.

    Attributes:
        transfer, samples, culling, shadow_cell: as handed in.
        camera, size: Camera that looks, and pixels of frames; can be set, and the next frame makes anew what depends on
            them.
        timings: dict of seconds that it took to get ready: "corners" of patches once, and for the camera what its
            pixels see ("places"), "field" and "cells".
        frame_timings: dict of seconds of the last frame: "relight" for indirect light everywhere, "direct", "picture".
        frame_rays: shadow rays of the last frame, beside those of indirect light.

    Raises:
        ValueError: an argument, by name.
        DeviceError: there are disks, which OpenGL draws, and no OpenGL; says what was tried.
        Cancelled: the callback returned False.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.01)]))
    >>> renderer = sf.LampRenderer(transfer, sf.Camera([2, -1, 2], [0.3, 0.5, 0.3]), (80, 60))
    >>> for x in (0.4, 0.6):
    ...     picture = renderer.frame(sf.PointLight([x, 0.5, 0.5], 1.0))
    ...     print(picture.shape, picture.dtype, f"{picture.max():.1f}")
    (60, 80, 3) float32 1.0
    (60, 80, 3) float32 0.7
    """

    def __init__(
        self,
        transfer: LocalTransfer,
        camera: Camera | None = None,
        size: Size = (800, 600),
        *,
        samples: int = 1,
        culling: bool = True,
        shadow_cell: int = 4,
        threads: int | None = None,
        progress: Progress = False,
    ) -> None:
        if not isinstance(transfer, LocalTransfer):
            raise ValueError(f"transfer: wanted a LocalTransfer, got {type(transfer).__name__}")
        self.transfer, self.size = transfer, size
        self.samples = check.count("samples", samples, 1, 8)
        self.culling = check.flag("culling", culling)
        self.shadow_cell = check.count("shadow_cell", shadow_cell, 1, 64)
        self.frame_timings: dict[str, float] = {}
        self.frame_rays = 0
        scene = transfer.scene
        self.camera = own_or_framing(scene.camera, scene.surfels, self.size) if camera is None else camera
        with thread_limit(threads), progress_callback(progress, "corners") as callback:
            start = perf_counter()
            self._corners = _core.PatchCorners(transfer._core, callback)
            self._corners_in = perf_counter() - start
            self._look()

    @property
    def camera(self) -> Camera:
        """The Camera that looks; can be set, and the next frame makes anew what depends on it."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera):
            raise ValueError(f"camera: wanted a Camera, got {type(camera).__name__}")
        self._camera, self._view = camera, None

    @property
    def size(self) -> Size:
        """(width, height) of frames in pixels; can be set, and the next frame makes anew what depends on it."""
        return self._size

    @size.setter
    def size(self, size: Size) -> None:
        self._size, self._view = picture_size(size), None

    @property
    def timings(self) -> dict[str, float]:
        """Seconds that it took to get ready, by stage: "corners" once, the others for the camera."""
        return {"corners": self._corners_in, **self._look().timings}

    @property
    def nbytes(self) -> int:
        """Bytes that are kept for the camera."""
        return self._look().bytes

    @overload
    def frame(
        self, lights: Light | Sequence[Light], *, layers: Literal[False] = False, **options: Unpack[Options]
    ) -> Image: ...
    @overload
    def frame(
        self,
        lights: Light | Sequence[Light],
        *,
        layers: Literal[True] | list[str] | tuple[str, ...],
        **options: Unpack[Options],
    ) -> dict[str, NDArray[Any]]: ...
    def frame(
        self,
        lights: Light | Sequence[Light],
        *,
        layers: bool | list[str] | tuple[str, ...] = False,
        background: ArrayLike | Environment = 0.0,
        reflectance: ArrayLike | None = None,
        bounces: int | None = None,
        shadow_rays: int = 16384,
        penumbra_rays: int = 16,
        seed: int = 0,
        threads: int | None = None,
    ) -> Any:
        """The picture under these lights: the same bits for any number of threads, whatever was drawn before.

        Args:
            lights: one or a list of PointLight, SpotLight, PhotometricLight, AreaLight and DirectionalLight. Area
                lights are seen as they shine.
            layers: True for a dict of all that is known about each pixel, or a list of some of the names: "radiance",
                "direct" and "indirect" (h, w, 3), "albedo", "alpha", "normal", "depth" and "index", as Solution.render
                has them. The albedo of a patch is its own, or its texture's, and does not blend. Where `reflectance` is
                given, that takes the place of textures, too.
            background: radiance where nothing is, scalar or RGB, or an Environment. True, which is those of the lights,
                is black here, for there is none among these.
            reflectance, bounces, shadow_rays, seed: see LocalTransfer.relight, which warns of lamps in bodies and of
                light on backs of surfels; this does not.
            penumbra_rays: of a pixel that sees an area light in part, stratified over it.
            threads: at most this many; None for all.

        Returns:
            (h, w, 3) float32, linear radiance, row 0 on top; or the dict.

        Raises:
            ValueError: an argument, by name.
            DeviceError: the camera has moved, there are disks, which OpenGL draws, and no OpenGL.
        """
        names = layer_names(layers, FRAME_LAYERS)
        self.transfer._scene_core()  # refuses areas that were set since
        given = self.transfer._given(lights, reflectance, bounces, shadow_rays, seed)
        behind = environments_behind(background, ())
        penumbra_rays = check.count("penumbra_rays", penumbra_rays, 1, 4096)
        with thread_limit(threads):
            view = self._look()
            parts = not {"direct", "indirect"}.isdisjoint(names)
            core_lights, reflectance, bounces, shadow_rays, seed = given
            found = view.frame(core_lights, reflectance, bounces, shadow_rays, penumbra_rays, parts, seed)
            self.frame_timings, self.frame_rays = found["timings"], found["shadow_rays"]
            if not set(names) <= set(_FOUND):
                found |= view.surfaces(core_lights, reflectance)
            found = add_background(found, behind, self._camera, self.samples)
        return found["radiance"] if layers is False else {name: found[name] for name in names}

    def _paint(self, view):
        """Puts in what subpixels see of textures."""
        core = self.transfer._scene_core()
        surfels = Surfels._from_core(core.surfels)
        colors = SeenColors(self.transfer.scene, surfels, core.object, np.arange(len(surfels)))
        if colors.textured.any():
            seen = view.seen()
            index = seen["index"]
            painted = (index >= 0) & colors.textured[index]
            rows = self.samples * self.size[1]
            view.paint(painted, *colors.at(seen, seen["position"], self._camera, rows))

    def _look(self):
        """What is kept for the camera, found anew where that has moved."""
        if self._view is None:
            camera = self._camera
            self._view = _core.LampView(
                self.transfer._core,
                self._corners,
                camera._to_core(),
                *self.size,
                self.samples,
                self.culling,
                self.shadow_cell,
            )
            self._paint(self._view)
        return self._view
