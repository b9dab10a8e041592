"""Irradiance of a solution anywhere on surfaces, from what its solver knows."""

from copy import copy
from typing import NamedTuple

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.types import Floats
from surflux._base.warn import warn

FUNCTIONS = 16  # of a basis, for each surfel: where there are more, surfels say too little of the light
MOSTLY = 0.5  # of the rays of a point: where so many end on backs it is said
ENDS = 1 << 18  # of rays at once
END_RAYS = 8  # that sample direct light where one ends: one to each light, about
RAYS = 1024  # of irradiance_at; 256 have four times as much noise through windows


def checked_direct(direct, scene):
    """How direct light of a solution is found, checked; scene: of the solution, or None."""
    return _by_rays("direct", direct, "traced", scene)


def _by_rays(name, how, rays, scene):
    """Argument `name`, checked: "interpolated", or what `rays` says, which needs a scene."""
    check.choice(name, how, ("interpolated", rays))
    if how == rays and scene is None:
        raise ValueError(f'{name}: wanted "interpolated", for a solution from a file has no scene to trace rays in')
    return how


class Evaluation:
    """How light at points is found, checked: of `Solution.irradiance_at`, of which these are arguments."""

    def __init__(self, direct, indirect, rays, seed, solution):
        scene = solution._scene
        self.is_gathered = _by_rays("indirect", indirect, "gathered", scene) == "gathered"
        if self.is_gathered and solution._bounces is not None:
            known = check.counted(solution._bounces, "bounce")
            raise ValueError(f'indirect: wanted "interpolated", for light gathered from {known} would have one more')
        if direct is None:
            direct = "interpolated" if scene is None else "traced"
        self.is_traced = checked_direct(direct, scene) == "traced"
        if self.is_gathered and not self.is_traced:
            raise ValueError('direct: wanted "traced" where indirect light is gathered, got "interpolated"')
        self.rays, self.seed = check.count("rays", rays, 1, 1 << 16), check.seed("seed", seed)


def warn_of_mid_air(on_surface, has_scene):
    """Of points in mid-air, whose irradiance is not what is asked for.

    on_surface: (m,) booleans. has_scene: of the solution, which rays that gather light need.
    """
    off = np.count_nonzero(~on_surface)
    if off:
        where = f"{off} of {check.counted(len(on_surface), 'point')} {'is' if off == 1 else 'are'}"
        gathered = 'indirect="gathered" finds that, or ' if has_scene else ""
        warn(
            f"points: {where} on no surface that faces the way of the normal: irradiance there is that of the nearest "
            f"surfels, which is not that of mid-air; {gathered}reference_irradiance() of the scene"
        )


def _warn_of_backs_around(on_backs):
    """on_backs: (m,) share of the rays of each point that end on backs."""
    few = np.count_nonzero(on_backs > MOSTLY)
    if few:
        where = f"{few} of {check.counted(len(on_backs), 'point')} {'has' if few == 1 else 'have'}"
        warn(
            f"points: {where} mostly backs of surfaces around, which are black and reflect nothing: walls that "
            "face away from a room (Surfels.flipped() turns them), or points inside of a body"
        )


def traced_direct(scene, points, normals, how, callback):
    """(m, 3) irradiance from lights and Environments, by rays; scene: compiled."""
    return _core.direct_at(scene, points, normals, how.rays, how.seed, callback)


def traced_emitted(scene, points, normals, how, callback):
    """The same from small surfels that shine."""
    return _core.emitted_at(scene, points, normals, how.rays, how.seed, callback)


class Light(NamedTuple):
    """Irradiance at surfels, (n, 3) each, by where it comes from."""

    direct: Floats  # lights and Environments
    emitted: Floats | None  # small surfels that shine; None where there are none, or it is not known apart
    others: Floats | None  # all else, which surfels reflect; None where it is not asked for


def light_of(solution):
    """The Light of a solution."""
    others = solution.irradiance - solution.direct
    if solution._emitted is not None:
        others -= solution._emitted
    return Light(solution.direct, solution._emitted, others)


class SurfelField:
    """From values at surfels (Franke and Nielson 1980), each part of a Light by itself."""

    def __init__(self, surfels, objects, light, scene, callback):
        """scene: compiled, or None."""
        others = "surfels" if light.emitted is None else "reflection"
        parts = {"lights": light.direct, "small emission": light.emitted, others: light.others}
        parts = {source: values for source, values in parts.items() if values is not None}
        groups = objects
        if scene is None:
            # What is buried, as the floor below a plinth is, is no neighbour of what is lit beside it. Where light
            # bounces, nothing else is black. With a scene, rays tell.
            bounces = any(np.any(values) for source, values in parts.items() if source != "lights")
            groups = 2 * objects + ((sum(parts.values()) == 0).all(axis=1) & bounces)
        groups = np.asarray(groups, dtype=np.uint32)
        self._sources = list(parts)
        self._traces_emitters = light.emitted is not None and scene is not None and _core.samples_patches_alone(scene)
        self._field = _core.Field(surfels._core, groups, list(parts.values()), scene, callback, self._sources)
        self._scene = scene

    def _from(self, sources, points, normals, callback):
        """What comes from those of the sources that are known apart."""
        found = np.zeros((len(points), 3))
        for k, source in enumerate(self._sources):
            if source in sources:
                found += self._field.at(k, points, normals, callback)
        return found

    def others(self, points, normals, callback):
        """All but direct light."""
        return self._from(("small emission", "surfels", "reflection"), points, normals, callback)

    def direct(self, points, normals, callback):
        return self._from(("lights",), points, normals, callback)

    def irradiance(self, points, normals, how, callback):
        if not how.is_traced:
            return self.others(points, normals, callback) + self.direct(points, normals, callback)
        at = (points, normals, how, callback)
        if how.is_gathered:
            others, on_backs = self._field.gathered(points, normals, how.rays, how.seed, callback)
            _warn_of_backs_around(on_backs)
            return others + traced_emitted(self._scene, *at) + traced_direct(self._scene, *at)
        direct = traced_direct(self._scene, *at)
        if not self._traces_emitters:
            return direct + self.others(points, normals, callback)
        others = self._from(("surfels", "reflection"), points, normals, callback)
        return direct + others + traced_emitted(self._scene, *at)


