"""surflux: diffuse global illumination directly on points.

>>> import surflux as sf
>>> sorted(sf.__all__)[:3]
['AreaLight', 'AreaShares', 'Camera']
"""

from importlib import import_module as _import_module

from surflux._core import Cancelled as Cancelled
from surflux._core import DeviceError as DeviceError
from surflux._core import FileError as FileError

# Named here, not below: the module surflux.info would otherwise hide the function of the same name.
from surflux.info import info as info

# Where each public name lives. Modules are loaded when they are first asked for: the viewer brings pyvista along.
_HOME = {
    "AreaLight": "lights",
    "AreaShares": "areas",
    "Camera": "camera",
    "DirectionalLight": "lights",
    "Environment": "lights",
    "Hierarchy": "hierarchy",
    "Page": "page",
    "PointLight": "lights",
    "Scene": "scene",
    "Solution": "solution",
    "SpotLight": "lights",
    "Surfels": "surfels",
    "area_shares": "areas",
    "build_hierarchy": "hierarchy",
    "camera_path": "animation",
    "effective_areas": "areas",
    "form_factors": "solver",
    "inward_patches": "orientation",
    "load_scene": "scene_file",
    "load_solution": "solution_file",
    "read": "files",
    "read_image": "images",
    "reference_irradiance": "reference",
    "save_camera": "camera_file",
    "solve": "solver",
    "solve_meshless": "meshless",
    "tone_map": "images",
    "turntable": "animation",
    "view": "viewing",
    "write_image": "images",
}

__all__ = sorted([*_HOME, "Cancelled", "DeviceError", "FileError", "info"])
__version__ = "0.1.0"

# The core's own exceptions come without words.
FileError.__doc__ = """A file that cannot be read or written, an OSError: "path (place): reason".

The place is the line, byte, or table and key, where there is one.
"""
Cancelled.__doc__ = "A progress callback returned False, or Ctrl-C was pressed: the pass has stopped without a result."
DeviceError.__doc__ = "There is no OpenGL to draw with, a RuntimeError: says what was tried."


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'surflux' has no attribute {name!r}")
    value = getattr(_import_module(f"surflux.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})
