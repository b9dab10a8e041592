"""Meshes of glTF files: all faces that the nodes of their scene show, with materials and textures."""

from typing import NamedTuple

import numpy as np

from surflux._base.files import file_error
from surflux._base.warn import warn
from surflux._core import FileError
from surflux.meshes.foreign_meshes import Mesh, joined, triangles
from surflux.meshes.gltf_container import DAMAGED, Container
from surflux.meshes.gltf_format import TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES
from surflux.meshes.gltf_looks import linear_reflectance, looks_of
from surflux.meshes.gltf_materials import Materials
from surflux.meshes.gltf_nodes import nodes_shown

# What a file may require: what is read, what a warning tells of, and what changes neither faces nor their colours.
_READ = {"KHR_mesh_quantization", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds", "KHR_texture_transform"}
_READ |= {"KHR_lights_punctual", "KHR_xmp_json_ld", "KHR_animation_pointer", "EXT_lights_image_based"}
_MATERIALS = "KHR_materials_"
_INSTANCES, _VISIBILITY = "EXT_mesh_gpu_instancing", "KHR_node_visibility"  # extensions that are not read
_FACES = (TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN)


def read_gltf(path):
    """The Mesh of all faces of a glTF file, in the order of its nodes; without faces where it has none.

    Points and lines are left out. What it requires and is not read is refused, what else changes faces is warned of.

    Raises FileError.
    """
    try:
        file = Container(path)
        others = [
            str(name)
            for name in file.header.get("extensionsRequired", ())
            if name not in _READ and not name.startswith(_MATERIALS)
        ]
        if others:
            raise file_error(path, f"requires {', '.join(others)}, which is not read; wanted a file without it")
        with np.errstate(all="ignore"):  # what is not finite is refused as such
            return _mesh(path, file)
    except FileError:
        raise
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault
    except DAMAGED as fault:
        reason = f"has no {fault}" if isinstance(fault, KeyError) else str(fault)
        raise file_error(path, f"no glTF of meshes: {reason}") from fault


class _Part(NamedTuple):
    """The faces of a primitive, and whether they have a texture and no place on it."""

    mesh: Mesh
    unplaced: bool


def _mesh(path, file):
    materials = Materials(path, file)
    shown, left_out = [], {}
    for node, matrix in nodes_shown(file):
        if _hides(node):
            left_out[_VISIBILITY] = None
        if "mesh" in node:
            mesh = file.entry("meshes", node["mesh"])
            left_out |= dict.fromkeys(_not_read(node, mesh))
            primitives = (one for one in enumerate(mesh["primitives"]) if one[1].get("mode", TRIANGLES) in _FACES)
            shown += [((node["mesh"], number), primitive, matrix) for number, primitive in primitives]
    # Each primitive once, and those with one texture together.
    once = {key: primitive for key, primitive, _ in shown}
    order = sorted(once, key=lambda key: materials.images(once[key].get("material")))
    parts = {key: _part(file, once[key], materials) for key in order}
    unplaced = [(once[key]["material"], len(parts[key].mesh.offsets) - 1) for key, *_ in shown if parts[key].unplaced]
    materials.tell(unplaced)
    if left_out:
        what = " and ".join(left_out) + (" is" if len(left_out) == 1 else " are")
        warn(f"{path}: {what} not read: faces stand as they do without")
    return joined([_moved(parts[key].mesh, matrix) for key, _, matrix in shown])


def _hides(node):
    """Whether a node says that it and those below it are not seen."""
    return (node.get("extensions") or {}).get(_VISIBILITY, {}).get("visible") is False


def _not_read(node, mesh):
    """What changes the faces of a mesh that a node shows and is not read."""
    if _INSTANCES in (node.get("extensions") or {}):
        yield _INSTANCES
    if "skin" in node:
        yield "skin"
    if any(node.get("weights") or mesh.get("weights") or ()):
        yield "weights"


def _part(file, primitive, materials):
    attributes = primitive["attributes"]
    vertices = file.array(attributes["POSITION"], "VEC3")
    faces = _faces(file, primitive, len(vertices))
    colors, places = None, None
    if "COLOR_0" in attributes:
        colors = file.array(attributes["COLOR_0"], "VEC3", "VEC4", normalized=True)
    if "TEXCOORD_0" in attributes:
        places = file.array(attributes["TEXCOORD_0"], "VEC2")
    if {len(values) for values in (vertices, colors, places) if values is not None} != {len(vertices)}:
        raise ValueError("attributes of a primitive have different counts")
    if colors is not None and not np.isfinite(colors).all():
        raise ValueError("COLOR_0: wanted finite numbers")
    if "material" not in primitive:
        return _Part(triangles(vertices, faces, None if colors is None else linear_reflectance(colors)), False)
    material = materials.of(primitive["material"])
    unplaced = places is None and (material.texture or material.shining) is not None
    if places is not None:
        places = (places * [1.0, -1.0] + [0.0, 1.0])[faces]  # v goes down in files
    return _Part(triangles(vertices, faces, **looks_of(material, faces, places, colors)), unplaced)


def _faces(file, primitive, count):
    """(f, 3) indices of the vertices of a primitive, of which there are `count`."""
    mode, corners = primitive.get("mode", TRIANGLES), np.arange(count)
    if "indices" in primitive:
        found = file.array(primitive["indices"], "SCALAR")
        corners = found.astype(np.int64)
        bad = (found != corners) | (found < 0) | (found >= count)
        if bad.any():
            raise ValueError(f"an index is {found[np.argmax(bad)]:g}; wanted one of {count} vertices of its primitive")
    if mode == TRIANGLES:
        if len(corners) % 3:
            raise ValueError(f"{len(corners)} corners of triangles; wanted three of each")
        return corners.reshape(-1, 3)
    if mode == TRIANGLE_FAN:
        return np.stack([np.full(max(len(corners) - 2, 0), corners[0]), corners[1:-1], corners[2:]], axis=1)
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2, [0, 2, 1]]  # every other triangle of a strip is wound the other way
    return faces


def _moved(mesh, matrix):
    """A Mesh of triangles by a matrix (4, 4); one that mirrors turns faces over, so that they look outwards still."""
    if not np.array_equal(matrix, np.eye(4)):
        mesh = mesh._replace(vertices=mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3])
    if np.linalg.det(matrix[:3, :3]) >= 0.0:
        return mesh
    places = None if mesh.places is None else mesh.places.reshape(-1, 3, 2)[:, ::-1].reshape(-1, 2)
    return mesh._replace(indices=mesh.indices.reshape(-1, 3)[:, ::-1].ravel(), places=places)
