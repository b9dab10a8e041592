"""Files of lamps that move: TOML with the keyframes of each lamp."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from surflux._base import check
from surflux._base.types import FilePath
from surflux.scenes.lights import Light
from surflux.scenes.scene_file import LIGHT_TYPES, Table, lamp_arguments, read_toml

_TYPES = ("point", "spot", "photometric", "area", "directional")
_NUMBERS = ("cone", "penumbra", "azimuth")
_COLORS = ("intensity", "exitance", "irradiance")
_SMOOTH = ("position", "corner", "direction")  # what may go through keyframes without a bend
_MOST_FRAMES = 1_000_000


def load_lamps(path: FilePath) -> list[list[Light]]:
    """Lamps that move, from a TOML file: the lights of each frame, for `LocalTransfer.relight` and `animate_lamps`.

    At the top: frames, how many (must be there where anything moves); interpolation, "linear" (default) or "smooth";
    closed (false): true returns to the first keyframe, and stops a frame before it, so that a film may run in a circle.

    Then tables [[light]], one for each lamp, with the type and the keys of scene files (see load_scene), "environment"
    excepted. In place of a value may stand a list of values, its keyframes: `position = [[0, 0, 2], [3, 0, 2]]`,
    `intensity = [[9, 9, 9], [0, 0, 0]]`, `cone = [30, 60]`. What has no list stays as it is.

    Keyframes are spread evenly over all frames, the first in frame 1 and the last in the last frame, or stand in the
    frames that the key `at` of their light lists: `at = [1, 10, 60]`, ascending. Before the first and after the last
    the light stays as it is there. Between them all is interpolated linearly; "smooth" takes position, corner and
    direction through their keyframes on a curve (Catmull and Rom 1974).

    Args:
        path: str or path of the file.

    Returns:
        A list with the list of lights of each frame.

    Raises:
        ValueError: path is none.
        FileError: names the file, the table and the key, or the line where the TOML itself is wrong.

    >>> import surflux as sf
    >>> with open("lights.toml", "w") as file:
    ...     written = file.write('''
    ... frames = 3
    ... [[light]]
    ... type = "point"
    ... position = [[0, 0, 2], [3, 0, 2]]
    ... intensity = 10
    ... ''')
    >>> [light.position for light, in sf.load_lamps("lights.toml")]
    [(0.0, 0.0, 2.0), (1.5, 0.0, 2.0), (3.0, 0.0, 2.0)]
    """
    path = Path(check.path("path", path))
    top = Table(path, "", read_toml(path))
    frames = top.get("frames")
    if frames is not None:
        frames = top.call(check.count, "frames", frames, 1, _MOST_FRAMES)
    smooth = top.choice("interpolation", ("linear", "smooth"), "linear") == "smooth"
    closed = top.call(check.flag, "closed", top.get("closed", False))
    tables = top.tables("light")
    top.no_more_keys()
    if not tables:
        raise top.error("light", "wanted at least one [[light]], got none")
    lamps = [_Lamp(table, frames, smooth, closed) for table in tables]
    if frames is None and any(lamp.moves for lamp in lamps):
        raise top.error("frames", "is missing")
    return [[lamp.at(frame) for lamp in lamps] for frame in range(1, (frames or 1) + 1)]


class _Lamp:
    """One [[light]]: what of it stays, and the keyframes of what does not."""

    def __init__(self, table, frames, smooth, closed):
        self._table, self._smooth = table, smooth
        self._kind = table.choice("type", _TYPES)
        self._at = table.get("at")
        given = lamp_arguments(table, self._kind)
        moving = {key: _keyframes(table, key, value) for key, value in given.items() if _is_moving(key, value)}
        self._fixed = {key: value for key, value in given.items() if key not in moving}
        self.moves = bool(moving)
        if self._at is not None and not moving:
            raise table.error("at", "is for keyframes, of which there are none")
        self._curves = {}
        if frames is not None:
            for key, values in moving.items():
                self._curves[key] = _ends_met(self._times(key, len(values), frames, closed), values, frames, closed)

    def _times(self, key, count, frames, closed):
        """(count,) frames in which the keyframes of a key stand."""
        if self._at is None:
            return 1.0 + np.arange(count) * (frames / count) if closed else np.linspace(1.0, frames, count)
        numbers = self._table.call(check.finite_array, "at", self._at, (None,))
        if (np.diff(numbers) <= 0.0).any() or ((numbers < 1.0) | (numbers > frames)).any():
            raise self._table.error("at", f"wanted ascending numbers of frames, from 1 to {frames}, got {self._at}")
        if len(numbers) != count:
            what = check.counted(count, "keyframe")
            raise self._table.error(key, f"has {what}, but `at` lists {check.counted(len(numbers), 'frame')}")
        return numbers

    def at(self, frame):
        """The light in a frame, counted from 1."""
        moved = {}
        for key, (times, values) in self._curves.items():
            curve = _catmull_rom if self._smooth and key in _SMOOTH else _linear
            value = curve(times, values, frame)
            moved[key] = float(value[0]) if key in _NUMBERS else value
        try:
            return LIGHT_TYPES[self._kind](**self._fixed, **moved)
        except ValueError as error:
            key, _, reason = str(error).partition(": ")
            raise self._table.error(key, f"{reason} in frame {frame}" if moved else reason) from None


def _is_moving(key, value):
    if not isinstance(value, list):
        return False
    return key in _NUMBERS or any(isinstance(entry, list) for entry in value)


def _keyframes(table, key, values):
    """(k, 3), or (k, 1) of a number."""
    if not values:
        raise table.error(key, "wanted a number or keyframes, got an empty list")
    checked = []
    for number, value in enumerate(values, start=1):
        try:
            if key in _NUMBERS:
                checked.append([check.number(key, value)])
            else:
                checked.append(check.rgb(key, value) if key in _COLORS else check.vector3(key, value))
        except ValueError as error:
            reason = str(error).partition(": ")[2]
            raise table.error(key, f"keyframe {number}: {reason}") from None
    return np.array(checked, np.float64)


def _ends_met(times, values, frames, closed):
    """Keyframes that go on beyond both ends, as a circle does where it is closed."""
    if not closed:
        return times, values
    period = float(frames)
    return np.concatenate([times - period, times, times + period]), np.concatenate([values] * 3)


def _linear(times, values, frame):
    return np.array([np.interp(frame, times, column) for column in values.T])


def _catmull_rom(times, values, frame):
    """A cubic between two keyframes, with the slope at each that its neighbours have between them."""
    if len(times) == 1 or frame <= times[0]:
        return values[0]
    if frame >= times[-1]:
        return values[-1]
    k = int(np.searchsorted(times, frame, side="right")) - 1
    width = times[k + 1] - times[k]
    before, after = max(k - 1, 0), min(k + 2, len(times) - 1)
    slope = (values[k + 1] - values[before]) / (times[k + 1] - times[before]) * width
    next_slope = (values[after] - values[k]) / (times[after] - times[k]) * width
    t, step = (frame - times[k]) / width, values[k + 1] - values[k]
    bend = t * (1.0 - t) * ((1.0 - t) * (slope - step) - t * (next_slope - step))
    return values[k] + t * step + bend
