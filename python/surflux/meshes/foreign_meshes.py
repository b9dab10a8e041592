"""Meshes of other libraries, told by what they have and not by their class, as vertices and polygons with colours."""

import sys
from hashlib import blake2b
from typing import NamedTuple

import numpy as np

from surflux._base.color import reflectance_of_colors, white_of_colors
from surflux._base.warn import warn
from surflux.meshes.fans import fans_of_faces, sums_of_rows
from surflux.meshes.gltf_looks import Material, linear_reflectance, looks_of
from surflux.meshes.strips import without_strips
from surflux.meshes.textures import TextureUse, texture_of
from surflux.meshes.transparency import cover_of


class Mesh(NamedTuple):
    """Vertices and polygons.

    The corners of face i are indices[offsets[i]:offsets[i + 1]]. Reflectance is linear, of the colours of vertices or
    faces, sRGB with white at .98, or of materials; None where there are none. Exitance is what faces send by
    themselves. A face has the mean of its texture in both; of parts of faces `face_colors` says it.
    """

    vertices: np.ndarray  # (v, 3) float64
    offsets: np.ndarray  # (f + 1,) int64
    indices: np.ndarray  # (k,) int64
    reflectance: np.ndarray | None  # (v, 3) float64
    of_faces: np.ndarray | None = None  # (f, 3) float64, which counts where both are there
    exitance: np.ndarray | None = None  # (f, 3) float64; None for 0
    places: np.ndarray | None = None  # (k, 2) float64: texture coordinates of the corners, v going up; NaN for none
    textures: tuple[TextureUse, ...] = ()
    clear: tuple[tuple[str | None, int], ...] = ()  # materials that are not opaque, and how many faces have them
    double_sided: int = 0  # faces that have backs in glTF

    def face_reflectance(self):
        """(f, 3): what each face has, else its mean of vertices; 0.5 where the mesh has no colours."""
        if self.of_faces is not None:
            return self.of_faces
        if self.reflectance is None:
            return np.full((len(self.offsets) - 1, 3), 0.5)
        return self.mean_over_faces(self.reflectance)

    def with_materials(self, reflectance=None, emission=None):
        """With these (f, 3) in place of its own, where given."""
        mesh = self
        if reflectance is not None:
            shining = tuple(use for use in mesh.textures if use.shines)
            mesh = mesh._replace(of_faces=reflectance, textures=shining)
        if emission is not None:
            kept = tuple(use for use in mesh.textures if not use.shines)
            mesh = mesh._replace(exitance=emission, textures=kept)
        return mesh

    def mean_over_faces(self, values):
        """(f, k): mean by area over each face of values (v, k) at vertices, linear over triangles of its fan."""
        at, counts = values[self.indices], np.diff(self.offsets)
        means = np.add.reduceat(at, self.offsets[:-1]) / counts[:, None]
        larger = np.flatnonzero(counts > 3)
        if len(larger):
            of, fan, shares = fans_of_faces(self.vertices, self.offsets, self.indices, larger)
            found = sums_of_rows(of, shares[:, None] * at[fan].mean(axis=1), len(larger))
            low, high = (of_all.reduceat(at, self.offsets[:-1])[larger] for of_all in (np.minimum, np.maximum))
            means[larger] = np.clip(found, low, high)
        return means

    def face_emission(self):
        """(f, 3): what each face sends by itself."""
        return np.zeros((len(self.offsets) - 1, 3)) if self.exitance is None else self.exitance


WANTED = "a path, a mesh of trimesh, pyvista, meshio or Open3D, or (vertices, faces)"
_SURFACES = ("triangle", "quad")  # of meshio's cells, and polygons
_WITHOUT_AREA = ("vertex", "line")


def convert(mesh):
    """The Mesh of an object of another library; None where it is none."""
    pyvista = sys.modules.get("pyvista")
    if pyvista is not None and isinstance(mesh, pyvista.PolyData):
        return _from_pyvista(mesh)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return _from_trimesh(mesh, None)
    if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
        return _from_open3d(mesh)
    if hasattr(mesh, "to_legacy"):  # open3d.t.geometry
        return _from_open3d(mesh.to_legacy())
    if hasattr(mesh, "dump") and hasattr(mesh, "geometry"):  # trimesh.Scene
        parts = [_from_trimesh(part, _colors_in(mesh, part)) for part in mesh.dump() if hasattr(part, "faces")]
        return joined(_sharing_textures(parts))
    if hasattr(mesh, "points") and isinstance(getattr(mesh, "cells", None), list):
        return _from_meshio(mesh)
    return None


def triangles(vertices, faces, reflectance=None, of_faces=None, exitance=None, places=None, textures=(), **of_gltf):
    """The Mesh of triangles (f, 3)."""
    faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    vertices = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    offsets = 3 * np.arange(len(faces) + 1)
    return Mesh(vertices, offsets, faces.ravel(), reflectance, of_faces, exitance, places, textures, **of_gltf)


