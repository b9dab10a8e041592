"""Small PLY files and surfels for tests."""

import numpy as np

from surflux import _core


def write(path, header, rows=()):
    """An ascii PLY; a header line such as `vertex 3: float x y z, uchar red` stands for an element."""
    lines = ["ply", "format ascii 1.0"]
    for line in header:
        name, _, properties = line.partition(":")
        lines.append(f"element {name}")
        for group in filter(None, properties.split(",")):
            kind, *names = group.split()
            lines += [f"property {kind} {n}" for n in names]
    lines += ["end_header", *rows]
    path.write_text("\n".join(lines) + "\n")
    return path


def core_surfels(points, *, radii=1.0, areas=None, reflectance=0.5, emission=0.0, triangles=(), triangle_surfel=()):
    n = len(points)
    return _core.Surfels(
        np.asarray(points, dtype=np.float64),
        np.tile([0.0, 0.6, 0.8], (n, 1)),
        np.broadcast_to(np.asarray(radii, dtype=np.float64), n),
        areas,
        np.broadcast_to(np.asarray(reflectance, dtype=np.float64), (n, 3)),
        np.broadcast_to(np.asarray(emission, dtype=np.float64), (n, 3)),
        np.asarray(triangles, dtype=np.float64).reshape(-1, 3, 3),
        np.asarray(triangle_surfel, dtype=np.uint32),
    )
