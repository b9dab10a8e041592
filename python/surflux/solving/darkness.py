"""Why a scene stays dark, or too dark: no light, none that arrives, or light that falls on backs."""

import numpy as np

from surflux import _core
from surflux._base.warn import warn
from surflux.geometry.cores import make_core, replaced
from surflux.scenes.lights import Environment
from surflux.solving.lamp_rays import seen_from_fronts, shines
from surflux.solving.light_on_backs import TURN

# A mean of direct irradiance below this share of its maximum makes it worth looking at backs. Closed scans leak a
# little: turned inside out, they are lit here and there.
HARDLY_LIT = 0.02
# Of the direct light that fronts and backs get, what fronts get: below this share it is said.
ON_FRONTS = 0.01
# The same of one lamp where surfels face down on the whole: of a floor that does, beneath the lit tops of a table and a
# box, 2.5 %.
ON_FRONTS_FACING_DOWN = 0.05
# Length of the mean normal, above which surfels face about one way.
ONE_WAY = 0.5
# Surfels whose backs are looked at, drawn by area; 100 of them tell a hundredth.
ASKED = 2000
RAYS = 256  # to the sky, of places that may be dark
NOISE_RAYS = 32  # of each front
# Of the power that enters a scene, what backs absorb: above this share it is said.
MUCH_INTO_BACKS = 0.01
# Of the rays that disks send, those that end on backs of others within so many radii: above this share it is said. Of a
# plane with noise of .1, .2 and .5 spacings .3, 1.1 and 7 %, of statues .2, of roofs without walls over their ground 0.
MUCH_ONTO_BACKS, CLOSE = 0.01, 2.0
# And what is neither absorbed nor gone.
MUCH_LOST = 0.01
# Widths of a scene, beyond which a lamp that does not light it may stand in other units.
FAR = 20.0


def warn_of_darkness(scene, core, result, told=None):
    """Warns where (next to) no light reaches the fronts of surfels; whether that makes the whole scene dark.

    core: the compiled scene. result: what the solver of _core found there. told: see warn_of_backs.
    """
    emits = any(np.any(s.emission) for s in scene.objects)
    shining = [light for light in scene.lights if shines(light)]
    if not shining:
        if not emits:
            what = "the scene's lights have no power" if scene.lights else "the scene has no lights"
            warn(f"{what} and nothing in it emits: all of it stays black")
        return not emits
    areas = result["surfels"].areas
    return warn_of_backs(shining, core.surfels, result["direct"], areas, told) and not emits


def warn_of_backs(lights, surfels, direct, areas, told=None):
    """Warns where (next to) nothing of lights reaches the fronts of surfels; whether it did.

    lights: that shine. surfels: of the compiled scene. direct, areas: (n, 3) irradiance found, and (n,). told: a list
    that gets the lights which it warns of.
    """
    shining = [light for light in lights if shines(light)]
    if not shining:
        return False
    told = [] if told is None else told
    direct = direct.sum(axis=1)
    total = areas.sum()
    fronts = areas @ direct / total if total > 0.0 else 0.0
    if fronts > HARDLY_LIT * direct.max():
        told += _warn_of_lamps_on_backs(lights, surfels)
        return False
    asked = _drawn_by_area(surfels.areas)
    if fronts > ON_FRONTS * (fronts + _light_unoccluded(surfels, asked, shining, -1.0)):
        told += _warn_of_lamps_on_backs(lights, surfels)
        return False
    backs = _light_on_backs(surfels, asked, shining)
    if fronts < ON_FRONTS * (fronts + backs):
        what = "none of it" if fronts == 0.0 else f"only {fronts / (fronts + backs):.2%} of it"
        warn(
            f"the scene's lights shine on backs of surfels, and {what} reaches fronts: normals face away from the "
            f"lights ({TURN}), or the lights stand outside of closed walls{_of_units(shining, surfels)}"
        )
    elif fronts == 0.0:
        warn(f"none of the scene's lights reaches a surfel: they shine past all of them{_of_units(shining, surfels)}")
    else:
        return False
    told += shining
    return True


def _of_units(lights, surfels):
    """What may be wrong with places of lights as far from the surfels as units are from each other; else nothing."""
    low, high = surfels.positions.min(axis=0), surfels.positions.max(axis=0)
    places = [light.position for light in lights if hasattr(light, "position")]
    places += [light.corner for light in lights if hasattr(light, "corner")]
    width = np.linalg.norm(high - low) + 2.0 * surfels.radii.max()
    times = max((np.linalg.norm(place - np.clip(place, low, high)) / width for place in places), default=0.0)
    return f", or are in other units: {times:.0f} times as far away as the scene is wide" if times > FAR else ""