def reflectance_of(colors):
    """Linear reflectance (n, 3) of an array of colours of any type, RGB or RGBA: fractions, 8 or 16 bits."""
    colors = np.asarray(colors)[:, :3]
    white = {"uint8": 255.0, "uint16": 65535.0}.get(colors.dtype.name)  # also where all of them are dark
    if white is None:
        white = white_of_colors(colors, "float" if colors.dtype.kind == "f" else colors.dtype.name, "mesh")
    if white is None or not np.all(np.isfinite(colors)):
        raise ValueError("colours: wanted finite numbers, at most 1, 255 or 65535")
    return reflectance_of_colors(colors, white)


def _colors_in(scene, part):
    """COLOR_0 of a part of a trimesh.Scene beside its material, which dump() forgets; or None."""
    visual = getattr(scene.geometry.get(part.metadata.get("name")), "visual", None)
    colors = getattr(visual, "vertex_attributes", {}).get("color")
    return colors if colors is not None and len(colors) == len(part.vertices) else None


def is_gltf(mesh):
    """Is a mesh or a cloud of trimesh from a glTF file? Its colours are linear then."""
    return "from_gltf_primitive" in (getattr(mesh, "metadata", None) or {})


def _from_trimesh(mesh, colors):
    """colors: of vertices, linear, beside a material of glTF."""
    visual = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        of_colors = linear_reflectance if is_gltf(mesh) else reflectance_of
        return triangles(mesh.vertices, mesh.faces, reflectance=of_colors(visual.vertex_colors))
    if kind == "face":
        return triangles(mesh.vertices, mesh.faces, of_faces=reflectance_of(visual.face_colors))
    if kind == "texture":
        if colors is None and not is_gltf(mesh):
            colors = getattr(mesh, "vertex_attributes", {}).get("color")  # of OBJ files
        return triangles(mesh.vertices, mesh.faces, **_textured(visual, np.asarray(mesh.faces), colors))
    return triangles(mesh.vertices, mesh.faces)


def joined(parts):
    """One Mesh of several of triangles, whose faces come one after another."""
    if not parts:
        return triangles(np.zeros((0, 3)), np.zeros((0, 3)))
    if len(parts) == 1:
        return parts[0]
    before = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    faces = [part.indices + first for part, first in zip(parts, before, strict=True)]
    if all(part.of_faces is None for part in parts):
        each = [
            np.full((len(part.vertices), 3), 0.5) if part.reflectance is None else part.reflectance for part in parts
        ]
        painted = {"reflectance": np.concatenate(each)}
    else:
        painted = {"of_faces": np.concatenate([part.face_reflectance() for part in parts])}
    if any(part.exitance is not None for part in parts):
        painted["exitance"] = np.concatenate([part.face_emission() for part in parts])
    if any(part.textures for part in parts):
        first = np.cumsum([0] + [len(part.offsets) - 1 for part in parts[:-1]])
        painted["textures"] = _merged(
            [
                use._replace(faces=use.faces + face)
                for part, face in zip(parts, first, strict=True)
                for use in part.textures
            ]
        )
        nowhere = (np.full((len(part.indices), 2), np.nan) for part in parts)
        painted["places"] = np.concatenate(
            [no if part.places is None else part.places for part, no in zip(parts, nowhere, strict=True)]
        )
    painted["clear"] = tuple(one for part in parts for one in part.clear)
    painted["double_sided"] = sum(part.double_sided for part in parts)
    return triangles(np.concatenate([part.vertices for part in parts]), np.concatenate(faces), **painted)


def _merged(uses):
    """TextureUses of faces of whole parts, one after another, as one for each texture."""
    alike = {}
    for use in uses:
        alike.setdefault((use.read, use.shines, use.most), []).append(use)
    return tuple(
        some[0]._replace(
            faces=np.concatenate([use.faces for use in some]), tint=np.concatenate([use.tint for use in some])
        )
        for some in alike.values()
    )


def _sharing_textures(parts):
    """Parts of a trimesh.Scene, which have copies of their textures, with one of each.

    trimesh itself would make one picture of their materials, without repeats and factors.
    """
    read = {}  # by what is in a texture
    return [
        part._replace(
            textures=tuple(use._replace(read=read.setdefault(_digest(use.read()), use.read)) for use in part.textures)
        )
        for part in parts
    ]


def _digest(texture):
    cover = b"" if texture.cover is None else texture.cover.tobytes()
    shape = str((texture.pixels.shape, texture.pixels.dtype)).encode()
    return blake2b(np.ascontiguousarray(texture.pixels).tobytes() + cover + shape).digest()


