"""Rays as lamps and suns send them, and which sides of surfels they meet first."""

from dataclasses import dataclass

import numpy as np

from surflux import _core
from surflux.scenes.lights import AreaLight, DirectionalLight, Environment, PhotometricLight, SpotLight, power_name

IN_AIR = 0xFFFFFFFF  # in place of the surfel that a ray leaves
# Of the size of the scene: so far from a lamp rays begin, for what lies in its plane is not in its way.
CLEAR = 1e-5


@dataclass(frozen=True, eq=False)
class Met:
    """What the rays of a light meet first, but for those that leave the scene: (m,) each.

    Attributes:
        surfels: of the compiled scene.
        on_backs: whether on their backs.
        power: of each ray, channels added up.
    """

    surfels: np.ndarray
    on_backs: np.ndarray
    power: np.ndarray

    @property
    def rays_on_backs(self):
        """Of the rays, the share that meets backs: of a lamp with a place, of the directions in which it shines."""
        return float(np.mean(self.on_backs)) if len(self.on_backs) else 0.0


def met_by(light, core, count):
    """The Met of some `count` rays of a light other than an Environment. core: the compiled scene."""
    surfels = core.surfels
    size = float(np.linalg.norm(np.ptp(surfels.positions, axis=0)) + surfels.radii.max())
    starts, ways, power = _sun_rays(light, surfels, count) if is_sun(light) else _lamp_rays(light, count)
    of = np.full(len(ways), IN_AIR, np.uint32)
    met, front, _ = _core.closest_hits(core, of, starts + CLEAR * size * ways, ways)
    hit = met >= 0
    return Met(met[hit], front[hit] == 0, power[hit])


def is_sun(light):
    return isinstance(light, DirectionalLight)


def shines(light):
    if isinstance(light, Environment):
        return bool(np.any(light.radiance if light.image is None else light.image))
    if isinstance(light, PhotometricLight) and not light.photometry.candela.any():
        return False
    return bool(np.any(getattr(light, power_name(light))))


def even_ways(count, least=-1.0):
    """(count, 3) directions of equal solid angles whose z is at least so much: a Fibonacci lattice."""
    k = np.arange(count) + 0.5
    z, turn = 1.0 - (1.0 - least) * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def _lamp_rays(lamp, count):
    """(m, 3) where rays of a lamp that has a place begin, (m, 3) their directions and (m,) powers."""
    if isinstance(lamp, AreaLight):
        u, v = np.asarray(lamp.edge_u), np.asarray(lamp.edge_v)
        across, cosines = np.cross(u, v), even_ways(count, 0.0)
        s, t = _even_places(count)
        power = np.sum(lamp.exitance) * np.linalg.norm(across) * 2.0 * cosines[:, 2] / count
        return lamp.corner + s[:, None] * u + t[:, None] * v, cosines @ _axes(across), power
    power = np.full(count, 4.0 * np.pi * np.sum(lamp.intensity) / count)
    if isinstance(lamp, SpotLight):  # what goes into its penumbra: lights/spot_cone.h
        outer, inner = np.radians(lamp.cone / 2.0), np.radians((lamp.cone - lamp.penumbra) / 2.0)
        ways = even_ways(count, np.cos(outer))
        x = np.clip((outer - np.arccos(ways[:, 2])) / max(outer - inner, 1e-12), 0.0, 1.0)
        ways, power = ways @ _axes(lamp.direction), power * np.sin(outer / 2.0) ** 2 * x * x * (3.0 - 2.0 * x)
    else:
        ways = even_ways(count)
        if isinstance(lamp, PhotometricLight):
            shares = lamp._shares(ways)
            ways, power = ways[shares > 0.0], (power * shares)[shares > 0.0]
    return np.tile(lamp.position, (len(ways), 1)), ways, power


def _sun_rays(sun, surfels, count):
    """The same of a sun, over the rectangle that it sees the scene in."""
    axes = _axes(sun.direction)
    places, radii = surfels.positions @ axes.T, surfels.radii[:, None]
    low, high = (places - radii).min(axis=0), (places + radii).max(axis=0)
    at = np.stack([*_even_places(count), np.zeros(count)], axis=1) * (high - low) + low
    area = np.prod((high - low)[:2])
    ways = np.tile(axes[2], (count, 1))
    return at @ axes, ways, np.full(count, np.sum(sun.irradiance) * area / count)


def _axes(direction):
    """(3, 3) rows: two unit vectors across a direction, and that."""
    z = np.asarray(direction, float) / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _even_places(count):
    """Two (count,) coordinates of places spread evenly over a unit square: additive recurrence."""
    plastic = 1.324717957244746  # x^3 = x + 1
    k = np.arange(1, count + 1)
    return (0.5 + k / plastic) % 1.0, (0.5 + k / plastic**2) % 1.0


def seen_from_fronts(core, asked, count):
    """What rays all over the hemisphere meet from the fronts of surfels, some `count` of each.

    core: the compiled scene. asked: (n,) surfels. Returns of (m,), which of the asked a ray leaves, its cosine, what it
    meets, or -1, whether that is a front, and how far away, (m,) each.
    """
    surfels, ways = core.surfels, even_ways(2 * count)
    cosines = np.maximum(surfels.normals[asked] @ ways.T, 0.0)
    of, way = np.nonzero(cosines)
    rows = asked[of]
    met, front, away = _core.closest_hits(core, rows.astype(np.uint32), surfels.positions[rows], ways[way])
    return of, cosines[of, way], met, front != 0, away
