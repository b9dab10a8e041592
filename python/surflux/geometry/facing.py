"""The side from which the points of a cloud are seen, and which of them face the other one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core
from surflux._base import check
from surflux._base.passes import stage, watched
from surflux._base.types import Floats, Points, Progress

_SMALLEST, _RAYS = 20, 8  # points of a sheet or patch; rays from each side of up to 2000 points of a sheet
_LOOKED_AT = 60_000  # places, drawn at random; the other points follow those beside them
_BODY, _ROOM = 0, 1  # kinds of sheets in the core
_TANGLED, _FEW = 0.002, 0.05  # as in the core: more links contradict the sides of a sheet, and more of it faces back
# An open sheet of a scan that is right may have less light in front by so much: walls of rooms up to .1, all that a
# depth camera saw of an office .08. A statue that lacks its back, turned inside out, has .2 less.
_AGAINST = -0.15
_REACH = 1e6  # extents of the points, beyond which a place sees them as one point


@dataclass(frozen=True, eq=False)
class Facing:
    """What `facing` finds, as arrays of one entry for each point; equal to itself alone.

    Attributes:
        turned: (n,) booleans: faces the side from which its sheet is not seen.
        room: (n,) booleans: in a sheet that closes around bodies, or a place in `seen_from`, and is seen from inside.
        inside_out: (n,) booleans: turned, with all or most of a closed sheet.
        open: (n,) booleans: in a sheet that both sides of are seen, as of a scan from one side, or in none; what most
            of the sheet face counts as right.
        margin: (n,) of the light from all around, how much more comes to the side that most of its sheet faces: 1 for
            all of it, -1 for the other side. 0 where normals say otherwise than the sheet that goes through them, as
            at seams of walls and ground that are coarsely sampled: sides of that are not known.
        bodies: (n,) the same of rays that meet bodies from outside: what faces those is in the air, as they are.
        unsure: (n,) booleans: on a line along which normals change sides, of a sheet of which neither its normals nor
            rays tell which side of the line is right.
    """

    turned: NDArray[np.bool_]
    room: NDArray[np.bool_]
    inside_out: NDArray[np.bool_]
    open: NDArray[np.bool_]
    margin: Floats
    bodies: Floats
    unsure: NDArray[np.bool_]

    @property
    def against(self) -> NDArray[np.bool_]:
        """(n,) booleans: in an open sheet that faces, by its margin, the side from which it is seen less."""
        return self.open & (self.margin < _AGAINST)


def facing(
    points: Points,
    normals: ArrayLike,
    *,
    seen_from: ArrayLike | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = False,
) -> Facing:
    """Which points of a cloud have normals that face the side from which they are not seen.

    Points whose normals continue each other, but for their sign, make a sheet. Rays from both sides of it vote, as
    for facets of meshes (Takayama and others 2014): from outside of a body they leave the scene, or meet other bodies.
    A sheet that closes around bodies is a room. In a sheet the patches that face elsewhere than most are turned, where
    the normals on their borders say so with one voice.

    Where normals of a closed sheet contradict one another, as in folds that are thinner than points are apart, rays
    from each patch of one mind tell which side of it is seen.

    A closed room with nothing in it, and no place in seen_from, is taken for a body. Of open sheets nothing is
    turned but such patches; of those that are no surface, as leaves, or walls thinner than points are apart, nothing;
    nor points at one place that face away from each other, as of two-sided sheets.

    Args:
        points: (n, 3).
        normals: (n, 3), of any length but 0.
        seen_from: (3,) or (k, 3), places in the air, as of a scanner or a camera: what closes around one is a room.
        seed: of the rays, and of the 60 000 places that are looked at of more.
        threads: at most this many; None for all.
        progress: True for a bar on stderr, or a callback (done, total) -> bool, where False cancels.

    Returns:
        Facing.

    Raises:
        ValueError: an argument, by name.
        Cancelled: the callback returned False.

    >>> import numpy as np
    >>> import surflux as sf
    >>> d = np.random.default_rng(0).normal(size=(2000, 3))
    >>> d /= np.linalg.norm(d, axis=1, keepdims=True)
    >>> print(sf.facing(d, -d).inside_out.all(), sf.facing(d, d).turned.any())
    True False
    >>> print(sf.facing(d, -d, seen_from=[0, 0, 0.5]).turned.any())  # a room
    False
    """
    points = check.positions("points", points, (None, 3))
    normals = check.unit_vectors("normals", check.finite_array("normals", normals, (len(points), 3)))
    places = np.zeros((0, 3)) if seen_from is None else checked_places("seen_from", seen_from)
    seed = check.seed("seed", seed)
    with watched(threads, progress):
        return facing_of(points, normals, places, seed)


def checked_places(name, value):
    """One place (3,) or several as (k, 3)."""
    array = check.numeric(name, value)
    return check.positions(name, array[None] if array.shape == (3,) else array, (None, 3))


def facing_of(points, normals, places=None, seed=0, estimated=False):
    """The Facing of checked points with unit normals; of those that are `estimated`, signs say nothing."""
    places = np.zeros((0, 3)) if places is None else _within_reach(points, places)
    given = points, normals, places, _SMALLEST, _RAYS, _LOOKED_AT, seed, estimated
    found = _core.facing(*given, progress=stage("facing"))
    sheet, turned = found["sheet"], found["turned"].astype(bool)
    kind, tangled = found["kind"], found["tangled"] > _TANGLED
    # The last entry is of points that are in no sheet.
    is_room = np.append(kind == _ROOM, False)[sheet]
    unknown = tangled & (found["against"] > _FEW) & ~found["settled"].astype(bool)
    is_open = np.append(((kind != _BODY) & (kind != _ROOM)) | unknown, True)[sheet]
    inside_out = turned & np.append(found["backwards"].astype(bool), False)[sheet]
    if not estimated:
        found["margin"] = np.where(unknown, 0.0, found["margin"])
    margin, bodies = (np.append(found[of], 0.0)[sheet] for of in ("margin", "bodies"))
    unsure = found["unsure"].astype(bool) & (not estimated)
    return Facing(turned, is_room & ~is_open, inside_out, is_open, margin, bodies, unsure)


def _within_reach(points, places):
    """Places (k, 3), moved to no farther from the points than _REACH: Embree has no rays from 1e19 extents away."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, reach = 0.5 * (low + high), _REACH * np.max(high - low)
    if not (reach > 0.0 and len(places)):
        return places
    way = places - middle
    farthest = np.abs(way).max(axis=1, keepdims=True)
    return np.where(farthest > reach, middle + way * (reach / np.maximum(farthest, reach)), places)
