"""Transparency of materials, and backs that they have: faces here are opaque, and their backs black."""

import numpy as np

from surflux._base.check import counted
from surflux._base.passes import LOG
from surflux._base.warn import warn
from surflux.geometry.textures import texture_of

_NAMED = 3  # so many names in a warning
_CUTOFF = 0.5  # glTF 2.0, where a material says nothing


def cover_of(material):
    """(256,): what is there of texels of a material of glTF by their alpha, from 0 to 1 (glTF 2.0, 3.9.2).

    None where alpha does not count, as by default.
    """
    mode = getattr(material, "alphaMode", None)
    if mode not in ("MASK", "BLEND"):
        return None
    factor = material.baseColorFactor
    alpha = np.arange(256) / 255.0 * (1.0 if factor is None else np.asarray(factor, np.float64)[3] / 255.0)
    if mode == "BLEND":
        return alpha
    cutoff = getattr(material, "alphaCutoff", None)
    return (alpha >= (_CUTOFF if cutoff is None else cutoff)).astype(np.float64)


def is_clear(material, placed=True):
    """Whether a material of glTF is not opaque somewhere; its texture counts where faces are placed on it."""
    cover = cover_of(material)
    if cover is None:
        return False
    image = material.baseColorTexture if placed else None
    return bool(cover[-1] < 1.0) or (image is not None and texture_of(image, cover).cover is not None)


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
