"""Scenes that come with surflux, to try it with: sf.examples.statues() and others. None needs a file of yours."""

from __future__ import annotations

from pathlib import Path

from surflux._core import FileError
from surflux.scenes.scene import Scene
from surflux.scenes.scene_file import load_scene

__all__ = ["colonnade", "cornell_box", "file", "folder", "schema", "statues", "street", "three_spheres"]


def folder() -> Path:
    """The folder of the scene files: the package's own, or data/ of the checkout that it runs from.

    Raises:
        FileError: neither is there.

    >>> import surflux as sf
    >>> (sf.examples.folder() / "sponza.toml").exists()  # some read models that are not part of surflux
    True
    """
    here = Path(__file__).resolve().parent
    for place in (here / "files", here.parents[2] / "data"):
        if (place / "three_spheres.toml").is_file():
            return place
    raise FileError(f"{here / 'files'}: the scene files of surflux are missing in this installation")


def file(name: str) -> Path:
    """The scene file of an example, to copy from or for `surflux solve`.

    Args:
        name: that of a function of this module, such as "statues".

    Returns:
        The Path of a TOML file.

    Raises:
        ValueError: there is no example of that name.
        FileError: the files are missing in this installation.

    >>> import surflux as sf
    >>> sf.examples.file("statues").name
    'statues.toml'
    """
    if name not in _FILES:
        raise ValueError(f"name: wanted one of {', '.join(sorted(_FILES))}, got {name!r}")
    return folder() / f"{_FILES[name]}.toml"


def schema() -> Path:
    """The JSON schema of scene files, with which editors complete keys and mark faults while a file is written.

    It knows keys, types, ranges and which keys go together; what needs a look at files or at geometry load_scene says.

    Returns:
        The Path of a JSON file (draft 2020-12).

    >>> import json
    >>> import surflux as sf
    >>> sorted(json.loads(sf.examples.schema().read_text())["properties"])
    ['camera', 'light', 'name', 'object', 'solve', 'units']
    """
    return Path(__file__).resolve().parent / "scene.schema.json"


def three_spheres(*, surfels: int | None = None) -> Scene:
    """Three spheres of points in a room with a red and a green wall, under four lamps (D04 8.1): 4326 surfels.

    Args:
        surfels: in all, exactly this many; None for what the file says. Points become denser or sparser, walls stay.

    Returns:
        Scene with a camera; metres, W/m2.

    Raises:
        ValueError: `surfels`, where the scene cannot be had in that number.

    >>> import surflux as sf
    >>> sf.examples.three_spheres()
    Scene('three spheres', 4 objects, 4326 surfels, 4 lights)
    """
    return load_scene(file("three_spheres"), surfels=surfels)


def statues(*, surfels: int | None = None) -> Scene:
    """A boulder and a knot on plinths in a gallery, under a spot and a lamp: 9268 surfels, most of them points.

    Args, Returns and Raises are those of three_spheres.

    >>> import surflux as sf
    >>> sf.examples.statues(surfels=5000)
    Scene('statues', 5 objects, 5000 surfels, 2 lights)
    """
    return load_scene(file("statues"), surfels=surfels)


def cornell_box() -> Scene:
    """The Cornell box, by its published measurements in metres, open towards the camera: 2568 patches.

    Returns:
        Scene with a camera; metres, W/m2.

    >>> import surflux as sf
    >>> sf.examples.cornell_box()
    Scene('Cornell box', 15 objects, 2568 surfels, 1 light)
    """
    return load_scene(file("cornell_box"))


def street() -> Scene:
    """A street between two rows of houses, in the sun of a clear afternoon: patches of up to a metre.

    Returns:
        Scene with a camera; metres, W/m2. x is east, y north.

    >>> import surflux as sf
    >>> len(sf.examples.street().objects)
    8
    """
    return load_scene(file("street"))


def colonnade() -> Scene:
    """A hall open to one side, where the sun falls in between columns, and a boulder stands: what comes of one bounce.

    Returns:
        Scene with a camera; metres, W/m2.

    >>> import surflux as sf
    >>> sf.examples.colonnade().name
    'colonnade'
    """
    return load_scene(file("colonnade"))


_FILES = {
    "three_spheres": "three_spheres",
    "statues": "statues",
    "cornell_box": "cornell",
    "street": "street",
    "colonnade": "colonnade",
}
