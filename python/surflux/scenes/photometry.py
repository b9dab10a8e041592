"""Intensities of luminaires by direction, and the files that makers give them in: IES LM-63 and EULUMDAT."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.files import file_error, require_file
from surflux._base.types import FilePath, Floats

_SUFFIXES = ".ies", ".ldt"
_ARRAYS = "planes", "angles", "candela"


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Photometry:
    """Intensity of a luminaire on half-planes through its axis (CIE 121: planes C, angles gamma).

    A luminaire that hangs has gamma = 0 straight down. Half-plane C = 0 is towards +x then, C = 90 towards +y: C counts
    counter-clockwise seen from above. Between planes and angles intensities are linear; below the first angle and above
    the last there is no light.

    Args:
        planes: (h,) C in degrees, ascending. One plane: alike all around. From 0 to 90, or to 180: the rest is
            mirrored, as it is from 90 to 270. Else from 0 all around; 360 may be left out.
        angles: (v,) gamma in degrees, ascending, within [0, 180], two at least.
        candela: (h, v), cd, or W/sr for who reckons in watts; at least 0.
        source: the file that it comes from, if any.

    Attributes:
        planes, angles, candela, source: as given.

    Raises:
        ValueError: an argument, by name.

    >>> import numpy as np, surflux as sf
    >>> gamma = np.arange(0.0, 95.0, 5.0)
    >>> panel = sf.Photometry([0.0], gamma, [1000.0 * np.cos(np.radians(gamma))])  # as a flat lamp shines
    >>> round(panel.lumens)  # 1000 pi, but for what is linear between five degrees
    3140
    """

    planes: Floats
    angles: Floats
    candela: Floats
    source: str | None

    def __init__(
        self, planes: ArrayLike, angles: ArrayLike, candela: ArrayLike, source: FilePath | None = None
    ) -> None:
        planes, angles = (
            check.in_range(name, check.finite_array(name, check.numeric(name, values), (None,)), 0.0, most)
            for name, values, most in (("planes", planes, 360.0), ("angles", angles, 180.0))
        )
        if not len(planes) or (np.diff(planes) <= 0.0).any():
            raise ValueError(f"planes: wanted one or more in ascending order, got {_few(planes)}")
        if len(angles) < 2 or (np.diff(angles) <= 0.0).any():
            raise ValueError(f"angles: wanted two or more in ascending order, got {_few(angles)}")
        if len(planes) > 1 and planes[0] != 0.0 and (planes[0], planes[-1]) != (90.0, 270.0):
            raise ValueError(f"planes: wanted them from 0 on, or from 90 to 270, got {planes[0]:g} to {planes[-1]:g}")
        shape = len(planes), len(angles)
        candela = check.finite_array("candela", check.numeric("candela", candela), shape)
        candela = check.in_range("candela", candela, 0.0)
        for name, array in (("planes", planes), ("angles", angles), ("candela", candela)):
            own = np.array(array, float)
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        object.__setattr__(self, "source", None if source is None else os.fspath(source))

    def all_around(self) -> tuple[Floats, Floats]:
        """(planes (m,) from 0 to 360, candela (m, v)): with what symmetry leaves out."""
        planes, candela = self.planes, self.candela
        if len(planes) == 1:
            return np.array([0.0, 360.0]), np.concatenate([candela, candela])
        if planes[0] == 90.0:  # about the plane of 90 and 270
            below, above = planes <= 180.0, planes >= 180.0
            planes = np.concatenate([180.0 - planes[below][::-1], planes[1:-1], 540.0 - planes[above][::-1]])
            candela = np.concatenate([candela[below][::-1], candela[1:-1], candela[above][::-1]])
            if 180.0 not in self.planes:  # 0 and 360 are one place
                at_zero = 0.5 * (candela[:1] + candela[-1:])
                planes = np.concatenate([[0.0], planes, [360.0]])
                candela = np.concatenate([at_zero, candela, at_zero])
            return planes, candela
        for end in (90.0, 180.0):
            if planes[-1] == end:
                planes = np.concatenate([planes, 2.0 * end - planes[-2::-1]])
                candela = np.concatenate([candela, candela[-2::-1]])
        if planes[-1] != 360.0:
            planes, candela = np.append(planes, 360.0), np.concatenate([candela, candela[:1]])
        return planes, candela

    @property
    def lumens(self) -> float:
        """All that it sends: the integral of the intensity over all directions."""
        planes, candela = self.all_around()
        a, b = np.radians(self.angles[:-1]), np.radians(self.angles[1:])
        slope = np.diff(candela, axis=1) / (b - a)
        rings = candela[:, :-1] * np.cos(a) - candela[:, 1:] * np.cos(b) + slope * (np.sin(b) - np.sin(a))
        each = rings.sum(axis=1)
        return float(np.sum(np.radians(np.diff(planes)) * (each[1:] + each[:-1]) / 2.0))

    def _to_file(self):
        """The arguments, as JSON takes them."""
        arrays = {name: getattr(self, name).tolist() for name in _ARRAYS}
        return arrays | {"source": self.source}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Photometry):
            return NotImplemented
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in _ARRAYS)

    def __hash__(self) -> int:
        return hash((self.candela.shape, float(self.candela.sum())))

    def __repr__(self) -> str:
        shape, of = self.candela.shape, "" if self.source is None else f", of {os.path.basename(self.source)}"
        return f"Photometry({shape[0]} x {shape[1]} intensities up to {self.candela.max():.4g} cd{of})"


def read_photometry(path: FilePath) -> Photometry:
    """The Photometry of an IES file (ANSI/IES LM-63, .ies) or of a EULUMDAT file (.ldt).

    Intensities are cd as the file has them, with its factors (multiplier and ballast of IES files; the lamps' flux and
    the conversion of EULUMDAT, of its first set of lamps). Tilts of lamps inside of the luminaire are not read.

    Args:
        path: str or path, .ies or .ldt.

    Raises:
        FileError: there is none, it is neither, is damaged (with the line), or has photometry of type A or B, whose
            angles turn about another axis.

    >>> import surflux as sf
    >>> with open("lamp.ies", "w") as file:
    ...     written = file.write("TILT=NONE\\n1 -1 1 3 1 1 2 .1 .1 0\\n1 1 12\\n0 45 90\\n0\\n500 300 0\\n")
    >>> sf.read_photometry("lamp.ies")
    Photometry(1 x 3 intensities up to 500 cd, of lamp.ies)
    """
    path = check.path("path", path)
    require_file(path)
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in _SUFFIXES:
        raise file_error(path, f"wanted a name ending in {' or '.join(_SUFFIXES)}")
    try:
        with open(path, encoding="latin-1") as file:
            lines = file.read().splitlines()
    except OSError as fault:
        raise file_error(path, fault.strerror or str(fault)) from fault
    planes, angles, candela = (_ies if suffix == ".ies" else _eulumdat)(path, lines)
    try:
        return Photometry(planes, angles, candela, path)
    except ValueError as fault:
        raise file_error(path, str(fault)) from fault


class _Numbers:
    """Numbers of some lines, one after another, wherever lines end."""

    def __init__(self, path, lines, first, separators=","):
        self._path, self._at = path, 0
        for separator in separators:
            lines = [line.replace(separator, " ") for line in lines]
        self._words = [(word, k + first) for k, line in enumerate(lines) for word in line.split()]

    def take(self, what, count=None):
        """The next number, or (count,) of them."""
        found = []
        for _ in range(1 if count is None else count):
            if self._at == len(self._words):
                raise file_error(self._path, f"ends before its {what}")
            word, line = self._words[self._at]
            self._at += 1
            try:
                found.append(float(word))
            except ValueError:
                raise file_error(self._path, f"{what}: wanted a number, got {word[:40]!r}", f"line {line}") from None
        return found[0] if count is None else np.array(found)

    def count(self, what, most=10_000):
        """The next number as a count of something."""
        value = self.take(what)
        if not (1 <= value <= most and value == int(value)):
            place = f"line {self._words[self._at - 1][1]}"
            raise file_error(self._path, f"{what}: wanted a whole number from 1 to {most}, got {value:g}", place)
        return int(value)


def _ies(path, lines):
    tilt = next((k for k, line in enumerate(lines) if line.strip().upper().startswith("TILT=")), None)
    if tilt is None:
        raise file_error(path, "is no IES file: it has no line TILT=")
    numbers = _Numbers(path, lines[tilt + 1 :], tilt + 2)
    if lines[tilt].strip().upper() == "TILT=INCLUDE":
        numbers.take("geometry of tilts")
        numbers.take("tilts", 2 * numbers.count("number of tilts"))
    numbers.take("lamps and their lumens", 2)
    factor = numbers.take("multiplier")
    height, width = numbers.count("number of vertical angles"), numbers.count("number of horizontal angles")
    kind = numbers.take("photometric type")
    if kind != 1:
        name = {2: "B", 3: "A"}.get(kind, f"{kind:g}")
        raise file_error(path, f"has photometry of type {name}: wanted type C (1)")
    numbers.take("units and measures", 4)
    factor *= numbers.take("ballast factor") * (numbers.take("factor of ballast and lamp") or 1.0)
    numbers.take("watts")
    angles, planes = numbers.take("vertical angles", height), numbers.take("horizontal angles", width)
    return planes, angles, factor * numbers.take("candela values", width * height).reshape(width, height)


# Which planes a EULUMDAT file has intensities of, by its symmetry: from, to, and the part of all around that this is.
_PLANES_OF = {0: (0.0, 360.0, 1), 2: (0.0, 180.0, 2), 3: (90.0, 270.0, 2), 4: (0.0, 90.0, 4)}


def _eulumdat(path, lines):
    def number(k, what):
        text = lines[k].strip().replace(",", ".") if k < len(lines) else ""
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise file_error(path, f"{what}: wanted a number, got {text[:40]!r}", f"line {k + 1}")
        return value

    symmetry = number(2, "symmetry")
    if symmetry not in (0, 1, 2, 3, 4):
        raise file_error(path, f"symmetry: wanted 0 to 4, got {symmetry:g}", "line 3")
    height, width = number(5, "number of angles in a plane"), number(3, "number of planes")
    for k, count in ((5, height), (3, width)):
        if not (1 <= count <= 10_000 and count == int(count)):
            raise file_error(path, f"wanted a whole number from 1 to 10000, got {count:g}", f"line {k + 1}")
    conversion, sets = number(23, "conversion of intensities"), int(number(25, "number of sets of lamps"))
    if not 1 <= sets <= 100:
        raise file_error(path, f"number of sets of lamps: wanted 1 or more, got {sets}", "line 26")
    flux = number(28, "flux of the lamps")
    first = 26 + 6 * sets + 10  # behind the direct ratios
    numbers = _Numbers(path, [line.replace(",", ".") for line in lines[first:]], first + 1, "")
    planes, angles = numbers.take("planes", int(width)), numbers.take("angles", int(height))
    if symmetry == 1:
        planes = planes[:1]
    else:
        low, high, parts = _PLANES_OF[int(symmetry)]
        planes = planes[(planes >= low) & (planes <= high)]
        wanted = int(width) // parts + (parts > 1)
        if len(planes) != wanted:
            raise file_error(
                path, f"planes: wanted {wanted} of {int(width)} from {low:g} to {high:g}, got {len(planes)}"
            )
    candela = numbers.take("intensities", len(planes) * int(height)).reshape(len(planes), int(height))
    return planes, angles, candela * (conversion or 1.0) * flux / 1000.0


def _few(values):
    return np.array2string(values, threshold=8, precision=6)
