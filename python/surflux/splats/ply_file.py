"""PLY files of Gaussians, as the program of Kerbl and others 2023 writes and reads them.

https://github.com/graphdeco-inria/gaussian-splatting, scene/gaussian_model.py: logarithms of the standard deviations,
opacities before the logistic function, quaternions (w, x, y, z), and harmonics channel by channel: f_rest_0 is the
first one of degree 1 for red, f_rest_15 that for green. Its viewer takes the columns by their order.
"""

import numpy as np

from surflux import _core
from surflux._base import check
from surflux._base.files import file_error, require_file
from surflux.geometry.rotation import rotation_matrices
from surflux.points.writing import pack_comments, unpack_comments
from surflux.splats.origins import to_origin

_LEAST, _MOST = float(np.finfo(np.float32).tiny), 0.9999 * check.LARGEST  # scales whose logarithms are floats
_CERTAIN = 2.0**-24  # opacities this close to 0 and 1 have logits of -16.6 and 16.6, for infinite ones

PLACES, NORMALS = ("x", "y", "z"), ("nx", "ny", "nz")
FIRST = ("f_dc_0", "f_dc_1", "f_dc_2")
SCALES = ("scale_0", "scale_1", "scale_2")
TURNS = ("rot_0", "rot_1", "rot_2", "rot_3")


def write_ply(path, gaussians):
    """Writes Gaussians whose colours are sRGB-coded; raises FileError."""
    g, n = gaussians, len(gaussians)
    positions, origin = to_origin(g.positions, g.scales)
    # Other programs have zeros here; the thinnest axis, which of surfels is the normal, lights a plain point cloud.
    turned = rotation_matrices(g.rotations.astype(np.float32).astype(np.float64))
    normals = np.take_along_axis(turned, g.scales.argmin(axis=1)[:, None, None], axis=2)[:, :, 0]
    rest = g.harmonics[:, 1:].transpose(0, 2, 1).reshape(n, -1)
    opacity = np.clip(g.opacities, _CERTAIN, 1.0 - _CERTAIN)
    columns = [
        *zip(PLACES, positions.T, strict=True),
        *zip(NORMALS, normals.T, strict=True),
        *zip(FIRST, g.harmonics[:, 0].T, strict=True),
        *((f"f_rest_{i}", column) for i, column in enumerate(rest.T)),
        ("opacity", np.log(opacity / (1.0 - opacity))),
        *zip(SCALES, np.log(np.clip(g.scales, _LEAST, _MOST)).T, strict=True),
        *zip(TURNS, g.rotations.T, strict=True),
    ]
    vertex = [(name, "float", np.ascontiguousarray(column, np.float64)) for name, column in columns]
    about = {"gaussians": 1} | ({"origin": origin.tolist()} if origin.any() else {})
    _core.write_ply(path, [("vertex", n, vertex)], None, pack_comments(about))


def read_ply(path):
    """(positions, scales, rotations, opacities, harmonics, "srgb") of a file; raises FileError."""
    require_file(path)
    ply = _core.read_ply(path, ["vertex"])
    columns = ply["columns"].get("vertex", {})
    for name in (*PLACES, *FIRST, "opacity", *SCALES, *TURNS):
        if name not in columns:
            raise file_error(path, f"holds no Gaussians: its vertices have no {name}")
    n = ply["elements"]["vertex"]
    if n == 0:
        raise file_error(path, "holds no Gaussians: it has no vertices")
    more = sum(name.startswith("f_rest_") for name in columns)
    if more not in (0, 9, 24, 45) or any(f"f_rest_{i}" not in columns for i in range(more)):
        raise file_error(path, f"has {check.counted(more, 'property', 'properties')} f_rest_; wanted 0, 9, 24 or 45")
    first = _stacked(columns, FIRST)[:, None]
    rest = _stacked(columns, [f"f_rest_{i}" for i in range(more)]).reshape(n, 3, more // 3)
    origin = unpack_comments(ply["comments"], path).get("origin", [0.0, 0.0, 0.0])
    try:
        positions = _stacked(columns, PLACES) + check.positions("origin", origin)
    except ValueError as fault:
        raise file_error(path, str(fault)) from fault
    with np.errstate(over="ignore"):  # infinity is refused as such
        scales = np.exp(_stacked(columns, SCALES))
        opacities = 1.0 / (1.0 + np.exp(-columns["opacity"]))
    harmonics = np.concatenate([first, rest.transpose(0, 2, 1)], axis=1)
    return positions, scales, _stacked(columns, TURNS), opacities, harmonics, "srgb"


def _stacked(columns, names):
    n = len(next(iter(columns.values())))
    return np.stack([columns[name] for name in names], axis=-1) if names else np.zeros((n, 0))
