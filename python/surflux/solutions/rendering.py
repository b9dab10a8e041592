"""Pictures of solutions: splats by OpenGL, layer by layer."""

from __future__ import annotations

from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.types import Progress
from surflux._base.warn import warn
from surflux.geometry.cores import replaced
from surflux.pictures.camera import Camera, come_close
from surflux.pictures.framing import own_or_framing
from surflux.scenes.lights import Environment
from surflux.solutions.background import add_background, environments_behind
from surflux.solutions.basis_rendering import basis_layers
from surflux.solutions.blending import blended_groups
from surflux.solutions.fields import BasisField, checked_direct
from surflux.solutions.leaves import inserted_among
from surflux.solutions.seen_colors import SeenColors
from surflux.solutions.subpixels import in_bands
from surflux.solutions.towards import glossy, towards_eye

# Of a picture.
LAYERS = ("radiance", "direct", "indirect", "albedo", "alpha", "normal", "depth", "index", "level")

# Splats reach this many radii: beyond 1, so that every pixel of a disk lies well inside of some splat.
FOOTPRINT = 1.5

# What was inserted is drawn larger by this: disks, and parts of patches.
INSERTED_FOOTPRINT = 1.6
INSERTED_OVERLAP = 1.002


class Walls:
    """Where walls stand between the surfels of solutions that have the same: found for the first picture, and kept."""

    def __init__(self):
        self._found = None

    def between(self, drawn, progress=None):
        """_core.KernelWalls of what drawn_surfels gives of such a solution; progress: of the picture."""
        if self._found is None:
            going = None if progress is None else lambda done, total: progress(0, total)
            self._found = _core.KernelWalls(drawn, FOOTPRINT, going)
        return self._found


class Options(TypedDict, total=False):
    """What Solution.render takes by name, whatever it returns."""

    background: ArrayLike | Environment
    samples: int
    direct: Literal["interpolated", "traced"]
    rays: int
    culling: bool
    threads: int | None
    progress: Progress


def picture_size(size):
    """(width, height) of a picture, checked."""
    if not (isinstance(size, (tuple, list)) and len(size) == 2):
        raise ValueError(f"size: wanted (width, height), got {size!r}")
    return tuple(check.count("size", v, 1, 16384) for v in size)


class View:
    """What a picture is drawn from and how, checked."""

    def __init__(self, solution, camera, size, background, samples, culling, direct="interpolated", rays=64):
        self.size = picture_size(size)
        if camera is None:
            camera = own_or_framing(solution.camera, solution.surfels, size)
        if not isinstance(camera, Camera):
            raise ValueError(f"camera: wanted a Camera or None, got {type(camera).__name__}")
        if camera.height is not None and isinstance(solution._field, BasisField):
            raise ValueError("camera: wanted one without height, for a meshless basis is drawn in perspective alone")
        self.through, self.came = come_close(camera, solution.surfels, solution._lamps)
        self.camera = self.through._to_core()
        self.behind = environments_behind(background, solution._environments)
        self.samples = check.count("samples", samples, 1, 8)
        self.culling = check.flag("culling", culling)
        self.rays = check.count("rays", rays, 1, 1 << 16)
        self.direct = checked_direct(direct, solution._scene)


def layer_names(layers, known=LAYERS):
    """The names of the layers that are asked for: all of them, or some; of none, radiance alone."""
    if isinstance(layers, (list, tuple)):
        for name in layers:
            check.choice("layers", name, known)
        return tuple(layers)
    return known if check.flag("layers", layers) else ("radiance",)


def picture(solution, view, names, progress, groups=None, flat=None):
    """A dict of the layers named; progress: a callback or None. groups, flat: see painting.Painter."""
    surfels = solution.surfels
    drawn = drawn_surfels(solution)
    groups = blended_groups(solution) if groups is None else groups
    colors = SeenColors.of(solution)
    lamps = [(lamp.corner, lamp.edge_u, lamp.edge_v, np.divide(lamp.exitance, np.pi)) for lamp in solution._lamps]

    def splat(layers, size=view.size, samples=view.samples, progress=progress, **rows):
        """Layers (values, are lamps seen?) -> what _core.render_splats gives."""
        if flat is not None:
            return flat(layers)
        rows["walls"] = solution._walls.between(drawn, progress)
        return _core.render_splats(
            drawn, layers, lamps, view.camera, *size, FOOTPRINT, samples, view.culling, groups, progress, **rows
        )

    if isinstance(solution._field, BasisField):
        found = basis_layers(solution._field, surfels, lamps, view, names, splat, progress, colors)
    elif view.direct == "traced" or colors.textured.any():
        found = _by_subpixels(solution, view, splat, progress, colors)
    else:
        found = _splatted(solution, view, names, splat)
    if "level" in names and "level" not in found:
        found["level"] = by_index(found["index"], solution.values()["level"])
    if view.culling and not np.any(found["alpha"]):
        _warn_of_backs_in_view(surfels, view)
    found = add_background(found, view.behind, view.through, view.samples)
    if view.came and "depth" in names:
        found["depth"] = (found["depth"] + view.came).astype(np.float32)
    return {name: found[name] for name in names}


