"""Light that falls on backs straight from lamps and suns: how much of it, of which lamps, on which objects."""

import numpy as np

from surflux._base import check
from surflux._base.warn import warn
from surflux.scenes.lights import Environment
from surflux.solving.lamp_rays import is_sun, met_by, seen_from_fronts, shines

TURN = "Surfels.flipped() turns them, viewpoint= orients estimated ones, `surflux check` says which"
# Of what the light of a lamp meets, backs: above this share it is said.
ON_BACKS = 0.5
LAMP_RAYS = 256  # which tell that
# Rays that tell how much light of it backs take, of which objects: of a lamp, and of all together.
RAYS, ALL_RAYS = 16384, 262144
# Of the light of lamps that an object gets, what its backs take: above this share it is said. Coarse clouds have some
# 8 % at edges, a scanned lion 12 % through its holes.
MUCH_ON_BACKS = 0.2
# The same, and of suns, where it is plain that backs are not meant, as those of a room or of one wall are: where as
# large a part of what their fronts see is backs, as in a part of a body that is turned inside out.
ENCLOSED_ON_BACKS, ENCLOSED = 0.03, 0.35
LEAST_RAYS = 8  # on backs of an object, which chance may put there else
ASKED, FRONT_RAYS = 512, 32  # backs of each light that are looked at, and rays of each
LISTED = 5  # objects


class LightOnBacks:
    """What lamps and suns of a scene shine on first. Skies are left out: whatever stands free has one behind it.

    Args:
        lights: of the scene.
        core: the compiled scene.
    """

    def __init__(self, lights, core):
        shining = [(k, light) for k, light in enumerate(lights) if not isinstance(light, Environment) and shines(light)]
        each = max(LAMP_RAYS, min(RAYS, ALL_RAYS // max(len(shining), 1)))
        self._core, self._objects = core, np.asarray(core.object)
        self._met = [(k, light, met_by(light, core, each)) for k, light in shining]

    @property
    def share(self):
        """Of what surfels get straight from lamps and suns, on either side, what backs take; None of no such light."""
        power = sum(met.power.sum() for _, _, met in self._met)
        return float(sum(met.power[met.on_backs].sum() for _, _, met in self._met) / power) if power > 0.0 else None

    def warn(self, told):
        """Warns of lamps in bodies, and of objects whose backs take much; told: lights of which enough was said."""
        told = [id(light) for light in told]
        rest = []
        for index, light, met in self._met:
            if id(light) in told:
                continue
            if is_sun(light) or met.rays_on_backs <= ON_BACKS:
                rest.append((light, met))
            else:
                warn(_said_of_lamp(index, met, self._objects))
        self._warn_of_objects(rest)

    def _warn_of_objects(self, of_lights):
        """of_lights: pairs of a light and its Met."""
        count = int(self._objects.max(initial=0)) + 1
        power, on_backs, of_lamps, enclosed, lamp_rays, enclosed_rays = np.zeros((6, count))
        for light, met in of_lights:
            of, stands = self._objects[met.surfels], self._are_enclosed(met)
            backs = np.bincount(of, met.power * met.on_backs, count)
            power += np.bincount(of, met.power, count)
            on_backs += backs
            enclosed += np.bincount(of, met.power * stands, count)
            enclosed_rays += np.bincount(of[stands > 0.0], minlength=count)
            if not is_sun(light):
                of_lamps += backs
                lamp_rays += np.bincount(of[met.on_backs], minlength=count)
        by_lamps = (of_lamps > MUCH_ON_BACKS * power) & (lamp_rays >= LEAST_RAYS)
        which = np.flatnonzero(by_lamps | (enclosed > ENCLOSED_ON_BACKS * power) & (enclosed_rays >= LEAST_RAYS))
        if len(which) == 0:
            return
        share = on_backs / np.maximum(power, np.finfo(float).tiny)
        which = which[np.argsort(-on_backs[which], kind="stable")]
        where = ", ".join(f"{share[k]:.0%} on object {k}" for k in which[:LISTED])
        more = f" and more on {len(which) - LISTED} others" if len(which) > LISTED else ""
        warn(
            f"backs take much of what lamps and suns shine on objects: {where}{more}: normals face away from the light "
            f"({TURN}), or what is lit from both sides should be two_sided"
        )

    def _are_enclosed(self, met):
        """(m,) of backs that a ray meets: how many like it there are for each that was looked at, and whose
        front sees backs; 0 of all others.
        """
        backs = np.flatnonzero(met.on_backs)
        out = np.zeros(len(met.on_backs))
        if len(backs) == 0:
            return out
        asked = backs[np.unique(np.linspace(0, len(backs) - 1, ASKED).astype(np.int64))]
        of, weights, found, front, _ = seen_from_fronts(self._core, met.surfels[asked], FRONT_RAYS)
        seen = np.bincount(of, weights * ((found >= 0) & ~front), len(asked)) / np.bincount(of, weights, len(asked))
        out[asked[seen > ENCLOSED]] = len(backs) / len(asked)
        return out


def lamps_in_bodies(lights, core):
    """(number of a lamp that has a place, share of its rays that meet backs, what is wrong in words), of those of most
    of whose rays that is so. core: the compiled scene.
    """
    objects = np.asarray(core.object)
    for index, light in enumerate(lights):
        if isinstance(light, Environment) or is_sun(light) or not shines(light):
            continue
        met = met_by(light, core, LAMP_RAYS)
        if met.rays_on_backs > ON_BACKS:
            yield index, met.rays_on_backs, _said_of_lamp(index, met, objects)


def warn_of_lamps_in_bodies(lights, core, told=()):
    """Warns of those, but for lights of which enough was told."""
    told = [id(light) for light in told]
    for index, _, text in lamps_in_bodies(lights, core):
        if id(lights[index]) not in told:
            warn(text)


def _said_of_lamp(index, met, objects):
    counts = np.bincount(objects[met.surfels[met.on_backs]])
    which = np.argsort(-counts, kind="stable")[: np.count_nonzero(counts)]
    owner = f"object {which[0]}" if len(which) == 1 else f"objects {check.listed(which, LISTED)}"
    return (
        f"lights: of what light {index} shines on {met.rays_on_backs:.0%} are backs of surfels of {owner}: it "
        f"stands inside of a body or outside of closed walls, or normals face away from it ({TURN})"
    )
