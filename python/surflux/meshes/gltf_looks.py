"""Materials of glTF 2.0: what faces reflect diffusely, and what they send by themselves.

Base colours are factor times texture times COLOR_0, all linear (glTF 2.0, 3.9.2). What faces send by themselves is
factor times texture times strength (3.9.4, KHR_materials_emissive_strength): radiance, so that they send pi times as
much.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from surflux._base.color import WHITE
from surflux.meshes.texel_means import mean_texels
from surflux.meshes.textures import Texture, TextureUse


class Material(NamedTuple):
    """A material, whoever has read it; textures are None where it has none."""

    name: str | None
    factor: np.ndarray  # (3,) of the base colour, linear
    texture: Callable[[], Texture] | None  # of the base colour
    exitance: np.ndarray | None = None  # (3,): what its faces send by themselves, before its texture; None for 0
    shining: Callable[[], Texture] | None = None  # the texture of that
    cover: np.ndarray | None = None  # (256,), as transparency.cover_of has it
    double_sided: bool = False


def linear_reflectance(colors):
    """(n, 3) of COLOR_0 (n, 3 or 4), fractions or normalized integers: white is .98."""
    colors = np.asarray(colors)[:, :3]
    full = 1.0 if colors.dtype.kind == "f" else float(np.iinfo(colors.dtype).max)
    return WHITE * np.clip(colors / full, 0.0, 1.0)


def looks_of(material, faces, places, colors):
    """What foreign_meshes.triangles takes of a Material on triangles (f, 3) of vertices.

    places: (f, 3, 2) of their corners on its textures, v going up, or None; colors: COLOR_0 of the vertices, or None.
    """
    looks, uses = {}, []

    def of_faces(read, tint, most, shines=False):
        tint = np.broadcast_to(tint, (len(faces), 3))
        if read is None:
            return np.clip(tint, 0.0, most)
        uses.append(TextureUse(np.arange(len(faces)), tint, read, shines=shines, most=most))
        return np.clip(tint * mean_texels(read(), places), 0.0, most)

    texture, shining = (material.texture, material.shining) if places is not None else (None, None)
    if material.cover is not None and (material.cover[-1] < 1.0 or (texture and texture().cover is not None)):
        looks["clear"] = ((material.name, len(faces)),)
    if material.double_sided:
        looks["double_sided"] = len(faces)
    if colors is None:
        looks["of_faces"] = of_faces(texture, material.factor if texture is None else WHITE * material.factor, WHITE)
    elif texture is None:
        looks["reflectance"] = np.clip(material.factor * linear_reflectance(colors), 0.0, WHITE)
    else:
        looks["of_faces"] = of_faces(texture, material.factor * linear_reflectance(colors)[faces].mean(axis=1), WHITE)
    if material.exitance is not None:
        looks["exitance"] = of_faces(shining, material.exitance, np.inf, shines=True)
    if uses:
        looks |= {"places": places.reshape(-1, 2), "textures": tuple(uses)}
    return looks