def _warn_of_backs_in_view(surfels, view):
    """Says why a picture is empty, where surfels are in it."""
    column, row, depth = view.through.project(surfels.points, view.size).T
    width, height = view.size
    inside = (depth > 0.0) & (column >= 0.0) & (column < width) & (row >= 0.0) & (row < height)
    towards = towards_eye(surfels.points, view.through)
    if inside.any() and not np.any((towards * surfels.normals).sum(axis=1)[inside] > 0.0):
        warn(
            f"the picture is empty: all of the {np.count_nonzero(inside)} surfels in it show the camera their backs, "
            "which are not drawn (culling=False draws them; Surfels.flipped() or --normals flip turns them)"
        )


def by_index(index, values):
    """The values of the surfels seen, NaN where none is."""
    out = np.full(index.shape, np.nan, np.float32)
    seen = index >= 0
    out[seen] = values[index[seen]]
    return out


def _splatted(solution, view, names, splat):
    gloss = glossy(solution, towards_eye(solution.surfels.points, view.through))
    rho, emission = solution.surfels.reflectance, solution.surfels.emission
    everything = {  # values, and are lamps seen?
        "radiance": (solution.radiosity / np.pi + gloss, True),
        "direct": ((emission + rho * solution.direct) / np.pi, True),
        "indirect": (rho * (solution.irradiance - solution.direct) / np.pi + gloss, False),
        "albedo": (rho, False),
    }
    blended = {name: layer for name, layer in everything.items() if name in names}
    found = splat(list(blended.values()))
    return found | {"alpha": found["coverage"]} | dict(zip(blended, found["layers"], strict=True))


def _by_subpixels(solution, view, splat, progress, colors):
    """All layers but "level", with colours of textures, and direct light by rays if asked, from what subpixels see."""
    surfels, rho = solution.surfels, colors.reflectance
    gloss = np.broadcast_to(glossy(solution, towards_eye(surfels.points, view.through)), rho.shape)
    exitance = colors.emission
    if view.direct == "interpolated":
        exitance = exitance + rho * solution.direct
    blended = [  # values, and are lamps seen?
        (exitance / np.pi, True),
        (rho, False),
        (rho * (solution.irradiance - solution.direct) / np.pi, False),
        *([(gloss, False)] if gloss.any() else []),
    ]

    def layers(band):
        drawn = splat(blended, band.fine, 1, None, **band.part)
        direct, albedo, indirect, *lobes = drawn["layers"]
        places = band.places(surfels._core, drawn)
        direct, albedo, indirect = band.colored([direct, albedo, indirect], colors, drawn, places)
        if view.direct == "traced":
            direct += albedo / np.pi * band.traced(solution._scene._to_core(), surfels._core, drawn, places)
        return band.layers(drawn, direct, sum(lobes, indirect), albedo)

    return in_bands(view, layers, progress)


def drawn_surfels(solution):
    """The compiled surfels, without gaps: four disks of half the radius do not cover the one they replace."""
    s = solution.surfels
    inserted = inserted_among(solution.parents)
    if not inserted.any():
        return s._core
    radii = np.where(inserted, INSERTED_FOOTPRINT, 1.0) * s.radii
    # Parts of patches overlap by a hair: where their edges meet in the middle of another's, pixels would stay open.
    owner = s.triangle_surfel
    grown = np.where(inserted, INSERTED_OVERLAP, 1.0)
    center = s.points[owner][:, None, :]
    triangles = center + grown[owner][:, None, None] * (s.triangles - center)
    return replaced(s._core, radii=radii, areas=grown**2 * s.areas, triangles=triangles)
