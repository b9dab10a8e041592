"""What solar_irradiation finds."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux._base import check
from surflux._base.passes import watched
from surflux._base.types import Floats, Progress
from surflux.drawing import plots
from surflux.points.surfels import Surfels
from surflux.solving.sky_transfer import SkyTransfer
from surflux.solving.sun_paths import beam_hours

PARTS = "total", "beam", "diffuse", "reflected"
_AT_ONCE = 512  # hours


class SolarHours(NamedTuple):
    """W/m2 on m surfels in each of h hours, (m, h) each: the sun, the sky, and what surfaces and ground reflect.

    A tuple of the three, but equal to itself alone, for arrays are not compared as a whole.
    """

    beam: Floats
    diffuse: Floats
    reflected: Floats

    def __eq__(self, other: object) -> bool:
        return self is other

    def __ne__(self, other: object) -> bool:
        return self is not other

    def __hash__(self) -> int:
        return id(self)

    @property
    def total(self) -> Floats:
        """(m, h) W/m2, of all three."""
        return self.beam + self.diffuse + self.reflected


class SolarIrradiation:
    """Irradiation of surfels by sun and sky, as `solar_irradiation` finds it.

    Attributes:
        surfels: of the scene.
        beam, diffuse, reflected: (n,) kWh/m2 over all hours: the sun, the sky, and what arrives by way of surfaces.
        total: (n,) kWh/m2, their sum.
        hours: how many there are, of sun and of night.
        times: (h,) UTC, middles of the hours; None where Skies were given.
        transfer: SkyTransfer, which solar_irradiation takes again for the same scene.
        timings: dict, seconds per stage.
    """

    def __init__(
        self,
        transfer: SkyTransfer,
        found: Any,
        rays: Any,
        parts: tuple[Floats, Floats, Floats],
        timings: dict[str, float],
    ) -> None:
        """Not called by users: see `solar_irradiation`."""
        self.transfer, self.timings = transfer, timings
        self.surfels: Surfels = transfer.scene.surfels
        self._found, self._rays = found, rays
        for part in parts:
            part.setflags(write=False)
        self.beam, self.diffuse, self.reflected = parts
        self.hours = found.hours * len(found.skies)
        self.times: NDArray[np.datetime64] | None = found.times

    @property
    def total(self) -> Floats:
        """(n,) kWh/m2: beam, diffuse and reflected."""
        return self.beam + self.diffuse + self.reflected

    @property
    def mean(self) -> Floats:
        """(n,) W/m2, the mean of the total over all hours, nights included."""
        return self.total * (1000.0 / self.hours)

    def hourly(
        self,
        surfels: ArrayLike | None = None,
        *,
        threads: int | None = None,
        progress: Progress = False,
    ) -> SolarHours:
        """W/m2 of each hour, apart: daylight coefficients of some surfels, by rays, times the skies of all hours.

        Its sums over the hours are `beam`, `diffuse` and `reflected`, to about a thousandth.

        Args:
            surfels: (m,) indices, or a mask (n,); None for all, which takes 24 bytes for each hour of each.
            threads: at most this many; None for all.
            progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

        Returns:
            SolarHours of (m, h) each.

        Raises:
            ValueError, IndexError: an argument, by name.
            Cancelled: the callback returned False.

        >>> import surflux as sf
        >>> roof = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
        >>> day = [sf.Sky.from_sun(up, 180.0, direct_normal=700.0, diffuse=100.0) for up in (30.0, 90.0)]
        >>> sf.solar_irradiation(roof, skies=day).hourly().beam.round().tolist()
        [[350.0, 700.0]]
        """
        chosen = check.selection("surfels", slice(None) if surfels is None else surfels, len(self.surfels))
        skies, patches = self._found.skies, self.transfer.patches
        paths, lit, rays = self._rays
        with watched(threads, progress):
            first = rays.coefficients(chosen)
            rest = self.transfer.coefficients(chosen).mean(axis=2, dtype=float)
            rest -= self.transfer.coefficients(chosen, bounces=0).mean(axis=2, dtype=float)
        diffuse, reflected = np.empty((len(chosen), len(skies))), np.empty((len(chosen), len(skies)))
        for begin in range(0, len(skies), _AT_ONCE):
            some = slice(begin, begin + _AT_ONCE)
            of_patches = skies.of(some).patch_radiances(patches)
            diffuse[:, some] = first[:, 1:] @ of_patches[:, 1:].T
            reflected[:, some] = np.outer(first[:, 0], of_patches[:, 0])
            which, added = skies.of(some).sun_radiances(patches)
            of_patches[np.arange(len(of_patches)), which] += added
            reflected[:, some] += rest @ of_patches.T
        normals = self.surfels.normals[chosen]
        beam = beam_hours(normals, skies.beams, paths, lit[chosen])
        return SolarHours(beam, diffuse, reflected.clip(0.0))

    def plot(
        self, part: Literal["total", "beam", "diffuse", "reflected"] = "total", **options: Any
    ) -> Path | plots.Picture | None:
        """Shows kWh/m2 in colours, as Surfels.plot shows its properties, in a window or as a picture.

        Args:
            part: which.
            options: screenshot, camera, size and more, see Surfels.plot.

        Returns:
            The path of the picture, None after a window was closed, in a notebook what that shows.

        Raises:
            ValueError: an argument, by name.
            FileError: a picture that cannot be written.
        """
        check.choice("part", part, PARTS)
        name = f"{part}, kWh/m2"
        return plots.plot(self.surfels, color=name, values={name: getattr(self, part)}, **options)

    def __repr__(self) -> str:
        areas = self.transfer.scene._to_core().surfels.areas
        means = (
            np.average(getattr(self, part), weights=np.asarray(areas)) for part in ("beam", "diffuse", "reflected")
        )
        beam, diffuse, reflected = means
        what = f"beam {beam:.4g} + diffuse {diffuse:.4g} + reflected {reflected:.4g}"
        return f"SolarIrradiation({len(self.surfels)} surfels, {self.hours:g} h, mean of {what} kWh/m2)"
