"""Materials as glTF files have them."""

import numpy as np

from surflux._base.check import counted
from surflux._base.files import file_error
from surflux._base.warn import warn
from surflux.geometry.gltf_container import numbers
from surflux.geometry.gltf_looks import Material
from surflux.geometry.gltf_textures import Textures
from surflux.geometry.transparency import cover_of

_TRANSFORM = "KHR_texture_transform"
_STRENGTH = "KHR_materials_emissive_strength"
_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_LARGEST = 1e30  # of light, as transfers take it
_ALONE = "factors alone count there"


class Materials:
    """The materials of a Container, each read once; and what of them is not read, for warnings."""

    def __init__(self, path, file):
        self._path, self._file = path, file
        self._textures = Textures()
        self._read = {}
        self._left_out = set()

    def images(self, index):
        """What orders materials so that those of one texture stand together; index: None of none."""
        if index is None:
            return -1, -1
        material = self._file.entry("materials", index)
        return _base(material)[1].get("index", -1), _of(material, "emissiveTexture").get("index", -1)

    def of(self, index):
        """The Material of an index."""
        if index not in self._read:
            self._read[index] = self._material(self._file.entry("materials", index), index)
        return self._read[index]

    def tell(self, unplaced):
        """Warnings of what is not there; unplaced: faces with a texture and without a place on it."""
        lost = list(dict.fromkeys(self._textures.lost))
        if lost:
            more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
            warn(f"{self._path}: texture {lost[0]}{more}; {_ALONE}")
        if unplaced:
            what = "has" if unplaced == 1 else "have"
            faces = counted(unplaced, "face")
            warn(f"{self._path}: {faces} {what} a texture and no place on it (TEXCOORD_0); {_ALONE}")
        if self._left_out:
            what = " and ".join(sorted(self._left_out)) + (" is" if len(self._left_out) == 1 else " are")
            warn(f"{self._path}: {what} not read of textures: pictures lie on faces as TEXCOORD_0 has them")

    def _material(self, material, index):
        name = material.get("name")
        told = f"material {index}" if name is None else f"material {name}"
        factor, of_base = _base(material)
        cover = cover_of(material.get("alphaMode"), factor[3], material.get("alphaCutoff"))
        if _GLOSSINESS in _of(material, "extensions"):
            factor[:3] *= 1.0 - self._specular(_of(material["extensions"], _GLOSSINESS), told)
        exitance = self._exitance(material)
        return Material(
            name,
            np.clip(factor[:3], 0.0, 1.0),
            self._texture(of_base, cover, told),
            exitance,
            None if exitance is None else self._texture(_of(material, "emissiveTexture"), None, told),
            cover,
            material.get("doubleSided") is True,
        )

    def _texture(self, info, cover, told):
        """What reads the texture of a textureInfo, {} of none, of a material that messages call `told`."""
        if not info:
            return None
        transform = _of(_of(info, "extensions"), _TRANSFORM)
        if transform:
            self._left_out.add(_TRANSFORM)
        if transform.get("texCoord", info.get("texCoord", 0)) != 0:
            self._left_out.add("texCoord")
        return self._textures.read(self._file, info, cover, told)

    def _exitance(self, material):
        """(3,): what faces send by themselves, before their texture; None of none."""
        factor = material.get("emissiveFactor")
        factor = np.zeros(3) if factor is None else numbers("emissiveFactor", factor, 3)
        strength = _of(_of(material, "extensions"), _STRENGTH).get("emissiveStrength", 1.0)
        if factor.min() < 0.0:
            raise ValueError(f"emissiveFactor: wanted numbers of at least 0, got {factor.min():g}")
        if type(strength) not in (int, float) or not 0.0 <= strength * factor.max() <= _LARGEST:
            raise file_error(self._path, f"emissiveStrength is {strength}; wanted a finite number of at least 0")
        return np.pi * strength * factor if factor.any() else None

    def _specular(self, material, told):
        """What KHR_materials_pbrSpecularGlossiness takes off diffuse colours: the largest channel of the specular one.

        Of a texture the mean counts.
        """
        factor = numbers("specularFactor", material.get("specularFactor", [1, 1, 1]), 3)
        read = self._texture(_of(material, "specularGlossinessTexture"), None, told)
        if read is not None:
            texture = read()
            factor = factor * texture.linear[texture.pixels].mean(axis=(0, 1))
            warn(f"{self._path}: specularGlossinessTexture of {told} counts by its mean")
        return np.clip(factor.max(), 0.0, 1.0)


def _base(material):
    """(factor (4,), textureInfo) of the base colour, or of the diffuse one in its place."""
    of, name = _of(material, "pbrMetallicRoughness"), "baseColor"
    if _GLOSSINESS in _of(material, "extensions"):
        of, name = _of(material["extensions"], _GLOSSINESS), "diffuse"
    factor = f"{name}Factor"
    return numbers(factor, of.get(factor, [1, 1, 1, 1]), 4), _of(of, f"{name}Texture")


def _of(element, name):
    """The dict that another one has under a name; an empty one where it has none."""
    found = element.get(name)
    return found if isinstance(found, dict) else {}
