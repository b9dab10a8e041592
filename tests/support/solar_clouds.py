"""Small clouds under the sun, and what tests of `surflux solar` ask of it."""

import numpy as np

import surflux as sf

NOON = "2025-06-21T11:26Z"  # of 8.5 east, by mean solar time
FEW = "--sun-step", 10, "--no-image", "--no-sky-view"
PLACE = "--place", "47.4,8.5"


def plane(path="plane.npz", size=40.0, count=35, tilt=0.0, **columns):
    """A square of points, level or tilted to the south by so many degrees; centres are those of a grid."""
    at = (np.arange(count) + 0.5) / count * size - size / 2
    x, y = (axis.ravel() for axis in np.meshgrid(at, at))
    b = np.radians(tilt)
    if tilt:
        columns["normals"] = np.tile([0.0, -np.sin(b), np.cos(b)], (count**2, 1))
    np.savez(path, points=np.stack([x, np.cos(b) * y, np.sin(b) * y], axis=1), **columns)
    return path


def layers(path="layers.npz", kinds=(2, 5)):
    """A level square, and a smaller one of another class 4 above its middle: (points, whether they are its own)."""
    low = np.load(plane("low.npz"))["points"]
    high = np.load(plane("high.npz", size=10.0, count=12))["points"] + [0.0, 0.0, 4.0]
    points = np.concatenate([low, high])
    upper = np.arange(len(points)) >= len(low)
    mixed = np.random.default_rng(0).permutation(len(points))  # as returns come: not class by class
    points, upper = points[mixed], upper[mixed]
    np.savez(path, points=points, classification=np.where(upper, kinds[1], kinds[0]).astype(np.uint8))
    return points, upper


def town(seed):
    """Sixteen flat roofs of 900 points, 4 to 30 high, on level ground, both rough by .03: (Scan, which are roofs)."""
    rng = np.random.default_rng(seed)
    at = np.arange(4) * 14.0 - 21.0
    middles = np.stack(np.meshgrid(at, at), axis=-1).reshape(16, 2)
    ground = rng.uniform(-60.0, 60.0, (12_000, 2))
    ground = ground[np.abs(ground[:, None] - middles).max(axis=2).min(axis=1) > 5.0]
    parts = [np.column_stack([ground, np.zeros(len(ground))])]
    for middle in middles:
        parts.append(np.column_stack([middle + rng.uniform(-5.0, 5.0, (900, 2)), np.full(900, rng.uniform(4.0, 30.0))]))
    points = np.concatenate(parts)
    points[:, 2] += rng.normal(0.0, 0.03, len(points))
    mixed = rng.permutation(len(points))
    roof = mixed >= len(ground)
    return sf.Scan(points[mixed], attributes={"classification": np.where(roof, 6, 2)}), roof
