"""Transparency of materials, and backs that they have: faces here are opaque, and their backs black."""

import numpy as np

from surflux._base.check import counted
from surflux._base.passes import LOG
from surflux._base.warn import warn

_NAMED = 3  # so many names in a warning
_CUTOFF = 0.5  # glTF 2.0, where a material says nothing


def cover_of(mode, alpha=1.0, cutoff=None):
    """(256,): what is there of texels of a material of glTF by their alpha, from 0 to 1 (glTF 2.0, 3.9.2).

    None where alpha does not count, as by default.

    Args:
        mode: its alphaMode, or None.
        alpha: of its baseColorFactor.
        cutoff: its alphaCutoff, or None.
    """
    if mode not in ("MASK", "BLEND"):
        return None
    alphas = np.arange(256) / 255.0 * alpha
    return alphas if mode == "BLEND" else (alphas >= (_CUTOFF if cutoff is None else cutoff)).astype(np.float64)


def warn_of_transparency(name, keys, clear):
    """A warning of the faces that a mesh has transparent: by (name of a material, number of its faces)."""
    faces = sum(number for _, number in clear)
    if not faces:
        return
    names = list(dict.fromkeys(material for material, number in clear if number and material))
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    of = f" ({', '.join(names[:_NAMED])}{more})" if names else ""
    these = "this face is" if faces == 1 else "these faces are"
    warn(
        f"{name}: transparency ({keys}) of {counted(faces, 'face')}{of} is left out: {these} opaque; "
        "leave out faces of glass"
    )


def tell_backs(name, mesh, two_sided):
    """Logs that faces of a Mesh have backs in their file, where two_sided gives them none.

    It is no warning, for exporters write that of closed bodies as well.
    """
    if mesh.double_sided and not two_sided:
        faces = counted(mesh.double_sided, "face")
        LOG.info("%s: doubleSided of %s is left out: backs are black (two_sided=True gives them one)", name, faces)