def _textured(visual, faces, colors):
    """What `triangles` takes of the material of faces, and of its textures, which it is times."""
    if colors is None:
        colors = visual.vertex_attributes.get("color")
    material = visual.material
    places = None if visual.uv is None else np.asarray(visual.uv, np.float64)[faces]
    name = getattr(material, "name", None)
    if hasattr(material, "baseColorFactor"):
        return looks_of(_material_of_gltf(material, places is not None), faces, places, colors)
    diffuse, image = _diffuse(material), getattr(material, "image", None)
    if image is not None and places is not None:  # as paint has it for files
        tint = diffuse if diffuse is not None and diffuse.any() else np.ones(3)
        return looks_of(Material(name, tint, _held(image)), faces, places, None)
    if colors is not None:
        return {"reflectance": reflectance_of(colors)}
    return {} if diffuse is None else looks_of(Material(name, diffuse, None), faces, None, None)


def _material_of_gltf(material, placed):
    """The Material of a PBRMaterial of trimesh, which has 8 bits of factors; its textures where faces lie on them."""
    factor = np.full(4, 255.0) if material.baseColorFactor is None else np.asarray(material.baseColorFactor, np.float64)
    cover = cover_of(material.alphaMode, factor[3] / 255.0, material.alphaCutoff)
    emissive = material.emissiveFactor
    return Material(
        material.name,
        factor[:3] / 255.0,
        _held(material.baseColorTexture if placed else None, cover),
        None if emissive is None or not np.any(emissive) else np.pi * np.asarray(emissive, np.float64),
        _held(material.emissiveTexture if placed else None),
        cover,
        bool(material.doubleSided),
    )


def _held(image, cover=None):
    """What gives the Texture of an image; None of none."""
    if image is None:
        return None
    texture = texture_of(image, cover)
    return lambda: texture


def _diffuse(material):
    """(3,): Kd of a material as of OBJ files; None where nobody has said anything, and of others.

    trimesh has it in 8 bits, linear all the same, and what the file says, which counts unless that was changed since.
    """
    stored = getattr(material, "diffuse", None)
    if stored is None:
        return None
    said = np.asarray(getattr(material, "kwargs", {}).get("kd"))
    linear = np.asarray(stored, np.float64)[:3] / 255.0
    if (
        said.shape == (3,)
        and said.dtype.kind in "fiu"
        and np.allclose(np.clip(said, 0.0, 1.0), linear, atol=0.51 / 255)
    ):
        return said.astype(np.float64)
    # Grey, where nobody has said anything.
    return None if np.array_equal(stored, type(material)().diffuse) else linear


def _from_open3d(mesh):
    colors = np.asarray(getattr(mesh, "vertex_colors", ()))
    reflectance = reflectance_of(colors) if len(colors) else None
    return triangles(mesh.vertices, mesh.triangles, reflectance=reflectance)


def _from_meshio(mesh):
    rings, left_out = [], set()
    for block in mesh.cells:
        kind, data = (block.type, block.data) if hasattr(block, "type") else block  # pairs in older versions
        if kind in _SURFACES or kind.startswith("polygon"):
            rings += [np.asarray(ring, dtype=np.int64) for ring in data]
        elif not kind.startswith(_WITHOUT_AREA):
            left_out.add(kind)
    if left_out:
        kinds = ", ".join(sorted(left_out))
        if not rings:
            raise ValueError(f"mesh cells: wanted triangles, quads or polygons, got {kinds}; give the surface")
        warn(f"mesh cells: {kinds} are left out; triangles, quads and polygons are the surface")
    vertices = np.array(mesh.points, dtype=np.float64)
    if vertices.ndim == 2 and vertices.shape[1] == 2:
        vertices = np.pad(vertices, ((0, 0), (0, 1)))
    data = getattr(mesh, "point_data", None) or {}
    reflectance = None
    if all(name in data for name in ("red", "green", "blue")):  # as its reader of PLY has them
        reflectance = reflectance_of(np.stack([data[name] for name in ("red", "green", "blue")], axis=1))
    offsets = np.cumsum([0, *map(len, rings)])
    return Mesh(vertices, offsets, np.concatenate(rings) if rings else np.zeros(0, np.int64), reflectance)


def _from_pyvista(mesh):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    mesh = without_strips(mesh)
    polygons = mesh.GetPolys()
    offsets = vtk_to_numpy(polygons.GetOffsetsArray()).astype(np.int64)
    indices = vtk_to_numpy(polygons.GetConnectivityArray()).astype(np.int64)
    reflectance, of_faces = (colors_among(data) for data in (mesh.point_data, mesh.cell_data))
    if of_faces is not None:
        of_faces = of_faces[mesh.n_verts + mesh.n_lines :]  # cells of these kinds come first
    return Mesh(np.array(mesh.points, dtype=np.float64), offsets, indices, reflectance, of_faces)


def _are_fractions(colors):
    return colors.dtype.kind == "f" and len(colors) and colors.min() >= 0.0 and colors.max() <= 1.0


def colors_among(data):
    """Linear reflectance of the colours among arrays of pyvista; None where there are none."""
    for name in ("RGB", "RGBA"):
        colors = data.get(name)
        if (
            colors is not None
            and colors.ndim == 2
            and (colors.dtype in (np.uint8, np.uint16) or _are_fractions(colors))
        ):
            return reflectance_of(colors)
    return None
