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
    """The same of a call: what is to be computed, the options by name, and a digest of the scene."""
    about, arrays = scene_arrays(scene)
    own = hashlib.blake2b(digest_size=16)
    _add(own, about["lights"])
    _add(own, arrays)
    options = {f"option {name}": _plain(value) for name, value in arguments.items()}
    return {"solver": program.__module__.rpartition(".")[2], **options, "scene": own.hexdigest()}


def difference(ours, theirs):
    """(name, our value, theirs) of the first fact that is not the same; None where all are."""
    for name in [*ours, *(name for name in theirs if name not in ours)]:
        if ours.get(name) != theirs.get(name):
            return name, ours.get(name), theirs.get(name)
    return None


def _plain(value):
    """An option as text; arrays as a digest."""
    if isinstance(value, np.ndarray):
        own = hashlib.blake2b(digest_size=16)
        _add(own, value)
        return own.hexdigest()
    return repr(value)


def _add(digest, value):
    if isinstance(value, dict):
        for name in sorted(value):
            digest.update(name.encode())
            _add(digest, value[name])
    elif isinstance(value, (list, tuple)):
        digest.update(f"{len(value)}".encode())
        for entry in value:
            _add(digest, entry)
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(np.ascontiguousarray(value).reshape(-1).view(np.uint8).data)
    else:
        digest.update(repr(value).encode())
