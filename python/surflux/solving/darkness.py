"""Why a scene stays dark: no light, none that arrives, or light that falls on backs."""

import numpy as np

from surflux import _core
from surflux._base.warn import warn
from surflux.geometry.cores import make_core, replaced
from surflux.scenes.lights import Environment, power_name
from surflux.solutions.fields import RAYS

# A mean of direct irradiance below this share of its maximum makes it worth looking at backs. Closed scans leak a
# little: turned inside out, they are lit here and there.
HARDLY_LIT = 0.02
# Of the direct light that fronts and backs get, what fronts get: below this share it is said.
ON_FRONTS = 0.01
# Surfels whose backs are looked at, drawn by area; 100 of them tell a hundredth.
ASKED = 2000
TURN = "Surfels.flipped() turns them, viewpoint= orients estimated ones, `surflux check` says which"


def warn_of_darkness(scene, core, result):
    """Warns where (next to) no light reaches the fronts of surfels; whether that makes the whole scene dark.

    core: the compiled scene. result: what the solver of _core found there.
    """
    emits = any(np.any(s.emission) for s in scene.objects)
    shining = [light for light in scene.lights if _shines(light)]
    if not shining:
        if not emits:
            what = "the scene's lights have no power" if scene.lights else "the scene has no lights"
            warn(f"{what} and nothing in it emits: all of it stays black")
        return not emits
    direct = result["direct"].sum(axis=1)
    areas = result["surfels"].areas
    total = areas.sum()
    fronts = areas @ direct / total if total > 0.0 else 0.0
    if fronts > HARDLY_LIT * direct.max():
        return False
    asked = _drawn_by_area(core.surfels.areas)
    if fronts > ON_FRONTS * (fronts + _light_on_backs(core.surfels, asked, shining, blocked=False)):
        return False
    backs = _light_on_backs(core.surfels, asked, shining, blocked=True)
    if fronts < ON_FRONTS * (fronts + backs):
        what = "none of it" if fronts == 0.0 else f"only {fronts / (fronts + backs):.2%} of it"
        warn(
            f"the scene's lights shine on backs of surfels, and {what} reaches fronts: normals face away from the "
            f"lights ({TURN}), or the lights stand outside of closed walls"
        )
    elif fronts == 0.0:
        warn("none of the scene's lights reaches a surfel: they shine past all of them")
    else:
        return False
    return not emits


def warn_of_no_arrival(lights, direct):
    """Warns where lights have power, and nothing of it arrives directly: direct is (n, 3) irradiance of all surfels."""
    if not np.any(direct) and any(_shines(light) for light in lights):
        warn(
            "none of the lights reaches the front of a surfel: they stand outside of closed walls, shine past all "
            f"surfels, or normals face away from them ({TURN})"
        )


def _shines(light):
    if isinstance(light, Environment):
        return bool(np.any(light.radiance if light.image is None else light.image))
    return bool(np.any(getattr(light, power_name(light))))


def _drawn_by_area(areas):
    shares = np.cumsum(areas)
    return np.searchsorted(shares, (np.arange(ASKED) + 0.5) / ASKED * shares[-1])


def _light_on_backs(surfels, asked, lights, blocked):
    """Mean direct irradiance, channels added up, of the asked of the surfels turned round; if not `blocked`, with
    nothing in between.
    """
    points, normals = surfels.positions[asked], -surfels.normals[asked]
    if blocked:
        turned = replaced(surfels, normals=-surfels.normals, triangles=surfels.triangles[:, ::-1])
    else:  # one surfel that is no obstacle to any other
        turned = make_core(points[:1], normals[:1], surfels.radii[asked[:1]])
    scene = _core.Scene([turned], [light._to_core() for light in lights])
    field = _core.Field(turned, np.zeros(len(turned), np.uint32), [], scene, None)
    return field.direct_at(points, normals, RAYS, 0, None).sum(axis=1).mean()
