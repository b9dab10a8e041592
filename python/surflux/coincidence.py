"""Surfaces that lie in one place: what of them counts once, in words."""

import warnings

import numpy as np

from surflux._check import counted

# Of the smaller object's points, and points: where fewer lie closely over another object, the two touch.
_LAYERED, _LEAST = 0.2, 10
# Of a patch: what less of it is covered by is where edges meet.
_COVERED = 1e-3


def warn_of_layers(scene, stacklevel):
    """Warns of objects whose points lie so closely over each other that they may be one surface, scanned twice."""
    for text in _layers(scene):
        warnings.warn(text, UserWarning, stacklevel=stacklevel + 1)


def coincidence_of(scene):
    """What of a scene coincides: a dict for programs, and lines of text."""
    found = scene._find_coincidence()
    covered = np.flatnonzero(found.uncovered < 1.0 - _COVERED)
    surfels, lines = scene.surfels, []
    if len(covered):
        center = ", ".join(f"{x:.6g}" for x in surfels.points[covered].mean(axis=0))
        area = float((surfels.areas * (1.0 - found.uncovered)).sum()) if surfels.areas is not None else None
        size = "" if area is None else f" ({area:.6g} of area)"
        many = "1 patch coincides" if len(covered) == 1 else f"{len(covered)} patches coincide"
        lines.append(f"{many} with later ones that face the same way{size}, around ({center}): counted once")
    for one, other, joined, _, _ in found.overlaps:
        if joined:
            lines.append(f"objects {one} and {other} are one surface at {counted(joined, 'point')}, which count once")
    lines += _layers(scene)
    overlaps = [dict(zip(("one", "other", "joined", "layered", "height"), o, strict=True)) for o in found.overlaps]
    return {"covered": len(covered), "overlaps": overlaps}, lines


def _layers(scene):
    for one, other, _, layered, height in scene._find_coincidence().overlaps:
        if layered >= max(_LEAST, _LAYERED * min(len(scene.objects[one]), len(scene.objects[other]))):
            yield (
                f"objects {one} and {other}: {layered} points of them lie some {height:.2g} over or under "
                "the other's, facing the same way, which is more than their noise: taken as two sheets, of which the "
                "lower gets no light. If they are scans of one surface, register them more closely"
            )
