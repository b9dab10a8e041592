"""Surfaces that lie in one place: what of them counts once, in words."""

import numpy as np

from surflux._base.check import counted
from surflux._base.warn import warn
from surflux.scenes.shut_off import shut_off

# Of the smaller object's points, and points: where fewer lie closely over another object, the two touch.
_LAYERED, _LEAST = 0.2, 10
# The same where all that is out of the ordinary is asked for.
_LEAST_CHECKED = 1e-3
# Of a patch: what less of it is covered by is where edges meet.
_COVERED = 1e-3


def warn_of_layers(scene):
    """Warns of objects so close over each other that they may be one surface, and of what floats cannot tell apart.

    And of areas that do not fit the disks that have them, and of points of two sides that shut each other off.
    """
    dark = (*_covered_emitters(scene), *_gaps(scene, glowing=True))
    for text in (
        *_layers(scene),
        *dark,
        *_coarse(scene),
        *_unlike_areas(scene),
        *_shut_off(shut_off(scene)),
        *_divided(scene),
    ):
        warn(text)


def coincidence_of(scene):
    """What of a scene coincides: a dict for programs, and lines of text."""
    found = scene._coincidence()
    covered = np.flatnonzero(found.uncovered < 1.0 - _COVERED)
    surfels, lines = scene.surfels, []
    if len(covered):
        center = rounded_for(surfels)(surfels.points[covered].mean(axis=0))
        area = float((surfels.areas * (1.0 - found.uncovered)).sum()) if surfels.areas is not None else None
        size = "" if area is None else f" ({area:.3g} of area)"
        many = "1 patch coincides" if len(covered) == 1 else f"{len(covered)} patches coincide"
        lines.append(f"{many} with later ones that face the same way{size}, around ({center}): counted once")
    for one, other, joined, _, _ in found.overlaps:
        if joined:
            lines.append(f"objects {one} and {other} are one surface at {counted(joined, 'point')}, which count once")
    lines += [*_layers(scene, _LEAST_CHECKED), *_covered_emitters(scene), *_gaps(scene)]
    shut = shut_off(scene)
    lines += [*_coarse(scene), *_unlike_areas(scene), *_shut_off(shut), *_divided(scene)]
    overlaps = [dict(zip(("one", "other", "joined", "layered", "height"), o, strict=True)) for o in found.overlaps]
    names = ("mesh", "other", "points", "area", "share", "height")
    sheets = [dict(zip(names, s, strict=True)) for s in found.close_sheets]
    gaps = [dict(zip(("one", "other", "area", "width"), g, strict=True)) for g in found.gaps]
    coarse = [dict(zip(("object", "surfels", "contact"), c, strict=True)) for c in found.coarse]
    unlike = [dict(zip(("object", "ratio"), u, strict=True)) for u in found.unlike_areas]
    lists = {"overlaps": overlaps, "close_sheets": sheets, "gaps": gaps, "coarse": coarse, "unlike_areas": unlike}
    lists["shut_off"] = [dict(zip(("object", "points", "by"), s, strict=True)) for s in shut]
    return {"covered": len(covered), **lists}, lines


def rounded_for(surfels):
    """Point -> text, with digits down to about a thousandth of the size of all surfels."""
    size = float(np.linalg.norm(np.ptp(surfels.bounds, axis=0)))
    decimals = max(0, 3 - int(np.ceil(np.log10(size)))) if size > 0.0 else 3
    return lambda point: ", ".join(f"{round(x, decimals) + 0.0:.{decimals}f}" for x in point)


def _layers(scene, least=_LAYERED):
    yield from _close_sheets(scene, least)
    for one, other, _, layered, height in scene._coincidence().overlaps:
        if layered >= max(_LEAST, least * min(len(scene.objects[one]), len(scene.objects[other]))):
            yield (
                f"objects {one} and {other}: {layered} points of them lie some {height:.2g} over or under "
                "the other's, facing the same way, which is more than their noise: taken as two sheets, of which the "
                "lower gets no light. If they are scans of one surface, register them more closely"
            )


