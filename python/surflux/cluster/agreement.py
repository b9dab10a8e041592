"""What processes that share out a pass must have in common, and how they tell that they do."""

import hashlib

import numpy as np

from surflux import _core
from surflux.scenes.scene_arrays import scene_arrays


def machine_facts():
    """What of a process decides about the bits of its results, by name."""
    libraries = {f"version of {name}": version for name, version in _core.versions().items()}
    return {"version of surflux": _core.version(), **libraries, "instruction set": _core.instruction_set()}


def call_facts(program, scene, arguments):
    """The same of a call: what is to be computed, the scene's arrays and lights, the options, each by its name."""
    about, arrays = scene_arrays(scene)
    options = {f"option {name}": _plain(value) for name, value in arguments.items()}
    lights = {f"scene's light {k}": _plain(values) for k, values in enumerate(about["lights"])}
    of_scene = {f"scene's array {name}": _plain(values) for name, values in arrays.items()}
    return {"solver": program.__module__.rpartition(".")[2], **of_scene, **lights, **options}


def difference(ours, theirs):
    """(name, our value, theirs) of the first fact that is not the same; None where all are."""
    for name in [*ours, *(name for name in theirs if name not in ours)]:
        if ours.get(name) != theirs.get(name):
            return name, ours.get(name), theirs.get(name)
    return None


def _plain(value):
    """What is compared, as text; of arrays their shape and a digest."""
    if not isinstance(value, np.ndarray):
        return repr(value)
    digest = hashlib.blake2b(f"{value.dtype.str}{value.shape}".encode(), digest_size=16)
    digest.update(np.ascontiguousarray(value).reshape(-1).view(np.uint8).data)
    return f"array of {' x '.join(map(str, value.shape))}, digest {digest.hexdigest()}"
