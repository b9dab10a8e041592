"""glTF files of Gaussians, written."""

import numpy as np

from surflux._base.color import srgb_to_linear
from surflux.scans.gltf import Primitive, placed, write_primitives
from surflux.splats import gltf_format as gltf
from surflux.splats.origins import to_origin
from surflux.splats.view_colors import even_color


def write_gltf(path, gaussians, up):
    """Writes Gaussians, .glb or .gltf by the name; `up` (3,), a unit vector, becomes +y by the matrix of the node.

    The arrays are those of the Gaussians, harmonics included: what is written does not depend on up, and comes back as
    it was. Raises FileError.
    """
    positions, origin = to_origin(gaussians.positions, gaussians.scales)
    extensions = {gltf.EXTENSION: {"kernel": "ellipse", "colorSpace": gltf.COLOR_SPACES[gaussians.color_space]}}
    write_primitives(path, [Primitive(_attributes(gaussians, positions), extensions=extensions)], placed(origin, up))


def _attributes(g, positions):
    """{semantic: (n, width) or (n,)} of all that a Gaussian has."""
    color = np.clip(even_color(g.harmonics.astype(np.float32).astype(np.float64)), 0.0, 1.0)
    color = srgb_to_linear(color) if g.color_space == "srgb" else color
    return {
        "POSITION": positions,
        "COLOR_0": np.concatenate([color, g.opacities[:, None]], axis=1),  # linear, whatever the Gaussians are
        gltf.ROTATION: np.roll(g.rotations, -1, axis=1),  # (x, y, z, w)
        gltf.SCALE: g.scales,
        gltf.OPACITY: g.opacities,
        **{name: g.harmonics[:, k] for k, name in enumerate(gltf.harmonics(g.degree))},
    }
