"""Materials as glTF files have them."""

import numpy as np

from surflux._base.check import counted, listed
from surflux._base.files import file_error
from surflux._base.warn import warn
from surflux.meshes.gltf_container import numbers
from surflux.meshes.gltf_looks import Material
from surflux.meshes.gltf_textures import Textures
from surflux.meshes.transparency import cover_of

_TRANSFORM = "KHR_texture_transform"
_STRENGTH = "KHR_materials_emissive_strength"
_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness"
_LARGEST = 1e30  # of light, as transfers take it
_NAMED = 3  # so many names in a warning
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
        """Warnings of what is not there.

        unplaced: of faces with a texture and without a place on it, (index of their material, how many).
        """
        lost = list(dict.fromkeys(self._textures.lost))
        if lost:
            more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
            warn(f"{self._path}: texture {lost[0]}{more}; {_ALONE}")
        if unplaced:
            number = sum(count for _, count in unplaced)
            names = list(dict.fromkeys(self._name(index) for index, _ in unplaced))
            what = f"{counted(number, 'face')} of {listed(names, _NAMED)} {'has' if number == 1 else 'have'} a texture"
            warn(f"{self._path}: {what} and no place on it (TEXCOORD_0); {_ALONE}")
        if self._left_out:
            what = " and ".join(sorted(self._left_out)) + (" is" if len(self._left_out) == 1 else " are")
            warn(f"{self._path}: {what} not read of textures: pictures lie on faces as TEXCOORD_0 has them")

    def _name(self, index):
        """What messages call a material."""
        return f"material {self._file.entry('materials', index).get('name', index)}"

    def _material(self, material, index):
        told = self._name(index)
        factor, of_base = _base(material)
        cover = cover_of(material.get("alphaMode"), factor[3], material.get("alphaCutoff"))
        gloss = _glossiness(material)
        if gloss is not None:
            factor[:3] *= 1.0 - self._specular(gloss, told)
        exitance = self._exitance(material)
        return Material(
            material.get("name"),
            np.clip(factor[:3], 0.0, 1.0),
            self._texture(of_base, cover, told),
            exitance,
            None if exitance is None else self._texture(_of(material, "emissiveTexture"), None, told),
            cover,
            material.get("doubleSided") is True,
        )

    def _texture(self, info, cover, told):
        """What reads the texture of a textureInfo, None of an empty one, of a material that messages call `told`."""
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
        factor = _factor(material, "emissiveFactor", np.zeros(3))
        strength = _of(_of(material, "extensions"), _STRENGTH).get("emissiveStrength", 1.0)
        if factor.min() < 0.0:
            raise ValueError(f"emissiveFactor: wanted numbers of at least 0, got {factor.min():g}")
        if type(strength) not in (int, float) or not 0.0 <= strength * factor.max() <= _LARGEST:
            raise file_error(self._path, f"emissiveStrength is {strength}; wanted a finite number of at least 0")
        return np.pi * strength * factor if factor.any() else None

    def _specular(self, gloss, told):
        """What KHR_materials_pbrSpecularGlossiness takes off diffuse colours: the largest channel of the specular one.

        Of a texture the mean counts.
        """
        factor = _factor(gloss, "specularFactor", np.ones(3))
        read = self._texture(_of(gloss, "specularGlossinessTexture"), None, told)
        if read is not None:
            texture = read()
            factor = factor * texture.linear[texture.pixels].mean(axis=(0, 1))
            warn(f"{self._path}: specularGlossinessTexture of {told} counts by its mean")
        return np.clip(factor.max(), 0.0, 1.0)


def _base(material):
    """(factor (4,), textureInfo) of the base colour, or of the diffuse one in its place."""
    gloss = _glossiness(material)
    of, name = (_of(material, "pbrMetallicRoughness"), "baseColor") if gloss is None else (gloss, "diffuse")
    return _factor(of, f"{name}Factor", np.ones(4)), _of(of, f"{name}Texture")


def _glossiness(material):
    """The object of a material's specular reflection and glossiness; None without it."""
    found = _of(material, "extensions").get(_GLOSSINESS)
    return found if isinstance(found, dict) else None


def _factor(of, name, usual):
    """The numbers of an object under a name; the usual ones where it has none."""
    return usual if of.get(name) is None else numbers(name, of[name], len(usual))


def _of(element, name):
    """The dict that another one has under a name; an empty one where it has none."""
    found = element.get(name)
    return found if isinstance(found, dict) else {}
