"""The sky over a place at a time, with its sun, as the all-weather model has it (Perez, Seals and Michalsky 1993)."""

from __future__ import annotations

import datetime
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from surflux._base import check
from surflux._base.color import rgb_of_grey
from surflux._base.types import FilePath, Floats
from surflux.scenes import weather
from surflux.scenes.lights import DirectionalLight, Environment
from surflux.scenes.sky_hours import SkyHours, sun_directions
from surflux.scenes.sky_patches import SkyPatches

SUN_DIAMETER = 0.533  # degrees
_ROWS = 256  # of the dome that `radiance` is scaled by


def place_of(latitude: Any, longitude: Any) -> tuple[float, float]:
    """Degrees, north and east, checked."""
    return check.number("latitude", latitude, -90.0, 90.0), check.number("longitude", longitude, -180.0, 180.0)


def figures_of(direct_normal: Any, diffuse: Any, h: int) -> tuple[Floats, Floats]:
    """(h,) each, W/m2, checked; one number stands for all."""
    found = []
    for name, value in (("direct_normal", direct_normal), ("diffuse", diffuse)):
        array = check.numeric(name, value)
        if array.ndim == 0:
            array = np.full(h, array)
        found.append(check.in_range(name, check.finite_array(name, array, (h,)), 0.0, 2000.0))
    return found[0], found[1]


