"""Where light goes, found by rays of the test's own: drawn here, and followed by the tracer alone."""

import numpy as np
from scipy import stats

from surflux import _core

CONTACT = 1e-6  # of the scene's diagonal: what faces a surfel and is nearer covers it


def starts(surfels, uv, alone=0.0):
    """Points of each surfel for uv (n, k, 2): anywhere on a patch; of a disk its centre, which lies on the surface.

    A disk that stands alone (n,) is a surface of its own: anywhere on it.
    """
    points = np.repeat(surfels.points[:, None], uv.shape[1], axis=1)
    radius = np.sqrt(alone * surfels.areas / np.pi)[:, None] * np.sqrt(uv[..., 0])
    points += in_frame(surfels.normals, radius, 2 * np.pi * uv[..., 1], 0.0)
    owner, triangles = surfels.triangle_surfel, surfels.triangles
    if len(owner):
        a, e, f = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        size = np.linalg.norm(np.cross(e, f), axis=1)
        for i in np.unique(owner):
            mine = np.flatnonzero(owner == i)
            share = np.cumsum(size[mine]) / size[mine].sum()
            t = np.minimum(np.searchsorted(share, uv[i, :, 0], side="right"), len(mine) - 1)
            low = np.r_[0.0, share][t]
            root = np.sqrt((uv[i, :, 0] - low) / (share[t] - low))[:, None]
            t, v = mine[t], uv[i, :, 1, None]
            inside = a[t] + root * (1 - v) * e[t] + root * v * f[t]
            # A hair from the rim: on it, single precision puts some starts behind the next wall.
            points[i] = inside + 1e-5 * (surfels.points[i] - inside)
    return points


def in_frame(normals, radius, angle, height):
    """(n, k, 3) vectors by cylindrical coordinates (n, k) around n normals."""
    aside = np.where(np.abs(normals[:, :1]) < 0.6, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(normals, aside)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(normals, u)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return (
        x[..., None] * u[:, None]
        + y[..., None] * v[:, None]
        + np.multiply(height, np.ones_like(x))[..., None] * (normals[:, None])
    )


def fates(core, surfels, rays, seed, alone):
    """Of the light of each surfel, the shares (n,) that leave the scene and that end on a back or under a cover."""
    n = len(surfels)
    random = np.random.default_rng(seed)
    even = stats.qmc.Sobol(4, rng=random).random(rays)
    uv = (even[None] + random.random((n, 1, 4))) % 1.0
    sine = np.sqrt(uv[..., 0])
    directions = in_frame(surfels.normals, sine, 2 * np.pi * uv[..., 1], np.sqrt(1 - uv[..., 0]))
    points = starts(surfels, uv[..., 2:], alone)
    met, front, distance = _core.closest_hits(
        core, np.repeat(np.arange(n), rays), points.reshape(-1, 3), directions.reshape(-1, 3)
    )
    diagonal = np.linalg.norm(np.ptp(np.concatenate([surfels.points, surfels.triangles.reshape(-1, 3)]), axis=0))
    facing = np.einsum("ni,ni->n", np.repeat(surfels.normals, rays, axis=0), surfels.normals[met]) < -0.5
    covered = (distance <= CONTACT * diagonal) & facing
    escaped, absorbed = met < 0, (met >= 0) & (~front.astype(bool) | covered)
    return escaped.reshape(n, rays).mean(axis=1), absorbed.reshape(n, rays).mean(axis=1)


def unaccounted(scene, solution, rays=1024, batches=8, seed=71):
    """What was emitted and neither absorbed nor seen to leave, as a share of what was emitted; its standard error."""
    s = solution.surfels
    core = scene._to_core()
    alone = np.concatenate([np.full(len(o), len(o) == 1 and not len(o.triangles)) for o in scene.objects])
    emitted = (s.areas[:, None] * (s.emission + solution.direct)).sum()
    absorbed = (s.areas[:, None] * (1 - s.reflectance) * solution.irradiance).sum()
    power = s.areas * solution.radiosity.sum(axis=1)
    left = []
    for batch in range(batches):
        escaped, ended = fates(core, s, rays // batches, [seed, batch], alone)
        left.append((emitted - absorbed - (power * (escaped + ended)).sum()) / emitted)
    return np.mean(left), np.std(left, ddof=1) / np.sqrt(batches)
