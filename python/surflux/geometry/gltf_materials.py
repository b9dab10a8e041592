"""Materials of glTF 2.0 as trimesh has them, and what of them it does not read.

Base colours are factor times texture times COLOR_0, all linear (glTF 2.0, 3.9.2). What faces send by themselves is
factor times texture times strength (3.9.4, KHR_materials_emissive_strength): radiance, so that they send pi times as
much.
"""

import json

import numpy as np

from surflux import _core
from surflux._base.color import WHITE
from surflux._base.warn import warn

_UNSIGNED_SHORT = 5123  # a componentType
_TRANSFORM = "KHR_texture_transform"
_STRENGTH = "KHR_materials_emissive_strength"
_LARGEST = 1e30  # of light, as transfers take it


def is_gltf(mesh):
    """Is a mesh or a cloud of trimesh from a glTF file? Its colours are linear then."""
    return "from_gltf_primitive" in (getattr(mesh, "metadata", None) or {})


def linear_reflectance(colors):
    """(n, 3) of COLOR_0 (n, 3 or 4), fractions or normalized integers: white is .98."""
    colors = np.asarray(colors)[:, :3]
    full = 1.0 if colors.dtype.kind == "f" else float(np.iinfo(colors.dtype).max)
    return WHITE * np.clip(colors / full, 0.0, 1.0)


def factor_of(material, of_file=None):
    """(3,): baseColorFactor of a material, which is white where nobody has said anything; None of other materials.

    of_file: factors_of_file of the file that it is from. trimesh keeps 8 bits, linear: of .002 that is the double.
    """
    if not hasattr(material, "baseColorFactor"):
        return None
    factor = material.baseColorFactor
    if factor is None:
        return np.ones(3)
    factor = np.asarray(factor, np.float64)[:3]
    whole = (of_file or {}).get((material.name, _rounded(factor)))
    return factor / 255.0 if whole is None else whole


def exitance_of(material):
    """(3,): what faces of a material send by themselves, before its texture; None where they do not."""
    factor = getattr(material, "emissiveFactor", None)
    return None if factor is None or not np.any(factor) else np.pi * np.asarray(factor, np.float64)


def take_strengths(path, scene):
    """Multiplies the emissiveFactors that trimesh has read of a file by their strengths, which it does not read.

    Materials are told by their names and factors; a FileError names those that are alike but for their strengths.
    """
    strengths = {}
    for material in _header(path).get("materials", ()):
        factor = tuple(material.get("emissiveFactor") or ())
        strength = _of(_of(material, "extensions"), _STRENGTH).get("emissiveStrength", 1.0)
        if not isinstance(strength, (int, float)) or not 0.0 <= strength * max(factor, default=0.0) <= _LARGEST:
            raise _core.FileError(f"{path}: emissiveStrength is {strength}; wanted a finite number of at least 0")
        if any(factor) and strengths.setdefault((material.get("name"), factor), strength) != strength:
            name = material.get("name", "without a name")
            raise _core.FileError(
                f"{path}: materials {name}: alike but for their emissiveStrength; wanted a name of each one's own"
            )
    seen = {}
    for part in getattr(scene, "geometry", {}).values():
        material = getattr(getattr(part, "visual", None), "material", None)
        if exitance_of(material) is not None:
            seen[id(material)] = material
    for material in seen.values():
        factor = material.emissiveFactor
        material.emissiveFactor = factor * strengths.get((material.name, tuple(factor.tolist())), 1.0)


def factors_of_file(path):
    """What factor_of takes of a file: its base colours, by names of materials and by what trimesh keeps of them."""
    factors = {}
    for material in _header(path).get("materials", ()):
        factor = _of(material, "pbrMetallicRoughness").get("baseColorFactor")
        if factor is not None:
            factor = np.clip(np.array(factor[:3], np.float64), 0.0, 1.0)
            factors.setdefault((material.get("name"), _rounded(255.0 * factor)), []).append(factor)
    return {key: alike[0] for key, alike in factors.items() if np.ptp(alike, axis=0).max() == 0.0}


def _rounded(factor):
    return tuple(np.round(factor).astype(int).tolist())


def check_colors(path):
    """What trimesh does not read of a file's base colours, and of what its faces send.

    A warning tells of other texture coordinates than the first, and of transforms; a FileError of colours of 16 bits
    without a material, of which trimesh takes the lower 8.
    """
    header = _header(path)
    for primitive in (one for mesh in header.get("meshes", ()) for one in mesh.get("primitives", ())):
        colors = primitive.get("attributes", {}).get("COLOR_0")
        if colors is None or "material" in primitive:
            continue
        if header["accessors"][colors]["componentType"] == _UNSIGNED_SHORT:
            raise _core.FileError(
                f"{path}: COLOR_0 has 16 bits and no material; wanted floats or 8 bits, or a material"
            )
    left_out = set()
    for material in header.get("materials", ()):
        of_base = _of(_of(material, "pbrMetallicRoughness"), "baseColorTexture")
        for texture in (of_base, _of(material, "emissiveTexture")):
            transform = _of(texture, "extensions").get(_TRANSFORM)
            if transform is not None:
                left_out.add(_TRANSFORM)
            if (transform or {}).get("texCoord", texture.get("texCoord", 0)) != 0:
                left_out.add("texCoord")
    if left_out:
        what = " and ".join(sorted(left_out)) + (" is" if len(left_out) == 1 else " are")
        warn(f"{path}: {what} not read of textures: pictures lie on faces as TEXCOORD_0 has them")


def _of(element, name):
    """The dict that another one has under a name; an empty one where it has none."""
    found = element.get(name)
    return found if isinstance(found, dict) else {}


def _header(path):
    with open(path, "rb") as file:
        start = file.read(20)
        if start[:4] == b"glTF":
            return json.loads(file.read(int.from_bytes(start[12:16], "little")))
        return json.loads(start + file.read())