def _close_sheets(scene, least):
    for mesh, other, points, area, share, height in scene._coincidence().close_sheets:
        if points and points < _LEAST:
            continue
        if max(share, points / len(scene.objects[other])) < least:
            continue
        what = f"{points} points" if points else "faces"
        who = f"object {mesh}: {what}" if mesh == other else f"objects {mesh} and {other}: {what} of object {other}"
        yield (
            f"{who} lie some {height:.2g} {'over or under' if points else 'over'} the mesh of object {mesh}, facing "
            f"the same way, on {area:.3g} of its area: taken as two sheets, of which the lower gets no light. If they "
            "are one surface, leave one of them out"
        )


def _covered_emitters(scene):
    """Patches that emit more than later ones in the same place, which are what is seen."""
    found = scene._coincidence()
    covers = np.asarray(found.covers, np.int64).reshape(-1, 2)
    covers = covers[found.uncovered[covers[:, 0]] < 1.0 - _COVERED]
    if len(covers) == 0:
        return
    emission = np.concatenate([s.emission for s in scene.objects])
    covers = covers[(emission[covers[:, 0]] > emission[covers[:, 1]]).any(axis=1)]
    objects = np.repeat(np.arange(len(scene.objects)), [len(s) for s in scene.objects])[covers]
    for one, other in np.unique(objects, axis=0):
        patches = np.unique(covers[(objects == (one, other)).all(axis=1), 0])
        yield (
            f"object {one}: {counted(len(patches), 'patch', 'patches')} of it that emit light lie in one place with "
            f"later faces of {'it' if one == other else f'object {other}'}, which are what is seen: light is lost "
            "there. Put what glows last, or leave out what covers it"
        )


def _gaps(scene, glowing=False):
    """Gaps that rays cannot see. Next to no light comes in from their edges: what lacks is what a side emits."""
    for one, other, area, width in scene._coincidence().gaps:
        if glowing and not any(scene.objects[k].emission.any() for k in (one, other)):
            continue
        who = f"object {one}: faces of it" if one == other else f"objects {one} and {other}: faces of them"
        yield (
            f"{who} stand {width:.2g} apart, facing each other, on {area:.3g} of their area, closer than rays can tell "
            "apart in a scene of this size: they may exchange no light. Move them apart, make them touch, or make a "
            "scene of them"
        )


def _coarse(scene):
    for which, surfels, contact in scene._coincidence().coarse:
        yield (
            f"object {which}: {counted(surfels, 'surfel')} so far from the middle of the scene, or so small, that "
            f"rays take all within up to {contact:.2g} of them for touching, more than their radius: they exchange no "
            "light with what is as close. Leave out what is far away, or make a scene of it"
        )


def _unlike_areas(scene):
    for which, ratio in scene._coincidence().unlike_areas:
        yield (
            f"object {which}: by their areas, its disks that emit send {ratio:.3g} times what rays meet of them: light "
            "that is found by areas (pairs, powers) and light that is found by rays differ by as much. Give such lamps "
            "as meshes, or by more points"
        )


def _shut_off(found):
    for which, points, by in found:
        beneath = "others that face them" if by == which else f"object {by}, which faces them"
        end = "Give one side" if by == which else "Where the two are the sides of one sheet, give one"
        yield (
            f"object {which}: {counted(points, 'point')} of it lie beneath {beneath}, as where both sides "
            f"of a sheet are sampled apart from each other: they get no light. {end}, with two_sided=True"
        )


def _divided(scene):
    for which, patches in enumerate(scene._count_divided()):
        if patches:
            yield (
                f"object {which}: walls of other objects stand on {counted(patches, 'patch', 'patches')} of it, "
                "each with one value for both sides. surflux.divide_patches(objects) cuts them there"
            )