class Sky:
    """Sun and sky over a place at a time: a light.

    +z is up, +y is north, +x is east. A Scene takes it among its lights, as the two that it is made of: an Environment
    and the sun, a DirectionalLight (`Sky.lights`). `SkyTransfer.relight` takes it by patches.

    The radiance of the sky is that of the all-weather model of Perez, Seals and Michalsky (1993, with its erratum),
    scaled so that a level plane receives `diffuse` of it exactly. Where its gradation would grow without bound towards
    the horizon (a low sun in a bright sky, a high one in a dim sky; gendaylit has a ring there), it is even. The
    ground, all of the lower half, reflects `albedo` of what a level plane receives, evenly. Where neither direct_normal
    nor diffuse are given the sky is clear (Ineichen and Perez 2002). While the sun is down there is no beam, and what
    is diffuse comes evenly from all of the sky.

    Sun positions and clear skies need pvlib, `pip install 'surflux[solar]'`; `Sky.from_sun` does not.

    Args:
        latitude, longitude: degrees, north and east.
        time: with its time zone: text such as "2025-06-21T12:00+02:00", an aware datetime; or datetime64 in UTC.
        direct_normal: W/m2 of the sun on a plane that faces it, 0 to 2000.
        diffuse: W/m2 of the sky on a level plane, 0 to 2000; the one is given with the other.
        turbidity: of a clear sky, by Linke, 1 to 20; None for the monthly mean of the place.
        altitude: of the place, metres above the sea, of clear skies: at 500 m a roof has 2 % more than at 0.
        albedo: of the ground, 0 to 1.

    Raises:
        ValueError: an argument, by name.
        ImportError: pvlib is not there.
    """

    _hours: SkyHours

    def __init__(
        self,
        latitude: float,
        longitude: float,
        time: str | datetime.datetime | np.datetime64,
        *,
        direct_normal: float | None = None,
        diffuse: float | None = None,
        turbidity: float | None = None,
        altitude: float = 0.0,
        albedo: float = 0.2,
    ) -> None:
        latitude, longitude = place_of(latitude, longitude)
        times = weather.utc("time", time)
        if len(times) != 1:
            raise ValueError(f"time: wanted one, got {len(times)}; solar_irradiation takes several")
        albedo = check.number("albedo", albedo, 0.0, 1.0)
        found = hours_at((latitude, longitude), times, direct_normal, diffuse, turbidity, altitude, albedo)
        self._hours = found

    @classmethod
    def from_sun(
        cls,
        altitude: float,
        azimuth: float,
        direct_normal: float,
        diffuse: float,
        *,
        albedo: float = 0.2,
        day: int = 80,
    ) -> Self:
        """The sky around a sun that stands where it is said to; needs no pvlib.

        Args:
            altitude: of the sun over the horizon, degrees, -90 to 90.
            azimuth: of the sun, degrees clockwise from north.
            direct_normal, diffuse: W/m2, see Sky.
            albedo: of the ground.
            day: of the year, 1 to 366: in January the sun is nearer, and the model goes by what arrives above the air.

        Raises:
            ValueError: an argument, by name.

        >>> import surflux as sf
        >>> sky = sf.Sky.from_sun(30.0, 180.0, direct_normal=700.0, diffuse=100.0)
        >>> sky
        Sky(sun 30.0 up at 180.0, direct 700 and diffuse 100 W/m2, albedo 0.2)
        >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), 0.1)
        >>> print(sf.solve(sf.Scene([floor], lights=[sky])).irradiance[0].round())  # 700 sin 30 + 100
        [450. 450. 450.]
        """
        altitude = check.number("altitude", altitude, -90.0, 90.0)
        azimuth = check.number("azimuth", azimuth, -1e6, 1e6)
        figures = figures_of(check.number("direct_normal", direct_normal), check.number("diffuse", diffuse), 1)
        days = np.array([check.count("day", day, 1, 366)])
        suns = sun_directions(np.array([altitude]), np.array([azimuth]))
        return cls._of(SkyHours(suns, *figures, days, check.number("albedo", albedo, 0.0, 1.0)))

    @classmethod
    def from_epw(cls, path: FilePath, hour: int, *, albedo: float = 0.2) -> Self:
        """An hour of a file of weather, EPW: its direct normal and diffuse irradiance, the sun in the middle of it.

        Args:
            path: of the file. Where its time zone does not fit its own sun, that of the sun is taken, with a warning.
            hour: row, from 0: 24 (day - 1) + the hour at which it begins, in the standard time of the place; in a file
                of several records an hour so many times that, and the sun stands in the middle of the record.
            albedo: of the ground.

        Raises:
            ValueError: an argument, by name.
            FileError: the file cannot be read.
            ImportError: pvlib is not there.
        """
        albedo = check.number("albedo", albedo, 0.0, 1.0)
        found = weather.read_weather(path)
        row = check.count("hour", hour, 0, len(found.times) - 1)
        return cls._of(hours_of_weather(found, albedo).of(slice(row, row + 1)))

    @classmethod
    def _of(cls, hours):
        sky = cls.__new__(cls)
        sky._hours = hours
        return sky

    @property
    def sun_direction(self) -> Floats:
        """(3,) unit vector towards the sun."""
        return self._hours.suns[0].copy()

    @property
    def sun_altitude(self) -> float:
        """Of the sun over the horizon, degrees, with refraction."""
        return float(np.degrees(np.arcsin(self._hours.suns[0, 2].clip(-1.0, 1.0))))

    @property
    def sun_azimuth(self) -> float:
        """Of the sun, degrees clockwise from north, 0 to 360."""
        return float(np.degrees(np.arctan2(*self._hours.suns[0, :2])) % 360.0)

    @property
    def direct_normal(self) -> float:
        """W/m2 of the sun on a plane that faces it; 0 while it is down."""
        return float(self._hours.beams[0])

    @property
    def diffuse(self) -> float:
        """W/m2 of the sky on a level plane."""
        return float(self._hours.diffuse[0])

    @property
    def global_horizontal(self) -> float:
        """W/m2 of sun and sky on a level plane."""
        return self.diffuse + self.direct_normal * max(0.0, float(self._hours.suns[0, 2]))

    @property
    def albedo(self) -> float:
        """Of the ground."""
        return self._hours.albedo

    @property
    def clearness(self) -> float:
        """Epsilon of the model: 1 overcast, above 6.2 clear; NaN while the sun is down."""
        return float(self._hours.index()[0][0])

    @property
    def brightness(self) -> float:
        """Delta of the model; NaN while the sun is down."""
        return float(self._hours.index()[1][0])

    @property
    def sun_radiance(self) -> float:
        """Mean radiance of the sun's disk, 0.533 degrees across, in W/(m2 sr)."""
        return self.direct_normal / (2.0 * np.pi * (1.0 - np.cos(np.radians(0.5 * SUN_DIAMETER))))

    @property
    def sun(self) -> DirectionalLight | None:
        """The sun as parallel light; None while it is down or hidden."""
        return DirectionalLight(-self.sun_direction, self.direct_normal) if self.direct_normal > 0.0 else None

    @property
    def lights(self) -> list[Environment | DirectionalLight]:
        """The sky, an Environment, and the sun, where there is one: what a Scene takes a Sky for."""
        sun = self.sun
        return [self.environment()] if sun is None else [self.environment(), sun]

    def radiance(self, directions: ArrayLike) -> Floats:
        """(m,) radiance in W/(m2 sr) towards directions (m, 3), of any length but 0, without the sun's disk.

        Raises:
            ValueError: directions of another shape, not finite or of zero length.
        """
        directions = check.unit_vectors("directions", check.finite_array("directions", directions, (None, 3)))
        places, level = _dome(_ROWS)
        scale = self.diffuse / (self._hours.relative(places.reshape(-1, 3))[0] @ np.repeat(level, places.shape[1]))
        found = scale * self._hours.relative(directions)[0]
        return np.where(directions[:, 2] >= 0.0, found, self._hours.ground[0])

    def environment(self, height: int = 128, *, sun: bool = False) -> Environment:
        """The sky and the ground as a light, an image of so many rows and twice as many columns.

        A level plane receives `diffuse` of it exactly.

        Args:
            height: rows, even, 2 to 8192.
            sun: whether the sun is in it, its power in one pixel.

        Raises:
            ValueError: an argument, by name.
        """
        height = check.count("height", height, 2, 8192)
        if height % 2:
            raise ValueError(f"height: wanted an even number, so that the horizon lies between rows, got {height}")
        places, level = _dome(height)
        found = self._hours.relative(places.reshape(-1, 3))[0].reshape(places.shape[:2])
        image = np.full((height, 2 * height), self._hours.ground[0])
        image[: height // 2] = found * (self.diffuse / (found.sum(axis=1) @ level))
        if check.flag("sun", sun) and self.direct_normal > 0.0:
            x, y, z = self.sun_direction
            row = min(int(np.arccos(z) / np.pi * height), height // 2 - 1)
            column = int(np.arctan2(y, -x) % (2.0 * np.pi) / np.pi * height) % (2 * height)
            angle = np.pi / height * (np.cos(np.pi * row / height) - np.cos(np.pi * (row + 1) / height))
            image[row, column] += self.direct_normal / angle
        return Environment(rgb_of_grey(image))

    def patch_radiances(self, patches: SkyPatches, *, sun: bool = False) -> Floats:
        """(len(patches),) mean radiance of each patch of the sky, the ground's first: what SkyTransfer.relight takes.

        A level plane receives `diffuse` of them exactly.

        Args:
            patches: SkyPatches.
            sun: whether the sun's power is in them, spread over the patch that it stands in.

        Raises:
            ValueError: an argument, by name.

        >>> import surflux as sf
        >>> patches, sky = sf.SkyPatches(145), sf.Sky.from_sun(30.0, 180.0, direct_normal=700.0, diffuse=100.0)
        >>> print(f"{sky.patch_radiances(patches) @ patches.projected:.9f}")
        100.000000000
        """
        if not isinstance(patches, SkyPatches):
            raise ValueError(f"patches: wanted SkyPatches, got {type(patches).__name__}")
        found = self._hours.patch_radiances(patches)[0]
        if check.flag("sun", sun):
            which, added = self._hours.sun_radiances(patches)
            found[which[0]] += added[0]
        return found

    def _contents(self):
        h = self._hours
        return (*h.suns[0].tolist(), float(h.direct_normal[0]), float(h.diffuse[0]), int(h.days[0]), h.albedo)

    def __eq__(self, other: object) -> bool:
        return self._contents() == other._contents() if isinstance(other, Sky) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._contents())

    def __repr__(self) -> str:
        sun = f"sun {self.sun_altitude:.1f} up at {self.sun_azimuth:.1f}"
        return f"Sky({sun}, direct {self.direct_normal:g} and diffuse {self.diffuse:g} W/m2, albedo {self.albedo:g})"


def _dome(height):
    """Middles (height / 2, 2 height, 3) of the pixels above the horizon; what one of each row sends a level plane."""
    edges = np.pi * np.arange(height // 2 + 1) / height
    theta, phi = 0.5 * (edges[1:] + edges[:-1]), np.pi - np.pi * (np.arange(2 * height) + 0.5) / height
    sine, cosine = np.sin(theta)[:, None], np.cos(theta)[:, None]
    places = np.stack(np.broadcast_arrays(sine * np.cos(phi), sine * np.sin(phi), cosine), axis=-1)
    return places, 0.5 * np.pi / height * np.diff(np.sin(edges) ** 2)


def hours_at(place, times, direct_normal, diffuse, turbidity, altitude, albedo):
    """SkyHours of times (h,), by figures that are given or clear."""
    altitude = check.number("altitude", altitude, -500.0, 9000.0)
    given = [name for name, value in (("direct_normal", direct_normal), ("diffuse", diffuse)) if value is not None]
    if len(given) == 1:
        other = "diffuse" if given == ["direct_normal"] else "direct_normal"
        raise ValueError(f"{other}: wanted with {given[0]}; neither for a clear sky")
    if turbidity is not None:
        if given:
            raise ValueError("turbidity: wanted without direct_normal and diffuse, which say all")
        turbidity = check.number("turbidity", turbidity, 1.0, 20.0)
    figures = figures_of(direct_normal, diffuse, len(times)) if given else None
    angles = weather.sun_angles(times, *place, altitude)
    if figures is None:
        figures = weather.clear_sky(times, *place, altitude, turbidity)
    return SkyHours(sun_directions(*angles), *figures, weather.day_of_year(times), albedo)


def hours_of_weather(found, albedo):
    """SkyHours of a Weather."""
    angles = weather.sun_angles(found.times, found.latitude, found.longitude, found.altitude)
    days = weather.day_of_year(found.times)
    return SkyHours(sun_directions(*angles), found.direct_normal, found.diffuse, days, albedo)