def _warn_of_lamps_on_backs(lights, surfels):
    """Warns, lamp by lamp, where all that it lights are backs, which light of a sky from below may hide: of which ones.

    Of surfels that face the ground fronts count as they are lit; of others as they would be with nothing in between,
    where rooms and bodies have as much on fronts as on backs, wherever the lamp stands.
    What faces one way and not down, as a facade or one side of a roof, a sun may well stand behind.
    """
    asked = _drawn_by_area(surfels.areas)
    facing = surfels.normals[asked].mean(axis=0)
    down = facing[2] < -ONE_WAY
    least = ON_FRONTS_FACING_DOWN if down else ON_FRONTS
    told = []
    if np.linalg.norm(facing) > ONE_WAY and not down:
        return told
    for light in lights:
        if isinstance(light, Environment) or not shines(light):
            continue
        fronts = _light_of(surfels, asked, [light]) if down else _light_unoccluded(surfels, asked, [light], 1.0)
        backs = _light_unoccluded(surfels, asked, [light], -1.0)  # soon found; so are most lamps done with
        if fronts < least * backs and fronts < least * (backs := _light_on_backs(surfels, asked, [light])):
            alone = "alone" if fronts < ON_FRONTS * backs else "nearly alone"
            warn(f"{light!r} shines on backs of surfels {alone}: normals face away from it ({TURN})")
            told.append(light)
    return told


def warn_of_power_into_backs(figures):
    """Warns where backs absorb much of the power; figures: of a history's last iteration."""
    share = figures["power_into_backs"] / max(figures["power_in"], np.finfo(float).tiny)
    if share > MUCH_INTO_BACKS:
        warn(
            f"backs of surfaces absorb {share:.0%} of the light: some face the wrong way, should be two_sided, or are "
            "clouds that lie back to back (surflux check tells which faces point inwards); or points are so noisy that "
            "disks stand out of the surface, which fewer points help against (--points, thinned)"
        )


def warn_of_noise(core):
    """Warns where disks that stand out of their surface are in each other's way. core: the compiled scene."""
    surfels = core.surfels
    is_disk = np.ones(len(surfels), bool)
    is_disk[surfels.triangle_surfel] = False
    disks = np.flatnonzero(is_disk)
    if len(disks) == 0:
        return
    asked = disks[np.unique(np.linspace(0, len(disks) - 1, ASKED).astype(np.int64))]
    of, weights, met, front, away = seen_from_fronts(core, asked, NOISE_RAYS)
    stopped = (met >= 0) & ~front & is_disk[met] & (away < CLOSE * surfels.radii[asked[of]])
    share = weights[stopped].sum() / weights.sum()
    if share > MUCH_ONTO_BACKS:
        warn(
            f"{share:.0%} of what disks see are backs of others close by, which shade them: points are so few that "
            "disks reach past edges, which more points help against, or so noisy, or scans of one surface so far "
            "apart, that disks stand out of it, which fewer points help against (--points, thinned)"
        )


def warn_of_lost_power(figures, by, error=0.0):
    """Warns where much of the power, beyond 3 of its standard errors, is made or lost; figures: as above, of all
    reflections. by: what found the light."""
    lost = figures["power_lost"]
    if abs(lost) > max(MUCH_LOST * figures["power_in"], 3.0 * error):
        share = abs(lost) / max(figures["power_in"], np.finfo(float).tiny)
        warn(
            f"{share:.1%} of the light is {'lost' if lost > 0.0 else 'made'} by the {by}: more rays help, more points "
            "where a cloud is coarse, and its own areas where others were given"
        )


def warn_of_no_arrival(power, direct):
    """Warns where light whose power is any numbers does not arrive directly: direct is (n, 3), of all surfels."""
    if np.any(power) and not np.any(direct):
        warn(f"none of the light reaches the front of a surfel: walls are closed, or normals face away ({TURN})")


def _drawn_by_area(areas):
    shares = np.cumsum(areas)
    return np.searchsorted(shares, (np.arange(ASKED) + 0.5) / ASKED * shares[-1])


def _light_unoccluded(surfels, asked, lights, side):
    """Mean direct irradiance, channels added up, of the asked of the surfels were nothing in between: of their fronts
    (side 1) or backs (-1).
    """
    points, normals = surfels.positions[asked], side * surfels.normals[asked]
    alone = make_core(points[:1], normals[:1], surfels.radii[asked[:1]])  # no obstacle to any other
    return _mean_of(alone, lights, points, normals)


def _light_of(surfels, asked, lights):
    """Mean direct irradiance, channels added up, of the asked of the surfels."""
    return _mean_of(surfels, lights, surfels.positions[asked], surfels.normals[asked])


def _light_on_backs(surfels, asked, lights):
    """Mean direct irradiance, channels added up, of the asked of the surfels turned round."""
    turned = replaced(surfels, normals=-surfels.normals, triangles=surfels.triangles[:, ::-1])
    return _mean_of(turned, lights, surfels.positions[asked], -surfels.normals[asked])


def _mean_of(obstacles, lights, points, normals):
    scene = _core.Scene([obstacles], [light._to_core() for light in lights])
    return _core.direct_at(scene, points, normals, RAYS, 0, None).sum(axis=1).mean()