def light_between(solution, points, normals, callback):
    """(irradiance, direct), (m, 3) each, at places on the surface of a solution, from values at its surfels."""
    scene = None if solution._scene is None else solution._scene._to_core()
    field = SurfelField(solution.surfels, solution.objects, light_of(solution), scene, callback)
    direct = np.asarray(field.direct(points, normals, callback))
    return field.others(points, normals, callback) + direct, direct


class BasisField:
    """From a meshless basis (L07 eq. 9); what is not in the basis, from values at surfels."""

    def __init__(self, basis, scene, surfels, objects, light, lit):
        """scene: compiled. light: at surfels, for places that see no function. lit (n, 3): what of light.direct the
        basis leaves out, as it does light.emitted."""
        self.basis, self.emitted, self.lit = basis, light.emitted, lit
        self.scene, self._at = scene, (surfels, objects)
        self._light = light
        self._surfels = self._rest = self._functions = None

    def pickled(self):
        """What `basis_field` makes it from again, with the solution that it belongs to."""
        return {"functions": self.basis.functions(), "lit": self.lit}

    def _make_surfels(self, callback):
        return SurfelField(*self._at, self._light, self.scene, callback)

    def receivers(self):
        """(points, normals) where light was gathered."""
        functions = self.basis.functions()
        gathered = functions["gathered"] > 0
        return functions["positions"][gathered], functions["normals"][gathered]

    def _are_patches_wide(self):
        """Tells the basis more of the light of surfels than their means?"""
        if self._functions is None:
            self._functions = len(self.basis.functions()["gathered"])
        return self._functions > FUNCTIONS * len(self._at[0])

    def _gathered(self, points, normals, how, callback):
        """What rays find, each where it ends."""
        surfels = self._at[0]
        sent = copy(how)
        sent.is_gathered, sent.rays = False, END_RAYS
        found = np.empty((len(points), 3))
        on_backs = np.empty(len(points))
        step = max(1, ENDS // how.rays)
        for k in range(0, len(points), step):
            part = slice(k, k + step)
            places, on, of, emitted, on_backs[part] = _core.ray_ends(
                self.scene, points[part], normals[part], how.rays, how.seed, callback
            )
            reflected = surfels.reflectance[on] * self.irradiance(places, surfels.normals[on], sent, callback)
            for c in range(3):
                emitted[:, c] += np.bincount(of, reflected[:, c], len(emitted)) / how.rays
            found[part] = emitted
        _warn_of_backs_around(on_backs)
        at = (self.scene, points, normals, how, callback)
        return found + traced_emitted(*at) + traced_direct(*at)

    def at_surfels(self, points, normals, callback=None):
        """From values at surfels, for places that see no function: (all but direct light, direct light)."""
        self._surfels = self._surfels or self._make_surfels(callback)
        return self._surfels.others(points, normals, callback), self._surfels.direct(points, normals, callback)

    def irradiance(self, points, normals, how, callback):
        if how.is_gathered:
            if self._are_patches_wide():
                return self._gathered(points, normals, how, callback)
            self._surfels = self._surfels or self._make_surfels(callback)
            return self._surfels.irradiance(points, normals, how, callback)
        in_basis, direct_in_basis, hidden = self.basis.at(points, normals, callback)
        hidden = hidden != 0
        seen = ~hidden
        total = np.empty_like(in_basis)
        total[seen] = in_basis[seen] + self._beside(points[seen], normals[seen], direct_in_basis[seen], how, callback)
        if hidden.any():
            self._surfels = self._surfels or self._make_surfels(callback)
            total[hidden] = self._surfels.irradiance(points[hidden], normals[hidden], how, callback)
        return total

    def _beside(self, points, normals, direct_in_basis, how, callback):
        """What is to be added to what the basis holds."""
        if how.is_traced and self.emitted is None:
            return traced_direct(self.scene, points, normals, how, callback) - direct_in_basis
        rest = self._rest_of(callback)
        found = rest.irradiance(points, normals, how, callback) if rest else 0.0
        return found - direct_in_basis if how.is_traced else found

    def _rest_of(self, callback):
        if self._rest is None and (self.emitted is not None or np.any(self.lit)):
            rest = Light(self.lit, self.emitted, None)
            self._rest = SurfelField(*self._at, rest, self.scene, callback)
        return self._rest


def basis_field(pickled, solution):
    """The BasisField of a solution that was pickled: the same functions, on its scene compiled anew."""
    scene = solution._scene._to_core()
    basis = _core.MeshlessField(pickled["functions"], scene)
    return BasisField(basis, scene, solution.surfels, solution.objects, light_of(solution), pickled["lit"])
