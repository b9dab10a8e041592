"""Images of glTF files, as textures: beside the file, in data URIs or in its buffers."""

from functools import partial
from urllib.parse import unquote

from surflux.meshes.gltf_container import DAMAGED
from surflux.meshes.gltf_format import NEAREST
from surflux.meshes.textures import decoded_texture

_KEPT = 2  # decoded at a time: base colour and emission of a material


class Textures:
    """The textures of a file, each image once, however many materials and nodes have it."""

    def __init__(self):
        self._images = {}  # bytes, by index
        self._covers = {}
        self._reads = {}  # by image, cover and filter
        self._decoded = {}
        self.lost = []  # why a texture is not there

    def read(self, file, texture_info, cover, material):
        """What reads the Texture of a textureInfo of a Container; None, and an entry in `lost`, where nothing does.

        cover: as transparency.cover_of has it; material: what messages call it.
        """
        name = f"of {material}"
        try:
            texture = file.entry("textures", texture_info["index"])
            index = _image_of(texture)
            image = file.entry("images", index)
            name = f"{_name_of(image, index)!r} of {material}"
            if index not in self._images:
                self._images[index] = file.data(image["uri"]) if "uri" in image else file.view(image["bufferView"])
            key = index, None if cover is None else cover.tobytes(), _is_nearest(file, texture)
            self._covers[key] = cover
            self._texture(key)
        except FileNotFoundError:
            self.lost.append(f"{name} is not there")
        except ImportError:
            self.lost.append(f"{name} needs Pillow to be read (pip install pillow)")
        except KeyError as fault:
            self.lost.append(f"{name} has no {fault}")
        except DAMAGED as fault:
            self.lost.append(f"{name} is not read ({fault})")
        except Exception as fault:  # of Pillow, which raises many kinds
            kind = type(fault).__name__
            reason = "no image that Pillow knows" if kind == "UnidentifiedImageError" else f"{kind}: {fault}"
            self.lost.append(f"{name} is not read ({reason})")
        else:
            return self._reads.setdefault(key, partial(self._texture, key))
        return None

    def _texture(self, key):
        if key not in self._decoded:
            while len(self._decoded) >= _KEPT:
                del self._decoded[next(iter(self._decoded))]
            texture = decoded_texture(self._images[key[0]], self._covers[key])
            self._decoded[key] = texture._replace(nearest=key[2])
        return self._decoded[key]


def _image_of(texture):
    """The index of the image of a texture, which one of another format has in an extension."""
    for one in (texture, *(texture.get("extensions") or {}).values()):
        if "source" in one:
            return one["source"]
    raise ValueError("it has no source")


def _is_nearest(file, texture):
    """Whether a texture shows its texels as they are where it is magnified."""
    return "sampler" in texture and file.entry("samplers", texture["sampler"]).get("magFilter") == NEAREST


def _name_of(image, index):
    uri = image.get("uri", "data:")
    return image.get("name") or f"image {index}" if uri.startswith("data:") else unquote(uri)[:60]
