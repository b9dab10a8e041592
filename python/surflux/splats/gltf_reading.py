"""glTF files of Gaussians, read: whoever wrote them."""

from typing import NamedTuple

import numpy as np

from surflux._base.files import file_error, require_file
from surflux.meshes.gltf_container import DAMAGED, Container, whole
from surflux.meshes.gltf_format import POINTS
from surflux.meshes.gltf_nodes import nodes_shown
from surflux.scans.gltf import up_to_y
from surflux.splats import gltf_format as gltf
from surflux.splats import turning
from surflux.splats.view_colors import HIGHEST, PHASE

_READ = {gltf.EXTENSION, "KHR_mesh_quantization", "KHR_materials_unlit"}
_FEWEST_BYTES = 8  # of a Gaussian in any file: primitives that share their data would make more of little
_EXACT, _SAME = 1e-12, 1e-5


class _Part(NamedTuple):
    positions: np.ndarray
    scales: np.ndarray
    rotations: np.ndarray
    opacities: np.ndarray
    harmonics: np.ndarray


def read_gltf(path, up):
    """(positions, scales, rotations, opacities, harmonics, color space) of a file; raises FileError.

    All primitives of Gaussians that nodes of the scene show, one after another, in the coordinates in which the unit
    vector `up` is what +y is in the file.
    """
    require_file(path)
    try:
        file = Container(path)
        required = set(file.header.get("extensionsRequired", [])) - _READ
        if required:
            raise ValueError(f"it needs {', '.join(sorted(map(str, required)))}, which is not read here")
        parts, spaces = [], set()
        with np.errstate(all="ignore"):  # what is not finite is refused as such
            for primitive, matrix in _shown(file):
                spaces.add(_color_space(primitive["extensions"][gltf.EXTENSION]))
                parts.append(_moved(_part(file, primitive), up_to_y(up).T @ matrix[:3]))
        if len(spaces) > 1:
            raise ValueError("some of its Gaussians are sRGB-coded and some linear, which is not read here")
    except OSError as fault:
        raise file_error(path, f"cannot be read: {fault.strerror or fault}") from fault
    except DAMAGED as fault:
        reason = f"has no {fault}" if isinstance(fault, KeyError) else str(fault)
        raise file_error(path, f"no glTF of Gaussians: {reason}") from fault
    if not parts:
        raise file_error(path, f"holds no Gaussians: nothing in its scene has {gltf.EXTENSION}")
    most = max(part.harmonics.shape[1] for part in parts)
    padded = [np.pad(part.harmonics, ((0, 0), (0, most - part.harmonics.shape[1]), (0, 0))) for part in parts]
    arrays = (np.concatenate(columns) for columns in list(zip(*parts, strict=True))[:-1])
    return *arrays, np.concatenate(padded), spaces.pop()


def _shown(file):
    """(primitive, global matrix (4, 4)) of all Gaussians in the scene that is shown, or in all nodes without one."""
    total = 0
    for node, matrix in nodes_shown(file):
        if "mesh" not in node:
            continue
        for primitive in file.entry("meshes", node["mesh"])["primitives"]:
            if gltf.EXTENSION in primitive.get("extensions", {}):
                total += file.count(primitive["attributes"]["POSITION"])
                yield primitive, matrix
                if total * _FEWEST_BYTES > file.size():
                    raise ValueError("its primitives share their data, which is not read here")


def _color_space(extension):
    if extension["kernel"] != "ellipse":
        raise ValueError(f"its kernel is {extension['kernel']!r}; wanted 'ellipse'")
    if extension.get("extensions"):
        raise ValueError(f"its Gaussians have {', '.join(extension['extensions'])}, which is not read here")
    for ours, theirs in gltf.COLOR_SPACES.items():
        if extension["colorSpace"] == theirs:
            return ours
    raise ValueError(f"its colorSpace is {extension['colorSpace']!r}; wanted one of {list(gltf.COLOR_SPACES.values())}")


def _part(file, primitive):
    """The Gaussians of a primitive, as its accessors have them."""
    if whole("mode", primitive.get("mode", 4)) != POINTS:
        raise ValueError("its Gaussians are no points")
    attributes = primitive["attributes"]
    positions = file.array(attributes["POSITION"], "VEC3")
    rotations = np.roll(file.array(attributes[gltf.ROTATION], "VEC4"), 1, axis=1)
    scales = file.array(attributes[gltf.SCALE], "VEC3")
    opacities = file.array(attributes[gltf.OPACITY], "SCALAR")
    degree = max(d for d in range(HIGHEST + 1) if d == 0 or gltf.harmonic(d, 0) in attributes)
    harmonics = [file.array(attributes[name], "VEC3") for name in gltf.harmonics(degree)]
    if any(name.startswith(f"{gltf.EXTENSION}:SH_") and name not in gltf.harmonics(degree) for name in attributes):
        raise ValueError("its spherical harmonics are not whole degrees up to 3")
    if {len(a) for a in (positions, rotations, scales, opacities, *harmonics)} != {len(positions)}:
        raise ValueError("its attributes have different counts")
    return _Part(positions, scales, rotations, opacities, np.stack(harmonics, axis=1))


def _moved(part, matrix):
    """A part by a matrix (3, 4) that turns, moves and scales alike in all directions."""
    lengths = np.linalg.norm(matrix[:, :3], axis=0)
    size = float(np.cbrt(np.prod(lengths)))
    turn = matrix[:, :3] / size if size > 0.0 and np.isfinite(size) else np.zeros((3, 3))
    if not np.abs(turn.T @ turn - np.eye(3)).max() <= _SAME or np.linalg.det(turn) < 0.0:
        raise ValueError("a node stretches, skews or mirrors its Gaussians, which is not read here")
    size = 1.0 if abs(size - 1.0) < _EXACT else size
    if np.abs(turn - np.eye(3)).max() < _EXACT:  # and the numbers are those of the file
        return part._replace(positions=size * part.positions + matrix[:, 3], scales=size * part.scales)
    phase = PHASE[: part.harmonics.shape[1], None]
    return _Part(
        size * (part.positions @ turn.T) + matrix[:, 3],
        size * part.scales,
        turning.product(turning.of_matrix(turn), part.rotations),
        part.opacities,
        phase * turning.turned_harmonics(phase * part.harmonics, turn),
    )
